//! Long work without the GIL, during which the calling thread still handles Ctrl-C and reports progress.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use shotline::query::batch::{Run, SEQUENTIAL_MAX};

/// The longest delay of Ctrl-C, also within a single ray, and the interval between progress reports.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Progress, reported as (done, total) by the calling thread.
struct Progress<'a> {
    callback: Option<&'a Py<PyAny>>,
    done: AtomicU64,
    total: usize,
}

impl Progress<'_> {
    fn add(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Checks signals, then reports. An exception of either ends the work.
    fn report(&self, py: Python) -> PyResult<()> {
        py.check_signals()?;
        match self.callback {
            Some(callback) => callback.call1(py, (self.done.load(Ordering::Relaxed), self.total)).map(drop),
            None => Ok(()),
        }
    }
}

/// Runs a batch of `rows` rows. Ctrl-C and exceptions of the callable cancel it, and are raised when it has ended.
pub fn batch_work<T: Send>(
    py: Python,
    rows: usize,
    threads: usize,
    progress: Option<&Py<PyAny>>,
    batch: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    // Starting another thread takes 0.1 ms, as long as some hundred rays.
    if threads == 1 || rows <= SEQUENTIAL_MAX {
        run_here(py, rows, progress, batch)
    } else {
        work(py, rows, threads, progress, batch)
    }
}

/// Runs work on the calling thread.
fn run_here<T: Send>(
    py: Python,
    total: usize,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let state = Progress { callback: progress, done: AtomicU64::new(0), total };
    // The time of the last report, and what it raised.
    let last = Mutex::new((Instant::now(), Ok(())));
    let advance = |steps| {
        state.add(steps);
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.0.elapsed() >= POLL_INTERVAL && last.1.is_ok() {
            *last = (Instant::now(), Python::attach(|py| state.report(py)));
            cancel.store(last.1.is_err(), Ordering::Relaxed);
        }
    };
    let run = Run { threads: 1, progress: Some(&advance), cancel: Some(&cancel), ..Run::default() };
    let result = py.detach(|| work(run));
    last.into_inner().unwrap_or_else(PoisonError::into_inner).1?;
    state.report(py)?;
    Ok(result)
}

/// Runs work of `total` steps that may use any threads: it starts on a new thread, while the calling thread waits. Ctrl-C
/// and exceptions of the callable cancel it, and are raised when it has ended.
pub fn work<T: Send>(
    py: Python,
    total: usize,
    threads: usize,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let state = Progress { callback: progress, done: AtomicU64::new(0), total };
    let advance = |steps| state.add(steps);
    thread::scope(|scope| {
        let (ended, mut wait) = channel();
        let run = Run { threads, progress: Some(&advance), cancel: Some(&cancel), ..Run::default() };
        let worker = thread::Builder::new().name("shotline".into()).spawn_scoped(scope, move || {
            let result = work(run);
            // Nothing receives this once an exception was raised.
            let _ = ended.send(());
            result
        })?;
        let mut raised = Ok(());
        loop {
            let (message, again) = py.detach(move || (wait.recv_timeout(POLL_INTERVAL), wait));
            wait = again;
            if message != Err(RecvTimeoutError::Timeout) {
                break;
            }
            raised = state.report(py);
            if raised.is_err() {
                cancel.store(true, Ordering::Relaxed);
                break;
            }
        }
        let result = py.detach(|| worker.join());
        raised?;
        let result = result.map_err(|_| PyRuntimeError::new_err("shotline failed; please report it"))?;
        state.report(py)?;
        Ok(result)
    })
}
