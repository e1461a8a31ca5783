//! Ends a search of a mesh early.

use std::sync::atomic::{AtomicBool, Ordering};

/// A search of a mesh was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A flag that any thread may set to end a search. What a search has found when the flag is set is incomplete, so the
/// caller calls [`Stop::check`] after the search and drops what was found.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stop<'c>(Option<&'c AtomicBool>);

impl<'c> Stop<'c> {
    /// Never ends the search.
    pub(super) const NEVER: Stop<'static> = Stop(None);

    pub(super) fn when(cancel: Option<&'c AtomicBool>) -> Stop<'c> {
        Stop(cancel)
    }

    /// Whether the search should end.
    pub(super) fn is_set(self) -> bool {
        self.0.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// # Errors
    /// [`Cancelled`] if the flag is set.
    pub(super) fn check(self) -> Result<(), Cancelled> {
        if self.is_set() { Err(Cancelled) } else { Ok(()) }
    }
}
