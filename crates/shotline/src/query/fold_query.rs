//! What a query requests of a ray, and how it receives the boundaries.

use super::Scope;
use super::traversal::{BodyEntry, Traversal};
use crate::csg::Boundary;
use crate::solid::Wanted;

/// How the fold continues after a boundary.
pub(super) enum FoldControl {
    /// Boundaries beyond this `t` are no longer needed.
    Limit(f64),
    Stop,
}

/// The callback of a query, called for each boundary with the traversal and the body.
pub(super) type Fold<'f, 'w> = dyn FnMut(&mut Traversal<'w>, &BodyEntry, Boundary) -> FoldControl + 'f;

/// What a query requests of a ray.
pub(super) struct FoldQuery<'q> {
    pub scope: Scope,
    /// All boundaries of each body, or only the first.
    pub wanted: Wanted,
    /// The placements on the path to the body that is tested first; empty without a hint.
    pub hint: &'q [u32],
}
