//! Triangle meshes of solids and combinations, within a tolerance.
//!
//! Rays along the lines of a grid give the exact crossings and normals of a surface. Dual contouring puts a vertex into each cell
//! that the surface passes through, where these planes meet, so that edges and corners stay sharp; the mesh is closed. The grid
//! is refined until the mesh is within the tolerance, which is measured both ways: by rays from points of the mesh, and by the points
//! of the mesh that are nearest to crossings.
//!
//! ```
//! use shotline::prelude::*;
//! use shotline_tessellate::{Settings, tessellate};
//!
//! let part = Shape::cuboid([0.0; 3], [2.0, 2.0, 1.0])? - Shape::sphere(0.8)?;
//! let scene = Scene::of([Object::new("part", part)]);
//! let found = tessellate(&scene, &Settings::new(0.05), Default::default())?;
//! assert!(found.parts[0].deviation <= 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

mod contour;
mod crossed_edges;
mod deviation;
mod grid;
mod quadratic_error;

use shotline::compile::{InvalidScene, World};
use shotline::math::Vec3;
use shotline::query::batch::{self, BatchError, Run};
use shotline::scene::{Node, NodeId, Scene};
use shotline::solid::mesh::TriangleMesh;

use self::crossed_edges::CrossedEdges;
use self::deviation::{Surface, deviation};
use self::grid::Grid;

/// The cells along the longest side of the first grid, and the most.
const CELLS: std::ops::RangeInclusive<usize> = 24..=768;

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
    /// The scene, each of whose objects is a mesh in world coordinates. Objects that are made of meshes only are as they were.
    pub scene: Scene,
    /// The meshes that were made.
    pub parts: Vec<Part>,
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
    /// The finest grid is too coarse.
    #[error(
        "object '{object}' needs a finer grid than {} cells for the tolerance {tolerance}; the best mesh is within \
         {reached:.3}: choose a larger tolerance", CELLS.end()
    )]
    TooFine {
        /// Its name.
        object: String,
        /// The tolerance.
        tolerance: f64,
        /// The least distance reached.
        reached: f64,
    },
    /// Rays could not be cast.
    #[error(transparent)]
    Batch(#[from] BatchError),
}

/// Makes the objects of a scene into meshes. An object that contains others is whole: what it contains is not cut out of it.
/// Instances of one object are one mesh.
///
/// # Errors
/// [`TessellateError`] names the object and says how to mend it.
pub fn tessellate(scene: &Scene, settings: &Settings, run: Run) -> Result<Tessellation, TessellateError> {
    let tolerance = settings.tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(TessellateError::Tolerance(tolerance));
    }
    let mut out = Scene { objects: Vec::new(), defs: Vec::new(), ..scene.clone() };
    let mut parts = Vec::new();
    for root in &scene.objects {
        if is_of_meshes(scene, *root) {
            out.objects.push(*root);
            continue;
        }
        let world = Scene { objects: vec![*root], ..scene.clone() }.compile()?;
        // Refuses surfaces without an inside, by object.
        batch::contains(&world, &[] as &[Vec3], run)?;
        for (object, name) in (0..).zip(world.object_names()) {
            let (mesh, deviation) = mesh_within(&world, object, name, tolerance, run)?;
            if mesh.faces.is_empty() {
                continue;
            }
            parts.push(Part { object: name.clone(), triangles: mesh.faces.len(), deviation });
            let material =
                world.object_material(object).map(|number| world.material_names()[number as usize].clone());
            let node = out.add(Node::Mesh { mesh: mesh.into(), file: None });
            out.add_object(name, material.as_deref(), node);
        }
    }
    Ok(Tessellation { scene: out, parts })
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

/// The mesh of an object within a tolerance, and how far it is from the surface. It is empty if the object is.
fn mesh_within(
    world: &World,
    object: u32,
    name: &str,
    tolerance: f64,
    run: Run,
) -> Result<(TriangleMesh, f64), TessellateError> {
    let bounds = world.bounds();
    if bounds.is_empty() || bounds.size() == Vec3::ZERO {
        return Ok((TriangleMesh::default(), 0.0));
    }
    if !(bounds.min.is_finite() && bounds.max.is_finite()) {
        return Err(TessellateError::Unbounded { object: name.into() });
    }
    let surface = Surface { world, object, run };
    let (mut cells, mut reached) = (*CELLS.start(), f64::INFINITY);
    while cells <= *CELLS.end() {
        let grid = Grid::around(&bounds, cells);
        let CrossedEdges { edges, points } = CrossedEdges::of(world, object, &grid, run)?;
        let mesh = contour::contour(&grid, &edges);
        let deviation = deviation(&surface, &mesh, &points, 2.0 * grid.step, tolerance)?;
        reached = reached.min(deviation);
        if deviation <= tolerance {
            return Ok((mesh, deviation));
        }
        cells *= 2;
    }
    Err(TessellateError::TooFine { object: name.into(), tolerance, reached })
}
