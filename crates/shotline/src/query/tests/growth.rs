//! The cost of queries for many leaves, many nested objects and many overlaps.

use super::*;
use crate::accel;
use crate::compile::Body;
use crate::csg::ProgramState;
use crate::query::{Conflict, QueryError};

/// A box with spherical holes in a lattice.
fn sponge(holes: usize) -> Scene {
    let mut scene = Scene::default();
    let block = scene.add_solid("box", &[&[0.0; 3], &[1.0; 3]]).expect("a box");
    let side = (holes as f64).cbrt().ceil();
    let hole = scene.add_solid("sphere", &[&[0.4 / side]]).expect("a sphere");
    let place = |i: usize| {
        let n = side as usize;
        (Vec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) + Vec3::splat(0.5)) / side
    };
    let holes: Vec<_> =
        (0..holes).map(|i| scene.add_transform(Affine::translation(place(i)), hole)).collect();
    let node = scene.add_csg(Op::Difference, [block].into_iter().chain(holes).collect());
    scene.add_object("sponge", None, node);
    scene
}

/// A point is tested against the leaves whose boxes contain it, not against all.
#[test]
fn membership_in_many_operands_costs_what_the_point_is_in() {
    let mut random = Random::new(61);
    let points: Vec<Vec3> = (0..300).map(|_| random.point(0.0, 1.0)).collect();
    let counters = |holes: usize| {
        let world = world(&sponge(holes), "bvh");
        let mut caster = Caster::new(&world);
        let inside = points.iter().filter(|p| {
            let mut objects = Vec::new();
            caster.contains(**p, &mut objects).expect("solids");
            !objects.is_empty()
        });
        assert!((100..300).contains(&inside.count()));
        caster.take_counters()
    };
    let (few, many) = (counters(100), counters(10_000));
    assert!(many.primitive_tests <= 3 * 300, "{many:?}");
    assert!(many.boxes + many.primitive_tests <= 3 * (few.boxes + few.primitive_tests), "{few:?} {many:?}");
}

/// Membership is the same as if every leaf were tested, also on faces, edges and corners.
#[test]
fn leaves_that_are_not_asked_would_change_nothing() {
    let mut random = Random::new(62);
    for case in 0..40 {
        let mut scene = Scene::default();
        let mut nodes = Vec::new();
        for _ in 0..12 {
            let a = Vec3::new(random.below(5) as f64, random.below(5) as f64, random.below(5) as f64);
            let b = a + Vec3::new(1.0, 2.0, 1.0 + random.below(2) as f64);
            let block = scene.add_solid("box", &[&a.to_array(), &b.to_array()]).expect("a box");
            let below: [&[f64]; 2] = [&[0.0, 1.0, 0.0], &[random.below(5) as f64]];
            let half = scene.add_solid("halfspace", &below).expect("a half-space");
            nodes.push(if random.below(6) == 0 { half } else { block });
        }
        while nodes.len() > 1 {
            let count = (2 + random.below(3)).min(nodes.len());
            let args = (0..count).map(|_| nodes.swap_remove(random.below(nodes.len()))).collect();
            nodes.push(scene.add_csg([Op::Union, Op::Intersection, Op::Difference][random.below(3)], args));
        }
        scene.add_object("all", None, nodes[0]);
        for name in accel::NAMES {
            let world = world(&scene, name);
            let mut caster = Caster::new(&world);
            for _ in 0..60 {
                let p = Vec3::new(random.below(13) as f64, random.below(13) as f64, random.below(13) as f64)
                    * 0.5;
                let mut objects = Vec::new();
                caster.contains(p, &mut objects).expect("solids");
                assert_eq!(!objects.is_empty(), held_by_all_leaves(&world, p), "case {case}, {name}, {p}");
            }
        }
    }
}

/// Membership in the only body of a world, with all leaves tested.
fn held_by_all_leaves(world: &World, p: Vec3) -> bool {
    let Body::Solid(body) = world.body(0) else { panic!("a solid") };
    let mut state = ProgramState::default();
    state.reset(&body.program);
    for (i, leaf) in (0..).zip(&body.leaves) {
        if leaf.solid.contains(leaf.local_from_body.point(p)) {
            state.toggle(&body.program, i);
        }
    }
    state.value(&body.program)
}

/// Objects along x, each from one integer to another, with priorities.
fn slabs(slabs: &[(i32, i32, i32)]) -> World {
    let mut scene = Scene::default();
    for (i, &(from, to, rank)) in slabs.iter().enumerate() {
        let corner = |x: i32, y: f64| [f64::from(x), y, y];
        let block = scene.add_solid("box", &[&corner(from, -1.0), &corner(to, 1.0)]).expect("a box");
        let id = scene.add_object(&format!("slab {i}"), None, block);
        if let Node::Object { priority, .. } = &mut scene.nodes[id.0 as usize] {
            *priority = rank;
        }
    }
    world(&scene, "bvh")
}

/// Random slabs, at most `most`, each with its ends and one of `ranks` priorities.
fn random_slabs(random: &mut Random, most: usize, ranks: usize) -> Vec<(i32, i32, i32)> {
    let slab = |random: &mut Random| {
        let from = 1 + random.below(20) as i32;
        (from, from + 1 + random.below(9) as i32, random.below(ranks) as i32)
    };
    (0..1 + random.below(most)).map(|_| slab(random)).collect()
}

fn along() -> Ray {
    Ray::new(Vec3::ZERO, Vec3::X).expect("a ray")
}

/// The owner of each interval has the highest rank among the objects that contain its centre.
#[test]
fn segments_are_owned_by_the_highest_rank() {
    let mut random = Random::new(63);
    for case in 0..200 {
        let list = random_slabs(&mut random, 12, 3);
        let world = slabs(&list);
        let mut segments = Vec::new();
        let met = Caster::new(&world).segments(&along(), Span::FORWARD, Overlaps::Priority, &mut segments);
        let owner = |t: f64| {
            let holds = |(from, to, _): &(i32, i32, i32)| f64::from(*from) < t && t < f64::from(*to);
            let held = (0..).zip(&list).filter(|(_, slab)| holds(slab));
            held.max_by_key(|(i, (_, _, rank))| (*rank, *i)).map(|(i, _)| i)
        };
        for k in 0..31 {
            let t = f64::from(k) + 0.5;
            let found = segments.iter().find(|s| s.t_in < t && t < s.t_out).map(|s| s.object);
            assert_eq!(found, owner(t), "case {case} at {t}: {list:?} {segments:?}");
        }
        let joined = segments.windows(2).all(|w| w[0].t_out < w[1].t_in || w[0].object != w[1].object);
        assert!(joined, "case {case}: {list:?} {segments:?}");
        assert!(met.is_ok());
    }
}

/// One sweep returns all overlaps: those that repeated queries for the first overlap find, each begun after the
/// last.
#[test]
fn overlaps_are_those_that_segments_refuse() {
    let mut random = Random::new(64);
    let mut some = 0;
    for case in 0..200 {
        let list = random_slabs(&mut random, 9, 2);
        let world = slabs(&list);
        let mut caster = Caster::new(&world);
        let (mut expected, mut rest) = (Vec::new(), Span::FORWARD);
        while let Err(error) = caster.segments(&along(), rest, Overlaps::Error, &mut Vec::new()) {
            let QueryError::Overlap { first, second, t_in, t_out } = error else { panic!("{error}") };
            let number =
                |name: &str| name.strip_prefix("slab ").and_then(|n| n.parse().ok()).expect("a number");
            // After the last overlap both objects may begin where the span does: then the lower number is reported
            // first.
            let (a, b): (u32, u32) = (number(&first), number(&second));
            expected.push((a.min(b), a.max(b), t_in, t_out));
            rest = Span::new(t_out, f64::INFINITY).expect("an interval");
        }
        let mut found: Vec<Conflict> = Vec::new();
        caster.conflicts(&along(), Span::FORWARD, &mut found).expect("solids");
        let pair = |o: &Conflict| (o.first.min(o.second), o.first.max(o.second), o.t_in, o.t_out);
        assert_eq!(found.iter().map(pair).collect::<Vec<_>>(), expected, "case {case}: {list:?}");
        some += found.len();
    }
    assert!(some > 200, "{some}");
}

/// Any number of objects may be nested.
#[test]
fn ten_thousand_nested_objects_have_their_segments() {
    let n = 10_000;
    let world = slabs(&(0..n).map(|i| (1 + i, 4 * n - i, 0)).collect::<Vec<_>>());
    let mut segments = Vec::new();
    let met = Caster::new(&world).segments(&along(), Span::FORWARD, Overlaps::Priority, &mut segments);
    assert_eq!(met, Ok(2 * n as u64 - 3));
    assert_eq!(segments.len(), 2 * n as usize - 1);
    assert_eq!((segments[0].t_in, segments[n as usize - 1].length), (1.0, f64::from(2 * n + 1)));
}

/// A segment ends where the owning body changes, even if the next one is of the same object.
#[test]
fn segments_of_bodies_that_abut_have_their_paths() {
    let mut scene = Scene::default();
    let block = scene.add_solid("box", &[&[0.0; 3], &[1.0; 3]]).expect("a box");
    let at = [1.0, 2.0, 3.0, 5.0].map(|x| scene.add_transform(Affine::translation(Vec3::X * x), block));
    let group = scene.add(Node::Group { members: at.to_vec() });
    scene.add_object("cells", None, group);
    let world = world(&scene, "bvh");
    let ray = Ray::new(Vec3::new(0.0, 0.5, 0.5), Vec3::X).expect("a ray");
    let paths = |overlaps| {
        let mut segments = Vec::new();
        Caster::new(&world).segments(&ray, Span::FORWARD, overlaps, &mut segments).expect("solids");
        segments.iter().map(|s| (s.t_in, s.t_out, s.path)).collect::<Vec<_>>()
    };
    assert_eq!(paths(Overlaps::Error), [(1.0, 2.0, 0), (2.0, 3.0, 1), (3.0, 4.0, 2), (5.0, 6.0, 3)]);
    assert_eq!(paths(Overlaps::All).len(), 4);
    let rows = batch::segments(&world, &[ray], Span::FORWARD, Overlaps::Error, Run::default()).expect("rows");
    assert_eq!(rows.path, [0, 1, 2, 3]);
}
