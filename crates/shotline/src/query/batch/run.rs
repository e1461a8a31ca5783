//! Runs a batch: workers on all threads take chunks of rows in ascending order.
//!
//! Each result depends only on its row, so neither the chunks nor the number of threads can change it. Chunks
//! are always taken from the front of the remaining rows. So if several rows fail, the first of them is
//! reported, however fast each worker is.

use std::iter;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::BatchError;
use super::rays::Rows;
use super::rows::Ragged;
use crate::budget::Watch;
use crate::compile::World;
use crate::counters::Counters;
use crate::query::{Caster, Hit, QueryError, Segment};

/// How to run a batch.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Number of threads, at most 256; 0 for one per core. With 1, and for batches of at most
    /// [`SEQUENTIAL_MAX`] rows, the calling thread does the work.
    pub threads: usize,
    /// A thread pool of the caller. Where new threads would be started, all threads of this pool are used
    /// instead.
    pub pool: Option<&'a ThreadPool>,
    /// Called from time to time, from any thread, with the number of rows completed since the last call. Called
    /// with 0 while a single ray takes long.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
    /// The caller sets this flag to end the batch early, even within a ray.
    pub cancel: Option<&'a AtomicBool>,
    /// Receives the sum of the counters of all rays.
    pub counters: Option<&'a Mutex<Counters>>,
    /// Maximum number of result rows, of crossings or segments. More are an error, which is returned before
    /// they fill the memory.
    pub most_rows: u64,
}

impl Default for Run<'_> {
    fn default() -> Self {
        Run { threads: 0, pool: None, progress: None, cancel: None, counters: None, most_rows: 1_000_000_000 }
    }
}

impl<'a> Run<'a> {
    /// The cancel flag and the progress callback, for the queries of single rays.
    pub fn watch(&self) -> Watch<'a> {
        Watch { cancel: self.cancel, progress: self.progress }
    }

    /// The number of threads of a new pool. More than 256 threads take longer to start than they save.
    pub fn pool_threads(&self) -> usize {
        self.threads.min(256)
    }
}

/// Rows per work item: small enough to balance expensive rays across threads.
pub(super) const CHUNK: usize = 256;

/// Rows between checks of the cancel flag, which long rays also check themselves.
const BLOCK: usize = 64;

/// Rows per work item of the validation before the work starts.
const CHECK_CHUNK: usize = 1 << 14;

/// Batches of at most this many rows run on the calling thread: starting threads would cost more than it saves.
pub const SEQUENTIAL_MAX: usize = 4096;

/// Result rows that a worker produces before it adds them to the shared count.
const COUNT_INTERVAL: u64 = 4096;

/// Result rows, about 16 MB, that workers collect in their own buffers before these are appended to the result.
const WAVE: u64 = if cfg!(test) { 2_000 } else { 1 << 18 };

/// The memory of one worker.
pub(super) struct Worker<'w> {
    pub caster: Caster<'w>,
    pub hits: Vec<Hit>,
    pub segments: Vec<Segment>,
    pub objects: Vec<u32>,
}

/// Clears a buffer that a worker reuses from row to row, and frees memory that only a rare row needs.
pub(super) fn empty<T>(kept: &mut Vec<T>) {
    kept.clear();
    kept.shrink_to(4096);
}

/// A running batch.
pub(super) struct Batch<'a, A> {
    world: &'a World,
    rows: A,
    run: Run<'a>,
    /// Workers that are reused by the next wave.
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

    /// Computes any number of result rows for each row; `query` appends them and returns their number. Workers
    /// collect the result rows of a chunk in their own buffers, one wave of chunks at a time. Meanwhile the
    /// buffers of the previous wave are appended to the result.
    pub fn gather<T: Ragged>(
        &self,
        query: impl Fn(&mut Worker<'a>, &A::Row, &mut T) -> Result<usize, QueryError> + Sync,
    ) -> Result<T, BatchError> {
        self.on_threads(|workers| {
            self.check(workers)?;
            let mut all = T::empty();
            if workers == 1 {
                let mut worker = self.worker();
                self.run_rows(&mut worker, 0..self.rows.len(), |worker, one, _| query(worker, one, &mut all));
                self.recycle(worker);
                return self.outcome().map(|()| all);
            }
            let mut chunks = self.chunks(CHUNK);
            let mut done = Vec::new();
            loop {
                let wave = || self.wave(workers, &mut chunks, &query);
                let append = || done.drain(..).try_for_each(|(_, chunk)| all.append(chunk));
                let (next, appended) = rayon::join(wave, append);
                self.outcome()?;
                appended?;
                if next.is_empty() {
                    return Ok(all);
                }
                done = next;
            }
        })
    }

    /// Computes the next wave of chunks and returns their results in order.
    fn wave<T: Ragged>(
        &self,
        workers: usize,
        chunks: &mut (impl Iterator<Item = Range<usize>> + Send),
        query: &(impl Fn(&mut Worker<'a>, &A::Row, &mut T) -> Result<usize, QueryError> + Sync),
    ) -> Vec<(usize, T)> {
        let (size, done) = (AtomicU64::new(0), Mutex::new(Vec::new()));
        let next = || if size.load(Ordering::Relaxed) < WAVE { chunks.next() } else { None };
        self.dispatch(workers, iter::from_fn(next), |worker, rows| {
            let (first, mut chunk) = (rows.start, T::empty());
            self.run_rows(worker, rows, |worker, one, _| query(worker, one, &mut chunk));
            // Rows without crossings take memory too.
            size.fetch_add((chunk.len() + CHUNK) as u64, Ordering::Relaxed);
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
        match ThreadPoolBuilder::new().num_threads(self.run.pool_threads()).build() {
            Ok(pool) => pool.install(|| work(pool.current_num_threads())),
            // If no threads can be started, the calling thread does the work.
            Err(_) => work(1),
        }
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
        idle.unwrap_or_else(|| {
            let mut caster = Caster::new(self.world);
            caster.watch(self.run.watch());
            Worker { caster, hits: vec![], segments: vec![], objects: vec![] }
        })
    }

    fn recycle(&self, mut worker: Worker<'a>) {
        let done = worker.caster.take_counters();
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
            let block = first..rows.end.min(first + BLOCK);
            first = block.end;
            if let Err((row, error)) = self.run_block(worker, block, &mut query) {
                return self.fail(row, error);
            }
        }
    }

    fn run_block(
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

    fn outcome(&self) -> Result<(), BatchError> {
        match self.failure.lock().ok().and_then(|mut failure| failure.take()) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }
}

/// The error of a batch for the error of one row.
fn row_error(row: usize, error: QueryError) -> BatchError {
    match error {
        QueryError::Cancelled => BatchError::Cancelled,
        QueryError::OutOfMemory => BatchError::OutOfMemory,
        error => BatchError::Query { row, error },
    }
}
