//! Random cases: a world of a few placed meshes, rays and a scope.

use std::sync::Arc;

use shotline::math::{Affine, Vec3};
use shotline::prelude::*;
use shotline::query::{Kinds, Scope};
use shotline::solid::mesh::TriangleMesh;
use shotline::testkit::random::Random;

use super::compare::{compare, some_hits};
use super::meshes::{Coordinates, Family};
use super::rays::{Targets, shuffle, span};
use super::worlds::random_world;

/// A world, with its triangles in world coordinates.
pub struct Placed {
    pub world: World,
    /// The same without accelerators.
    pub brute: World,
    pub targets: Targets,
    pub what: String,
}

/// The transform of a placement, for a mesh with a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transform {
    Identity,
    Moved,
    Turned,
    Mirrored,
    Extreme,
}

impl Transform {
    pub fn any(random: &mut Random) -> Transform {
        use Transform::{Extreme, Identity, Mirrored, Moved, Turned};
        [Identity, Identity, Identity, Moved, Turned, Mirrored, Extreme][random.below(7)]
    }

    fn affine(self, random: &mut Random, size: f64) -> Affine {
        let turn = Affine::rotation_xyz(random.point(-180.0, 180.0));
        let shift = Affine::translation(random.point(-0.5, 0.5) * size);
        match self {
            Transform::Identity => Affine::IDENTITY,
            Transform::Moved => shift,
            Transform::Turned => shift.then_after(&turn.then_after(&Affine::scaling(random.point(0.3, 2.0)))),
            Transform::Mirrored => shift.then_after(&Affine::scaling(Vec3::new(-1.0, 1.0, 1.0))),
            Transform::Extreme => {
                let scale = Vec3::new(1e-6, 1.0, 1e5) * 10f64.powf(random.number(-9.0, 9.0));
                turn.then_after(&Affine::scaling(scale))
            }
        }
    }
}

/// Places meshes. Returns `None` if the scene is refused.
pub fn place(meshes: &[(Arc<TriangleMesh>, Affine)], what: String) -> Option<Placed> {
    let mut triangles = Vec::new();
    let mut objects = Vec::new();
    for (i, (mesh, transform)) in meshes.iter().enumerate() {
        let corners = mesh.faces.iter().map(|f| f.map(|v| transform.point(mesh.vertices[v as usize])));
        triangles.extend(corners.filter(|corners| corners.iter().all(|v| v.is_finite())));
        let shape = Shape::triangles(mesh.clone()).ok()?;
        let shape = if transform.is_identity() { shape } else { shape.transform(*transform) };
        objects.push(Object::new(format!("mesh {i}"), shape));
    }
    let (world, brute) = compile_both(objects, triangles.len())?;
    (!triangles.is_empty()).then(|| Placed { world, brute, targets: Targets::of(triangles), what })
}

/// A world of objects, and the same without accelerators. `None` if it is refused.
pub fn compile_both(objects: Vec<Object>, triangles: usize) -> Option<(World, World)> {
    let mut scene = Scene::of(objects);
    // Some with triangles in several leaves.
    scene.accel = [None, Some("bvh_best")][triangles / 4 % 2];
    let world = scene.compile().ok()?;
    scene.accel = Some("brute");
    Some((world, scene.compile().ok()?))
}

/// A world of one mesh of a family, placed `count` times; some of the placements coincide.
pub fn world_of(
    family: Family,
    coordinates: Coordinates,
    transform: Transform,
    count: usize,
    random: &mut Random,
) -> Option<Placed> {
    let mut mesh = family.mesh(random);
    coordinates.apply(&mut mesh);
    let mesh = Arc::new(mesh);
    let size = coordinates.scale;
    let mut placed: Vec<(Arc<TriangleMesh>, Affine)> = Vec::new();
    for i in 0..count {
        let affine = match placed.last() {
            Some((_, last)) if random.below(3) == 0 => *last,
            _ if i == 0 => transform.affine(random, size),
            _ => Transform::any(random).affine(random, size),
        };
        placed.push((mesh.clone(), affine));
    }
    place(&placed, format!("{family:?} {coordinates:?} {transform:?} x {count}"))
}

/// Casts `n` rays at a world. The description of the first difference is an error.
pub fn cast(placed: &Placed, n: usize, threads: usize, random: &mut Random) -> Result<(), String> {
    let targets = &placed.targets;
    let is_coherent = random.below(4) == 0;
    let mut rays = if is_coherent { targets.coherent(random, n) } else { targets.rays(random, n) };
    if random.below(4) == 0 {
        shuffle(&mut rays, random);
    }
    cast_rays(placed, &rays, threads, random)
}

/// The same for rays that begin in the box of the triangles. The first block of them makes the cells that decide where
/// later ones begin.
pub fn cast_from_within(
    placed: &Placed,
    n: usize,
    threads: usize,
    random: &mut Random,
) -> Result<(), String> {
    let rays = placed.targets.rays_from_within(random, n);
    cast_rays(placed, &rays, threads, random)
}

fn cast_rays(placed: &Placed, rays: &[Ray], threads: usize, random: &mut Random) -> Result<(), String> {
    let Placed { world, what, .. } = placed;
    let kinds = [Kinds::All, Kinds::Surfaces][random.below(2)];
    let hits = some_hits(world, rays, Span::FORWARD.into());
    let scope = Scope { span: span(random, &hits), kinds };
    let n = rays.len();
    compare(placed, rays, scope, threads)
        .map_err(|difference| format!("{what}, {n} rays, {scope:?}, {threads} threads: {difference}"))
}

/// A random case of a world of any kind. `Ok(false)` if its scene is refused.
pub fn any_world(seed: u64, families: &[Family], n: usize) -> Result<bool, String> {
    let mut random = Random::new(seed);
    let Some(placed) = random_world(families, &mut random) else { return Ok(false) };
    for threads in [1, 1, 2] {
        cast(&placed, n, threads, &mut random).map_err(|what| format!("seed {seed}: {what}"))?;
    }
    Ok(true)
}

/// A random case. `Ok(false)` if its scene is refused.
pub fn any(seed: u64, families: &[Family], n: usize) -> Result<bool, String> {
    let mut random = Random::new(seed);
    let family = families[random.below(families.len())];
    let coordinates = Coordinates::any(&mut random);
    let (transform, count) = (Transform::any(&mut random), [1, 1, 1, 2, 4][random.below(5)]);
    let Some(placed) = world_of(family, coordinates, transform, count, &mut random) else { return Ok(false) };
    for _ in 0..3 {
        cast_from_within(&placed, n, 1, &mut random).map_err(|what| format!("seed {seed}: {what}"))?;
        cast(&placed, n, 1, &mut random).map_err(|what| format!("seed {seed}: {what}"))?;
    }
    Ok(true)
}
