//! Runs a batch: workers on all threads take chunks of rows in ascending order.
//!
//! Each result depends only on its row, so neither the chunks nor the number of threads can change it. Chunks
//! are always taken from the front of the remaining rows. So if several rows fail, the first of them is
//! reported, however fast each worker is.

use std::iter;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use rayon::ThreadPool;

use super::rays::Rows;
use super::rows::Ragged;
use super::worker::Worker;
use super::{BatchError, Fields};
use crate::budget::Watch;
use crate::compile::World;
use crate::counters::Counters;
use crate::pool;
use crate::query::QueryError;
use crate::query::block_caster::{BlockError, BlockPlan, RayError};

/// How to run a batch.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Number of threads, at most 256; 0 for one per core. With 1, and for batches of at most
    /// [`SEQUENTIAL_MAX`] rows, the calling thread does the work.
    pub threads: usize,
    /// A thread pool of the caller. Where threads would be used that are kept from batch to batch, all threads of this
    /// pool are used instead.
    pub pool: Option<&'a ThreadPool>,
    /// Called from time to time, from any thread, with the number of rows completed since the last call. Called
    /// with 0 while a single ray takes long.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
    /// The caller sets this flag to end the batch early, even within a ray.
    pub cancel: Option<&'a AtomicBool>,
    /// Receives the sum of the counters of all rays. Rays are then cast one by one, which is slower for meshes.
    pub counters: Option<&'a Mutex<Counters>>,
    /// Receives the number of lists of crossings that were broken by rounding and had to be repaired.
    pub repaired: Option<&'a AtomicU64>,
    /// The columns of the result that are needed; the others stay empty and cost nothing.
    pub fields: Fields,
    /// Maximum number of result rows, of crossings or segments. More are an error, which is returned before
    /// they fill the memory.
    pub most_rows: u64,
}

impl Default for Run<'_> {
    fn default() -> Self {
        Run {
            threads: 0,
            pool: None,
            progress: None,
            cancel: None,
            counters: None,
            repaired: None,
            fields: Fields::ALL,
            most_rows: 1_000_000_000,
        }
    }
}

impl<'a> Run<'a> {
    /// The cancel flag and the progress callback, for the queries of single rays.
    pub fn watch(&self) -> Watch<'a> {
        Watch { cancel: self.cancel, progress: self.progress }
    }
}

/// Rows per work item: small enough to balance expensive rays across threads.
pub(super) const CHUNK: usize = 256;

/// Rows per work item where blocks of rays are cast at meshes, if there are enough for all threads.
const BLOCK_CHUNK: usize = 2048;

/// Fewer rays are cast one by one: to prepare blocks would take longer.
const FEWEST_IN_BLOCKS: usize = 4;

/// Rows between checks of the cancel flag, which long rays also check themselves.
const POLL_INTERVAL: usize = 64;

/// Rows per work item of the validation before the work starts.
const CHECK_CHUNK: usize = 1 << 14;

/// Batches of at most this many rows run on the calling thread: starting threads would cost more than it saves.
pub const SEQUENTIAL_MAX: usize = 4096;

/// Result rows that a worker produces before it adds them to the shared count.
const COUNT_INTERVAL: u64 = 4096;

/// Result rows, about 16 MB, that workers collect in their own buffers before these are appended to the result.
const ROUND: u64 = if cfg!(test) { 2_000 } else { 1 << 18 };

/// When rows are validated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Validation {
    /// All before any work starts.
    First,
    /// Those of a block when it is cast.
    InBlocks,
}

/// A running batch.
pub(super) struct Batch<'a, A> {
    world: &'a World,
    rows: A,
    run: Run<'a>,
    /// Workers that are reused by the next round.
    idle: Mutex<Vec<Worker<'a>>>,
    counted: AtomicU64,
    /// The first row known to have failed, `usize::MAX` if none, and its error.
    failed: AtomicUsize,
    failure: Mutex<Option<(usize, BatchError)>>,
}

impl<'a, A: Rows> Batch<'a, A> {
    pub fn new(world: &'a World, rows: A, run: Run<'a>) -> Batch<'a, A> {
        Batch {
            world,
            rows,
            run,
            idle: Mutex::default(),
            counted: AtomicU64::new(0),
            failed: AtomicUsize::new(usize::MAX),
            failure: Mutex::default(),
        }
    }

    /// Computes one result row for each row. Every worker writes its chunk of [`CHUNK`] rows of the columns in
    /// place.
    pub fn fill<P: Send>(
        &self,
        chunks: impl Iterator<Item = P> + Send,
        query: impl Fn(&mut Worker<'a>, &A::Row, &mut P, usize) -> Result<(), QueryError> + Sync,
    ) -> Result<(), BatchError> {
        self.on_threads(|workers| {
            self.check(workers)?;
            self.dispatch(workers, self.chunks(CHUNK).zip(chunks), |worker, (rows, mut chunk)| {
                let first = rows.start;
                self.run_rows(worker, rows, |worker, one, row| {
                    query(worker, one, &mut chunk, row - first).map(|()| 0)
                });
            });
            self.outcome()
        })
    }

    /// How blocks of rays are cast, see [`plan_of`].
    pub fn block_plan(&self) -> Option<BlockPlan<'a>> {
        plan_of(self.world, &self.run).filter(|_| self.rows.len() >= FEWEST_IN_BLOCKS)
    }

    /// Rows per work item of blocks: fewer if there would be too few items to balance the threads.
    pub fn block_chunk(&self) -> usize {
        let threads = match (self.run.threads, self.run.pool) {
            (1, _) => return BLOCK_CHUNK,
            (_, Some(pool)) => pool.current_num_threads(),
            (0, None) => std::thread::available_parallelism().map_or(1, usize::from),
            (threads, None) => threads,
        };
        (self.rows.len() / (4 * threads)).clamp(CHUNK, BLOCK_CHUNK)
    }

    /// As [`Batch::fill`], by chunks of [`Batch::block_chunk`] rows.
    pub fn fill_blocks<P: Send>(
        &self,
        chunks: impl Iterator<Item = P> + Send,
        query: impl Fn(&mut Worker<'a>, &[[f64; 6]], &mut P) -> Result<(), BlockError> + Sync,
    ) -> Result<(), BatchError> {
        self.on_threads(|workers| {
            let chunks = self.chunks(self.block_chunk()).zip(chunks);
            self.dispatch(workers, chunks, |worker, (rows, mut chunk)| {
                self.run_block(worker, rows, |worker, rays| query(worker, rays, &mut chunk).map(|()| 0));
            });
            self.outcome_of_blocks(workers)
        })
    }

    /// As [`Batch::gather`], by chunks of [`Batch::block_chunk`] rows.
    pub fn gather_blocks<T: Ragged>(
        &self,
        all: &mut T,
        query: impl Fn(&mut Worker<'a>, &[[f64; 6]], &mut T) -> Result<usize, BlockError> + Sync,
    ) -> Result<(), BatchError> {
        self.gather_chunks(self.block_chunk(), Validation::InBlocks, all, |worker, rows, all| {
            self.run_block(worker, rows, |worker, rays| query(worker, rays, all));
        })
    }

    /// Appends any number of result rows for each row; `query` makes them and returns their number. Workers
    /// collect the result rows of a chunk in their own buffers, one round of chunks at a time. Meanwhile the
    /// buffers of the previous round are appended to the result.
    pub fn gather<T: Ragged>(
        &self,
        all: &mut T,
        query: impl Fn(&mut Worker<'a>, &A::Row, &mut T) -> Result<usize, QueryError> + Sync,
    ) -> Result<(), BatchError> {
        self.gather_chunks(CHUNK, Validation::First, all, |worker, rows, all| {
            self.run_rows(worker, rows, |worker, one, _| query(worker, one, all));
        })
    }

    fn gather_chunks<T: Ragged>(
        &self,
        size: usize,
        validation: Validation,
        all: &mut T,
        run: impl Fn(&mut Worker<'a>, Range<usize>, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        self.on_threads(|workers| {
            if validation == Validation::First {
                self.check(workers)?;
            }
            let outcome = || match validation {
                Validation::First => self.outcome(),
                Validation::InBlocks => self.outcome_of_blocks(workers),
            };
            if workers == 1 {
                let mut worker = self.worker();
                self.chunks(size).for_each(|rows| run(&mut worker, rows, all));
                self.recycle(worker);
                return outcome();
            }
            let mut chunks = self.chunks(size);
            let mut done = Vec::new();
            loop {
                let round = || self.compute_round(workers, &mut chunks, &run);
                let append = || done.drain(..).try_for_each(|(_, chunk)| all.append(chunk));
                let (next, appended) = rayon::join(round, append);
                outcome()?;
                appended?;
                if next.is_empty() {
                    return Ok(());
                }
                done = next;
            }
        })
    }

    /// Computes the next round of chunks and returns their results in order.
    fn compute_round<T: Ragged>(
        &self,
        workers: usize,
        chunks: &mut (impl Iterator<Item = Range<usize>> + Send),
        run: &(impl Fn(&mut Worker<'a>, Range<usize>, &mut T) + Sync),
    ) -> Vec<(usize, T)> {
        let (size, done) = (AtomicU64::new(0), Mutex::new(Vec::new()));
        let next = || if size.load(Ordering::Relaxed) < ROUND { chunks.next() } else { None };
        self.dispatch(workers, iter::from_fn(next), |worker, rows| {
            let (first, count, mut chunk) = (rows.start, rows.len(), T::empty());
            run(worker, rows, &mut chunk);
            // Rows without crossings take memory too.
            size.fetch_add((chunk.len() + count) as u64, Ordering::Relaxed);
            if let Ok(mut done) = done.lock() {
                done.push((first, chunk));
            }
        });
        let mut done = done.into_inner().unwrap_or_default();
        done.sort_unstable_by_key(|(first, _)| *first);
        done
    }

    /// Runs `work` with the number of workers; 1 stands for the calling thread.
    fn on_threads<T: Send>(&self, work: impl FnOnce(usize) -> T + Send) -> T {
        if self.run.threads == 1 || self.rows.len() <= SEQUENTIAL_MAX {
            return work(1);
        }
        if let Some(pool) = self.run.pool {
            return pool.install(|| work(pool.current_num_threads()));
        }
        pool::on_threads(self.run.threads, work)
    }

    /// Hands out tasks, in order, to `workers` workers until no task is left or a row has failed.
    fn dispatch<T: Send>(
        &self,
        workers: usize,
        tasks: impl Iterator<Item = T> + Send,
        work: impl Fn(&mut Worker<'a>, T) + Sync,
    ) {
        let tasks = Mutex::new(tasks);
        let next = || tasks.lock().ok()?.next().filter(|_| self.failed.load(Ordering::Relaxed) == usize::MAX);
        let run_worker = || {
            let mut worker = self.worker();
            while let Some(task) = next() {
                work(&mut worker, task);
            }
            self.recycle(worker);
        };
        if workers == 1 {
            run_worker();
        } else {
            rayon::scope(|scope| (0..workers).for_each(|_| scope.spawn(|_| run_worker())));
        }
    }

    fn worker(&self) -> Worker<'a> {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        idle.unwrap_or_else(|| Worker::new(self.world, self.run.watch()))
    }

    fn recycle(&self, mut worker: Worker<'a>) {
        let done = worker.caster.take_counters();
        if let Some(repaired) = self.run.repaired {
            repaired.fetch_add(done.repaired, Ordering::Relaxed);
        }
        if let Some(mut work) = self.run.counters.and_then(|work| work.lock().ok()) {
            *work += done;
        }
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(worker);
        }
    }

    fn chunks(&self, size: usize) -> impl Iterator<Item = Range<usize>> + Send + use<'a, A> {
        let rows = self.rows.len();
        (0..rows).step_by(size).map(move |first| first..rows.min(first + size))
    }

    /// Validates all rows before any result is computed.
    fn check(&self, workers: usize) -> Result<(), BatchError> {
        self.dispatch(workers, self.chunks(CHECK_CHUNK), |_, rows| {
            let first = rows.start;
            let checked = self.check_cancelled().map_err(|error| (first, error));
            if let Err((row, error)) = checked.and_then(|()| self.rows.check(rows)) {
                self.fail(row, error);
            }
        });
        self.outcome()
    }

    /// Runs rows one after the other. Stops at a row that fails, and before rows that come after a failed row.
    fn run_rows(
        &self,
        worker: &mut Worker<'a>,
        rows: Range<usize>,
        mut query: impl FnMut(&mut Worker<'a>, &A::Row, usize) -> Result<usize, QueryError>,
    ) {
        let mut first = rows.start;
        while first < rows.end && first < self.failed.load(Ordering::Relaxed) {
            let some = first..rows.end.min(first + POLL_INTERVAL);
            first = some.end;
            if let Err((row, error)) = self.try_rows(worker, some, &mut query) {
                return self.fail(row, error);
            }
        }
    }

    /// Runs rays as one block, unless a row before it has failed.
    fn run_block(
        &self,
        worker: &mut Worker<'a>,
        rows: Range<usize>,
        query: impl FnOnce(&mut Worker<'a>, &[[f64; 6]]) -> Result<usize, BlockError>,
    ) {
        let first = rows.start;
        if first < self.failed.load(Ordering::Relaxed)
            && let Err((row, error)) = self.try_block(worker, rows, query)
        {
            self.fail(row, error);
        }
    }

    fn try_block(
        &self,
        worker: &mut Worker<'a>,
        rows: Range<usize>,
        query: impl FnOnce(&mut Worker<'a>, &[[f64; 6]]) -> Result<usize, BlockError>,
    ) -> Result<(), (usize, BatchError)> {
        let (first, count) = (rows.start, rows.len());
        self.check_cancelled().map_err(|error| (first, error))?;
        let mut memory = std::mem::take(&mut worker.rays);
        let made = self.rows.rays(rows, &mut memory).map(|rays| query(worker, rays));
        worker.rays = memory;
        let made = made?.map_err(|error| block_error(first, error))?;
        self.count(made as u64).map_err(|error| (first, error))?;
        if let Some(progress) = self.run.progress {
            progress(count as u64);
        }
        Ok(())
    }

    fn try_rows(
        &self,
        worker: &mut Worker<'a>,
        rows: Range<usize>,
        query: &mut impl FnMut(&mut Worker<'a>, &A::Row, usize) -> Result<usize, QueryError>,
    ) -> Result<(), (usize, BatchError)> {
        let (first, count) = (rows.start, rows.len());
        self.check_cancelled().map_err(|error| (first, error))?;
        let mut made = 0;
        for row in rows {
            let one = self.rows.row(row).map_err(|error| (row, error))?;
            let new = query(worker, &one, row);
            made += new.map_err(|error| (row, row_error(row, error)))? as u64;
            if made >= COUNT_INTERVAL {
                self.count(std::mem::take(&mut made)).map_err(|error| (row, error))?;
            }
        }
        self.count(made).map_err(|error| (first, error))?;
        if let Some(progress) = self.run.progress {
            progress(count as u64);
        }
        Ok(())
    }

    fn check_cancelled(&self) -> Result<(), BatchError> {
        let cancelled = self.run.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err(BatchError::Cancelled) } else { Ok(()) }
    }

    fn count(&self, rows: u64) -> Result<(), BatchError> {
        let most = self.run.most_rows;
        let too_many = self.counted.fetch_add(rows, Ordering::Relaxed) + rows > most;
        if too_many { Err(BatchError::TooMany { most }) } else { Ok(()) }
    }

    fn fail(&self, row: usize, error: BatchError) {
        self.failed.fetch_min(row, Ordering::Relaxed);
        if let Ok(mut failure) = self.failure.lock()
            && failure.as_ref().is_none_or(|(first, _)| row < *first)
        {
            *failure = Some((row, error));
        }
    }

    /// The outcome where blocks validate their own rows. An invalid row comes before any other error, as if all rows had
    /// been validated first.
    fn outcome_of_blocks(&self, workers: usize) -> Result<(), BatchError> {
        let outcome = self.outcome();
        if outcome.is_err() {
            self.failed.store(usize::MAX, Ordering::Relaxed);
            self.check(workers)?;
        }
        outcome
    }

    fn outcome(&self) -> Result<(), BatchError> {
        match self.failure.lock().ok().and_then(|mut failure| failure.take()) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }
}

/// How blocks of rays are cast. `None` where rays are cast one by one: also where counters are requested, which blocks
/// do not have.
pub(super) fn plan_of<'w>(world: &'w World, run: &Run) -> Option<BlockPlan<'w>> {
    if run.counters.is_some() { None } else { BlockPlan::of(world) }
}

/// The row and the error of a batch for the error of a block of rows from `first`.
pub(super) fn block_error(first: usize, BlockError { row, error }: BlockError) -> (usize, BatchError) {
    let row = first + row;
    let error = match error {
        RayError::Query(error) => row_error(row, error),
        RayError::Ray(error) => BatchError::Ray { row, error },
    };
    (row, error)
}

/// The error of a batch for the error of one row.
pub(super) fn row_error(row: usize, error: QueryError) -> BatchError {
    match error {
        QueryError::Cancelled => BatchError::Cancelled,
        QueryError::OutOfMemory => BatchError::OutOfMemory,
        error => BatchError::Query { row, error },
    }
}
