//! Bodies of many leaves: rays that are cast at them together find what single rays find.

use super::*;
use crate::prelude::{Object, Shape};
use crate::query::Scope;
use crate::query::batch::RowsOfSix;

/// Solids of all kinds of kernels in a block. Some lie on a grid, where faces and edges coincide, and some occur twice.
fn solids(random: &mut Random, count: usize) -> Vec<Shape> {
    let on_grid = |random: &mut Random| Vec3::from([0; 3].map(|_| 0.25 * random.below(8) as f64 - 1.0));
    let mut solids: Vec<Shape> = Vec::new();
    for _ in 0..count {
        let at = if random.below(2) == 0 { on_grid(random) } else { random.point(-1.0, 1.0) };
        let solid = match random.below(7) {
            0 => Shape::cuboid([0.0; 3], [0.25, 0.5, 0.25]).expect("a box"),
            1 => Shape::cylinder(0.125, 0.0, 0.5).expect("a cylinder"),
            2 => Shape::torus(0.2, 0.1).expect("a torus"),
            3 => Shape::halfspace([0.3, 0.2, 1.0], -0.9).expect("a half-space"),
            4 => Shape::cone(0.2, 0.0, 0.0, 0.4).expect("a cone"),
            5 if !solids.is_empty() => {
                solids.push(solids[0].clone());
                continue;
            }
            _ => Shape::sphere(0.2).expect("a sphere"),
        };
        let turned = if random.below(3) == 0 { solid.rotate(random.point(-90.0, 90.0)) } else { solid };
        solids.push(turned.translate(at));
    }
    solids
}

/// A body of one chain of operations, or of operations in two levels.
fn body(random: &mut Random) -> Shape {
    let block = || Shape::cuboid([-1.0; 3], [1.0; 3]).expect("a box");
    let count = [9, 20, 60][random.below(3)];
    let parts = solids(random, count);
    match random.below(4) {
        0 => Shape::union(parts),
        1 => block().difference(parts),
        2 => {
            let halves = parts.split_at(count / 2);
            Shape::union([block().difference(halves.0.to_vec()), Shape::union(halves.1.to_vec())])
        }
        _ => {
            let halves = parts.split_at(count / 2);
            Shape::intersection([block(), Shape::union(halves.0.to_vec())]).difference(halves.1.to_vec())
        }
    }
}

/// Pencils, grids along an axis, some of them in the planes of faces, and rays that run anywhere.
fn some_rays(random: &mut Random) -> Vec<[f64; 6]> {
    let mut rays = Vec::new();
    for _ in 0..8 {
        let (axis, step) = (random.below(3), [0.125, 0.01][random.below(2)]);
        let tilt = [Vec3::ZERO, random.point(-1e-3, 1e-3), random.point(-0.3, 0.3)][random.below(3)];
        let corner = Vec3::from([0; 3].map(|_| 0.25 * random.below(9) as f64 - 1.0));
        let back = [6.0, 0.5, 0.0][random.below(3)];
        for i in 0..40 {
            let d = Vec3::AXES[axis] + tilt;
            let o = corner + Vec3::AXES[(axis + 1) % 3] * (step * f64::from(i)) - d * back;
            rays.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        }
    }
    for _ in 0..60 {
        let (o, to) = (random.direction() * [6.0, 0.5][random.below(2)], random.point(-1.0, 1.0));
        rays.push([o.x, o.y, o.z, to.x - o.x, to.y - o.y, to.z - o.z]);
    }
    rays
}

#[test]
fn rays_cast_together_at_bodies_of_many_leaves_find_what_single_rays_find() {
    let mut random = Random::new(71);
    let (mut hits, mut in_lanes) = (0, 0);
    for case in 0..60 {
        let shapes: Vec<Shape> = (0..1 + random.below(3)).map(|_| body(&mut random)).collect();
        let objects = (0..[1, 3, 12][random.below(3)]).map(|i| {
            let shape = shapes[random.below(shapes.len())].clone();
            let at = random.point(-2.0, 2.0) * f64::from(u8::from(i > 0));
            Object::new(format!("part {i}"), shape.rotate(Vec3::splat(30.0 * f64::from(i))).translate(at))
        });
        let Ok(world) = compile(&Scene::of(objects.collect::<Vec<_>>()), Options::default()) else {
            continue;
        };
        in_lanes += usize::from(world.casts_lanes());
        let mut rays = some_rays(&mut random);
        if case % 3 == 2 {
            random.shuffle(&mut rays);
        }
        let rays = RowsOfSix(&rays);
        let counters = Default::default();
        let run = Run { threads: 1, ..Run::default() };
        // Rays are cast one by one where work is counted.
        let runs = [run, Run { counters: Some(&counters), ..run }];
        let short = Span::new(-0.5, 6.25).expect("a span");
        for scope in [Span::FORWARD.into(), short.into(), Scope::surfaces(Span::FORWARD)] {
            // As text, so that NaN normals are equal.
            let [found, expected] = runs.map(|run| {
                [
                    format!("{:?}", batch::closest(&world, &rays, scope, run)),
                    format!("{:?}", batch::any(&world, &rays, scope, run)),
                    format!("{:?}", batch::count(&world, &rays, scope, run)),
                    format!("{:?}", batch::crossings(&world, &rays, scope, run)),
                    format!("{:?}", batch::segments(&world, &rays, scope.span, Overlaps::All, run)),
                ]
            });
            for (query, (found, expected)) in found.iter().zip(&expected).enumerate() {
                assert!(found == expected, "case {case}, query {query}, {scope:?}");
            }
            hits += batch::crossings(&world, &rays, scope, run).expect("within limits").t.len();
        }
    }
    assert!(hits > 50_000 && in_lanes > 50, "{hits} hits, {in_lanes} worlds in lanes");
}
