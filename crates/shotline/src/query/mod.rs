//! Queries: a [`Caster`] holds a world and one thread's scratch memory and answers rays.

pub mod batch;

use crate::accel::Work;
use crate::compile::World;
use crate::math::Vec3;
use crate::ray::{Ray, Span};

/// What a crossing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum HitKind {
    /// The ray passes a surface.
    Surface = 0,
    /// The span begins inside: there is no surface.
    Start = 1,
    /// The span ends inside: there is no surface.
    End = 2,
}

/// A crossing of an object, in world terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The parameter, in lengths of the ray's direction.
    pub t: f64,
    /// A bound on its error.
    pub t_err: f64,
    /// Whether the ray passes into the object.
    pub entering: bool,
    /// Whether there is a surface here.
    pub kind: HitKind,
    /// The unit normal, out of the object; NaN where there is no surface.
    pub normal: Vec3,
    /// The object: an index into [`World::object_names`].
    pub object: u32,
    /// The leaf surface, see [`World::surface_name`]; `None` where there is no surface.
    pub surface: Option<u32>,
    /// The triangle of a mesh.
    pub primitive: Option<u32>,
    /// Barycentric coordinates in that triangle, weights of its second and third vertex.
    pub barycentric: Option<[f64; 2]>,
    /// The number of the instance path, see [`World::path_name`].
    pub path: u64,
}

/// A stretch of a ray inside an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Where it begins.
    pub t_in: f64,
    /// Where it ends.
    pub t_out: f64,
    /// Its length in world units.
    pub length: f64,
    /// The object.
    pub object: u32,
    /// Its material: an index into [`World::material_names`].
    pub material: Option<u32>,
    /// The instance path.
    pub path: u64,
}

/// What to do where objects of equal priority overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlaps {
    /// Refuse, naming both and the place.
    #[default]
    Error,
    /// The later object owns the overlap, which is counted.
    Priority,
    /// Every claimant keeps its segment.
    All,
}

/// Why a query has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QueryError {
    /// Segments were asked of a mesh that is not closed.
    #[error(
        "object '{object}' has no inside: its mesh has {open_edges} open edges, the first between vertices {first_edge:?}"
    )]
    NotASolid {
        /// The object.
        object: String,
        /// How many edges are open.
        open_edges: usize,
        /// The first of them.
        first_edge: [u32; 2],
    },
    /// Two objects of equal priority claim the same stretch.
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
}

/// A world with one thread's scratch memory.
#[derive(Debug)]
pub struct Caster<'w> {
    world: &'w World,
}

impl<'w> Caster<'w> {
    /// A caster for one thread.
    pub fn new(world: &'w World) -> Caster<'w> {
        Caster { world }
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// The first crossing in the span.
    pub fn closest(&mut self, _ray: &Ray, _span: Span) -> Option<Hit> {
        None
    }

    /// Whether there is any crossing in the span.
    pub fn any(&mut self, _ray: &Ray, _span: Span) -> bool {
        false
    }

    /// The number of crossings in the span.
    pub fn count(&mut self, _ray: &Ray, _span: Span) -> u64 {
        0
    }

    /// Appends every crossing in the span, ascending in `t`, alternating for each object's path.
    pub fn crossings(&mut self, _ray: &Ray, _span: Span, _out: &mut Vec<Hit>) {}

    /// Appends the stretches inside objects and answers how many overlaps of equal priority were met.
    ///
    /// # Errors
    /// [`QueryError`] for meshes that are not closed and, with [`Overlaps::Error`], for overlaps.
    pub fn segments(
        &mut self,
        _ray: &Ray,
        _span: Span,
        _overlaps: Overlaps,
        _out: &mut Vec<Segment>,
    ) -> Result<u64, QueryError> {
        Ok(0)
    }

    /// Appends the objects whose interior holds a point.
    ///
    /// # Errors
    /// [`QueryError`] for meshes that are not closed.
    pub fn contains(&mut self, _p: Vec3, _out: &mut Vec<u32>) -> Result<(), QueryError> {
        Ok(())
    }

    /// Work counted since the caster was made.
    pub fn work(&self) -> Work {
        Work::default()
    }
}
