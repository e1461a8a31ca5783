//! What a query wants of a ray, and what it makes of the boundaries that it is given.

use super::Scope;
use super::walk::{Meeting, Walk};
use crate::csg::Boundary;
use crate::solid::Wanted;

/// Where the fold stands after a boundary.
pub(super) enum Go {
    /// Nothing beyond this `t` is wanted any more.
    UpTo(f64),
    Stop,
}

/// What a query makes of the boundaries it is given. The walk can be asked about the body.
pub(super) type Fold<'f, 'w> = dyn FnMut(&mut Walk<'w>, &Meeting, Boundary) -> Go + 'f;

/// What is wanted of a ray.
pub(super) struct Quest<'q> {
    pub scope: Scope,
    /// All boundaries of each body, or the first.
    pub wanted: Wanted,
    /// The way to the body that is asked first.
    pub seed: &'q [u32],
}
