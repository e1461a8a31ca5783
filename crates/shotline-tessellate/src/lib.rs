//! Triangle meshes of solids and combinations, within a tolerance.
//!
//! Rays along the edges of the cells of an octree give the exact crossings and normals of a surface. Dual contouring puts a vertex
//! into each cell for each part of the surface in it, where these planes meet, so that edges and corners stay sharp; the mesh is
//! closed, and no edge has more than two triangles. Cells are divided until the mesh is within the tolerance, which is measured both
//! ways: by rays from points of the mesh, and by the points of the mesh that are nearest to crossings. Triangles may pass
//! through each other where the surface has a fold that is narrower than a cell.
//!
//! ```
//! use shotline::prelude::*;
//! use shotline_tessellate::{Settings, tessellate};
//!
//! let part = Shape::cuboid([0.0; 3], [2.0, 2.0, 1.0])? - Shape::sphere(0.8)?;
//! let scene = Scene::of([Object::new("part", part)]);
//! let found = tessellate(&scene, &Settings::new(0.05), Default::default(), &mut |_| {})?;
//! assert!(found.parts[0].deviation <= 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

mod components;
mod contour;
mod deviation;
mod disjoint_sets;
mod octree;
mod pairs;
mod quadratic_error;
mod refine;
mod samples;
mod shared_edges;
mod shared_parts;
mod surface;
mod surface_points;

use std::collections::HashMap;

use shotline::compile::{InvalidScene, World};
use shotline::math::Vec3;
use shotline::query::batch::{self, BatchError, Run};
use shotline::scene::{LocalTransform, Node, NodeId, Scene};

use self::refine::{RefineError, Refined, State, refine};
use self::shared_parts::{PlacedPart, shared_parts};
use self::surface::Surface;
use self::surface_points::first_points;

/// The most solids of an object, counted as often as it has them: each takes some dozen cells at least.
const MOST_SOLIDS: u64 = 1 << 15;

/// How a scene is made into meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The greatest distance between a mesh and its surface, in units of the scene.
    pub tolerance: f64,
}

impl Settings {
    /// Meshes within a tolerance.
    pub fn new(tolerance: f64) -> Settings {
        Settings { tolerance }
    }
}

/// The meshes of a scene.
#[derive(Clone, Debug)]
pub struct Tessellation {
    /// The scene, each of whose objects is a mesh, in world coordinates or placed. Objects that are made of meshes only are as they were.
    pub scene: Scene,
    /// The meshes that were made, one for each object. Objects of one part share it.
    pub parts: Vec<Part>,
    /// The names of objects in which there is nothing, and which have no mesh.
    pub empty: Vec<String>,
}

/// A mesh that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of the object.
    pub object: String,
    /// The number of triangles.
    pub triangles: usize,
    /// The greatest distance between the mesh and the surface that was found.
    pub deviation: f64,
}

/// Why a scene has no meshes.
#[derive(Debug, thiserror::Error)]
pub enum TessellateError {
    /// The tolerance is not positive and finite.
    #[error("the tolerance is {0}, but must be positive and finite")]
    Tolerance(f64),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] InvalidScene),
    /// An object has no bounds.
    #[error("object '{object}' has no bounds, so no mesh can hold it; intersect it with a box")]
    Unbounded {
        /// Its name.
        object: String,
    },
    /// An object consists of too many solids.
    #[error(
        "object '{object}' consists of {count} solids, but a mesh of its own is made of {MOST_SOLIDS} at most; make a mesh of one of \
         them, and place that"
    )]
    TooManySolids {
        /// Its name.
        object: String,
        /// How many there are in it.
        count: u64,
    },
    /// The cells would be too many or too small.
    #[error(
        "object '{object}': a mesh within {tolerance} needs more than 2 million cells, or cells that are too small; so far it is off by \
         {distance:.1e} near [{:.6}, {:.6}, {:.6}], perhaps at a thin wall or gap\nhelp: choose a larger tolerance", place.x, place.y, place.z
    )]
    TooFine {
        /// Its name.
        object: String,
        /// The tolerance.
        tolerance: f64,
        /// The distance of the mesh from the surface, where it is greatest.
        distance: f64,
        /// Where that is, in world coordinates.
        place: Vec3,
    },
    /// Rays could not be cast.
    #[error(transparent)]
    Batch(#[from] BatchError),
}

/// How far the mesh of an object is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The name of the object.
    pub object: &'a str,
    /// The cells so far.
    pub cells: usize,
    /// The triangles so far.
    pub triangles: usize,
    /// The distance between the mesh so far and the surface.
    pub deviation: f64,
}

/// Makes the objects of a scene into meshes. An object that contains others is whole: what it contains is not cut out of it.
/// Instances within one object are one mesh; objects that are one part in several places share its mesh. `report` is called from time to time.
///
/// # Errors
/// [`TessellateError`] names the object and says how to mend it.
pub fn tessellate(
    scene: &Scene,
    settings: &Settings,
    run: Run,
    report: &mut dyn FnMut(&Progress),
) -> Result<Tessellation, TessellateError> {
    let tolerance = settings.tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(TessellateError::Tolerance(tolerance));
    }
    let mut out = Scene { objects: Vec::new(), defs: Vec::new(), ..scene.clone() };
    let worlds = worlds(scene, run)?;
    let (mut parts, mut empty) = (Vec::new(), Vec::new());
    let mut made: HashMap<(NodeId, u64), Option<Made>> = HashMap::new();
    for ((root, world), placed) in scene.objects.iter().zip(&worlds).zip(shared_parts(scene)) {
        let Some(world) = world else {
            out.objects.push(*root);
            continue;
        };
        for (object, name) in (0..).zip(world.object_names()) {
            let mut within = |root, world: &World, tolerance| {
                let surface = Surface { world, object, run };
                let found = mesh_within(scene, root, &surface, name, tolerance, report)?;
                Ok::<_, TessellateError>(Made::of(found, &mut out))
            };
            let (found, transforms, scale) = match &placed {
                Some(PlacedPart { part, transforms, scale }) => {
                    let key = (*part, scale.to_bits());
                    let found = match made.get(&key) {
                        Some(found) => *found,
                        None => within(*part, &world_of_part(scene, *part, name)?, tolerance / scale)?,
                    };
                    made.insert(key, found);
                    (found, &transforms[..], *scale)
                }
                None => (within(*root, world, tolerance)?, &[][..], 1.0),
            };
            let Some(Made { mesh, triangles, deviation }) = found else {
                empty.push(name.clone());
                continue;
            };
            parts.push(Part { object: name.clone(), triangles, deviation: scale * deviation });
            let material =
                world.object_material(object).map(|number| world.material_names()[number as usize].clone());
            let place =
                |child, transform: &LocalTransform| out.add(Node::Transform { transform: *transform, child });
            let node = transforms.iter().rev().fold(mesh, place);
            out.add_object(name, material.as_deref(), node);
        }
    }
    Ok(Tessellation { scene: out, parts, empty })
}

/// A mesh that is in a scene.
#[derive(Clone, Copy)]
struct Made {
    mesh: NodeId,
    triangles: usize,
    deviation: f64,
}

impl Made {
    /// Adds a mesh to a scene; `None` if it has no triangle.
    fn of(Refined { mesh, deviation }: Refined, out: &mut Scene) -> Option<Made> {
        let triangles = mesh.faces.len();
        (triangles > 0).then(|| Made {
            mesh: out.add(Node::Mesh { mesh: mesh.into(), file: None }),
            triangles,
            deviation,
        })
    }
}

/// A world of one part, in its own coordinates.
fn world_of_part(scene: &Scene, part: NodeId, name: &str) -> Result<World, TessellateError> {
    let mut one = Scene { objects: Vec::new(), ..scene.clone() };
    one.add_object(name, None, part);
    Ok(one.compile()?)
}

/// A world for each object of a scene that is not made of meshes only, once it is known that all these have meshes.
fn worlds(scene: &Scene, run: Run) -> Result<Vec<Option<World>>, TessellateError> {
    let mut one = scene.clone();
    let world = |root: &NodeId| {
        if is_of_meshes(scene, *root) {
            return Ok(None);
        }
        one.objects = vec![*root];
        let world = one.compile()?;
        // Refuses surfaces without an inside, by object.
        batch::contains(&world, &[] as &[Vec3], run)?;
        let count = world.stats().virtual_leaves;
        if count > MOST_SOLIDS {
            return Err(TessellateError::TooManySolids { object: first_name(&world), count });
        }
        let bounds = world.bounds();
        if bounds.is_finite() || bounds.is_empty() {
            return Ok(Some(world));
        }
        Err(TessellateError::Unbounded { object: first_name(&world) })
    };
    scene.objects.iter().map(world).collect()
}

fn first_name(world: &World) -> String {
    world.object_names().first().cloned().unwrap_or_default()
}

/// Whether an object is made of meshes only, without combinations.
fn is_of_meshes(scene: &Scene, root: NodeId) -> bool {
    let mut todo = vec![root];
    let mut seen = vec![false; scene.nodes.len()];
    while let Some(id) = todo.pop() {
        if std::mem::replace(&mut seen[id.0 as usize], true) {
            continue;
        }
        match scene.node(id) {
            Node::Solid { .. } | Node::Csg { .. } => return false,
            node => todo.extend(node.children()),
        }
    }
    true
}

/// The mesh of an object within a tolerance. It is empty if the object is.
fn mesh_within(
    scene: &Scene,
    root: NodeId,
    surface: &Surface,
    name: &str,
    tolerance: f64,
    report: &mut dyn FnMut(&Progress),
) -> Result<Refined, TessellateError> {
    let bounds = surface.world.bounds();
    if bounds.is_empty() || bounds.size() == Vec3::ZERO {
        return Ok(Refined::default());
    }
    let points = first_points(scene, root, &bounds, tolerance, surface)?;
    let mut of_object = |State { cells, triangles, deviation }: State| {
        report(&Progress { object: name, cells, triangles, deviation });
    };
    refine(surface, &bounds, points, tolerance, &mut of_object).map_err(|error| match error {
        RefineError::Batch(error) => error.into(),
        RefineError::TooFine(far) => {
            let (distance, place) = (far.distance, far.place);
            TessellateError::TooFine { object: name.into(), tolerance, distance, place }
        }
    })
}
