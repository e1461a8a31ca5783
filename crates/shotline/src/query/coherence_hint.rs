//! Coherence hints: coherent rays often hit the same body, so each ray of a series first tests the body that
//! the previous ray hit.
//!
//! A hint only changes the order in which bodies are tested. Any occluder proves that there is one, and the
//! closest crossing is the minimum over all crossings in any order. So no result depends on the hint.

use super::traversal::{BodyEntry, Traversal};
use crate::counters::Counters;

/// The body that the previous ray of a series hit. It is stored as the placements on the path to it, because a
/// shared body has many placements.
///
/// Meant for coherent rays: those to one light, or those of neighbouring pixels. The caller owns it and keeps
/// one for each series and thread.
#[derive(Clone, Debug, Default)]
pub struct CoherenceHint {
    placements: Vec<u32>,
    path: u64,
}

impl CoherenceHint {
    pub(super) fn placements(&self) -> &[u32] {
        &self.placements
    }

    /// Stores the body that a ray hit for the next ray, and counts whether the hint was right for this ray.
    pub(super) fn keep(&mut self, met: &BodyEntry, traversal: &Traversal, counters: &mut Counters) {
        counters.hinted += 1;
        if !self.placements.is_empty() && self.path == met.placed.path {
            counters.hint_hits += 1;
            return;
        }
        traversal.placements_on_path(met, &mut self.placements);
        self.path = met.placed.path;
    }
}
