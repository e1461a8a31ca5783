//! Whole worlds under every accelerator: the same bits, whichever accelerator is traversed, in whatever order.

use std::sync::Arc;

use super::*;
use crate::aabb::Aabb;
use crate::accel;
use crate::outline::Outline;
use crate::scene::NodeId;
use crate::solid::mesh::shapes::{ball, sheet};
use crate::testkit::scene::random_scene;
use crate::trace::Act;

/// Runs every query on rays under every accelerator, also for bodies of few leaves. Compares the results to those of
/// the levels under `brute` and of the special cases for such bodies.
fn assert_all_accelerators_agree(scene: &Scene, rays: &[Ray], spans: &[Span], context: &str) {
    let oracle = world(scene, "brute");
    // The hints are also used in the worlds of other accelerators: a hint only determines what is tested first.
    let mut hints = [CoherenceHint::default(), CoherenceHint::default()];
    for name in accel::NAMES {
        let other = world(scene, name).reference_world(name);
        let mut caster = Caster::new(&other);
        for (i, ray) in rays.iter().enumerate() {
            // Results must not depend on whether the steps are recorded.
            if i % 2 == 0 {
                caster.record(100);
            }
            let context = format!("{context}, {name}, {ray:?}");
            let span = spans[i % spans.len()];
            let expected = crossings(&oracle, ray, span);
            let mut list = Vec::new();
            caster.crossings(ray, span, &mut list).expect("within limits");
            assert_same(&expected, &list, &context);
            let closest = caster.closest(ray, span).expect("within limits");
            assert_same(&expected[..expected.len().min(1)], closest.as_slice(), &context);
            let hinted = caster.closest_with_hint(&mut hints[0], ray, span).expect("within limits");
            assert_same(closest.as_slice(), hinted.as_slice(), &context);
            assert_eq!(caster.any(ray, span).expect("within limits"), !expected.is_empty(), "{context}");
            assert_eq!(
                caster.any_with_hint(&mut hints[1], ray, span).expect("within limits"),
                !expected.is_empty(),
                "{context}"
            );
            assert_eq!(caster.count(ray, span).expect("within limits"), expected.len() as u64, "{context}");
            assert_eq!(caster.take_trace().steps.is_empty(), i % 2 == 1);
        }
    }
}

#[test]
fn every_accelerator_gives_the_same_bits() {
    let mut random = Random::new(3);
    for case in 0..40 {
        let scene = random_scene(&mut random);
        let rays = rays(&mut random, 40);
        assert_all_accelerators_agree(&scene, &rays, &[Span::FORWARD], &format!("scene {case}"));
    }
}

/// A crowd for every accelerator: many placements of a level of many placements, a body of many leaves, meshes of
/// many triangles as leaf, operand and surface, and an unbounded solid. They have many sizes, so that items lie in
/// many cells.
pub(super) fn crowded_scene(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    let mesh = |scene: &mut Scene, mesh| scene.add(Node::Mesh { mesh: Arc::new(mesh), file: None });
    let (ball, sheet) = (mesh(&mut scene, ball(3)), mesh(&mut scene, sheet(6)));
    let sphere = scene.add_solid("sphere", &[&[1.0]]).expect("sphere");
    let block = scene.add_solid("box", &[&[-0.5; 3], &[0.5; 3]]).expect("box");
    let below: [&[f64]; 2] = [&[0.0, 0.0, 1.0], &[-0.9]];
    let ground = scene.add_solid("halfspace", &below).expect("halfspace");
    let mut placed = |scene: &mut Scene, node, size: f64| {
        let size = size * random.number(0.2, 2.0);
        let child = scene.add_transform(Affine::scaling(Vec3::splat(size)), node);
        scene.add_transform(Affine::translation(random.point(-1.0, 1.0)), child)
    };
    let members = (0..24).map(|i| placed(&mut scene, [sphere, block, ball, sheet][i % 4], 0.1)).collect();
    let crowd = scene.add(Node::Group { members });
    let members = (0..24).map(|_| placed(&mut scene, crowd, 0.3)).collect();
    let crowds = scene.add(Node::Group { members });
    let holes = (0..40).map(|i| placed(&mut scene, [sphere, ball][i % 2], 0.2));
    let args = [block].into_iter().chain(holes).collect();
    let sponge = scene.add_csg(Op::Difference, args);
    let sponge = scene.add(Node::Group { members: vec![sponge, ground] });
    scene.add_object("crowds", None, crowds);
    scene.add_object("sponge", None, sponge);
    scene
}

#[test]
fn crowds_are_the_same_to_every_accelerator() {
    let mut random = Random::new(13);
    let scene = crowded_scene(&mut random);
    let rays = rays(&mut random, 300);
    let spans = [Span::FORWARD, Span::new(0.5, 1.25).expect("an interval")];
    assert_all_accelerators_agree(&scene, &rays, &spans, "crowds");
}

/// Coherent rays are blocked by the same body, and a hint from one scene leads nowhere in another.
#[test]
fn seeds_save_the_walk_and_are_harmless_elsewhere() {
    let mut random = Random::new(15);
    let crowd = world(&crowded_scene(&mut random), "bvh");
    let mut caster = Caster::new(&crowd);
    let mut hint = CoherenceHint::default();
    let fan = |i: u32| {
        Ray::new(Vec3::new(-8.0, 0.0, 0.0), Vec3::new(1.0, 1e-4 * f64::from(i), 0.0)).expect("a ray")
    };
    assert!(
        (0..100).all(|i| caster.any_with_hint(&mut hint, &fan(i), Span::FORWARD).expect("within limits"))
    );
    let counters = caster.take_counters();
    assert_eq!(counters.hinted, 100);
    assert!(counters.hint_hits > 80, "{counters:?}");
    assert!((0..100).all(|i| caster.any(&fan(i), Span::FORWARD).expect("within limits")));
    assert!(caster.take_counters().boxes > 2 * counters.boxes, "{counters:?}");
    let small = two_boxes(0, 0.5);
    let mut caster = Caster::new(&small);
    for ray in rays(&mut random, 50) {
        assert_eq!(
            caster.any_with_hint(&mut hint.clone(), &ray, Span::FORWARD).expect("within limits"),
            caster.any(&ray, Span::FORWARD).expect("within limits")
        );
    }
}

/// A trace contains every test, every tag and every boundary, and if it is cut, how many steps are missing.
#[test]
fn traces_are_complete() {
    let mut random = Random::new(14);
    let scene = crowded_scene(&mut random);
    let rays = rays(&mut random, 100);
    for name in accel::NAMES {
        let world = world(&scene, name);
        let mut caster = Caster::new(&world);
        for ray in &rays {
            caster.take_counters();
            caster.record(usize::MAX);
            let mut hits = Vec::new();
            caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits");
            let (whole, counters) = (caster.take_trace(), caster.take_counters());
            let (mut tests, mut alone, mut saved, mut boundaries) = (0, 0, 0, 0);
            for step in &whole.steps {
                match &step.act {
                    // A mesh placed alone may be a surface: then it is not counted as a solid.
                    Act::Test { item } if item == "mesh" => alone += 1,
                    Act::Test { .. } => tests += 1,
                    Act::Saved { .. } => saved += 1,
                    Act::Run { tested, saved: by_tags, .. } => {
                        tests += tested;
                        saved += by_tags;
                    }
                    Act::Boundary { .. } | Act::Start | Act::End => boundaries += 1,
                    _ => {}
                }
            }
            assert_eq!((saved, boundaries), (counters.tags_saved, hits.len()), "{name}");
            assert!(
                tests <= counters.primitive_tests && counters.primitive_tests <= tests + alone,
                "{name}: {tests}, {counters:?}"
            );
            caster.record(10);
            caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits");
            let cut = caster.take_trace();
            assert_eq!(cut.steps, whole.steps[..whole.steps.len().min(10)]);
            assert_eq!(cut.steps.len() + cut.left_out as usize, whole.steps.len());
        }
    }
}

/// The shapes of a trace are where the ray meets them, also in the frames of shared parts.
#[test]
fn outlines_are_where_the_ray_meets_them() {
    let mut random = Random::new(18);
    let scenes = [crowded_scene(&mut random), crowded_scene(&mut random)];
    for name in accel::NAMES {
        let mut met = 0;
        for scene in &scenes {
            let world = world(scene, name);
            let mut caster = Caster::new(&world);
            for ray in rays(&mut random, 100) {
                caster.record(usize::MAX);
                match met % 2 {
                    0 => caster.crossings(&ray, Span::FORWARD, &mut Vec::new()).expect("within limits"),
                    _ => drop(caster.closest(&ray, Span::FORWARD).expect("within limits")),
                }
                for step in caster.take_trace().steps {
                    let (Some(t), Some(outline), Some(frame)) = (step.t, step.outline, step.frame) else {
                        continue;
                    };
                    let p = frame.inverse().expect("a frame").point(ray.at(t));
                    let room = 1e-9 * (1.0 + p.length());
                    let is_met = match outline {
                        Outline::Box(b) => (p - p.clamp(b.min, b.max)).length() <= room,
                        // The sphere around two siblings is not quite that of their parent, where the ray enters.
                        Outline::Sphere { centre, radius } => (p - centre).length() <= 2.0 * radius + room,
                        // A node begins at its own t, not at its plane.
                        Outline::Plane { normal, height } => normal != Vec3::ZERO && height.is_finite(),
                    };
                    assert!(is_met, "{name}: {:?} at {t} misses {outline:?}", step.act);
                    met += 1;
                }
            }
        }
        assert!(met > 100 || *name == "brute", "{name}: {met}");
    }
}

/// Each node is traversed with the accelerator that it chooses, and no result depends on it.
#[test]
fn parts_choose_their_accelerators() {
    let mut random = Random::new(16);
    let plain = crowded_scene(&mut random);
    let rays = rays(&mut random, 60);
    let lists = |scene: &Scene, accel| {
        let world = compile(scene, Options { accel }).expect("it compiles");
        let mut caster = Caster::new(&world);
        let mut hits = Vec::new();
        rays.iter().for_each(|ray| caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits"));
        (hits, caster.take_counters())
    };
    let (expected, counters) = lists(&plain, None);
    assert!(counters.cells == 0 && counters.planes == 0, "{counters:?}");
    let chosen = |choose: &dyn Fn(&mut Scene)| {
        let mut scene = plain.clone();
        choose(&mut scene);
        let (hits, counters) = lists(&scene, None);
        assert_same(&hits, &expected, "with choices");
        let (hits, everywhere) = lists(&scene, Some("bvh"));
        assert_same(&hits, &expected, "bvh everywhere");
        assert!(everywhere.cells == 0 && everywhere.planes == 0, "{everywhere:?}");
        counters
    };
    let all = |is: fn(&Node) -> bool, name: &'static str| {
        let nodes = (0..).map(NodeId).zip(&plain.nodes).filter(move |(_, node)| is(node));
        nodes.map(|(id, _)| (id, name)).collect::<Vec<_>>()
    };
    for is in [
        |n: &Node| matches!(n, Node::Mesh { .. }),
        |n: &Node| matches!(n, Node::Csg { .. }),
        |n: &Node| matches!(n, Node::Group { .. }),
    ] {
        let counters = chosen(&|scene| scene.accels.extend(all(is, "octree")));
        assert!(counters.cells > 5, "{:?} {counters:?}", all(is, "octree"));
        assert!(chosen(&|scene| scene.accels.extend(all(is, "bsp"))).planes > 5);
    }
    assert!(chosen(&|scene| scene.accel = Some("octree")).cells > 5);
    let mut scene = plain.clone();
    scene.accels.insert(NodeId(0), "tree");
    let errors = compile(&scene, Options::default()).expect_err("there is no such accelerator");
    assert!(errors[0].message.contains("'tree'") && errors[0].node == Some(NodeId(0)), "{errors:?}");
}

/// Accelerators that list an item in many cells intersect it once.
#[test]
fn tags_save_tests() {
    let mut random = Random::new(14);
    let scene = crowded_scene(&mut random);
    let rays = rays(&mut random, 100);
    let counters = |name| {
        let world = world(&scene, name);
        let mut caster = Caster::new(&world);
        rays.iter()
            .for_each(|ray| caster.crossings(ray, Span::FORWARD, &mut Vec::new()).expect("within limits"));
        caster.take_counters()
    };
    let mut overlapping = || {
        let corner = random.point(-1.0, 1.0);
        Aabb::new(corner, corner + random.point(0.1, 1.0))
    };
    let boxes: Vec<Aabb> = (0..200).map(|_| overlapping()).collect();
    let lists_twice = |name: &str| accel::build(name, &boxes).is_some_and(|accel| accel.has_duplicate_refs());
    let (most, mut saving) = (counters("brute").primitive_tests, 0);
    for name in accel::NAMES.iter().filter(|name| **name != "brute") {
        let counters = counters(name);
        assert!(counters.primitive_tests < most / 4, "{name}: {counters:?}, of {most}");
        assert!(counters.tags_saved == 0 || lists_twice(name), "{name}: {counters:?}");
        saving += usize::from(counters.tags_saved > 0);
    }
    assert!(saving >= 3, "{saving} accelerators were saved an intersection by tags");
}
