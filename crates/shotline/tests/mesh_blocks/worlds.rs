//! Random worlds with meshes beside solids, in combinations with them, and in groups of instances.

use std::sync::Arc;

use shotline::math::{Affine, Vec3};
use shotline::prelude::*;
use shotline::testkit::random::Random;

use super::cases::{Placed, compile_both};
use super::meshes::Family;
use super::rays::Targets;

/// A shape, with triangles at which rays are aimed.
struct Part {
    shape: Shape,
    triangles: Vec<[Vec3; 3]>,
}

impl Part {
    fn moved(&self, transform: Affine) -> Part {
        if transform.is_identity() {
            return Part { shape: self.shape.clone(), triangles: self.triangles.clone() };
        }
        let triangles = self.triangles.iter().map(|corners| corners.map(|v| transform.point(v)));
        Part { shape: self.shape.transform(transform), triangles: triangles.collect() }
    }

    fn of(parts: Vec<Part>, combine: impl FnOnce(Vec<Shape>) -> Shape) -> Part {
        let (mut shapes, mut triangles) = (Vec::new(), Vec::new());
        for part in parts {
            shapes.push(part.shape);
            triangles.extend(part.triangles);
        }
        Part { shape: combine(shapes), triangles }
    }
}

fn transform(random: &mut Random) -> Affine {
    let shift = Affine::translation(random.point(-0.7, 0.7));
    match random.below(6) {
        0 | 1 => Affine::IDENTITY,
        // Flush with what is not moved.
        2 => Affine::translation(Vec3::AXES[random.below(3)]),
        3 => shift,
        4 => Affine::scaling(Vec3::new(-1.0, 0.5, 2.0)),
        _ => shift.then_after(&Affine::rotation_xyz(random.point(-180.0, 180.0))),
    }
}

fn mesh(families: &[Family], random: &mut Random) -> Option<Part> {
    let mesh = Arc::new(families[random.below(families.len())].mesh(random));
    let corners = mesh.faces.iter().map(|f| f.map(|v| mesh.vertices[v as usize]));
    let triangles = corners.filter(|corners| corners.iter().all(|v| v.is_finite())).collect();
    Some(Part { shape: Shape::triangles(mesh.clone()).ok()?, triangles })
}

/// A solid, without triangles.
fn solid(random: &mut Random) -> Option<Part> {
    let shape = match random.below(6) {
        0 => Shape::sphere(0.4),
        1 | 2 => Shape::cuboid([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]),
        3 => Shape::cylinder(0.3, -0.5, 0.5),
        4 => Shape::torus(0.4, 0.1),
        _ => Shape::halfspace([0.0, 0.0, 1.0], 0.25),
    };
    Some(Part { shape: shape.ok()?, triangles: Vec::new() })
}

fn part(depth: usize, families: &[Family], random: &mut Random) -> Option<Part> {
    let part = match random.below(if depth == 0 { 4 } else { 8 }) {
        0..3 => mesh(families, random)?,
        3 => solid(random)?,
        _ => {
            let count = 2 + random.below(2);
            let mut args = Vec::new();
            for _ in 0..count {
                args.push(part(depth - 1, families, random)?);
            }
            if random.below(4) == 0 {
                // An operand twice: all its faces coincide.
                let again = args[0].moved(Affine::IDENTITY);
                args.push(again);
            }
            let op = random.below(3);
            Part::of(args, |shapes| match op {
                0 => Shape::union(shapes),
                1 => Shape::intersection(shapes),
                _ => shapes[0].difference(shapes[1..].iter().cloned()),
            })
        }
    };
    Some(part.moved(transform(random)))
}

/// A world of a few objects: parts, and groups of instances of parts. `None` if it is refused.
pub fn random_world(families: &[Family], random: &mut Random) -> Option<Placed> {
    let mut shared = Vec::new();
    for _ in 0..2 {
        shared.push(part(2, families, random)?);
    }
    let (mut objects, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..1 + random.below(4) {
        let mut object = if random.below(2) == 0 {
            let count = 1 + random.below(6);
            let instances = (0..count).map(|_| shared[random.below(2)].moved(transform(random)));
            Part::of(instances.collect(), Shape::group)
        } else {
            part(2, families, random)?
        };
        if random.below(3) == 0 {
            let copies = [Affine::IDENTITY, transform(random)].map(|affine| object.moved(affine));
            object = Part::of(copies.into(), Shape::group);
        }
        triangles.extend(object.triangles);
        objects.push(Object::new(format!("object {i}"), object.shape).priority(random.below(2) as i32));
    }
    let (world, brute) = compile_both(objects, triangles.len())?;
    let targets = Targets::of(triangles);
    (!targets.triangles.is_empty()).then(|| Placed { world, brute, targets, what: "a random world".into() })
}
