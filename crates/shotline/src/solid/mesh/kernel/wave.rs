//! Incoherent rays: 32 of them in flight, each a step at a time.
//!
//! A step has no branch that depends on the data, and the node or leaf that a ray needs next is requested one pass
//! before it is used. So neither mispredicted branches nor cache misses stop the CPU.

use super::block::Coordinate;
use super::context::Kernel;
use super::found::{Found, Mode};
use super::leaf;
use super::node::{push_eight, push_met};
use super::prepare::AT_A_TIME;
use super::ray::KernelRay;
use crate::accel::wide::{LEAF, WIDTH};
use crate::simd::Simd;

/// The number of rays in flight. 16 and 64 were slower.
pub(super) const IN_FLIGHT: usize = 32;

/// Passes between two reads of the cancel flag: well below a millisecond.
const POLL_INTERVAL: u32 = 256;

/// The end of a stack.
const END: u32 = u32::MAX;

/// The memory of a wave.
#[derive(Debug, Default)]
pub(super) struct Slots {
    rays: Vec<KernelRay>,
    /// A stack for each slot: the pending children, and the keys of where they begin.
    children: Vec<u32>,
    keys: Vec<u32>,
    /// The height of each stack, without the entry that the ray stands before.
    heights: [u32; IN_FLIGHT],
    /// The child that each ray stands before.
    current: [u32; IN_FLIGHT],
}

/// Slots by number.
#[derive(Clone, Copy)]
struct List {
    slots: [u8; IN_FLIGHT + 1],
    len: usize,
}

impl List {
    const EMPTY: List = List { slots: [0; IN_FLIGHT + 1], len: 0 };

    /// Appends a slot if a condition holds, without a branch.
    #[inline(always)]
    fn push_if(&mut self, slot: usize, condition: bool) {
        self.slots[self.len] = slot as u8;
        self.len += usize::from(condition);
    }
}

/// Casts the rays of some rows.
#[inline(always)]
pub(super) fn cast<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    rows: std::ops::Range<usize>,
    slots: &mut Slots,
    found: &mut Found,
) {
    let room = kernel.tree.stack_size + WIDTH;
    slots.rays.resize(IN_FLIGHT, KernelRay::default());
    slots.children.resize(IN_FLIGHT * room, END);
    slots.keys.resize(IN_FLIGHT * room, 0);
    let (mut next, mut free) = (rows.start, List::EMPTY);
    (0..IN_FLIGHT).for_each(|slot| free.push_if(slot, true));
    let (mut at_nodes, mut at_leaves) = (List::EMPTY, List::EMPTY);
    for pass in 1.. {
        if pass % POLL_INTERVAL == 0 && (kernel.block.is_cancelled() || found.is_full()) {
            return;
        }
        while free.len >= AT_A_TIME && next < rows.end {
            // Behind the last ray, it is prepared again.
            let rows_of: [usize; AT_A_TIME] = std::array::from_fn(|i| (next + i).min(rows.end - 1));
            let into: [usize; AT_A_TIME] =
                std::array::from_fn(|i| usize::from(free.slots[free.len - 1 - i]) % IN_FLIGHT);
            let prepared = kernel.prepare::<S>(rows_of, into, &mut slots.rays);
            free.len -= AT_A_TIME;
            let ready = found.take_prepared(next, rows.end - next, prepared);
            for (i, slot) in into.into_iter().enumerate() {
                let is_ready = ready >> i & 1 == 1;
                slots.current[slot] = 0;
                slots.heights[slot] = 1;
                slots.children[slot * room] = END;
                slots.keys[slot * room] = 0;
                at_nodes.push_if(slot, is_ready);
                free.push_if(slot, !is_ready);
            }
            next += AT_A_TIME;
        }
        if at_nodes.len == 0 && at_leaves.len == 0 {
            return;
        }
        // Rays that reach a leaf in this pass, after those that reached one in the last.
        let (mut nodes_next, mut leaves_now) = (List::EMPTY, at_leaves);
        for &slot in &at_nodes.slots[..at_nodes.len] {
            let slot = usize::from(slot) % IN_FLIGHT;
            let child = step::<S, C, M>(kernel, slots, slot, room);
            leaves_now.push_if(slot, child & LEAF != 0);
            nodes_next.push_if(slot, child & LEAF == 0);
        }
        let mut leaves_next = List::EMPTY;
        for &slot in &leaves_now.slots[..leaves_now.len] {
            let slot = usize::from(slot) % IN_FLIGHT;
            match visit_leaf::<S, C, M>(kernel, slots, slot, room, found) {
                None => free.push_if(slot, true),
                Some(child) => {
                    leaves_next.push_if(slot, child & LEAF != 0);
                    nodes_next.push_if(slot, child & LEAF == 0);
                }
            }
        }
        (at_nodes, at_leaves) = (nodes_next, leaves_next);
    }
}

/// Tests the node that a ray stands before, pushes the children that it meets, and pops the next.
#[inline(always)]
fn step<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    slots: &mut Slots,
    slot: usize,
    room: usize,
) -> u32 {
    let ray = &slots.rays[slot];
    let node = &kernel.tree.nodes[slots.current[slot] as usize];
    let stack = (&mut slots.children[slot * room..][..room], &mut slots.keys[slot * room..][..room]);
    let height = push_met::<S, M>(node, ray, stack, slots.heights[slot] as usize);
    pop::<S, C>(kernel, slots, slot, room, height)
}

/// Pops the top of a stack of the given height, which is what the ray stands before from now on. Asks for it, since it
/// is needed in the next pass.
#[inline(always)]
fn pop<S: Simd, C: Coordinate>(
    kernel: &Kernel<C>,
    slots: &mut Slots,
    slot: usize,
    room: usize,
    height: usize,
) -> u32 {
    let child = slots.children[slot * room + height - 1];
    slots.heights[slot] = height as u32 - 1;
    slots.current[slot] = child;
    prefetch::<S, C>(kernel, child);
    child
}

/// Prefetches a node or a leaf.
#[inline(always)]
fn prefetch<S: Simd, C: Coordinate>(kernel: &Kernel<C>, child: u32) {
    let index = (child & !LEAF) as usize;
    let node: *const u8 = kernel.tree.nodes.as_ptr().wrapping_add(index).cast();
    let block: *const u8 = kernel.blocks.as_ptr().wrapping_add(index).cast();
    let at = if child & LEAF == 0 { node } else { block };
    for line in 0..4 {
        S::prefetch(at.wrapping_add(64 * line));
    }
}

/// Tests the leaf that a ray stands before, and pops the next child. Returns `None` when the ray is done.
#[inline(always)]
fn visit_leaf<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    slots: &mut Slots,
    slot: usize,
    room: usize,
    found: &mut Found,
) -> Option<u32> {
    let (ray, child) = (&mut slots.rays[slot], slots.current[slot]);
    if child == END {
        found.finish(ray);
        return None;
    }
    let mut height = slots.heights[slot] as usize;
    let leaf = child & !LEAF;
    let corners = leaf::corners::<S, C>(&kernel.blocks[leaf as usize], ray.axes);
    let projection = &leaf::project::<S>(&corners, ray);
    if !projection.is_possible() {
        return Some(pop::<S, C>(kernel, slots, slot, room, height));
    }
    if M::CLOSEST {
        let before = ray.limit();
        kernel.closest_in_leaf::<S>(projection, ray, leaf);
        if ray.limit() != before {
            let limit = ray.limit().to_bits() + 16;
            let stacks = (&mut slots.children[slot * room..][..room], &mut slots.keys[slot * room..][..room]);
            height = drop_beyond::<S>(stacks.0, stacks.1, height, limit);
        }
    } else if M::ANY {
        if kernel.any_in_leaf::<S, M>(projection, ray, leaf) {
            found.finish(ray);
            return None;
        }
    } else {
        kernel.all_in_leaf::<S>(projection, ray, leaf, found);
    }
    Some(pop::<S, C>(kernel, slots, slot, room, height))
}

/// Removes the pending children that begin beyond a limit, and keeps the order of the others. The end of the stack
/// stays: its key is 0.
#[inline(always)]
fn drop_beyond<S: Simd>(children: &mut [u32], keys: &mut [u32], height: usize, limit: u32) -> usize {
    let (mut from, mut to) = (0, 0);
    while from < height {
        let eight = |stack: &[u32]| {
            stack[from..].first_chunk::<WIDTH>().map_or_else(|| S::load_u32(&[0; WIDTH]), S::load_u32)
        };
        let (some_keys, some_children) = (eight(keys), eight(children));
        let present = if height - from >= WIDTH { 0xff } else { (1 << (height - from)) - 1 };
        let kept = S::at_most(some_keys, limit) & present;
        push_eight::<S>(S::compress(some_keys, kept), keys, to);
        push_eight::<S>(S::compress(some_children, kept), children, to);
        from += WIDTH;
        to += kept.count_ones() as usize;
    }
    to
}
