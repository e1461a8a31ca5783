//! Batches over all cores: arrays in, arrays out. The result has the same bits for any split and any number of
//! threads.
//!
//! Rays and points are requested by index ([`Rays`], [`Points`]), so they need not be copied. All are validated
//! before any work starts. The memory needed is that of the result and some tens of MB.

mod batch_caster;
mod fields;
mod rays;
mod rows;
mod run;
mod worker;

use std::sync::atomic::{AtomicU64, Ordering};

pub use batch_caster::BatchCaster;
pub use fields::Fields;
pub use rays::{Points, Rays, RowsOfSix};
pub use rows::{By, ClosestRows, CrossingRows, ObjectRows, SegmentRows, Thickness};
use rows::{Ragged, blank};
pub use run::{Run, SEQUENTIAL_MAX};

use super::caster::all_solid;
use super::{Overlaps, QueryError, Scope, Segment};
use crate::compile::World;
use crate::counters::COUNTERS;
use crate::query::row_block::RowBlock;
use crate::query::row_hit::{ListsOfRows, RowHit};
use crate::ray::{InvalidRay, Span};
use rays::{PointRows, RayRows};
use run::{Batch, CHUNK};
use worker::empty;

/// Why a batch has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// The batch was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The world does not support the query. Found before any work starts.
    #[error(transparent)]
    World(QueryError),
    /// A row is not a ray. The first such row is reported, before any work starts unless the row changed later.
    #[error("ray {row}: {error}")]
    Ray {
        /// The row.
        row: usize,
        /// Why it is not a ray.
        error: InvalidRay,
    },
    /// A point is not finite. Found in the same way as rows that are not rays.
    #[error("point {row} has a coordinate that is NaN or infinite")]
    Point {
        /// The row.
        row: usize,
    },
    /// The result has too many rows.
    #[error("the answer has more than {most} row{}", if *most == 1 { "" } else { "s" })]
    TooMany {
        /// The maximum.
        most: u64,
    },
    /// The result does not fit into memory.
    #[error("there is not enough memory for the answers")]
    OutOfMemory,
    /// The query of a ray failed.
    #[error("ray {row}: {error}")]
    Query {
        /// The first row whose query failed.
        row: usize,
        /// Why.
        error: QueryError,
    },
}

/// Validates rays, as every query does before its work starts.
///
/// # Errors
/// [`BatchError::Ray`] with the first row that is not a ray.
pub fn check(rays: &(impl Rays + ?Sized)) -> Result<(), BatchError> {
    rays.check(0..rays.len()).map_err(|(row, error)| BatchError::Ray { row, error })
}

/// A block of rays for a query.
fn block<'r>(run: &Run<'r>, rays: &'r [[f64; 6]], scope: impl Into<Scope>) -> RowBlock<'r> {
    let wants_normals = run.fields.contains(Fields::NORMAL);
    RowBlock { rays, scope: scope.into(), wants_normals, cancel: run.cancel }
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
    let mut out = ClosestRows::default();
    closest_into(world, rays, scope, run, &mut out)?;
    Ok(out)
}

/// As [`closest`], into rows whose memory is used again.
///
/// # Errors
/// As [`closest`]. Then the rows mean nothing.
pub fn closest_into(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
    out: &mut ClosestRows,
) -> Result<(), BatchError> {
    let scope = scope.into();
    out.resize(rays.len(), run.fields)?;
    let batch = Batch::new(world, RayRows(rays), run);
    if let Some(plan) = batch.block_plan() {
        batch.fill_blocks(out.chunks(batch.block_chunk()), |worker, rays, chunk| {
            chunk.clear();
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.closest(&block(&run, rays, scope), memory, &mut |i, hit| chunk.set(i, hit))
        })?;
        return Ok(());
    }
    batch.fill(out.chunks(CHUNK), |worker, ray, chunk, i| {
        if i == 0 {
            chunk.clear();
        }
        if let Some(hit) = worker.caster.closest(ray, scope)? {
            chunk.set(i, &RowHit::from(&hit));
        }
        Ok(())
    })
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
    let batch = Batch::new(world, RayRows(rays), run);
    if let Some(plan) = batch.block_plan() {
        batch.fill_blocks(out.chunks_mut(batch.block_chunk()), |worker, rays, chunk| {
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.any(&block(&run, rays, scope), memory, &mut |i| chunk[i] = true)
        })?;
        return Ok(out);
    }
    batch.fill(out.chunks_mut(CHUNK), |worker, ray, chunk, i| {
        chunk[i] = worker.caster.any(ray, scope)?;
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
    let batch = Batch::new(world, RayRows(rays), run);
    if let Some(plan) = batch.block_plan() {
        batch.fill_blocks(out.chunks_mut(batch.block_chunk()), |worker, rays, chunk| {
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.count(&block(&run, rays, scope), memory, &mut |i, count| chunk[i] = count as i64)
        })?;
        return Ok(out);
    }
    batch.fill(out.chunks_mut(CHUNK), |worker, ray, chunk, i| {
        chunk[i] = worker.caster.count(ray, scope)? as i64;
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
    let mut out = CrossingRows::empty();
    crossings_into(world, rays, scope, run, &mut out)?;
    Ok(out)
}

/// As [`crossings`], into rows whose memory is used again.
///
/// # Errors
/// As [`crossings`]. Then the rows mean nothing.
pub fn crossings_into(
    world: &World,
    rays: &(impl Rays + ?Sized),
    scope: impl Into<Scope>,
    run: Run,
    out: &mut CrossingRows,
) -> Result<(), BatchError> {
    let scope = scope.into();
    out.clear();
    let batch = Batch::new(world, RayRows(rays), run);
    if let Some(plan) = batch.block_plan() {
        return batch.gather_blocks(out, |worker, rays, rows| {
            let mut made = 0;
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.crossings(&block(&run, rays, scope), memory, &mut |lists| {
                made += lists.hits.len();
                Ok(rows.push_rays(lists, run.fields)?)
            })?;
            Ok(made)
        });
    }
    batch.gather(out, |worker, ray, rows| {
        empty(&mut worker.hits);
        empty(&mut worker.row_hits);
        worker.caster.crossings(ray, scope, &mut worker.hits)?;
        worker.row_hits.extend(worker.hits.iter().map(RowHit::from));
        let (hits, ends) = (&worker.row_hits, &[worker.row_hits.len()]);
        rows.push_rays(ListsOfRows { hits, ends, before: 0 }, run.fields)?;
        Ok(worker.hits.len())
    })
}

/// The intervals of each ray inside objects.
///
/// # Errors
/// [`BatchError`]: a mesh that is not closed, a row that is not a ray, or otherwise the first ray, by row,
/// whose query fails.
pub fn segments(
    world: &World,
    rays: &(impl Rays + ?Sized),
    span: Span,
    overlaps: Overlaps,
    run: Run,
) -> Result<SegmentRows, BatchError> {
    let mut out = SegmentRows::empty();
    segments_into(world, rays, span, overlaps, run, &mut out)?;
    Ok(out)
}

/// As [`segments`], into rows whose memory is used again.
///
/// # Errors
/// As [`segments`]. Then the rows mean nothing.
pub fn segments_into(
    world: &World,
    rays: &(impl Rays + ?Sized),
    span: Span,
    overlaps: Overlaps,
    run: Run,
    out: &mut SegmentRows,
) -> Result<(), BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    out.clear();
    let batch = Batch::new(world, RayRows(rays), run);
    if let Some(plan) = batch.block_plan() {
        return batch.gather_blocks(out, |worker, rays, rows| {
            let mut made = 0;
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.segments(&block(&run, rays, span), overlaps, memory, &mut |_, segments, overlaps| {
                made += segments.len();
                rows.overlaps += overlaps;
                Ok(rows.push_ray(segments)?)
            })?;
            Ok(made)
        });
    }
    batch.gather(out, |worker, ray, rows| {
        empty(&mut worker.segments);
        rows.overlaps += worker.caster.segments(ray, span, overlaps, &mut worker.segments)?;
        rows.push_ray(&worker.segments)?;
        Ok(worker.segments.len())
    })
}

/// The length of each ray in each material or object. The result takes 8 bytes per ray and column of [`By`].
///
/// # Errors
/// As [`segments`], and [`BatchError::TooMany`] for more values than [`Run::most_rows`].
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
    // With a column per object there can be more values than any machine holds.
    let count = rays.len().checked_mul(columns).filter(|count| *count as u64 <= run.most_rows);
    let mut lengths = blank(0.0, count.ok_or(BatchError::TooMany { most: run.most_rows })?)?;
    let met = AtomicU64::new(0);
    let mut rest = &mut lengths[..];
    // Not `chunks_mut`, which panics for size 0: without objects every chunk is empty.
    let batch = Batch::new(world, RayRows(rays), run);
    let plan = batch.block_plan();
    let chunk_rows = if plan.is_some() { batch.block_chunk() } else { CHUNK };
    let chunks = std::iter::from_fn(move || {
        let size = rest.len().min(chunk_rows * columns);
        rest.split_off_mut(..size)
    });
    let add = |chunk: &mut [f64], i: usize, segments: &[Segment], overlaps: u64| {
        met.fetch_add(overlaps, Ordering::Relaxed);
        let lengths = &mut chunk[i * columns..][..columns];
        for segment in segments {
            lengths[by.column(segment, columns)] += segment.length;
        }
    };
    match plan {
        Some(plan) => batch.fill_blocks(chunks, |worker, rays, chunk| {
            let (mut blocks, memory) = worker.blocks(&plan);
            blocks.segments(&block(&run, rays, span), overlaps, memory, &mut |i, segments, overlaps| {
                add(chunk, i, segments, overlaps);
                Ok(())
            })
        })?,
        None => batch.fill(chunks, |worker, ray, chunk, i| {
            empty(&mut worker.segments);
            let overlaps = worker.caster.segments(ray, span, overlaps, &mut worker.segments)?;
            add(chunk, i, &worker.segments, overlaps);
            Ok(())
        })?,
    }
    Ok(Thickness { lengths, columns, overlaps: met.into_inner() })
}

/// The cost of the closest crossing of each ray: every counter of [`COUNTERS`], row by row.
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
    Batch::new(world, RayRows(rays), run).fill(
        out.chunks_mut(CHUNK * columns),
        |worker, ray, chunk, i| {
            worker.caster.take_counters();
            worker.caster.closest(ray, scope)?;
            let counters = worker.caster.take_counters();
            for (count, counter) in chunk[i * columns..].iter_mut().zip(COUNTERS) {
                *count = (counter.of)(&counters) as i64;
            }
            Ok(())
        },
    )?;
    Ok(out)
}

/// Whether each point is inside any object. Nothing is promised for points within rounding error of a surface.
///
/// # Errors
/// [`BatchError`]: a mesh that is not closed, a point that is not finite, or cancelled.
pub fn contains(world: &World, points: &(impl Points + ?Sized), run: Run) -> Result<Vec<bool>, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    let mut out = blank(false, points.len())?;
    Batch::new(world, PointRows(points), run).fill(out.chunks_mut(CHUNK), |worker, &point, chunk, i| {
        empty(&mut worker.objects);
        worker.caster.contains(point, &mut worker.objects)?;
        chunk[i] = !worker.objects.is_empty();
        Ok(())
    })?;
    Ok(out)
}

/// The objects that contain each point. Nothing is promised for points within rounding error of a surface.
///
/// # Errors
/// As [`contains`], and too many rows.
pub fn objects_containing(
    world: &World,
    points: &(impl Points + ?Sized),
    run: Run,
) -> Result<ObjectRows, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    let mut out = ObjectRows::empty();
    Batch::new(world, PointRows(points), run).gather(&mut out, |worker, &point, rows| {
        empty(&mut worker.objects);
        worker.caster.contains(point, &mut worker.objects)?;
        rows.push_point(&worker.objects)?;
        Ok(worker.objects.len())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests;
