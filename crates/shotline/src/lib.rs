//! shotline finds where rays cross solids: **every** crossing, in order, entering or exiting.
//!
//! Solids are exact (quadrics, the torus, closed meshes) and combined by union, intersection and difference; a graph
//! of affine transforms places and shares them. Lists of crossings have even length and alternate. Solids that only
//! touch leave no crossings. Every `t` has a bound on its error. Results are bit-identical for every accelerator,
//! batch and number of threads. `ARCHITECTURE.md` states the contract in full.
//!
//! # A tour
//!
//! Build a scene, compile it, cast:
//!
//! ```
//! use shotline::prelude::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A plate with a bore right through it: the caps of the bore lie in the faces of the plate.
//! let plate = Shape::cuboid([-2.0, -2.0, 0.0], [2.0, 2.0, 1.0])?;
//! let bore = Shape::cylinder(0.5, 0.0, 1.0)?;
//! let scene = Scene::of([Object::new("plate", plate - bore)]);
//!
//! let world = scene.compile()?;
//! let mut caster = Caster::new(&world);
//!
//! // Along the bore there is nothing, not even a film at its ends.
//! let down = Ray::new(Vec3::new(0.1, 0.2, 5.0), -Vec3::Z)?;
//! assert!(!caster.any(&down, Span::FORWARD)?);
//!
//! // Across it: into the plate, out into the bore, in again, out. `t` counts lengths of the direction.
//! let across = Ray::new(Vec3::new(-4.0, 0.0, 0.5), Vec3::X * 2.0)?;
//! let mut hits = Vec::new();
//! caster.crossings(&across, Span::FORWARD, &mut hits)?;
//! let list: Vec<_> = hits.iter().map(|h| (h.t, h.entering)).collect();
//! assert_eq!(list, [(1.0, true), (1.75, false), (2.25, true), (3.0, false)]);
//! assert_eq!(world.surface_name(hits[1].surface.unwrap()), "cylinder#1.side");
//! // Normals point out of the result: here into the bore.
//! assert_eq!(hits[1].normal, Vec3::X);
//!
//! // The stretches inside, with their lengths in world units.
//! let mut segments = Vec::new();
//! caster.segments(&across, Span::FORWARD, Overlaps::Error, &mut segments)?;
//! assert_eq!(segments.iter().map(|s| s.length).collect::<Vec<_>>(), [1.5, 1.5]);
//! # Ok(())
//! # }
//! ```
//!
//! # Modules
//!
//! - [`scene`] describes, [`compile`] checks and builds, [`query`] casts; [`query::batch`] casts arrays of rays on
//!   all cores.
//! - [`solid`] has the solids and [`accel`] the accelerators. Adding one takes one file and one line.
//! - [`measure`] computes the volume, mass, centroid and inertia of objects.
//! - [`polygon`] cuts polygons into triangles.
//! - [`pool`] keeps threads for work that is divided.
//! - [`region`] computes boxes around the region that planes and quadrics enclose together.
//! - [`trace`] records what a ray did, step by step; [`outline`] has the shapes of what it met.
//! - [`csg`] has the programs and the sweep that combine any number of operands.
//! - [`lecture`] has the textbook forms that production code replaces: Roth's table, quartics, normals by the adjugate.
//! - [`math`] and [`roots`] have planes as row vectors, affine maps and polynomial roots.
//!
//! # What is not promised
//!
//! - Whether a ray that is within rounding of a tangent, an edge, a rim or an apex touches or crosses there. In
//!   either case the list has even length and alternates.
//! - What a ray that lies in a face of a mesh finds of that face. (A ray in a face of another solid is not inside; a
//!   ray in a face that two operands of a union share is inside.)
//! - Crossings at distances at which f64 cannot distinguish the solid from a point.
#![deny(missing_docs)]

pub mod aabb;
#[cfg(test)]
mod aabb_tests;
pub mod accel;
pub mod budget;
pub mod compile;
pub mod contact;
pub mod counters;
pub mod crossing;
pub mod csg;
mod lanes;
pub mod lecture;
pub mod math;
pub mod measure;
pub mod outline;
pub mod polygon;
pub mod pool;
pub mod prelude;
pub mod query;
pub mod ray;
pub mod region;
pub mod roots;
pub mod scene;
pub mod scratch;
pub mod shape;
mod simd;
pub mod solid;
pub mod tags;
#[cfg(any(test, feature = "testkit"))]
pub mod testkit;
pub mod trace;

/// The example of the crate's README is run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
