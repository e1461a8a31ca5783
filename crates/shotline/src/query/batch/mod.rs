//! Batches over all cores: arrays in, arrays out; the same bits for any split and number of threads.
//!
//! Rays and points are asked for by number ([`Rays`], [`Points`]), so they need not be copied from wherever they are.
//! All are checked before any work starts. Answers take their own size and some tens of MB beside it.

mod rays;
mod rows;
mod run;

use std::sync::atomic::{AtomicU64, Ordering};

pub use rays::{Points, Rays};
use rows::blank;
pub use rows::{By, ClosestRows, CrossingRows, ObjectRows, SegmentRows, Thickness};
pub use run::{Run, SEQUENTIAL_MAX};

use super::caster::all_solid;
use super::{Overlaps, QueryError, Scope};
use crate::compile::World;
use crate::counters::COUNTERS;
use crate::ray::{InvalidRay, Span};
use rays::{PointRows, RayRows};
use run::{Batch, CHUNK, empty};

/// Why a batch has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// No ray has an answer: found before any work starts.
    #[error(transparent)]
    World(QueryError),
    /// A row is not a ray: the first one, found before any work starts, unless it changed later.
    #[error("ray {row}: {error}")]
    Ray {
        /// Which row.
        row: usize,
        /// Why it is not.
        error: InvalidRay,
    },
    /// A point is nowhere: found as rows that are not rays are.
    #[error("point {row} has a coordinate that is NaN or infinite")]
    Point {
        /// Which row.
        row: usize,
    },
    /// All answers together have too many rows.
    #[error("the answer has more than {most} row{}", if *most == 1 { "" } else { "s" })]
    TooMany {
        /// How many there may be.
        most: u64,
    },
    /// The answers do not fit into memory.
    #[error("there is not enough memory for the answers")]
    OutOfMemory,
    /// A ray has no answer.
    #[error("ray {row}: {error}")]
    Query {
        /// The ray's row; the first one that has no answer.
        row: usize,
        /// Why.
        error: QueryError,
    },
}

/// Checks rays, as every query does before its work starts.
///
/// # Errors
/// [`BatchError::Ray`] with the first row that is not a ray.
pub fn check(rays: &(impl Rays + ?Sized)) -> Result<(), BatchError> {
    rays.check(0..rays.len()).map_err(|(row, error)| BatchError::Ray { row, error })
}

/// The closest crossing of each ray.
///
/// # Errors
/// [`BatchError`]: cancelled, a row that is not a ray, a ray beyond its [limits](super::Limits), or too little memory.
pub fn closest(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
) -> Result<ClosestRows, BatchError> {
    let scope = scope.into();
    let mut out = ClosestRows::blank(rays.len())?;
    Batch::new(world, RayRows(rays), run).fill(out.parts(CHUNK), |worker, ray, part, i| {
        part.set(i, worker.caster.closest(ray, scope)?);
        Ok(())
    })?;
    Ok(out)
}

/// Whether each ray has any crossing.
///
/// # Errors
/// [`BatchError`]: cancelled, a row that is not a ray, a ray beyond its [limits](super::Limits), or too little memory.
pub fn any(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
) -> Result<Vec<bool>, BatchError> {
    let scope = scope.into();
    let mut out = blank(false, rays.len())?;
    Batch::new(world, RayRows(rays), run).fill(out.chunks_mut(CHUNK), |worker, ray, part, i| {
        part[i] = worker.caster.any(ray, scope)?;
        Ok(())
    })?;
    Ok(out)
}

/// The number of crossings of each ray.
///
/// # Errors
/// [`BatchError`]: cancelled, a row that is not a ray, a ray beyond its [limits](super::Limits), or too little memory.
pub fn count(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
) -> Result<Vec<i64>, BatchError> {
    let scope = scope.into();
    let mut out = blank(0, rays.len())?;
    Batch::new(world, RayRows(rays), run).fill(out.chunks_mut(CHUNK), |worker, ray, part, i| {
        part[i] = worker.caster.count(ray, scope)? as i64;
        Ok(())
    })?;
    Ok(out)
}

/// Every crossing of each ray.
///
/// # Errors
/// As [`closest`], and too many crossings of one ray or of all.
pub fn crossings(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
) -> Result<CrossingRows, BatchError> {
    let scope = scope.into();
    Batch::new(world, RayRows(rays), run).gather(|worker, ray, rows: &mut CrossingRows| {
        empty(&mut worker.hits);
        worker.caster.crossings(ray, scope, &mut worker.hits)?;
        rows.push_ray(&worker.hits)?;
        Ok(worker.hits.len())
    })
}

/// The stretches of each ray inside objects.
///
/// # Errors
/// [`BatchError`]: a mesh that is not closed, a row that is not a ray, or else the first ray, by row, that has no
/// answer.
pub fn segments(
    world: &World,
    rays: &(impl Rays + ?Sized),
    span: Span,
    overlaps: Overlaps,
    run: Run,
) -> Result<SegmentRows, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    Batch::new(world, RayRows(rays), run).gather(|worker, ray, rows: &mut SegmentRows| {
        empty(&mut worker.segments);
        rows.overlaps += worker.caster.segments(ray, span, overlaps, &mut worker.segments)?;
        rows.push_ray(&worker.segments)?;
        Ok(worker.segments.len())
    })
}

/// How far each ray goes through each material or object. It takes 8 bytes a ray and column of [`By`].
///
/// # Errors
/// As [`segments`]; too many are more numbers than [`Run::most_rows`].
pub fn thickness(
    world: &World,
    rays: &(impl Rays + ?Sized),
    span: Span,
    by: By,
    overlaps: Overlaps,
    run: Run,
) -> Result<Thickness, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    let columns = by.columns(world);
    // By object there can be more numbers than any machine holds.
    let count = rays.len().checked_mul(columns).filter(|count| *count as u64 <= run.most_rows);
    let mut lengths = blank(0.0, count.ok_or(BatchError::TooMany { most: run.most_rows })?)?;
    let met = AtomicU64::new(0);
    let mut rest = &mut lengths[..];
    // Not `chunks_mut`: without objects there are parts all the same.
    let parts = std::iter::from_fn(move || {
        let size = rest.len().min(CHUNK * columns);
        rest.split_off_mut(..size)
    });
    Batch::new(world, RayRows(rays), run).fill(parts, |worker, ray, part, i| {
        empty(&mut worker.segments);
        let new = worker.caster.segments(ray, span, overlaps, &mut worker.segments)?;
        met.fetch_add(new, Ordering::Relaxed);
        let lengths = &mut part[i * columns..][..columns];
        for segment in &worker.segments {
            lengths[by.column(segment, columns)] += segment.length;
        }
        Ok(())
    })?;
    Ok(Thickness { lengths, columns, overlaps: met.into_inner() })
}

/// What the closest crossing of each ray takes: every counter of [`COUNTERS`], row by row.
///
/// # Errors
/// [`BatchError`]: cancelled, a row that is not a ray, a ray beyond its [limits](super::Limits), or too little memory.
pub fn cost(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
) -> Result<Vec<i64>, BatchError> {
    let columns = COUNTERS.len();
    let scope = scope.into();
    let mut out = blank(0, rays.len().saturating_mul(columns))?;
    Batch::new(world, RayRows(rays), run).fill(out.chunks_mut(CHUNK * columns), |worker, ray, part, i| {
        worker.caster.take_counters();
        worker.caster.closest(ray, scope)?;
        let counters = worker.caster.take_counters();
        for (count, counter) in part[i * columns..].iter_mut().zip(COUNTERS) {
            *count = (counter.of)(&counters) as i64;
        }
        Ok(())
    })?;
    Ok(out)
}

/// Whether each point is inside any object. No promise within rounding of a surface.
///
/// # Errors
/// [`BatchError`]: a mesh that is not closed, a point that is not finite, or cancelled.
pub fn contains(world: &World, points: &(impl Points + ?Sized), run: Run) -> Result<Vec<bool>, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    let mut out = blank(false, points.len())?;
    Batch::new(world, PointRows(points), run).fill(out.chunks_mut(CHUNK), |worker, &point, part, i| {
        empty(&mut worker.objects);
        worker.caster.contains(point, &mut worker.objects)?;
        part[i] = !worker.objects.is_empty();
        Ok(())
    })?;
    Ok(out)
}

/// The objects that hold each point. No promise within rounding of a surface.
///
/// # Errors
/// As [`contains`], and too many rows.
pub fn objects_containing(
    world: &World,
    points: &(impl Points + ?Sized),
    run: Run,
) -> Result<ObjectRows, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    Batch::new(world, PointRows(points), run).gather(|worker, &point, rows: &mut ObjectRows| {
        empty(&mut worker.objects);
        worker.caster.contains(point, &mut worker.objects)?;
        rows.push_point(&worker.objects)?;
        Ok(worker.objects.len())
    })
}

#[cfg(test)]
mod tests;
