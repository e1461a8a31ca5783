//! Bounds a search of a mesh, by the steps that all of its threads take together.

use std::sync::atomic::{AtomicU64, Ordering};

use super::stop::Stop;

/// Steps that a thread takes before it adds them to those of the others: well below a millisecond.
const INTERVAL: u64 = 1024;

/// The steps of a search.
#[derive(Debug)]
pub(super) struct Effort<'c> {
    spent: AtomicU64,
    most: u64,
    stop: Stop<'c>,
}

impl<'c> Effort<'c> {
    /// A search that may take some steps, until `stop` is set.
    pub(super) fn new(most: u64, stop: Stop<'c>) -> Effort<'c> {
        Effort { spent: AtomicU64::new(0), most, stop }
    }

    /// Whether the search has taken more steps than it may. Once it has ended, that does not depend on its threads: a
    /// search that needs no more steps takes all of them, and none ends another before it has taken too many.
    pub(super) fn is_exhausted(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > self.most
    }

    /// Whether the search should end. What it has found then is incomplete.
    pub(super) fn is_over(&self) -> bool {
        self.stop.is_set() || self.is_exhausted()
    }

    /// Begins the steps of a thread.
    pub(super) fn steps(&self) -> Steps<'_> {
        Steps { effort: self, own: 0, is_over: self.is_over() }
    }
}

/// The steps of one thread.
#[derive(Debug)]
pub(super) struct Steps<'e> {
    effort: &'e Effort<'e>,
    /// The steps that have not been added to the effort.
    own: u64,
    is_over: bool,
}

impl Steps<'_> {
    /// Takes a step. Returns `false` if the search should end.
    #[inline]
    pub(super) fn step(&mut self) -> bool {
        self.own += 1;
        if self.own == INTERVAL {
            self.add();
        }
        !self.is_over
    }

    fn add(&mut self) {
        self.effort.spent.fetch_add(self.own, Ordering::Relaxed);
        self.own = 0;
        self.is_over = self.effort.is_over();
    }
}

impl Drop for Steps<'_> {
    fn drop(&mut self) {
        self.add();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_is_exhausted_by_the_steps_of_all_threads() {
        for (each, is_exhausted) in [(2500, false), (2501, true)] {
            let effort = Effort::new(10_000, Stop::NEVER);
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| {
                        let mut steps = effort.steps();
                        (0..each).for_each(|_| _ = steps.step());
                    });
                }
            });
            assert_eq!(effort.is_exhausted(), is_exhausted);
        }
        let effort = Effort::new(10_000, Stop::NEVER);
        let mut steps = effort.steps();
        assert!((0..100_000).filter(|_| steps.step()).count() as u64 <= 10_000 + INTERVAL);
    }
}
