//! Which bodies rays can be cast at in lanes together, each lane at a body of its own: bodies whose leaves are of the same
//! kinds, combined in the same way.

use std::collections::HashMap;
use std::sync::Arc;

use super::world::{Body, SolidBody};
use crate::solid::lanes::GROUPS;

/// The [`World::lane_group`](super::World::lane_group) of each body. Single leaves have the number of their kind of kernel.
pub(super) fn lane_groups(bodies: &[Arc<Body>]) -> Vec<u32> {
    let mut known = HashMap::new();
    let mut groups = Vec::with_capacity(bodies.len());
    // A body without others of its form has its own number.
    for (number, body) in (GROUPS..).zip(bodies) {
        groups.push(match kernels(body) {
            Some((_, kernels)) if kernels.len() == 1 => kernels[0],
            Some((body, kernels)) => *known.entry((body.program.form(), kernels)).or_insert(number),
            None => number,
        });
    }
    groups
}

/// A body that takes lanes, and the kinds of kernels of its leaves, if all have kernels.
fn kernels(body: &Body) -> Option<(&SolidBody, Vec<u32>)> {
    let Body::Solid(body @ SolidBody { takes_lanes: true, .. }) = body else { return None };
    let kernels = body.leaves.iter().map(|leaf| leaf.solid.in_lanes().map(|solid| solid.group()));
    Some((body, kernels.collect::<Option<_>>()?))
}
