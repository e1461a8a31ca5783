//! One function for each fault that was ever found in the core, with what was wrong. Each builds the smallest scene
//! that showed it and holds the answer to a closed form.
//!
//! Faults of readers are in `shotline-io/tests/regressions.rs`, those of the Python package in
//! `python/tests/test_regressions.py`, and what the fuzzers found in `fuzz/regressions`.

use std::sync::Arc;

use shotline::prelude::*;
use shotline::solid::mesh::TriangleMesh;

#[path = "regressions/measuring.rs"]
mod measuring;
#[path = "regressions/meshes.rs"]
mod meshes;
#[path = "regressions/queries.rs"]
mod queries;
#[path = "regressions/rounding.rs"]
mod rounding;
#[path = "regressions/surfaces.rs"]
mod surfaces;

fn scene_of(shape: impl Into<Shape>) -> Scene {
    Scene::of([Object::new("it", shape)])
}

fn world_of(shape: impl Into<Shape>) -> World {
    scene_of(shape).compile().unwrap()
}

fn ray(o: impl Into<Vec3>, d: impl Into<Vec3>) -> Ray {
    Ray::new(o.into(), d.into()).unwrap()
}

/// The crossings of a ray with a world. All other queries must agree with them.
#[track_caller]
fn crossings(world: &World, ray: &Ray, span: Span) -> Vec<Hit> {
    let (mut caster, mut hits) = (Caster::new(world), Vec::new());
    caster.crossings(ray, span, &mut hits).unwrap();
    let first = caster.closest(ray, span).unwrap().map(|hit| hit.t);
    assert_eq!(first, hits.first().map(|hit| hit.t), "closest beside {hits:?}");
    assert_eq!(caster.any(ray, span), Ok(!hits.is_empty()), "any beside {hits:?}");
    assert_eq!(caster.count(ray, span), Ok(hits.len() as u64), "count beside {hits:?}");
    hits
}

/// The `t` of all crossings of a half line with a shape.
#[track_caller]
fn seen(shape: impl Into<Shape>, o: impl Into<Vec3>, d: impl Into<Vec3>) -> Vec<f64> {
    crossings(&world_of(shape), &ray(o, d), Span::FORWARD).iter().map(|hit| hit.t).collect()
}

/// The same for a scene under a rotation of which the matrix is not exact, with the ray; up to rounding.
#[track_caller]
fn seen_turned(shape: &Shape, o: impl Into<Vec3>, d: impl Into<Vec3>) -> Vec<f64> {
    let turn = Affine::rotation_xyz(Vec3::new(10.0, 20.0, 330.0));
    let list = seen(shape.transform(turn), turn.point(o.into()), turn.vector(d.into()));
    list.iter().map(|t| (t * 1e9).round() * 1e-9).collect()
}

#[track_caller]
fn assert_near(list: &[f64], expected: &[f64], tolerance: f64) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= tolerance;
    assert!(
        list.len() == expected.len() && list.iter().zip(expected).all(near),
        "{list:?}, not {expected:?}"
    );
}

/// The box between two corners as a mesh of twelve triangles.
fn brick(min: [f64; 3], max: [f64; 3]) -> TriangleMesh {
    let ends = [Vec3::from(min), Vec3::from(max)];
    let corner = |i: usize| Vec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), faces)
}

/// Meshes as one mesh, each a shell of it.
fn shells(parts: impl IntoIterator<Item = TriangleMesh>) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for part in parts {
        let first = all.vertices.len() as u32;
        all.vertices.extend(part.vertices);
        all.faces.extend(part.faces.iter().map(|face| face.map(|v| v + first)));
    }
    all
}

fn shape_of(mesh: TriangleMesh) -> Shape {
    Shape::triangles(Arc::new(mesh)).unwrap()
}

/// A tetrahedron of volume 1/6 with a corner at the origin.
fn tetrahedron() -> TriangleMesh {
    TriangleMesh::new(
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
}
