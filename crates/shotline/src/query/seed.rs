//! Seeds: coherent rays meet the same bodies, so each may begin with what the one before it met.
//!
//! A seed only changes the order in which bodies are asked. Any occluder answers whether there is one; and the
//! closest crossing is the least of all, in whatever order they are found. So no answer depends on it.

use super::walk::{Meeting, Walk};
use crate::accel::Work;

/// The body that the last ray of a series met, by the whole way to it: shared parts are met in many places.
///
/// For rays that go alike: those to one light, or of neighbouring pixels. It belongs to whoever casts them, one
/// for each series and thread.
#[derive(Clone, Debug, Default)]
pub struct Seed {
    way: Vec<u32>,
    path: u64,
}

impl Seed {
    pub(super) fn way(&self) -> &[u32] {
        &self.way
    }

    /// Takes the body that a ray met as the next ray's, and counts whether it was this ray's.
    pub(super) fn keep(&mut self, met: &Meeting, walk: &Walk, work: &mut Work) {
        work.seeded += 1;
        if !self.way.is_empty() && self.path == met.path {
            work.seeded_right += 1;
            return;
        }
        walk.way(met, &mut self.way);
        self.path = met.path;
    }
}
