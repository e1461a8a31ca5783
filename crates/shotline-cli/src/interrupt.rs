//! Ctrl-C. Long work asks the flag from time to time and ends cleanly; outside of it Ctrl-C ends the
//! program at once.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

static ASKED: AtomicBool = AtomicBool::new(false);
static LISTENING: AtomicBool = AtomicBool::new(false);

/// Begins to catch Ctrl-C.
pub fn catch() {
    // Fails only if the process has a handler of its own already; then that one decides.
    let _ = ctrlc::set_handler(|| {
        let again = ASKED.swap(true, Ordering::SeqCst);
        if again || !LISTENING.load(Ordering::SeqCst) {
            Failure::Interrupted.report();
            std::process::exit(Failure::Interrupted.exit_code().into());
        }
    });
}

/// Runs work that asks the flag it is handed, and cleans up after itself when the flag is set. A second
/// Ctrl-C does not wait for it.
///
/// # Errors
/// Those of the work, and [`Failure::Interrupted`] if Ctrl-C came before its end.
pub fn listening<T>(work: impl FnOnce(&'static AtomicBool) -> Result<T, Failure>) -> Result<T, Failure> {
    ASKED.store(false, Ordering::SeqCst);
    LISTENING.store(true, Ordering::SeqCst);
    let result = work(&ASKED);
    LISTENING.store(false, Ordering::SeqCst);
    if ASKED.load(Ordering::SeqCst) { Err(Failure::Interrupted) } else { result }
}
