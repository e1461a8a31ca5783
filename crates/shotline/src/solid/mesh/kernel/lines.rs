//! The lines of a block of rays, in the frame of a mesh.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::math::{Affine, Vec3, unit};
use crate::ray::{Line, Span};

/// Lines by row: origin and direction, and bounds on their errors unless all are exact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lines<'a> {
    pub rows: &'a [[f64; 6]],
    pub errors: Option<&'a [[f64; 6]]>,
}

impl Lines<'_> {
    /// Origin and direction.
    #[inline(always)]
    pub fn nominal(&self, row: usize) -> (Vec3, Vec3) {
        halves(&self.rows[row])
    }

    /// The line of a row.
    pub fn line(&self, row: usize) -> Line {
        let (o, d) = self.nominal(row);
        let (o_err, d_err) = self.errors.map_or((Vec3::ZERO, Vec3::ZERO), |errors| halves(&errors[row]));
        Line { o, d, o_err, d_err }
    }
}

#[inline(always)]
fn halves(row: &[f64; 6]) -> (Vec3, Vec3) {
    (Vec3::new(row[0], row[1], row[2]), Vec3::new(row[3], row[4], row[5]))
}

/// The rays of a block, in the frame of the mesh and in that of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayBlock<'a> {
    pub rays: &'a [[f64; 6]],
    /// From the world to the mesh, in two steps.
    pub frames: [&'a Affine; 2],
    /// Whether the normals of hits are needed.
    pub wants_normals: bool,
    pub lines: Lines<'a>,
    pub span: Span,
    /// The `t` behind which hits of each ray are not needed, at most the end of the span. Not for queries of all hits.
    pub ends: Option<&'a [f64]>,
    /// Set by any thread to stop early; then the result means nothing.
    pub cancel: Option<&'a AtomicBool>,
}

/// What a block is cast for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockQuery {
    /// The first hit of the surface.
    Nearest,
    /// Whether there is a hit of the surface: one hit without a place.
    Any,
    /// All hits of the surface, in any order.
    All,
    /// Whether there is a hit that is off the edges of its triangle and farther from the ends of the span than an event
    /// is wide: one hit with its face. Rays that have other hits only are left to the plain path.
    AnyOffEdges,
    /// The first hit within the span, if it is an event of its own; other rays are left to the plain path. For rays that
    /// begin outside of the mesh's box it is the first boundary of the solid.
    First,
    /// The hits that [`crate::solid::Solid::crossings_within`] turns into crossings, in any order.
    Within,
    /// As `Within`, for an operand of a combination: rays that run in the plane of a triangle take the plain path, which
    /// finds how they touch it.
    Operand,
}

impl RayBlock<'_> {
    /// Origin and direction of a ray in the world.
    #[inline(always)]
    pub fn ray(&self, row: usize) -> (Vec3, Vec3) {
        halves(&self.rays[row])
    }

    /// The end of the span of a ray.
    #[inline(always)]
    pub fn end(&self, row: usize) -> f64 {
        self.ends.map_or(self.span.t_max(), |ends| ends[row])
    }

    /// A normal in world coordinates, of length 1: `(T^-1)^T n` in both steps.
    pub fn world_normal(&self, normal: Vec3) -> Vec3 {
        unit(self.frames[0].covector(self.frames[1].covector(normal)))
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
