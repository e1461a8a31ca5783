//! Small casts whose instructions `bench/instructions.py` counts. The argument names one of them; without an argument, their
//! names are printed.

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::sync::Arc;

use shotline::prelude::*;
use shotline::query::batch::{self, RowsOfSix, Run};
use shotline::solid::mesh::TriangleMesh;
use shotline::testkit::random::Random;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// How the rays are cast.
#[derive(Clone, Copy)]
enum Query {
    /// One by one.
    Closest,
    Crossings,
    /// As a batch.
    ClosestBatch,
    CrossingsBatch,
}

/// The rays of a cast.
#[derive(Clone, Copy)]
enum Aim {
    /// From a sphere around the scene to points in it.
    Random,
    /// The pixels of a camera.
    Camera,
}

const RAYS: usize = 1024;

/// A name, the scene, its size, and how it is cast at.
type Cast = (&'static str, fn() -> Result<Scene>, f64, Aim, Query);

const CASTS: &[Cast] = &[
    ("box", cuboid, 1.0, Aim::Random, Query::Closest),
    ("sphere", sphere, 1.0, Aim::Random, Query::CrossingsBatch),
    ("cylinder", cylinder, 1.0, Aim::Random, Query::Crossings),
    ("cone", cone, 1.0, Aim::Camera, Query::ClosestBatch),
    ("torus", torus, 1.0, Aim::Random, Query::Crossings),
    ("four leaves", four_leaves, 1.0, Aim::Camera, Query::CrossingsBatch),
    ("eight leaves", eight_leaves, 1.0, Aim::Random, Query::Crossings),
    ("block minus 200", block_minus_200, 1.0, Aim::Random, Query::Closest),
    ("mesh, closest", mesh, 1.0, Aim::Random, Query::ClosestBatch),
    ("mesh, all", mesh, 1.0, Aim::Random, Query::CrossingsBatch),
    ("instances", instances, 4.0, Aim::Camera, Query::ClosestBatch),
    ("field, random", field, 4.0, Aim::Random, Query::ClosestBatch),
    ("field, camera", field, 4.0, Aim::Camera, Query::ClosestBatch),
];

fn alone(shape: Shape) -> Result<Scene> {
    Ok(Scene::of([Object::new("it", shape)]))
}

fn cuboid() -> Result<Scene> {
    alone(Shape::cuboid([-1.0, -0.8, -0.6], [1.0, 0.8, 0.6])?.rotate([10.0, 20.0, 30.0]))
}

fn sphere() -> Result<Scene> {
    alone(Shape::sphere(1.0)?)
}

fn cylinder() -> Result<Scene> {
    alone(Shape::cylinder(0.7, -0.9, 0.9)?)
}

fn cone() -> Result<Scene> {
    alone(Shape::cone(1.0, 0.2, -1.0, 1.0)?)
}

fn torus() -> Result<Scene> {
    alone(Shape::torus(0.9, 0.4)?)
}

/// A block with holes along two axes, cut by a sphere.
fn four_leaves() -> Result<Scene> {
    let hole = Shape::cylinder(0.4, -2.0, 2.0)?;
    let block = Shape::cuboid([-1.0; 3], [1.0; 3])?.difference([hole.clone(), hole.rotate([90.0, 0.0, 0.0])]);
    alone(Shape::intersection([block, Shape::sphere(1.3)?]))
}

/// A plate with six holes, and a boss.
fn eight_leaves() -> Result<Scene> {
    let hole = Shape::cylinder(0.15, -1.0, 1.0)?;
    let holes = (0..6).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / 6.0).sin_cos();
        hole.translate([0.7 * cos, 0.7 * sin, 0.0])
    });
    let plate = Shape::cylinder(1.0, -0.2, 0.2)?.difference(holes);
    alone(Shape::union([plate, Shape::cone(0.5, 0.3, 0.1, 0.8)?]))
}

fn block_minus_200() -> Result<Scene> {
    let mut random = Random::new(3);
    let ball = Shape::sphere(0.15)?;
    let holes = (0..200).map(|_| ball.translate(random.point(-1.0, 1.0)));
    alone(Shape::cuboid([-1.0; 3], [1.0; 3])?.difference(holes))
}

/// A ball with waves, of 2,160 triangles.
fn mesh() -> Result<Scene> {
    let (rings, sides) = (28_u32, 40_u32);
    let point = |ring: u32, side: u32| {
        let (along, around) =
            (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(side) / f64::from(sides));
        let radius = 1.0 + 0.1 * (5.0 * along).sin() * (3.0 * around).cos();
        Vec3::new(along.sin() * around.cos(), along.sin() * around.sin(), along.cos()) * radius
    };
    let mut mesh = TriangleMesh::default();
    mesh.vertices.push(point(0, 0));
    for ring in 1..rings {
        mesh.vertices.extend((0..sides).map(|side| point(ring, side)));
    }
    mesh.vertices.push(point(rings, 0));
    let last = mesh.vertices.len() as u32 - 1;
    let number = |ring: u32, side: u32| match ring {
        0 => 0,
        ring if ring == rings => last,
        ring => 1 + (ring - 1) * sides + side % sides,
    };
    for ring in 0..rings {
        for side in 0..sides {
            let [a, b] = [number(ring, side), number(ring, side + 1)];
            let [c, d] = [number(ring + 1, side), number(ring + 1, side + 1)];
            mesh.faces.extend([[a, c, d], [a, d, b]].iter().filter(|[i, j, k]| i != j && j != k && i != k));
        }
    }
    alone(Shape::triangles(Arc::new(mesh))?)
}

/// Groups of groups of a part.
fn instances() -> Result<Scene> {
    let part = Shape::cuboid([-0.3; 3], [0.3; 3])?.difference([Shape::sphere(0.35)?]);
    let grid = |part: &Shape, count: i32, pitch: f64| {
        let places = (0..count * count * count).map(|i| [i % count, i / count % count, i / count / count]);
        let middle = 0.5 * f64::from(count - 1);
        let members = places.map(|place| part.translate(place.map(|k| (f64::from(k) - middle) * pitch)));
        Shape::group(members.collect::<Vec<_>>())
    };
    let group = grid(&part, 3, 0.9).rotate([0.0, 15.0, 25.0]);
    alone(grid(&group, 3, 2.8))
}

/// Spheres in a cube.
fn field() -> Result<Scene> {
    let mut random = Random::new(7);
    let ball = Shape::sphere(0.4)?;
    let object = |i: i32| Object::new(format!("ball {i}"), ball.translate(random.point(-4.0, 4.0)));
    Ok(Scene::of((0..200).map(object).collect::<Vec<_>>()))
}

/// Rays at a scene of some size around the origin.
fn rays(aim: Aim, size: f64) -> Vec<[f64; 6]> {
    let mut random = Random::new(1);
    let row = |o: Vec3, d: Vec3| [o.x, o.y, o.z, d.x, d.y, d.z];
    match aim {
        Aim::Random => {
            let ray = |_| {
                let o = random.direction() * (4.0 * size);
                row(o, random.point(-size, size) - o)
            };
            (0..RAYS).map(ray).collect()
        }
        Aim::Camera => {
            let (side, eye) = (32_usize, Vec3::new(2.2, -3.1, 1.7) * size);
            let forward = -eye;
            let right = forward.cross(Vec3::Z).normalize() * (1.2 * size);
            let up = right.cross(forward).normalize() * (1.2 * size);
            let place = |i: usize| 2.0 * (i as f64 + 0.5) / side as f64 - 1.0;
            let ray = |i: usize| row(eye, forward + right * place(i % side) + up * place(i / side));
            (0..RAYS).map(ray).collect()
        }
    }
}

/// What is counted: the callgrind tool of valgrind collects within this function.
#[inline(never)]
fn measured(cast: &mut dyn FnMut() -> Result<usize>) -> Result<usize> {
    black_box(cast())
}

/// Casts the rays once to fill caches and memory that is reused, then once measured. Prints the number of crossings.
fn run((_, scene, size, aim, query): &Cast) -> Result<()> {
    let world = scene()?.compile()?;
    let rows = rays(*aim, *size);
    let rays = rows.iter().map(|&[a, b, c, d, e, f]| Ray::new(Vec3::new(a, b, c), Vec3::new(d, e, f)));
    let rays = rays.collect::<std::result::Result<Vec<Ray>, _>>()?;
    let (mut caster, mut hits) = (Caster::new(&world), Vec::new());
    let run = Run { threads: 1, ..Run::default() };
    let mut cast = || -> Result<usize> {
        hits.clear();
        Ok(match query {
            Query::Closest => {
                let mut found = 0;
                for ray in &rays {
                    found += usize::from(black_box(caster.closest(ray, Span::FORWARD)?).is_some());
                }
                found
            }
            Query::Crossings => {
                for ray in &rays {
                    caster.crossings(ray, Span::FORWARD, &mut hits)?;
                }
                hits.len()
            }
            Query::ClosestBatch => {
                let found = batch::closest(&world, &RowsOfSix(&rows), Span::FORWARD, run)?;
                found.t.iter().filter(|t| t.is_finite()).count()
            }
            Query::CrossingsBatch => batch::crossings(&world, &RowsOfSix(&rows), Span::FORWARD, run)?.t.len(),
        })
    };
    cast()?;
    println!("{}", measured(&mut cast)?);
    Ok(())
}

fn main() -> Result<()> {
    let Some(name) = std::env::args().nth(1) else {
        CASTS.iter().for_each(|(name, ..)| println!("{name}"));
        return Ok(());
    };
    let cast = CASTS.iter().find(|(known, ..)| *known == name).ok_or_else(|| format!("no cast '{name}'"))?;
    run(cast)
}
