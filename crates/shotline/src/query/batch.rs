//! Batches over all cores: arrays in, arrays out; the same bits for any split and number of threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::caster::all_solid;
use super::{Caster, Hit, MAX_OF_A_RAY, Overlaps, QueryError, Segment};
use crate::accel::Work;
use crate::compile::World;
use crate::ray::{Ray, Span};

/// How to run a batch.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Threads; 0 for one a core.
    pub threads: usize,
    /// Called from time to time with the number of rays done since the last call, from any thread.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
    /// Set to end the batch early.
    pub cancel: Option<&'a AtomicBool>,
    /// Where the work done is added up.
    pub work: Option<&'a Mutex<Work>>,
    /// More rows than this, of crossings or segments, are an error, told before they fill the memory.
    pub most_rows: u64,
}

impl Default for Run<'_> {
    fn default() -> Self {
        Run { threads: 0, progress: None, cancel: None, work: None, most_rows: 1_000_000_000 }
    }
}

/// Why a batch has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// It was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// No ray has an answer: found before any work starts.
    #[error(transparent)]
    World(QueryError),
    /// All answers together have too many rows.
    #[error("the answer has more than {most} rows")]
    TooMany {
        /// How many there may be.
        most: u64,
    },
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

/// Rays answered by one thread between looks at the cancel flag.
const CHUNK: usize = 4096;

/// Rows that a thread gathers before it counts them with those of the others.
const ROWS: u64 = 4096;

/// Runs a job over chunks of rays on a pool of its own and answers the results in order. Each result depends
/// on its rays only, so the split and the number of threads cannot change it. The job says how many rows it
/// has added to a result that grows with the crossings.
fn over_chunks<T: Default + Send>(
    world: &World,
    rays: &[Ray],
    run: Run,
    job: impl Fn(&mut Caster, &Ray, &mut T) -> Result<usize, QueryError> + Sync,
) -> Result<Vec<T>, BatchError> {
    let all_rows = AtomicU64::new(0);
    let count = |rows: u64| {
        let too_many = all_rows.fetch_add(rows, Ordering::Relaxed) + rows > run.most_rows;
        if too_many { Err(BatchError::TooMany { most: run.most_rows }) } else { Ok(()) }
    };
    let one = |caster: &mut Caster, (index, chunk): (usize, &[Ray])| {
        if run.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
            return Err(BatchError::Cancelled);
        }
        let (mut result, mut rows) = (T::default(), 0);
        for (i, ray) in chunk.iter().enumerate() {
            let row = index * CHUNK + i;
            rows += job(caster, ray, &mut result).map_err(|error| BatchError::Query { row, error })? as u64;
            if rows >= ROWS {
                count(std::mem::take(&mut rows))?;
            }
        }
        count(rows)?;
        let done = caster.take_work();
        if let Some(mut work) = run.work.and_then(|work| work.lock().ok()) {
            *work += done;
        }
        if let Some(progress) = run.progress {
            progress(chunk.len() as u64);
        }
        Ok(result)
    };
    let sequential = || {
        let mut caster = Caster::new(world);
        rays.chunks(CHUNK).enumerate().map(|chunk| one(&mut caster, chunk)).collect()
    };
    if run.threads == 1 || rays.len() <= CHUNK {
        return sequential();
    }
    // Without threads to be had, the work is done by this one.
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(run.threads).build() else {
        return sequential();
    };
    let results: Vec<Result<T, BatchError>> =
        pool.install(|| rays.par_chunks(CHUNK).enumerate().map_init(|| Caster::new(world), one).collect());
    // In order, so that of several rays without an answer the first is named.
    results.into_iter().collect()
}

fn or_minus_one(x: Option<u32>) -> i32 {
    x.map_or(-1, |x| x as i32)
}

/// The closest crossing of each ray.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn closest(world: &World, rays: &[Ray], span: Span, run: Run) -> Result<ClosestRows, BatchError> {
    let parts = over_chunks(world, rays, run, |caster, ray, rows: &mut ClosestRows| {
        rows.push(caster.closest(ray, span));
        Ok(0)
    })?;
    let mut out = ClosestRows::default();
    parts.into_iter().for_each(|part| out.append(part));
    Ok(out)
}

impl ClosestRows {
    /// Appends the rows of further rays.
    pub fn append(&mut self, mut rows: ClosestRows) {
        self.t.append(&mut rows.t);
        self.normal.append(&mut rows.normal);
        self.object.append(&mut rows.object);
        self.surface.append(&mut rows.surface);
        self.primitive.append(&mut rows.primitive);
        self.path.append(&mut rows.path);
        self.entering.append(&mut rows.entering);
        self.t_err.append(&mut rows.t_err);
    }

    fn push(&mut self, hit: Option<Hit>) {
        self.t.push(hit.map_or(f64::INFINITY, |h| h.t));
        self.normal.push(hit.map_or([f64::NAN; 3], |h| h.normal.to_array()));
        self.object.push(or_minus_one(hit.map(|h| h.object)));
        self.surface.push(or_minus_one(hit.and_then(|h| h.surface)));
        self.primitive.push(or_minus_one(hit.and_then(|h| h.primitive)));
        self.path.push(hit.map_or(-1, |h| h.path as i64));
        self.entering.push(hit.is_some_and(|h| h.entering));
        self.t_err.push(hit.map_or(f64::NAN, |h| h.t_err));
    }
}

/// Whether each ray has any crossing.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn any(world: &World, rays: &[Ray], span: Span, run: Run) -> Result<Vec<bool>, BatchError> {
    let parts = over_chunks(world, rays, run, |caster, ray, rows: &mut Vec<bool>| {
        rows.push(caster.any(ray, span));
        Ok(0)
    })?;
    Ok(parts.concat())
}

/// The number of crossings of each ray.
///
/// # Errors
/// [`BatchError::Cancelled`].
pub fn count(world: &World, rays: &[Ray], span: Span, run: Run) -> Result<Vec<i64>, BatchError> {
    let parts = over_chunks(world, rays, run, |caster, ray, rows: &mut Vec<i64>| {
        rows.push(caster.count(ray, span) as i64);
        Ok(0)
    })?;
    Ok(parts.concat())
}

/// Every crossing of each ray.
///
/// # Errors
/// [`BatchError`]: cancelled, or too many of one ray or of all.
pub fn crossings(world: &World, rays: &[Ray], span: Span, run: Run) -> Result<CrossingRows, BatchError> {
    #[derive(Default)]
    struct Part {
        counts: Vec<usize>,
        hits: Vec<Hit>,
    }
    let parts = over_chunks(world, rays, run, |caster, ray, part: &mut Part| {
        let before = part.hits.len();
        caster.crossings_up_to(ray, span, MAX_OF_A_RAY, &mut part.hits)?;
        let rows = part.hits.len() - before;
        part.counts.push(rows);
        Ok(rows)
    })?;
    let mut out = CrossingRows { ray_splits: vec![0], ..CrossingRows::default() };
    for part in parts {
        append_splits(&mut out.ray_splits, &part.counts);
        for hit in part.hits {
            out.push(&hit);
        }
    }
    Ok(out)
}

fn append_splits(splits: &mut Vec<i64>, counts: &[usize]) {
    let mut at = splits.last().copied().unwrap_or(0);
    for &count in counts {
        at += count as i64;
        splits.push(at);
    }
}

impl CrossingRows {
    fn push(&mut self, hit: &Hit) {
        self.t.push(hit.t);
        self.normal.push(hit.normal.to_array());
        self.entering.push(hit.entering);
        self.object.push(hit.object as i32);
        self.surface.push(or_minus_one(hit.surface));
        self.primitive.push(or_minus_one(hit.primitive));
        self.path.push(hit.path as i64);
        self.kind.push(hit.kind as i8);
        self.t_err.push(hit.t_err);
    }
}

/// The stretches of each ray inside objects.
///
/// # Errors
/// [`BatchError`]: a mesh that is not closed, or else the first ray, by row, that has no answer.
pub fn segments(
    world: &World,
    rays: &[Ray],
    span: Span,
    overlaps: Overlaps,
    run: Run,
) -> Result<SegmentRows, BatchError> {
    all_solid(world).map_err(BatchError::World)?;
    #[derive(Default)]
    struct Part {
        counts: Vec<usize>,
        segments: Vec<Segment>,
        overlaps: u64,
    }
    let parts = over_chunks(world, rays, run, |caster, ray, part: &mut Part| {
        let before = part.segments.len();
        part.overlaps += caster.segments(ray, span, overlaps, &mut part.segments)?;
        let rows = part.segments.len() - before;
        part.counts.push(rows);
        Ok(rows)
    })?;
    let mut out = SegmentRows { ray_splits: vec![0], ..SegmentRows::default() };
    for part in parts {
        append_splits(&mut out.ray_splits, &part.counts);
        out.overlaps += part.overlaps;
        for segment in part.segments {
            out.push(&segment);
        }
    }
    Ok(out)
}

impl SegmentRows {
    fn push(&mut self, segment: &Segment) {
        self.t_in.push(segment.t_in);
        self.t_out.push(segment.t_out);
        self.length.push(segment.length);
        self.material.push(or_minus_one(segment.material));
        self.object.push(segment.object as i32);
        self.path.push(segment.path as i64);
    }
}
