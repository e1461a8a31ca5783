//! A block of rays.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Scope;

/// A block of rays, and what a query looks for.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowBlock<'r> {
    pub rays: &'r [[f64; 6]],
    pub scope: Scope,
    /// Whether the normals of hits are needed.
    pub wants_normals: bool,
    /// Set by any thread to stop early.
    pub cancel: Option<&'r AtomicBool>,
}

impl<'r> RowBlock<'r> {
    /// The same for a query whose answers have no normals.
    pub fn without_normals(&self) -> RowBlock<'r> {
        RowBlock { wants_normals: false, ..*self }
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
