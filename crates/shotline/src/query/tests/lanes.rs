//! Rays that are cast in lanes find what single rays find.

use super::*;
use crate::prelude::{Object, Shape};
use crate::query::Scope;
use crate::query::batch::RowsOfSix;
use crate::solid::{KINDS, Params};

/// A solid of any kind, or a box on a grid: then faces coincide.
fn solid(random: &mut Random) -> Shape {
    let on_grid = |random: &mut Random| f64::from(random.below(5) as i32 - 2) * 0.5;
    match random.below(3) {
        0 => {
            let low = [0; 3].map(|_| on_grid(random));
            let high = low.map(|x| x + 0.5 * (1 + random.below(3)) as f64);
            Shape::cuboid(low, high).expect("a box")
        }
        1 => {
            let z = on_grid(random);
            Shape::cylinder([0.5, 1.0][random.below(2)], z, z + 1.0).expect("a cylinder")
        }
        _ => {
            let kind = KINDS[random.below(KINDS.len())];
            let values: Vec<&[f64]> = kind.examples[0].to_vec();
            Shape::solid(kind, Params::of(kind, &values)).expect("an example")
        }
    }
}

/// A combination of a few solids.
fn body(random: &mut Random) -> Shape {
    let mut shape = solid(random);
    for _ in 0..[0, 0, 1, 2, 4][random.below(5)] {
        let mut other = solid(random);
        if random.below(2) == 0 {
            other = other.translate([0.5 * random.below(3) as f64, 0.0, 0.5]);
        }
        if random.below(4) == 0 {
            other = other.rotate(random.point(-90.0, 90.0));
        }
        shape = match random.below(4) {
            0 => Shape::union([shape, other]),
            1 => Shape::intersection([shape, other]),
            _ => shape.difference([other]),
        };
    }
    shape
}

fn scene(random: &mut Random) -> Scene {
    let parts: Vec<Shape> = (0..4).map(|_| body(random)).collect();
    let group = Shape::group(parts[..2].iter().map(|part| part.translate(random.point(-2.0, 2.0))));
    let count = [2, 6, 30][random.below(3)];
    let objects = (0..count).map(|i| {
        let part = if random.below(5) == 0 { group.clone() } else { parts[random.below(4)].clone() };
        let part = match random.below(3) {
            0 => part,
            1 => part.translate([0.5 * random.below(9) as f64 - 2.0, 0.0, 0.5]),
            _ => part.rotate(random.point(-90.0, 90.0)).translate(random.point(-3.0, 3.0)),
        };
        Object::new(format!("part {i}"), part)
    });
    Scene::of(objects.collect::<Vec<_>>())
}

/// Grids of rays along an axis or almost, some of them in the planes of faces; pencils; and rays that run anywhere.
fn rays(random: &mut Random) -> Vec<[f64; 6]> {
    let mut rays = Vec::new();
    for _ in 0..12 {
        let (axis, step) = (random.below(3), [0.125, 0.02, 0.011][random.below(3)]);
        let tilt = [Vec3::ZERO, random.point(-1e-3, 1e-3), random.point(-0.3, 0.3)][random.below(3)];
        let corner = Vec3::from([0; 3].map(|_| 0.5 * random.below(9) as f64 - 2.0));
        let back = [6.0, 0.5, 0.0][random.below(3)];
        for i in 0..40 {
            let mut d = Vec3::AXES[axis] + tilt;
            let o = corner + Vec3::AXES[(axis + 1) % 3] * (step * f64::from(i)) - d * back;
            if random.below(40) == 0 {
                d = -d;
            }
            rays.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        }
    }
    for _ in 0..70 {
        let (o, to) = (random.direction() * 6.0, random.point(-2.0, 2.0));
        rays.push([o.x, o.y, o.z, to.x - o.x, to.y - o.y, to.z - o.z]);
    }
    rays
}

/// Compares the answers of all queries with those of single rays. Returns the number of crossings.
fn compare(world: &World, rays: &[[f64; 6]], case: usize) -> usize {
    let rays = RowsOfSix(rays);
    let counters = Default::default();
    let run = Run { threads: 1, ..Run::default() };
    // Rays are cast one by one where work is counted.
    let runs = [run, Run { counters: Some(&counters), ..run }];
    let [short, back] = [(2.0, 6.5), (-3.0, 4.0)].map(|(a, b)| Span::new(a, b).expect("a span"));
    let mut hits = 0;
    for scope in [Span::FORWARD.into(), short.into(), back.into(), Scope::surfaces(Span::FORWARD)] {
        // As text, so that NaN normals are equal.
        let [found, expected] = runs.map(|run| {
            [
                format!("{:?}", batch::closest(world, &rays, scope, run)),
                format!("{:?}", batch::any(world, &rays, scope, run)),
                format!("{:?}", batch::count(world, &rays, scope, run)),
                format!("{:?}", batch::crossings(world, &rays, scope, run)),
                format!("{:?}", batch::segments(world, &rays, scope.span, Overlaps::All, run)),
            ]
        });
        for (query, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(found == expected, "case {case}, query {query}, {scope:?}");
        }
        hits += batch::crossings(world, &rays, scope, run).expect("within limits").t.len();
    }
    hits
}

#[test]
fn rays_in_lanes_find_what_single_rays_find() {
    let mut random = Random::new(47);
    let (mut hits, mut in_lanes, mut in_waves) = (0, 0, 0);
    for case in 0..100 {
        let scene = scene(&mut random);
        let Ok(world) = compile(&scene, Options::default()) else { continue };
        in_lanes += usize::from(world.casts_lanes());
        let mut rays = rays(&mut random);
        if case % 2 == 1 {
            // Rays that do not run close together are cast in waves, unless there are few bodies.
            random.shuffle(&mut rays);
            in_waves += usize::from(world.casts_waves() && world.root().placements.len() > 8);
        }
        hits += compare(&world, &rays, case);
    }
    assert!(
        hits > 70_000 && in_lanes > 70 && in_waves > 10,
        "{hits} hits, {in_lanes} worlds in lanes, {in_waves} in waves"
    );
}

/// A combination of one of a few forms: the kinds of its solids and what is done with them are the same, their sizes and places
/// are not. Some operands lie apart from the others, so that they never matter.
fn of_form(form: usize, random: &mut Random) -> Shape {
    let size = |random: &mut Random| [0.25, 0.5, 0.75, 1.0][random.below(4)];
    let place = |random: &mut Random| Vec3::from([0; 3].map(|_| [0.0, 0.25, 0.5, 9.0][random.below(4)]));
    let block =
        Shape::cuboid([0.0; 3], [0; 3].map(|_| size(random))).expect("a box").translate(place(random));
    let pin = Shape::cylinder(size(random), 0.0, 1.0).expect("a cylinder").translate(place(random));
    let ball = Shape::sphere(size(random)).expect("a ball").rotate(random.point(-90.0, 90.0));
    match form {
        0 => block.difference([pin]),
        1 => Shape::intersection([block, ball]),
        2 => Shape::union([pin, ball]).difference([block]),
        _ => pin.difference([Shape::union([block, ball])]),
    }
}

#[test]
fn bodies_of_one_form_are_cast_together_as_each_alone() {
    let mut random = Random::new(48);
    let (mut hits, mut shared) = (0, 0);
    for case in 0..30 {
        let objects = (0..24).map(|i| {
            let part = of_form([random.below(4), case % 4][i % 2], &mut random);
            Object::new(format!("part {i}"), part.translate(random.point(-2.0, 2.0)))
        });
        let scene = Scene::of(objects.collect::<Vec<_>>());
        let world = compile(&scene, Options::default()).expect("a world");
        let mut groups: Vec<u32> = (0..24).map(|body| world.lane_group(body)).collect();
        groups.sort_unstable();
        groups.dedup();
        shared += 24 - groups.len();
        let mut rays = rays(&mut random);
        random.shuffle(&mut rays);
        hits += compare(&world, &rays, case);
    }
    assert!(hits > 50_000 && shared > 30 * 18, "{hits} hits, {shared} bodies share a group");
}

/// A crossing that is known so badly that it reaches over the end of the span: what begins behind the end is not one event
/// with it. (The ray runs almost in a face.)
#[test]
fn what_begins_behind_the_span_of_a_bundle_does_not_count() {
    let block = Shape::cuboid([-1.0, 0.0, -0.5], [2.0, 1.0, 1.5]).expect("a box");
    let pin = Shape::sphere(0.01).expect("a ball");
    let pins = (0..9).map(|i| pin.translate([0.1 * f64::from(i), 0.5, 1.0]));
    let body = block.difference(pins).translate([0.0, 0.0, -0.5]);
    let world = compile(&Scene::of([Object::new("part", body)]), Options::default()).expect("a world");
    let rays = [[1.23, 0.06, -1.0, 0.0, -1.0, 1e-16]; 8];
    let counters = Default::default();
    let run = Run { threads: 1, ..Run::default() };
    let span = Span::new(-1.0, 1e-323).expect("a span");
    let [found, expected] = [run, Run { counters: Some(&counters), ..run }]
        .map(|run| batch::crossings(&world, &RowsOfSix(&rays), Scope::surfaces(span), run).expect("few"));
    assert_eq!((found.t.len(), found.t), (8, expected.t));
}
