//! Long work without the GIL, in which Python's thread still answers Ctrl-C and tells of progress.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use shotline::query::batch::{Run, SEQUENTIAL_MAX};

/// How long Ctrl-C may have to wait, also within a single ray, and how often progress is reported.
const PULSE: Duration = Duration::from_millis(50);

/// Progress, reported as (done, total) by the thread that called.
struct Told<'a> {
    to: Option<&'a Py<PyAny>>,
    done: AtomicU64,
    total: usize,
}

impl Told<'_> {
    fn add(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Tells, after a look at signals. What either raises ends the work.
    fn tell(&self, py: Python) -> PyResult<()> {
        py.check_signals()?;
        match self.to {
            Some(to) => to.call1(py, (self.done.load(Ordering::Relaxed), self.total)).map(drop),
            None => Ok(()),
        }
    }
}

/// Runs a batch of so many rows. Ctrl-C and what the callable raises cancel it, and are raised when it has ended.
pub fn batch_work<T: Send>(
    py: Python,
    rows: usize,
    threads: usize,
    progress: Option<&Py<PyAny>>,
    batch: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    // Another thread to wait for takes 0.1 ms: as long as some hundred rays.
    if threads == 1 || rows <= SEQUENTIAL_MAX {
        work_here(py, rows, progress, batch)
    } else {
        work(py, rows, threads, progress, batch)
    }
}

/// Runs work that stays on the thread it is called from, and on that of the caller.
fn work_here<T: Send>(
    py: Python,
    total: usize,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let told = Told { to: progress, done: AtomicU64::new(0), total };
    // When it was told last, and what was raised then.
    let last = Mutex::new((Instant::now(), Ok(())));
    let advance = |steps| {
        told.add(steps);
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.0.elapsed() >= PULSE && last.1.is_ok() {
            *last = (Instant::now(), Python::attach(|py| told.tell(py)));
            cancel.store(last.1.is_err(), Ordering::Relaxed);
        }
    };
    let run = Run { threads: 1, progress: Some(&advance), cancel: Some(&cancel), ..Run::default() };
    let result = py.detach(|| work(run));
    last.into_inner().unwrap_or_else(PoisonError::into_inner).1?;
    told.tell(py)?;
    Ok(result)
}

/// Runs work of so many steps that may use any threads: it has one of its own, while that of the caller waits. Ctrl-C and
/// what the callable raises cancel it, and are raised when it has ended.
pub fn work<T: Send>(
    py: Python,
    total: usize,
    threads: usize,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let told = Told { to: progress, done: AtomicU64::new(0), total };
    let advance = |steps| told.add(steps);
    thread::scope(|scope| {
        let (ended, mut wait) = channel();
        let run = Run { threads, progress: Some(&advance), cancel: Some(&cancel), ..Run::default() };
        let worker = thread::Builder::new().name("shotline".into()).spawn_scoped(scope, move || {
            let result = work(run);
            // Nobody listens any more once something was raised.
            let _ = ended.send(());
            result
        })?;
        let mut raised = Ok(());
        loop {
            let (message, again) = py.detach(move || (wait.recv_timeout(PULSE), wait));
            wait = again;
            if message != Err(RecvTimeoutError::Timeout) {
                break;
            }
            raised = told.tell(py);
            if raised.is_err() {
                cancel.store(true, Ordering::Relaxed);
                break;
            }
        }
        let result = py.detach(|| worker.join());
        raised?;
        let result = result.map_err(|_| PyRuntimeError::new_err("shotline failed; please report it"))?;
        told.tell(py)?;
        Ok(result)
    })
}
