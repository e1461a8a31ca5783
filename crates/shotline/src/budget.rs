//! The budget of one ray: a number of steps, and a cancel flag that is read between them.
//!
//! Traversals call [`Budget::step`] for each entry that they take from a heap or a stack. It costs a decrement; the
//! flag is read once in `POLL_INTERVAL` steps.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

/// Steps between two reads of the cancel flag: a fraction of a millisecond.
const POLL_INTERVAL: u64 = 1024;

/// How the caller of a query monitors and cancels it while it runs.
#[derive(Clone, Copy, Default)]
pub struct Watch<'c> {
    /// Set by any thread to end the query with an error.
    pub cancel: Option<&'c AtomicBool>,
    /// Called with 0 from time to time while a single ray is processed, by the thread that processes it.
    pub progress: Option<&'c (dyn Fn(u64) + Sync)>,
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Watch { cancel, progress } = self;
        f.debug_struct("Watch").field("cancel", cancel).field("progress", &progress.is_some()).finish()
    }
}

/// Why a ray was abandoned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The cancel flag was set.
    Cancelled,
    /// The ray has used all its steps.
    Exhausted,
}

/// The steps of one ray. Without [`Budget::begin`] they are unlimited.
#[derive(Clone, Debug)]
pub struct Budget<'c> {
    watch: Watch<'c>,
    /// Steps until the flag is read next.
    slice: u64,
    /// Steps left after those.
    rest: u64,
    most: u64,
    ended: Option<StopReason>,
}

impl Default for Budget<'_> {
    fn default() -> Self {
        Budget { watch: Watch::default(), slice: 0, rest: u64::MAX, most: u64::MAX, ended: None }
    }
}

impl<'c> Budget<'c> {
    /// Uses another watch from the next ray on.
    pub fn watch(&mut self, watch: Watch<'c>) {
        self.watch = watch;
    }

    /// Begins a ray of at most `most` steps.
    pub fn begin(&mut self, most: u64) {
        let slice = most.min(POLL_INTERVAL);
        (self.slice, self.rest, self.most, self.ended) = (slice, most - slice, most, None);
    }

    /// Takes a step. If it returns `false` the traversal must end: its result is invalid, and [`Budget::ended`]
    /// returns the reason.
    #[inline]
    pub fn step(&mut self) -> bool {
        match self.slice.checked_sub(1) {
            Some(left) => {
                self.slice = left;
                true
            }
            None => self.refill(),
        }
    }

    #[cold]
    fn refill(&mut self) -> bool {
        if self.rest == 0 {
            self.ended = self.ended.or(Some(StopReason::Exhausted));
        }
        self.check();
        if self.ended.is_some() {
            return false;
        }
        let slice = self.rest.min(POLL_INTERVAL);
        self.rest -= slice;
        self.slice = slice - 1;
        true
    }

    /// Reads the cancel flag now and reports progress, for work that takes no steps.
    pub fn check(&mut self) {
        if let Some(progress) = self.watch.progress {
            progress(0);
        }
        if self.watch.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
            self.ended = Some(StopReason::Cancelled);
        }
    }

    /// Why the ray was abandoned; `None` if it was not.
    pub fn ended(&self) -> Option<StopReason> {
        self.ended
    }

    /// Steps taken since [`Budget::begin`].
    pub fn used(&self) -> u64 {
        self.most - self.rest - self.slice
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU64;

    use super::*;

    #[test]
    fn a_ray_has_so_many_steps_and_no_more() {
        for most in [0, 1, POLL_INTERVAL - 1, POLL_INTERVAL, POLL_INTERVAL + 1, 10 * POLL_INTERVAL + 7] {
            let mut budget = Budget::default();
            for _ in 0..2 {
                budget.begin(most);
                assert_eq!((0..2 * most + 9).filter(|_| budget.step()).count() as u64, most);
                assert_eq!((budget.ended(), budget.used()), (Some(StopReason::Exhausted), most));
            }
        }
    }

    #[test]
    fn the_flag_is_read_within_a_slice() {
        let (cancel, looks) = (AtomicBool::new(false), AtomicU64::new(0));
        let progress = |steps| {
            assert_eq!(steps, 0);
            looks.fetch_add(1, Ordering::Relaxed);
        };
        let mut budget = Budget::default();
        budget.watch(Watch { cancel: Some(&cancel), progress: Some(&progress) });
        budget.begin(u64::MAX);
        assert!((0..10 * POLL_INTERVAL).all(|_| budget.step()));
        assert_eq!(looks.load(Ordering::Relaxed), 9);
        cancel.store(true, Ordering::Relaxed);
        assert!((0..3 * POLL_INTERVAL).filter(|_| budget.step()).count() as u64 <= POLL_INTERVAL);
        assert_eq!(budget.ended(), Some(StopReason::Cancelled));
    }
}
