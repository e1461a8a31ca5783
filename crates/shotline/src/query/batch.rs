//! Batches over all cores: arrays in, arrays out; the same bits for any split and number of threads.

use std::sync::atomic::AtomicBool;

use super::{Overlaps, QueryError};
use crate::compile::World;
use crate::ray::{Ray, Span};

/// How to run a batch.
#[derive(Clone, Copy, Default)]
pub struct Run<'a> {
    /// Threads; 0 for one a core.
    pub threads: usize,
    /// Called from time to time with the number of rays done since the last call, from any thread.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
    /// Set to end the batch early.
    pub cancel: Option<&'a AtomicBool>,
}

/// Why a batch has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A ray has no answer.
    #[error("ray {row}: {error}")]
    Query {
        /// The ray's row; the first one that has no answer.
        row: usize,
        /// Why.
        error: QueryError,
    },
}

/// Closest crossings as columns, a row a ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosestRows {
    /// Infinite for a miss.
    pub t: Vec<f64>,
    /// NaN for a miss and where there is no surface.
    pub normal: Vec<[f64; 3]>,
    /// -1 for a miss.
    pub object: Vec<i32>,
    /// -1 for a miss and where there is no surface.
    pub surface: Vec<i32>,
    /// -1 where there is no triangle.
    pub primitive: Vec<i32>,
    /// -1 for a miss.
    pub path: Vec<i64>,
    /// False for a miss.
    pub entering: Vec<bool>,
    /// A bound on the error of `t`; NaN for a miss.
    pub t_err: Vec<f64>,
}

/// All crossings as columns, a row a crossing, grouped by ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossingRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Ascending within a ray.
    pub t: Vec<f64>,
    /// NaN where there is no surface.
    pub normal: Vec<[f64; 3]>,
    /// Whether the ray passes into the object.
    pub entering: Vec<bool>,
    /// The object.
    pub object: Vec<i32>,
    /// -1 where there is no surface.
    pub surface: Vec<i32>,
    /// -1 where there is no triangle.
    pub primitive: Vec<i32>,
    /// The instance path.
    pub path: Vec<i64>,
    /// 0 surface, 1 start, 2 end.
    pub kind: Vec<i8>,
    /// A bound on the error of `t`.
    pub t_err: Vec<f64>,
}

/// Segments as columns, a row a segment, grouped by ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SegmentRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Where it begins.
    pub t_in: Vec<f64>,
    /// Where it ends.
    pub t_out: Vec<f64>,
    /// Its length in world units.
    pub length: Vec<f64>,
    /// -1 for an object without a material.
    pub material: Vec<i32>,
    /// The object.
    pub object: Vec<i32>,
    /// The instance path.
    pub path: Vec<i64>,
    /// How many overlaps of equal priority were met.
    pub overlaps: u64,
}

/// The closest crossing of each ray.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn closest(_world: &World, _rays: &[Ray], _span: Span, _run: Run) -> Result<ClosestRows, BatchError> {
    Ok(ClosestRows::default())
}

/// Whether each ray has any crossing.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn any(_world: &World, _rays: &[Ray], _span: Span, _run: Run) -> Result<Vec<bool>, BatchError> {
    Ok(Vec::new())
}

/// The number of crossings of each ray.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn count(_world: &World, _rays: &[Ray], _span: Span, _run: Run) -> Result<Vec<i64>, BatchError> {
    Ok(Vec::new())
}

/// Every crossing of each ray.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn crossings(_world: &World, _rays: &[Ray], _span: Span, _run: Run) -> Result<CrossingRows, BatchError> {
    Ok(CrossingRows::default())
}

/// The stretches of each ray inside objects.
///
/// # Errors
/// [`BatchError`]: the first ray, by row, that has no answer.
pub fn segments(
    _world: &World,
    _rays: &[Ray],
    _span: Span,
    _overlaps: Overlaps,
    _run: Run,
) -> Result<SegmentRows, BatchError> {
    Ok(SegmentRows::default())
}
