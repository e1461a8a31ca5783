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

impl RowBlock<'_> {
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
