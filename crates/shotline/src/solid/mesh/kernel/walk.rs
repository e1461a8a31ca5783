//! One ray alone, from a node of a stream down. What a stream does at a node for all of its rays at once costs more than
//! it saves where few of them get there.

use super::block::Coordinate;
use super::context::Kernel;
use super::found::{Found, Mode};
use super::leaf::{corners, project};
use super::node::push_met;
use super::ray::KernelRay;
use crate::accel::wide::{LEAF, WIDTH};
use crate::simd::Simd;

/// Steps between two reads of the cancel flag: well below a millisecond.
const POLL_INTERVAL: u32 = 1024;

/// The pending children of a ray, and the keys of where they begin.
#[derive(Debug, Default)]
pub(super) struct WalkStack {
    children: Vec<u32>,
    keys: Vec<u32>,
}

/// Visits a child and what is below it. Returns whether that ends the ray.
#[inline(always)]
pub(super) fn walk<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    ray: &mut KernelRay,
    child: u32,
    stack: &mut WalkStack,
    found: &mut Found,
) -> bool {
    let room = kernel.tree.stack_size + WIDTH;
    stack.children.resize(room, 0);
    stack.keys.resize(room, 0);
    let (mut child, mut height) = (child, 0);
    for steps in 1.. {
        if steps % POLL_INTERVAL == 0 && (kernel.block.is_cancelled() || found.is_full()) {
            return true;
        }
        if child & LEAF == 0 {
            let node = &kernel.tree.nodes[child as usize];
            height = push_met::<S, M>(node, ray, (&mut stack.children[..], &mut stack.keys[..]), height);
        } else if visit_leaf::<S, C, M>(kernel, ray, child & !LEAF, found) {
            return true;
        }
        loop {
            let Some(below) = height.checked_sub(1) else { return false };
            height = below;
            child = stack.children[height];
            if !M::CLOSEST || stack.keys[height] <= ray.limit().to_bits() + 16 {
                break;
            }
        }
    }
    false
}

/// Visits a leaf. Returns whether that ends the ray.
#[inline(always)]
fn visit_leaf<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    ray: &mut KernelRay,
    leaf: u32,
    found: &mut Found,
) -> bool {
    let corners = corners::<S, C>(&kernel.blocks[leaf as usize], ray.axes);
    let projection = &project::<S>(&corners, ray);
    if !projection.is_possible() {
        return false;
    }
    if M::ANY {
        return kernel.any_in_leaf::<S, M>(projection, ray, leaf);
    }
    if M::CLOSEST {
        kernel.closest_in_leaf::<S>(projection, ray, leaf);
    } else {
        kernel.all_in_leaf::<S>(projection, ray, leaf, found);
    }
    false
}
