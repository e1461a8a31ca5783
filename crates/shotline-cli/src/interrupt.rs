//! Ctrl-C, and the other signals that request a program to end. Long work tests a flag from time to time and ends
//! cleanly. Otherwise Ctrl-C ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::failure::Failure;

/// The time that work has, after Ctrl-C, to end by itself.
const GRACE: Duration = Duration::from_millis(150);

/// Whether the user has requested the program to end.
static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Whether cancellable work is running.
static IS_WORKING: AtomicBool = AtomicBool::new(false);
/// Whether the last cancellable work ended after the request, so that its command ends the program.
static WAS_CANCELLED: AtomicBool = AtomicBool::new(false);

/// Begins to catch Ctrl-C.
pub fn catch() {
    // Fails only if the process already has a handler; then that handler decides.
    let _ = ctrlc::set_handler(|| {
        let again = REQUESTED.swap(true, Ordering::SeqCst);
        if !again && IS_WORKING.load(Ordering::SeqCst) {
            std::thread::sleep(GRACE);
        }
        // If the work has ended by itself by now, its command ends the program.
        if again || IS_WORKING.load(Ordering::SeqCst) || !WAS_CANCELLED.load(Ordering::SeqCst) {
            shotline_io::remove_unfinished();
            Failure::Interrupted.report();
            std::process::exit(Failure::Interrupted.exit_code().into());
        }
    });
}

/// Runs work that tests the given flag, and ends and cleans up when the flag is set. If it does not end soon, or at a
/// second Ctrl-C, the program ends at once and removes the file that is being written.
///
/// # Errors
/// The errors of the work, and [`Failure::Interrupted`] if Ctrl-C came before its end.
pub fn cancellable<T>(work: impl FnOnce(&'static AtomicBool) -> Result<T, Failure>) -> Result<T, Failure> {
    REQUESTED.store(false, Ordering::SeqCst);
    IS_WORKING.store(true, Ordering::SeqCst);
    let result = work(&REQUESTED);
    let requested = REQUESTED.load(Ordering::SeqCst);
    WAS_CANCELLED.store(requested, Ordering::SeqCst);
    IS_WORKING.store(false, Ordering::SeqCst);
    if requested { Err(Failure::Interrupted) } else { result }
}
