//! The conformance suite that every accelerator passes.

use std::collections::BTreeMap;
use std::ops::Range;

use super::random::Random;
use crate::aabb::{Aabb, BoxRay};
use crate::accel::{self, Accelerator, Child, Items, QueueEntry};
use crate::counters::Counters;
use crate::math::Vec3;
use crate::ray::{Line, Span};

/// Runs the suite on the accelerator of the given name.
///
/// # Panics
/// If the accelerator breaks a rule. The message names the rule and the case.
pub fn conformance(name: &str) {
    let mut random = Random::new(7);
    for (case, boxes) in cases(&mut random) {
        let groups = groups(&mut random, boxes.len());
        let items = Items { boxes: &boxes, groups: Some(&groups) };
        let Some(structure) = accel::build(name, items) else { panic!("no accelerator named {name}") };
        for (i, (line, span)) in lines(&mut random, &boxes).into_iter().enumerate() {
            holds_on_a_line(&*structure, &boxes, &line, span, &format!("{name}, {case}, line {i}: {line:?}"));
        }
    }
    for (case, mut boxes) in cases(&mut random) {
        if !boxes.is_empty() {
            refits_moved_items(name, case, &mut boxes, &mut random);
        }
    }
}

fn holds_on_a_line(a: &dyn Accelerator, boxes: &[Aabb], line: &Line, span: Span, context: &str) {
    let ray = BoxRay::new(line, span);
    proposes_every_box_met_in_time(a, &ray, boxes, context);
    traversal_visits_every_box_hit(a, &ray, boxes, context);
    finds_the_nearest_under_a_shrinking_limit(a, &ray, boxes, context);
}

/// Moves items slightly, far and beyond all bounds. Checks the structure after each refit or rebuild.
fn refits_moved_items(name: &str, case: &str, boxes: &mut [Aabb], random: &mut Random) {
    let groups = groups(random, boxes.len());
    let build = |boxes: &[Aabb]| {
        accel::build(name, Items { boxes, groups: Some(&groups) }).expect("a name that was built before")
    };
    let mut structure = build(boxes);
    for round in 0..6 {
        let moved: Vec<u32> = (0..=random.below(40)).map(|_| random.below(boxes.len()) as u32).collect();
        for &item in &moved {
            let b = boxes[item as usize];
            let step = b.size() * random.point(-1.0, 1.0) * [0.1, 0.5, 2.0, 100.0][round % 4];
            boxes[item as usize] = match random.below(60) {
                0 => Aabb::EMPTY,
                1 => Aabb::new(b.min, Vec3::INFINITY),
                2 => Aabb::new(Vec3::ZERO, Vec3::ONE),
                _ => Aabb::new(b.min + step, b.max + step),
            };
        }
        if !structure.refit(&moved, &|item| boxes[item as usize]) {
            structure = build(boxes);
        }
        for (i, (line, span)) in lines(random, boxes).into_iter().enumerate().step_by(4) {
            let context = format!("{name}, {case}, moved {round} times, line {i}: {line:?}");
            holds_on_a_line(&*structure, boxes, &line, span, &context);
        }
    }
}

/// Nested ranges of items, outer before inner. Some are empty or equal to the enclosing range.
fn groups(random: &mut Random, count: usize) -> Vec<Range<u32>> {
    let (mut groups, everything) = (Vec::new(), 0..count as u32);
    let mut open = vec![everything];
    while let Some(range) = open.pop() {
        groups.push(range.clone());
        if range.len() > 3 {
            let cut = |random: &mut Random| range.start + random.below(range.len() + 1) as u32;
            let (a, b) = (cut(random), cut(random));
            // The lower range is pushed last, so it comes first.
            open.extend([a.max(b)..range.end, range.start..a.min(b)]);
        }
    }
    groups
}

type Case = (&'static str, Vec<Aabb>);

fn cases(random: &mut Random) -> Vec<Case> {
    let mut cases = everyday_cases(random);
    cases.extend(uneven_cases(random));
    cases.extend(flat_cases(random));
    cases
}

/// Boxes of up to a given size, scattered in a cube.
fn cloud(random: &mut Random, n: usize, size: f64) -> Vec<Aabb> {
    let mut scattered = || {
        let p = random.point(-1.0, 1.0);
        Aabb::new(p, p + random.point(0.0, size))
    };
    (0..n).map(|_| scattered()).collect()
}

fn unit_box_at(p: Vec3) -> Aabb {
    Aabb::new(p, p + Vec3::ONE)
}

fn scaled(boxes: &[Aabb], factor: f64) -> Vec<Aabb> {
    boxes.iter().map(|b| Aabb::new(b.min * factor, b.max * factor)).collect()
}

fn everyday_cases(random: &mut Random) -> Vec<Case> {
    let place = |i: usize| Vec3::new((i % 6) as f64, (i / 6 % 6) as f64, (i / 36) as f64);
    let small = cloud(random, 500, 0.05);
    vec![
        ("no item", vec![]),
        ("one item", cloud(random, 1, 0.5)),
        ("two items", cloud(random, 2, 0.5)),
        ("large boxes", cloud(random, 200, 1.5)),
        ("tiny space", scaled(&small, 1e-200)),
        ("vast space", scaled(&small, 1e140)),
        ("small boxes", small),
        ("all coincident", vec![unit_box_at(Vec3::ZERO); 100]),
        (
            "two crowds of coincident boxes",
            [Vec3::ZERO, Vec3::splat(3.0)].map(|p| [unit_box_at(p); 60]).concat(),
        ),
        ("a lattice that shares faces", (0..216).map(|i| unit_box_at(place(i))).collect()),
        ("nested", (0..100).map(|i| Aabb::new(Vec3::ZERO, Vec3::splat(0.9f64.powi(i)))).collect()),
    ]
}

/// Clusters that are small compared to the whole, and unbounded boxes.
fn uneven_cases(random: &mut Random) -> Vec<Case> {
    let plane = Aabb::new(Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, -1.0), Vec3::splat(f64::INFINITY));
    let huge = Aabb::new(Vec3::splat(-1e300), Vec3::splat(1e300));
    let mut stadium: Vec<Aabb> = scaled(&cloud(random, 100, 0.2), 50.0);
    stadium.extend(cloud(random, 200, 0.1));
    stadium.push(Aabb::new(Vec3::new(-50.0, -50.0, -50.0), Vec3::new(50.0, 50.0, -49.0)));
    let with = |mut boxes: Vec<Aabb>, more: &[Aabb]| {
        boxes.extend(more);
        boxes
    };
    vec![
        ("huge empty space", with(cloud(random, 100, 0.1), &[unit_box_at(Vec3::splat(1e9))])),
        ("a crowd in a stadium", stadium),
        (
            "unbounded and empty boxes",
            with(cloud(random, 50, 0.2), &[plane, Aabb::EVERYTHING, Aabb::EMPTY, huge]),
        ),
        ("only unbounded and empty boxes", vec![plane, Aabb::EVERYTHING, Aabb::EMPTY]),
    ]
}

/// Boxes without volume, area or length, and boxes that end on the same planes.
fn flat_cases(random: &mut Random) -> Vec<Case> {
    let points = cloud(random, 300, 0.0);
    let squashed = |keep: Vec3, boxes: Vec<Aabb>| -> Vec<Aabb> {
        boxes.iter().map(|b| Aabb::new(b.min * keep, b.max * keep)).collect()
    };
    // Corners lie on few planes, so that many boxes touch the planes that split them.
    let mut whole = || {
        let corner = |v: Vec3| (v * 4.0).round();
        Aabb::around([corner(random.point(-1.0, 1.0)), corner(random.point(-1.0, 1.0))])
    };
    vec![
        ("whole numbers", (0..150).map(|_| whole()).collect()),
        ("a sheet", squashed(Vec3::new(1.0, 1.0, 0.0), cloud(random, 200, 0.2))),
        ("a string", squashed(Vec3::X, cloud(random, 200, 0.02))),
        ("points", points),
        ("coincident points", vec![Aabb::new(Vec3::ONE, Vec3::ONE); 50]),
    ]
}

/// Lines and spans that test boxes of any size.
fn lines(random: &mut Random, boxes: &[Aabb]) -> Vec<(Line, Span)> {
    let mut out = lines_at_corners(random, boxes);
    out.extend(lines_along_axes(random, boxes));
    out
}

/// Returns a corner of a random box.
fn corner(random: &mut Random, boxes: &[Aabb]) -> Vec3 {
    let corner = match boxes.len() {
        0 => Vec3::ZERO,
        n => {
            let b = boxes[random.below(n)];
            Vec3::from([0, 1, 2].map(|axis| if random.below(2) == 0 { b.min[axis] } else { b.max[axis] }))
        }
    };
    if corner.is_finite() { corner } else { Vec3::ONE }
}

/// Lines through corners and past them, from near, from inside and from far away, exact and with errors, over the
/// whole ray and over short spans.
fn lines_at_corners(random: &mut Random, boxes: &[Aabb]) -> Vec<(Line, Span)> {
    let span = |a, b| Span::new(a, b).expect("an interval");
    let spans = [Span::FORWARD, span(0.25, 1.5), span(-2.0, 0.5), span(1.0, 1.0), span(1.0, f64::INFINITY)];
    let mut out = Vec::new();
    for i in 0..90 {
        let aim = corner(random, boxes);
        let size = if aim == Vec3::ZERO { 1.0 } else { aim.abs().max_element() };
        let target = if i % 2 == 0 { aim } else { aim + random.point(-0.5, 0.5) * size };
        let distance = [0.1, 1.0, 4.0, 1e9, 1e18][i % 5] * size;
        let o = if i % 7 == 0 { corner(random, boxes) } else { target + random.point(-1.0, 1.0) * distance };
        let d = (target - o) * [1.0, 1e-3, 1e5][i % 3];
        if d == Vec3::ZERO {
            continue;
        }
        let mut line = Line::exact(o, d);
        if i % 4 == 0 {
            line.o_err = random.point(0.0, 1.0) * size * [1e-15, 0.1][i / 4 % 2];
            line.d_err = d.abs() * random.point(0.0, 1.0) * [1e-15, 1e-2, 0.5][i / 8 % 3];
        }
        out.push((line, spans[i % spans.len()]));
    }
    out
}

/// Lines along the axes and in axis-aligned planes, through corners of boxes: in faces and along edges. Zeros
/// have either sign.
fn lines_along_axes(random: &mut Random, boxes: &[Aabb]) -> Vec<(Line, Span)> {
    let mut out = Vec::new();
    for i in 0..48 {
        let zero = if i % 2 == 0 { 0.0 } else { -0.0 };
        let mut d = Vec3::splat(zero);
        d[i % 3] = if i % 4 < 2 { 1.0 } else { -1.0 };
        if i % 5 == 0 {
            d[(i + 1) % 3] = if i % 10 == 0 { 1.0 } else { -2.0 };
        }
        let p = if i % 6 == 5 { random.point(0.0, 1.0) } else { corner(random, boxes) };
        let back = if i % 8 == 7 { 0.0 } else { 4.0 * p.abs().max_element().max(1e-300) };
        out.push((Line::exact(p - d * back, d), Span::FORWARD));
    }
    out
}

fn boxes_hit(ray: &BoxRay, boxes: &[Aabb]) -> BTreeMap<u32, f64> {
    (0..)
        .zip(boxes)
        .filter(|(_, b)| !b.is_empty())
        .filter_map(|(i, b)| ray.enter_exit(b).map(|(t, _)| (i, t)))
        .collect()
}

fn proposes_every_box_met_in_time(a: &dyn Accelerator, ray: &BoxRay, boxes: &[Aabb], context: &str) {
    let mut counters = Counters::default();
    let mut queue: Vec<QueueEntry> = Vec::new();
    let mut first_proposal: BTreeMap<u32, f64> = BTreeMap::new();
    a.roots(ray, &mut queue, &mut counters);
    while let Some(next) = queue.pop() {
        match next.child {
            Child::Item(item) | Child::Entered(item) => {
                if let Child::Entered(_) = next.child {
                    let own = ray.enter_exit(&boxes[item as usize]).map(|(t, _)| t);
                    assert_eq!(own, Some(next.t), "{context}: item {item} is not entered there");
                    assert!(!first_proposal.contains_key(&item), "{context}: item {item} is offered twice");
                }
                let t = first_proposal.entry(item).or_insert(next.t);
                *t = t.min(next.t);
            }
            Child::Node(part) => a.expand(part, next.t, ray, &mut queue, &mut counters),
        }
    }
    for (item, enter) in boxes_hit(ray, boxes) {
        match first_proposal.get(&item) {
            None => panic!("{context}: item {item}, whose box is hit at {enter}, is not proposed"),
            Some(t) => assert!(*t <= enter, "{context}: item {item} proposed at {t}, after {enter}"),
        }
    }
}

fn traversal_visits_every_box_hit(a: &dyn Accelerator, ray: &BoxRay, boxes: &[Aabb], context: &str) {
    let mut seen = vec![false; boxes.len()];
    a.traverse(ray, &mut Counters::default(), &mut |items, _| {
        for &item in items {
            seen[item as usize] = true;
        }
        f64::INFINITY
    });
    for item in boxes_hit(ray, boxes).keys() {
        assert!(seen[*item as usize], "{context}: the walk does not come to item {item}");
    }
}

fn finds_the_nearest_under_a_shrinking_limit(
    a: &dyn Accelerator,
    ray: &BoxRay,
    boxes: &[Aabb],
    context: &str,
) {
    let mut nearest = f64::INFINITY;
    a.traverse(ray, &mut Counters::default(), &mut |items, _| {
        for &item in items {
            if let Some((t, _)) = ray.enter_exit(&boxes[item as usize]) {
                nearest = nearest.min(t);
            }
        }
        nearest
    });
    let expected = boxes_hit(ray, boxes).values().fold(f64::INFINITY, |a, &b| a.min(b));
    assert_eq!(nearest, expected, "{context}: not the nearest");
}
