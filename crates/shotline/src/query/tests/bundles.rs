//! Rays that traverse levels in bundles find what each of them finds alone.

use std::sync::Arc;

use super::*;
use crate::prelude::{Object, Shape};
use crate::query::Scope;
use crate::query::batch::RowsOfSix;
use crate::solid::mesh::shapes::{ball, sheet};

/// A random placement: moved, turned, stretched and mirrored.
fn placed(random: &mut Random, shape: &Shape) -> Shape {
    let factors = [Vec3::ONE, Vec3::splat(0.5), Vec3::new(-1.0, 0.7, 1.2)][random.below(3)];
    let turn = if random.below(2) == 0 { Vec3::ZERO } else { random.point(-90.0, 90.0) };
    shape.scale_axes(factors).rotate(turn).translate(random.point(-3.0, 3.0))
}

/// Groups of groups of meshes and other bodies. Some placements occur twice, so that hits have the same `t`.
fn nested(random: &mut Random) -> Scene {
    let closed = Shape::triangles(Arc::new(ball(2))).expect("a mesh");
    let open = Shape::triangles(Arc::new(sheet(4))).expect("a mesh");
    let solid = Shape::sphere(0.7).expect("a sphere");
    let cut = closed.difference([solid.translate(Vec3::X * 0.5)]);
    let mut parts = vec![closed, open, solid, cut];
    for accel in ["bvh", ["bvh", "grid", "octree"][random.below(3)], "bvh"] {
        let mut members = Vec::new();
        for _ in 0..5 {
            let part = &parts[random.below(parts.len())];
            members.push(placed(random, part));
            if random.below(3) == 0 {
                members.push(members[0].clone());
            }
        }
        parts.push(Shape::group(members).with_accel(accel));
    }
    let objects = (0..8).map(|i| {
        let part = &parts[random.below(parts.len())].clone();
        Object::new(format!("part {i}"), placed(random, part))
    });
    let mut objects: Vec<Object> = objects.collect();
    let again = objects[0].clone();
    objects.push(again);
    Scene::of(objects)
}

/// Rays that run close together, and others between them.
fn some_rays(random: &mut Random) -> Vec<[f64; 6]> {
    let mut rays = Vec::new();
    for _ in 0..25 {
        let o = if random.below(3) == 0 { random.point(-3.0, 3.0) } else { random.direction() * 12.0 };
        let mut d = random.point(-3.0, 3.0) - o;
        if random.below(4) == 0 {
            d[random.below(3)] = 0.0;
        }
        for _ in 0..[1, 3, 17, 40][random.below(4)] {
            let (o, d) = (o + random.point(-0.02, 0.02), d + random.point(-0.1, 0.1) * d.abs());
            rays.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        }
    }
    rays
}

#[test]
fn bundles_find_what_single_rays_find() {
    let mut random = Random::new(31);
    let mut hits = 0;
    for _ in 0..30 {
        let scene = nested(&mut random);
        let accel = ["bvh", "bvh", "grid", "bsp"][random.below(4)];
        let world = world(&scene, accel);
        let rays = some_rays(&mut random);
        let rays = RowsOfSix(&rays);
        let counters = Default::default();
        let run = Run { threads: 1, ..Run::default() };
        // Rays are cast one by one where work is counted.
        let runs = [run, Run { counters: Some(&counters), ..run }];
        let short = Span::new(2.0, 9.5).expect("a span");
        for scope in [Span::FORWARD.into(), Scope::from(short), Scope::surfaces(Span::FORWARD)] {
            // As text, so that NaN normals are equal.
            let [found, expected] = runs.map(|run| {
                [
                    format!("{:?}", batch::closest(&world, &rays, scope, run)),
                    format!("{:?}", batch::any(&world, &rays, scope, run)),
                    format!("{:?}", batch::count(&world, &rays, scope, run)),
                    format!("{:?}", batch::crossings(&world, &rays, scope, run)),
                ]
            });
            for (found, expected) in found.iter().zip(&expected) {
                assert!(found == expected, "{accel} {scope:?}");
            }
            hits += batch::crossings(&world, &rays, scope, run).expect("within limits").t.len();
        }
    }
    assert!(hits > 10_000, "{hits} hits");
}

/// A ray that is known so badly that all crossings of the small box are one event. Once its span was cut at the first hit
/// so far, and then another boundary came first: the result depended on the order of the bodies.
#[test]
fn the_first_crossing_does_not_depend_on_the_order_of_bodies() {
    let cube = |half: f64| Shape::cuboid([-half; 3], [half; 3]).expect("a box");
    let mesh = Shape::triangles(Arc::new(ball(1))).expect("a mesh");
    let small = Object::new("small", cube(0.5).translate([2.0, 0.0, 0.0]));
    let large = Object::new("large", cube(2.0).translate([2.0, 0.0, 0.0]));
    let half = Object::new("half", Shape::halfspace([0.0, 0.0, 1.0], 3.0).expect("a half-space"));
    let far = Object::new("far", mesh.translate([-8.0, 0.0, 0.0]));
    let near = Object::new("near", mesh.translate([1.0, 0.0, 0.0]));
    let rays = [-1e-15, -1e-18, -1e-310].map(|z| [2.0, 0.0, 0.5, -0.19, 1.03, z]);
    for objects in [vec![far, small.clone(), large], vec![small, near, half]] {
        let scene = Scene::of(objects);
        let mut expected = None;
        for accel in crate::accel::NAMES {
            let world = world(&scene, accel);
            let found = batch::closest(&world, &RowsOfSix(&rays), Span::FORWARD, Run::default());
            let found = found.expect("within limits");
            let object_and_surface = (found.object, found.surface);
            assert_eq!(expected.get_or_insert(object_and_surface.clone()), &object_and_surface, "{accel}");
        }
    }
}
