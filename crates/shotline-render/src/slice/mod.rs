//! Slices: which object, material or instance owns each pixel of a plane.
//!
//! Ownership is found by rays along the rows of pixels, so that the boundaries along a row are exact: a pixel belongs to what
//! owns its middle.

mod area;
mod coloring;
mod conflicts;
mod figure;
mod outline;
mod owners;
mod picture;
mod plane;
mod svg;
mod ticks;

pub use area::{Area, area_within_enclosures};
pub use coloring::{ColorBy, Region, regions};
pub use conflicts::{ConflictPart, PairInConflict};
pub use figure::Conflicts;
pub use owners::{Part, Slice, SliceSettings, slice};
pub use picture::{slice_jpeg, slice_png};
pub use plane::{InvalidSlicePlane, SlicePlane};
pub use svg::slice_svg;

use shotline::query::QueryError;
use shotline::query::batch::BatchError;

use crate::error::{MAX_PIXELS, MAX_SIDE};

/// Why there is no slice, and how to correct that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SliceError {
    /// The number of pixels is out of range.
    #[error(
        "a slice of {width}x{height} pixels: each side must be from 1 to {MAX_SIDE}, all pixels at most {MAX_PIXELS}"
    )]
    Size {
        /// The requested width.
        width: u32,
        /// The requested height.
        height: u32,
    },
    /// The area is empty or not finite.
    #[error(
        "the area U0,V0,U1,V1 of a slice is from its lower left to its upper right corner: U0 < U1 and V0 < V1, all finite"
    )]
    Area,
    /// There is nothing that a default area could be around.
    #[error("the scene has nothing of finite size that the slice could be around: give the area U0,V0,U1,V1")]
    NothingBounded,
    /// An object has no inside.
    #[error("a slice needs solids, which have an inside: {0}; close the mesh")]
    NotSolid(QueryError),
    /// A row exceeds a limit.
    #[error("a row of the slice has no result: {0}; slice a smaller area, or nest fewer parts in each other")]
    Row(QueryError),
    /// A row is not a ray: its numbers overflow.
    #[error("the plane and the area are too large, or too far away, for numbers of 64 bits")]
    Overflow,
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl From<QueryError> for SliceError {
    fn from(error: QueryError) -> SliceError {
        match error {
            QueryError::Cancelled => SliceError::Cancelled,
            error @ QueryError::NotASolid { .. } => SliceError::NotSolid(error),
            error => SliceError::Row(error),
        }
    }
}

impl From<BatchError> for SliceError {
    fn from(error: BatchError) -> SliceError {
        match error {
            BatchError::Cancelled => SliceError::Cancelled,
            BatchError::World(error) | BatchError::Query { error, .. } => error.into(),
            BatchError::Ray { .. } | BatchError::Point { .. } => SliceError::Overflow,
            BatchError::TooMany { .. } | BatchError::OutOfMemory => SliceError::Row(QueryError::OutOfMemory),
        }
    }
}
