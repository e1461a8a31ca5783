//! What a query wants of a ray, and what it makes of the boundaries that it is given.

use super::Scope;
use super::traversal::{BodyEntry, Traversal};
use crate::csg::Boundary;
use crate::solid::Wanted;

/// Where the fold stands after a boundary.
pub(super) enum FoldControl {
    /// Nothing beyond this `t` is wanted any more.
    Limit(f64),
    Stop,
}

/// What a query makes of the boundaries it is given. The walk can be asked about the body.
pub(super) type Fold<'f, 'w> = dyn FnMut(&mut Traversal<'w>, &BodyEntry, Boundary) -> FoldControl + 'f;

/// What is wanted of a ray.
pub(super) struct FoldQuery<'q> {
    pub scope: Scope,
    /// All boundaries of each body, or the first.
    pub wanted: Wanted,
    /// The way to the body that is asked first.
    pub hint: &'q [u32],
}
