//! Seeds: coherent rays meet the same bodies, so each may begin with what the one before it met.
//!
//! A seed only changes the order in which bodies are asked. Any occluder answers whether there is one; and the
//! closest crossing is the least of all, in whatever order they are found. So no answer depends on it.

use super::traversal::{BodyEntry, Traversal};
use crate::counters::Counters;

/// The body that the last ray of a series met, by the whole way to it: shared parts are met in many places.
///
/// For rays that go alike: those to one light, or of neighbouring pixels. It belongs to whoever casts them, one
/// for each series and thread.
#[derive(Clone, Debug, Default)]
pub struct CoherenceHint {
    placements: Vec<u32>,
    path: u64,
}

impl CoherenceHint {
    pub(super) fn placements(&self) -> &[u32] {
        &self.placements
    }

    /// Takes the body that a ray met as the next ray's, and counts whether it was this ray's.
    pub(super) fn keep(&mut self, met: &BodyEntry, traversal: &Traversal, counters: &mut Counters) {
        counters.hinted += 1;
        if !self.placements.is_empty() && self.path == met.path {
            counters.hinted_right += 1;
            return;
        }
        traversal.placements_on_path(met, &mut self.placements);
        self.path = met.path;
    }
}
