//! The closest crossing is the first of all crossings, also where bodies touch: there a boundary may lie before the box of
//! its body, by rounding.

use super::*;
use crate::prelude::{Object, Shape};
use crate::query::Scope;
use crate::query::batch::RowsOfSix;

/// A coordinate near zero, so that crossings there are one event, or nearly.
fn near_zero(random: &mut Random) -> f64 {
    f64::from(random.below(24) as i32 - 4) * [0.5, 1.0, 3.0, 8.0][random.below(4)] * f64::EPSILON
}

/// A box, a ball or a half-space with a surface near the plane `x = 0`, on either side of it.
fn solid(random: &mut Random) -> Shape {
    let x = near_zero(random);
    let edge = [-1.0, -0.3, 0.0][random.below(3)];
    match random.below(8) {
        0 => Shape::sphere(0.5).expect("a sphere").translate([0.5 + x, 0.0, 0.0]),
        1 => Shape::halfspace([-1.0, 0.0, 0.0], -x).expect("a half-space"),
        2 | 3 => Shape::cuboid([-1.0, edge, -1.0], [x, 1.0, 1.0]).expect("a box"),
        4 => Shape::cuboid([x, edge, -1.0], [x + near_zero(random).abs() + 1e-16, 1.0, 1.0]).expect("a box"),
        _ => Shape::cuboid([x, edge, -1.0], [1.0, 1.0, 1.0]).expect("a box"),
    }
}

/// A combination of a few solids.
fn body(random: &mut Random) -> Shape {
    let mut body = solid(random);
    for _ in 0..[0, 1, 1, 3, 6][random.below(5)] {
        let other = solid(random);
        body = match random.below(3) {
            0 => Shape::union([body, other]),
            1 => Shape::intersection([body, other]),
            _ => body.difference([other]),
        };
    }
    body
}

/// Bodies that nearly touch, alone or in groups, some moved by little.
fn scene(random: &mut Random, frame: &Affine) -> Scene {
    let mut bodies = (0..2 + random.below(6)).map(|_| body(random)).collect::<Vec<_>>();
    for body in &mut bodies {
        if random.below(3) == 0 {
            *body = body.translate([near_zero(random), 0.0, 0.0]);
        }
    }
    let size = 1 + random.below(3);
    let shapes = bodies.chunks(size).map(|some| Shape::group(some.to_vec()).transform(*frame));
    Scene::of(shapes.enumerate().map(|(i, shape)| Object::new(format!("part {i}"), shape)))
}

/// A ray towards the plane `x = 0`, at any angle, or that begins on it.
fn ray(random: &mut Random, frame: &Affine) -> [f64; 6] {
    let tilt = [0.0, 1e-9, 1e-3, 1.0, 30.0][random.below(5)];
    let d = (Vec3::X + random.point(-1.0, 1.0) * tilt) * random.number(0.1, 3.0);
    let target = Vec3::new(0.0, random.number(-0.4, 0.4), random.number(-0.4, 0.4));
    let o = target - d * [0.0, 0.3, 1.0, 8.0][random.below(4)];
    let (o, d) = (frame.point(o), frame.vector(d));
    [o.x, o.y, o.z, d.x, d.y, d.z]
}

/// A boundary before the box of its body, behind a boundary of another body, was not found.
#[test]
fn the_closest_crossing_is_the_first_where_bodies_touch() {
    let (mut random, mut hits) = (Random::new(71), 0);
    for _ in 0..400 {
        let turn = [Vec3::ZERO, random.point(-180.0, 180.0)][random.below(2)];
        let away = [Vec3::ZERO, random.point(-9.0, 9.0)][random.below(2)];
        let frame = Affine::translation(away).then_after(&Affine::rotation_xyz(turn));
        let world = world(&scene(&mut random, &frame), ["bvh", "brute", "grid"][random.below(3)]);
        let rays: Vec<_> = (0..64).map(|_| ray(&mut random, &frame)).collect();
        let from = if random.below(2) == 0 { 0.0 } else { random.number(-1.0, 1.0) };
        let span = Span::new(from, f64::INFINITY).expect("a span");
        let scope = [Scope::from(span), Scope::surfaces(span)][random.below(2)];
        let (mut caster, mut all) = (Caster::new(&world), Vec::new());
        let run = Run { threads: 1, ..Run::default() };
        let batch = batch::closest(&world, &RowsOfSix(&rays), scope, run).expect("within limits");
        for (row, [ox, oy, oz, dx, dy, dz]) in rays.iter().copied().enumerate() {
            let ray = Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz)).expect("a ray");
            all.clear();
            caster.crossings(&ray, scope, &mut all).expect("within limits");
            let closest = caster.closest(&ray, scope).expect("within limits");
            // As text, so that NaN normals are equal.
            assert_eq!(format!("{closest:?}"), format!("{:?}", all.first()), "{scope:?}");
            assert_eq!(batch.t[row], closest.map_or(f64::INFINITY, |hit| hit.t));
            hits += all.len().min(1);
        }
    }
    assert!(hits > 20_000, "{hits}");
}

/// Two caps that a line grazes are one event, before the box of their body by more than the share of the way.
#[test]
fn the_closest_crossing_is_the_first_where_a_line_grazes_caps() {
    let outer = Shape::cylinder(1.0, -0.9999999999999999, 1.0000000000000018).expect("a cylinder");
    let other = Shape::cylinder(1.0, -0.9999999999999994, 1.0000000000000002).expect("a cylinder");
    let bowl = Shape::paraboloid(1.0000000000000009, -1.0, 1.0000000000000027).expect("a paraboloid");
    let both = Shape::group([outer, Shape::intersection([other, bowl])]).translate([
        0.0,
        0.0,
        6.661338147750939e-16,
    ]);
    let world = world(&Scene::of([Object::new("part", both)]), "bvh");
    let ray = [-1.7499999999999998, -0.499999998, 1.000000002, 0.9999999999999999, -1e-9, -1e-9];
    let run = Run { threads: 1, ..Run::default() };
    let rays = RowsOfSix(&[ray; 5]);
    let all = batch::crossings(&world, &rays, Span::FORWARD, run).expect("within limits");
    let closest = batch::closest(&world, &rays, Span::FORWARD, run).expect("within limits");
    assert_eq!(closest.t, [all.t[0]; 5]);
}
