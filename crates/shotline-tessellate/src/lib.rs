//! Triangle meshes of solids and combinations, within a tolerance.
//!
//! Single solids of revolution, boxes and solids of flat faces are made straight from their parameters. For all others,
//! rays along the edges of the cells of an octree give the exact crossings and normals of a surface. Dual contouring puts a vertex
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

mod apart;
mod boxes;
mod components;
mod contour;
mod deviation;
mod direct;
mod disjoint_sets;
mod graph;
mod octree;
mod pairs;
mod plan;
mod profile;
mod quadratic_error;
mod refine;
mod samples;
mod shape;
mod shared_edges;
mod surface;
mod surface_points;
mod turned;
mod uses;

use std::collections::{HashMap, HashSet};
use std::sync::atomic::Ordering;

use shotline::compile::InvalidScene;
use shotline::math::Vec3;
use shotline::query::batch::{BatchError, Run};
use shotline::scene::{Node, NodeId, Scene};

use self::graph::postorder;
use self::plan::Plan;
use self::refine::Refined;
use self::shape::Shape;

/// The most solids of one mesh, counted as often as they are placed in it: each takes some dozen cells at least.
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
    /// The scene, with meshes in place of solids and combinations. An object at the root that shares nothing is in world coordinates; all
    /// else is placed as it was. Objects that are made of meshes only are as they were.
    pub scene: Scene,
    /// The objects for which meshes were made, in the order of their numbers in a world.
    pub parts: Vec<Part>,
    /// The names of objects in which there is nothing.
    pub empty: Vec<String>,
}

/// The meshes that were made for an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of the object.
    pub object: String,
    /// The number of triangles; those of a mesh that is shared, by copies in the object or by other objects, are counted once.
    pub triangles: usize,
    /// The greatest distance between the meshes and the surface that was found.
    pub deviation: f64,
}

/// Numbers in messages are written in full if they are this short.
const MOST_DIGITS: usize = 20;

/// Why a scene has no meshes.
#[derive(Debug, thiserror::Error)]
pub enum TessellateError {
    /// The tolerance is not positive and finite.
    #[error("the tolerance is {}, but must be positive and finite", short(.0))]
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
        "object '{object}': a mesh within {} needs more than 2 million cells, or cells that are too small; so far it is off by \
         {distance:.1e} near [{:.6}, {:.6}, {:.6}], perhaps at a thin wall or gap\nhelp: choose a larger tolerance", short(tolerance), place.x, place.y, place.z
    )]
    TooFine {
        /// Its name.
        object: String,
        /// The tolerance.
        tolerance: f64,
        /// The distance of the mesh from the surface, where it is greatest.
        distance: f64,
        /// Where that is, in the coordinates of the mesh.
        place: Vec3,
    },
    /// Rays could not be cast.
    #[error(transparent)]
    Batch(#[from] BatchError),
}

/// A number as text; with an exponent, where it would have hundreds of digits.
fn short(x: &f64) -> String {
    let plain = x.to_string();
    if plain.len() > MOST_DIGITS { format!("{x:e}") } else { plain }
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
/// Parts that are placed several times share a mesh, unless they are close to other parts of their object. `report` is called from time to
/// time.
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
    scene.compile()?;
    let Plan { mut scene, pieces } = Plan::of(scene, tolerance)?;
    // All are examined before the first mesh is made.
    let mut shapes = Vec::with_capacity(pieces.len());
    for piece in &pieces {
        expect_not_cancelled(run)?;
        shapes.push(Shape::of(&scene, piece, run)?);
    }
    let mut made = HashMap::new();
    for (piece, shape) in pieces.iter().zip(&shapes) {
        expect_not_cancelled(run)?;
        let Refined { mesh, deviation } = shape.mesh_within(tolerance, run, report)?;
        made.insert(piece.node, (mesh.faces.len(), deviation));
        scene.nodes[piece.node.0 as usize] = match mesh.faces.is_empty() {
            true => Node::Group { members: Vec::new() },
            false => Node::Mesh { mesh: mesh.into(), file: None },
        };
    }
    let (parts, empty) = objects_made(&scene, &made);
    leave_out_empty(&mut scene);
    Ok(Tessellation { scene: Scene { defs: Vec::new(), ..scene }, parts, empty })
}

/// Single solids need no rays, which would notice it.
fn expect_not_cancelled(run: Run) -> Result<(), BatchError> {
    let is_cancelled = run.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
    if is_cancelled { Err(BatchError::Cancelled) } else { Ok(()) }
}

/// Leaves out the members of groups, the contents of objects, and the roots in which there is no mesh.
fn leave_out_empty(scene: &mut Scene) {
    let mut has_mesh = vec![false; scene.nodes.len()];
    for id in postorder(scene, &scene.objects) {
        let index = id.0 as usize;
        let node = scene.node(id);
        has_mesh[index] =
            matches!(node, Node::Mesh { .. }) || node.children().any(|child| has_mesh[child.0 as usize]);
        match &mut scene.nodes[index] {
            Node::Group { members: parts } | Node::Object { contents: parts, .. } => {
                parts.retain(|part| has_mesh[part.0 as usize]);
            }
            _ => {}
        }
    }
    scene.objects.retain(|root| has_mesh[root.0 as usize]);
}

/// What was made for each object that is not of meshes only: a part, or the name of an object in which there is nothing. `made` has the
/// triangles and the deviation of each piece.
fn objects_made(scene: &Scene, made: &HashMap<NodeId, (usize, f64)>) -> (Vec<Part>, Vec<String>) {
    let (mut parts, mut empty) = (Vec::new(), Vec::new());
    for id in scene.numbered_objects() {
        let Node::Object { name, node, .. } = scene.node(id) else { continue };
        let own: Vec<_> = own_nodes(scene, *node).into_iter().filter_map(|id| made.get(&id)).collect();
        let triangles = own.iter().map(|(triangles, _)| triangles).sum();
        let deviation = own.iter().map(|(_, deviation)| *deviation).fold(0.0, f64::max);
        if triangles > 0 {
            parts.push(Part { object: name.clone(), triangles, deviation });
        } else if !own.is_empty() {
            empty.push(name.clone());
        }
    }
    (parts, empty)
}

/// The nodes below a shape and itself, each once, but for objects and what is in them.
fn own_nodes(scene: &Scene, shape: NodeId) -> HashSet<NodeId> {
    let (mut own, mut todo) = (HashSet::new(), vec![shape]);
    while let Some(id) = todo.pop() {
        if !matches!(scene.node(id), Node::Object { .. }) && own.insert(id) {
            todo.extend(scene.node(id).children());
        }
    }
    own
}
