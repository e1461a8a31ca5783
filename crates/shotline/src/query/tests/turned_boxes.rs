//! Levels whose boxes are in a frame of their own return what they return without.

use super::*;
use crate::compile::DynamicWorld;
use crate::prelude::{Object, Shape};
use crate::query::batch::RowsOfSix;
use crate::scene::{LocalTransform, NodeId};

/// A part, most of whose many solids are turned in the same way, placed twice.
fn planes_of_wires(random: &mut Random) -> Scene {
    let wires = [
        Shape::cylinder(0.02, -1.5, 1.5),
        Shape::cuboid([-0.02, -0.03, -1.0], [0.02, 0.03, 2.0]),
        Shape::tube(0.02, 0.04, -1.0, 1.0),
    ]
    .map(|wire| wire.expect("a wire"));
    let turn = random.point(-90.0, 90.0);
    let stretch = if random.below(3) == 0 { [1.0, 1.5, 1.0] } else { [1.0; 3] };
    let count = 20 + random.below(60);
    let wire = |i: usize, random: &mut Random| {
        let wire = wires[if random.below(4) == 0 { random.below(3) } else { 0 }].scale_axes(stretch);
        let turned =
            if random.below(12) == 0 { wire.rotate(random.point(-90.0, 90.0)) } else { wire.rotate(turn) };
        turned.translate(
            Vec3::new(0.1 * i as f64 - 2.0, 0.0, 0.05 * i as f64 - 1.0) + random.point(-0.02, 0.02),
        )
    };
    // A body of the plane itself, and a combination of many leaves that is not turned.
    let around = Shape::cuboid([-3.0; 3], [3.0; 3]).expect("a box");
    let frame = around.difference((0..12).map(|i| {
        Shape::cuboid([-4.0, -4.0, 0.5 * f64::from(i) - 3.0], [4.0, 4.0, 0.5 * f64::from(i) - 2.75])
            .expect("a slit")
    }));
    let parts = [around, frame][..random.below(3)].to_vec();
    let plane = Shape::group((0..count).map(|i| wire(i, random)).chain(parts));
    let spun = plane.rotate(random.point(-180.0, 180.0)).translate(random.point(-1.0, 1.0));
    Scene::of([Object::new("first", plane), Object::new("second", spun).priority(1)])
}

/// Rays of which many run close together, and some in the planes of the wires.
fn rows(random: &mut Random) -> Vec<[f64; 6]> {
    let row = |o: Vec3, d: Vec3| [o.x, o.y, o.z, d.x, d.y, d.z];
    let mut rows: Vec<_> = rays(random, 60).iter().map(|ray| row(ray.origin(), ray.direction())).collect();
    let (eye, target) = (random.direction() * 6.0, random.point(-1.0, 1.0));
    for i in 0..64 {
        let aside = Vec3::new(f64::from(i % 8), f64::from(i / 8), 0.0) * 0.02;
        rows.push(row(eye, target + aside - eye));
    }
    for axis in 0..3 {
        let mut d = Vec3::ZERO;
        d[axis] = 1.0;
        rows.extend((0..8).map(|_| row(random.point(-0.5, 0.5) - d * 8.0, d)));
    }
    rows
}

fn found(world: &World, rows: &[[f64; 6]]) -> String {
    let (span, run) = (Span::FORWARD, Run::default());
    let rays = RowsOfSix(rows);
    let crossings = batch::crossings(world, &rays, span, run).expect("valid rays");
    let closest = batch::closest(world, &rays, span, run).expect("valid rays");
    let segments = batch::segments(world, &rays, span, Overlaps::Priority, run).expect("solids");
    let count = batch::count(world, &rays, span, run).expect("valid rays");
    format!("{crossings:?} {closest:?} {segments:?} {count:?}")
}

#[test]
fn turned_boxes_change_no_result() {
    let mut random = Random::new(95);
    let (mut turned, mut crossings) = (0, 0);
    for case in 0..60 {
        let scene = planes_of_wires(&mut random);
        let accel = crate::accel::NAMES[case % crate::accel::NAMES.len()];
        let (own, plain) = (world(&scene, "bvh"), world(&scene, accel));
        turned += own.levels().iter().filter(|level| level.box_frame.is_some()).count();
        let plain = plain.reference_world("brute");
        assert!(plain.levels().iter().all(|level| level.box_frame.is_none()));
        let rows = rows(&mut random);
        assert_eq!(found(&own, &rows), found(&plain, &rows), "case {case}");
        for ray in rays(&mut random, 10) {
            let lists = [&own, &plain].map(|world| super::crossings(world, &ray, Span::FORWARD));
            assert_same(&lists[0], &lists[1], "alone");
            crossings += lists[0].len();
        }
    }
    assert!(turned >= 25 && crossings > 500, "{turned} {crossings}");
}

#[test]
fn wires_that_move_get_boxes_in_the_frame_of_their_level() {
    let mut random = Random::new(96);
    for _ in 0..20 {
        let scene = planes_of_wires(&mut random);
        let is_transform = |id: &NodeId| matches!(scene.node(*id), Node::Transform { .. });
        let transforms: Vec<NodeId> =
            (0..scene.nodes.len() as u32).map(NodeId).filter(is_transform).collect();
        let mut live = DynamicWorld::new(scene.clone(), Options::default()).unwrap();
        for _ in 0..3 {
            let node = transforms[random.below(transforms.len())];
            let turn = Affine::rotation_xyz(random.point(-90.0, 90.0));
            let moved = Affine::translation(random.point(-1.0, 1.0)).then_after(&turn);
            live.set(&[(node, LocalTransform::Matrix(moved))]).unwrap();
            let rebuilt = compile(live.scene(), Options::default()).unwrap();
            let rows = rows(&mut random);
            assert_eq!(found(live.world(), &rows), found(&rebuilt, &rows));
            assert_eq!(live.world().bounds(), rebuilt.bounds());
        }
    }
}
