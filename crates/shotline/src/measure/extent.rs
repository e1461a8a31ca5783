//! What is known of an object before rays are cast: its box, and its moments where they have a closed form.

use super::known::KnownMoments;
use crate::aabb::Aabb;

/// All there is of an object in some frame.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    pub bounds: Aabb,
    /// Its moments, where bodies and boxes allow.
    pub moments: Option<KnownMoments>,
    /// A body of it that has no inside.
    pub open: Option<u32>,
}

impl Extent {
    /// Whether it has no end, or none that its box tells.
    pub fn is_unbounded(&self) -> bool {
        !self.bounds.is_empty() && !self.bounds.is_finite()
    }
}
