//! Queries: a [`Caster`] holds a world and the scratch memory of one thread, and traces rays.

mod all;
pub mod batch;
mod block_caster;
mod block_casts;
mod block_fold;
mod block_queries;
mod block_visitor;
mod bundle;
mod bundle_lists;
mod bundle_stream;
mod bundles;
mod caster;
mod coherence_hint;
mod contains;
mod counted_parts;
mod few_meshes;
mod first_boundaries;
mod first_visible;
mod fold;
mod fold_query;
mod heap;
mod hit;
mod hit_lists;
mod instances;
mod interval_ends;
mod intervals;
mod lane_bodies;
mod lane_cast;
mod lane_events;
mod lane_leaf;
mod lane_normals;
mod level_boxes;
mod level_paths;
mod level_visit;
mod limit;
mod meetings;
mod membership;
mod mesh_requests;
mod met_bodies;
mod nearest;
mod offers;
mod ordered_set;
mod owned_parts;
mod ownership;
mod pending_boxes;
mod placed_mesh;
mod ranks;
mod repair;
mod row_block;
mod row_hit;
mod scope;
mod small_body;
mod stream;
mod traversal;
mod wave;
mod wave_bodies;
mod wave_casts;
mod wave_memory;

pub use crate::budget::Watch;
pub use crate::compile::ConflictKind;
pub use crate::csg::HitKind;
pub use caster::Caster;
pub use coherence_hint::CoherenceHint;
pub use scope::{Kinds, Scope};

use crate::math::Vec3;

/// A crossing of an object, in world coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter, in units of the length of the ray's direction.
    pub t: f64,
    /// A bound on the error of `t`.
    pub t_err: f64,
    /// Whether the ray enters the object.
    pub entering: bool,
    /// Whether there is a surface at the crossing.
    pub kind: HitKind,
    /// The outward unit normal; NaN where there is no surface.
    pub normal: Vec3,
    /// The object: an index into [`object_names`](crate::compile::World::object_names).
    pub object: u32,
    /// The leaf surface, see [`surface_name`](crate::compile::World::surface_name); `None` where there is no surface.
    pub surface: Option<u32>,
    /// The triangle of a mesh.
    pub primitive: Option<u32>,
    /// The polygon of the mesh file that the triangle was cut from, counted from 0.
    pub polygon: Option<u32>,
    /// Barycentric coordinates in that triangle, weights of its second and third vertex.
    pub barycentric: Option<[f64; 2]>,
    /// The number of the instance path, see [`path_name`](crate::compile::World::path_name).
    pub path: u64,
}

/// An interval of a ray inside an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where the segment begins.
    pub t_in: f64,
    /// Where the segment ends.
    pub t_out: f64,
    /// Its length in world units.
    pub length: f64,
    /// The object.
    pub object: u32,
    /// Its material: an index into [`material_names`](crate::compile::World::material_names).
    pub material: Option<u32>,
    /// The instance path.
    pub path: u64,
}

/// An interval of a ray in which two instances of objects are in conflict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// What is wrong.
    pub kind: ConflictKind,
    /// The object that is entered first; the one that sticks out.
    pub first: u32,
    /// The other; the one that it sticks out of. Both may be the same object, placed twice.
    pub second: u32,
    /// Where the overlap begins.
    pub t_in: f64,
    /// Where it ends.
    pub t_out: f64,
    /// The sum of the bounds on the errors of both ends.
    pub t_err: f64,
}

/// What to do where objects of equal priority overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlaps {
    /// Return an error that names both objects and the interval.
    #[default]
    Error,
    /// The object that is placed later owns the overlap. Overlaps are counted.
    Priority,
    /// Every object keeps its whole segment; what an object that clips contains keeps what is inside it.
    All,
}

/// What one ray may cost. Realistic models stay far below the defaults; a ray that reaches them takes a few seconds
/// and less than 1 GB.
///
/// Rays that [`batch`] casts together do not count what they do at a mesh, or at a body of solids, as steps.
///
/// The depth of a combination is not counted as steps. Each crossing of an operand nested `n` deep on the right, as in
/// `a - (b - (c - ...))`, may take time in proportion to `n`; chains as `a - b - c` have no depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Number of boxes, cells, bodies and crossings that are processed.
    pub steps: u64,
    /// Number of crossings that are collected.
    pub crossings: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { steps: 10_000_000, crossings: 1 << 20 }
    }
}

/// Why a query failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QueryError {
    /// The query needs the inside of a mesh that is not closed.
    #[error("object '{object}' has no inside: its mesh is not closed: {why}")]
    NotASolid {
        /// The object.
        object: String,
        /// How many edges are open and where the first is.
        why: String,
    },
    /// Two objects of equal priority overlap.
    #[error("objects '{first}' and '{second}' of equal priority overlap from t = {t_in} to t = {t_out}")]
    Overlap {
        /// The object entered first.
        first: String,
        /// The other.
        second: String,
        /// Where the overlap begins.
        t_in: f64,
        /// Where it ends.
        t_out: f64,
    },
    /// A ray has more crossings than [`Limits::crossings`].
    #[error("the ray has more than {most} crossings")]
    TooMany {
        /// The limit.
        most: usize,
    },
    /// A ray takes more than [`Limits::steps`].
    #[error("the ray takes more than {most} steps through boxes, bodies and crossings")]
    TooLong {
        /// The limit.
        most: u64,
    },
    /// The crossings of the ray do not fit into memory.
    #[error("there is not enough memory for the crossings of the ray")]
    OutOfMemory,
    /// The caller cancelled the query: see [`Caster::watch`].
    #[error("cancelled")]
    Cancelled,
}

#[cfg(test)]
mod tests;
