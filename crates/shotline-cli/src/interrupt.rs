//! Ctrl-C, and the other signals that ask a program to end. Long work asks the flag from time to time and ends cleanly; outside of it Ctrl-C ends the
//! program at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::failure::Failure;

/// How long work may take to notice.
const PATIENCE: Duration = Duration::from_millis(150);

static ASKED: AtomicBool = AtomicBool::new(false);
static LISTENING: AtomicBool = AtomicBool::new(false);
static NOTICED: AtomicBool = AtomicBool::new(false);

/// Begins to catch Ctrl-C.
pub fn catch() {
    // Fails only if the process has a handler of its own already; then that one decides.
    let _ = ctrlc::set_handler(|| {
        let again = ASKED.swap(true, Ordering::SeqCst);
        if !again && LISTENING.load(Ordering::SeqCst) {
            std::thread::sleep(PATIENCE);
        }
        // Work that has ended by itself ends the program.
        if again || LISTENING.load(Ordering::SeqCst) || !NOTICED.load(Ordering::SeqCst) {
            shotline_io::remove_unfinished();
            Failure::Interrupted.report();
            std::process::exit(Failure::Interrupted.exit_code().into());
        }
    });
}

/// Runs work that asks the flag it is handed, and cleans up after itself when the flag is set. Work that does not end soon
/// then, and a second Ctrl-C, end the program at once; what was being written is removed.
///
/// # Errors
/// Those of the work, and [`Failure::Interrupted`] if Ctrl-C came before its end.
pub fn listening<T>(work: impl FnOnce(&'static AtomicBool) -> Result<T, Failure>) -> Result<T, Failure> {
    ASKED.store(false, Ordering::SeqCst);
    LISTENING.store(true, Ordering::SeqCst);
    let result = work(&ASKED);
    let asked = ASKED.load(Ordering::SeqCst);
    NOTICED.store(asked, Ordering::SeqCst);
    LISTENING.store(false, Ordering::SeqCst);
    if asked { Err(Failure::Interrupted) } else { result }
}
