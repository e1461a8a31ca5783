//! Long work on another thread, while Python's own answers Ctrl-C and tells of progress.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use shotline::query::batch::Run;

/// How long Ctrl-C may have to wait, and how often progress is told.
const PULSE: Duration = Duration::from_millis(50);

/// So few rays are not worth a thread of their own, nor several.
const FEW: usize = 64;

/// Runs work of so many steps without the GIL. Progress is told to a callable as (done, total), from the thread that
/// called. What that raises, and Ctrl-C, cancel the work, and are raised when it has ended.
pub fn work<T: Send>(
    py: Python,
    total: usize,
    threads: usize,
    progress: Option<&Bound<PyAny>>,
    work: impl FnOnce(Run) -> T + Send,
) -> PyResult<T> {
    if total <= FEW && progress.is_none() {
        return Ok(py.detach(|| work(Run { threads: 1, ..Run::default() })));
    }
    let (cancel, done) = (AtomicBool::new(false), AtomicU64::new(0));
    let advance = |steps| _ = done.fetch_add(steps, Ordering::Relaxed);
    let tell = || match progress {
        Some(progress) => progress.call1((done.load(Ordering::Relaxed), total)).map(|_| ()),
        None => Ok(()),
    };
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
            raised = py.check_signals().and_then(|()| tell());
            if raised.is_err() {
                cancel.store(true, Ordering::Relaxed);
                break;
            }
        }
        let result = py.detach(|| worker.join());
        raised?;
        let result = result.map_err(|_| PyRuntimeError::new_err("shotline failed; please report it"))?;
        py.check_signals()?;
        tell()?;
        Ok(result)
    })
}
