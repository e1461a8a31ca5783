//! The memory of one thread that queries use again from ray to ray.

use crate::budget::Budget;
use crate::counters::Counters;
use crate::tags::Tags;
use crate::trace::Log;

/// The memory of whoever walks; reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub struct Scratch<'c> {
    /// Work counted so far.
    pub counters: Counters,
    /// Tags of the items of one structure at a time.
    pub tags: Tags,
    /// Steps, while they are recorded.
    pub log: Log,
    /// The triangles of the mesh asked last in whose planes the line runs, up to rounding.
    pub in_plane: Vec<u32>,
    /// What the ray may still cost.
    pub budget: Budget<'c>,
}
