//! The working memory of one thread, which queries reuse from ray to ray.

use crate::budget::Budget;
use crate::counters::Counters;
use crate::tags::Tags;
use crate::trace::Log;

/// The working memory of a traversal, reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub struct Scratch<'c> {
    /// Work counted so far.
    pub counters: Counters,
    /// Tags of the items of one structure at a time.
    pub tags: Tags,
    /// The pending nodes and leaves of the hierarchy of a mesh, each with the `t` at which it begins.
    pub(crate) pending: Vec<(f64, u32)>,
    /// Steps, while they are recorded.
    pub log: Log,
    /// The triangles of the mesh queried last whose planes contain the line, up to rounding.
    pub in_plane: Vec<u32>,
    /// The remaining budget of the ray.
    pub budget: Budget<'c>,
}
