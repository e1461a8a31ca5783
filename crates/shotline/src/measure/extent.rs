//! What is known of an object before rays are cast: its box, and its moments if they have a closed form.

use super::known::KnownMoments;
use crate::aabb::Aabb;

/// The extent of an object in some frame.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    pub bounds: Aabb,
    /// Its moments, if its bodies and boxes determine them.
    pub moments: Option<KnownMoments>,
    /// A body of it that has no inside.
    pub open: Option<u32>,
}

impl Extent {
    /// Whether it is unbounded, or its box does not show that it is bounded.
    pub fn is_unbounded(&self) -> bool {
        !self.bounds.is_empty() && !self.bounds.is_finite()
    }
}
