//! The suite that every accelerator passes.

use std::collections::BTreeMap;

use super::random::Random;
use crate::aabb::{Aabb, BoxRay};
use crate::accel::{self, Accelerator, Offer, Pending, Work};
use crate::math::Vec3;
use crate::ray::{Line, Span};

/// Runs the suite on the accelerator of a name.
///
/// # Panics
/// Where it breaks a rule, with the rule and the case.
pub fn conformance(name: &str) {
    let mut random = Random::new(7);
    for (case, boxes) in cases(&mut random) {
        let Some(structure) = accel::build(name, &boxes) else { panic!("no accelerator named {name}") };
        for (i, (line, span)) in lines(&mut random, &boxes).into_iter().enumerate() {
            let ray = BoxRay::new(&line, span);
            let context = format!("{name}, {case}, line {i}: {line:?}");
            proposes_every_box_met_in_time(&*structure, &ray, &boxes, &context);
            walks_to_every_box_met(&*structure, &ray, &boxes, &context);
            finds_the_nearest_under_a_shrinking_limit(&*structure, &ray, &boxes, &context);
        }
    }
}

fn cases(random: &mut Random) -> Vec<(&'static str, Vec<Aabb>)> {
    let mut cloud = |n: usize, size: f64| -> Vec<Aabb> {
        (0..n)
            .map(|_| {
                let p = random.point(-1.0, 1.0);
                Aabb::new(p, p + random.point(0.0, size))
            })
            .collect()
    };
    let with = |mut boxes: Vec<Aabb>, more: &[Aabb]| {
        boxes.extend(more);
        boxes
    };
    let plane = Aabb::new(Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, -1.0), Vec3::splat(f64::INFINITY));
    let far = Aabb::new(Vec3::splat(1e9), Vec3::splat(1e9 + 1.0));
    vec![
        ("no item", vec![]),
        ("one item", cloud(1, 0.5)),
        ("two items", cloud(2, 0.5)),
        ("small boxes", cloud(500, 0.05)),
        ("large boxes", cloud(200, 1.5)),
        ("points", cloud(300, 0.0)),
        ("all coincident", vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 100]),
        ("huge empty space", with(cloud(100, 0.1), &[far])),
        ("unbounded and empty boxes", with(cloud(50, 0.2), &[plane, Aabb::EVERYTHING, Aabb::EMPTY])),
        (
            "a lattice that shares faces",
            (0..216)
                .map(|i| {
                    let p = Vec3::new((i % 6) as f64, (i / 6 % 6) as f64, (i / 36) as f64);
                    Aabb::new(p, p + Vec3::ONE)
                })
                .collect(),
        ),
    ]
}

fn lines(random: &mut Random, boxes: &[Aabb]) -> Vec<(Line, Span)> {
    let short = Span::new(0.25, 1.5).expect("an interval");
    let mut out = Vec::new();
    for i in 0..60 {
        let corner = match boxes.len() {
            0 => Vec3::ZERO,
            n => boxes[random.below(n)].min,
        };
        let target = if corner.is_finite() && i % 2 == 0 { corner } else { random.point(-1.0, 1.0) };
        let o = random.point(-4.0, 4.0);
        out.push((Line::exact(o, target - o), if i % 3 == 0 { short } else { Span::FORWARD }));
    }
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut d = Vec3::splat(-0.0);
            d[axis] = sign;
            // Along faces and edges of the lattice, and through its middle.
            for o in [Vec3::ZERO, Vec3::splat(1.0), Vec3::splat(0.5), random.point(0.0, 1.0)] {
                out.push((Line::exact(o - d * 3.0, d), Span::FORWARD));
            }
        }
    }
    out
}

fn met(ray: &BoxRay, boxes: &[Aabb]) -> BTreeMap<u32, f64> {
    (0..).zip(boxes).filter_map(|(i, b)| ray.enter_exit(b).map(|(t, _)| (i, t))).collect()
}

fn proposes_every_box_met_in_time(a: &dyn Accelerator, ray: &BoxRay, boxes: &[Aabb], context: &str) {
    let mut work = Work::default();
    let mut pending: Vec<Pending> = Vec::new();
    let mut first_proposal: BTreeMap<u32, f64> = BTreeMap::new();
    a.start(ray, &mut pending, &mut work);
    while let Some(next) = pending.pop() {
        match next.what {
            Offer::Item(item) => {
                let t = first_proposal.entry(item).or_insert(next.t);
                *t = t.min(next.t);
            }
            Offer::Part(part) => a.open(part, ray, &mut pending, &mut work),
        }
    }
    for (item, enter) in met(ray, boxes) {
        match first_proposal.get(&item) {
            None => panic!("{context}: item {item}, whose box is met at {enter}, is not proposed"),
            Some(t) => assert!(*t <= enter, "{context}: item {item} proposed at {t}, after {enter}"),
        }
    }
}

fn walks_to_every_box_met(a: &dyn Accelerator, ray: &BoxRay, boxes: &[Aabb], context: &str) {
    let mut seen = vec![false; boxes.len()];
    a.walk(ray, &mut Work::default(), &mut |items, _| {
        for &item in items {
            seen[item as usize] = true;
        }
        f64::INFINITY
    });
    for item in met(ray, boxes).keys() {
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
    a.walk(ray, &mut Work::default(), &mut |items, _| {
        for &item in items {
            if let Some((t, _)) = ray.enter_exit(&boxes[item as usize]) {
                nearest = nearest.min(t);
            }
        }
        nearest
    });
    let expected = met(ray, boxes).values().fold(f64::INFINITY, |a, &b| a.min(b));
    assert_eq!(nearest, expected, "{context}: not the nearest");
}
