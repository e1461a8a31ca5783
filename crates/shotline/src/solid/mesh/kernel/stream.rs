//! Ray streams, for coherent rays: 64 of them share one traversal, with a mask of the rays that need each node (Barringer and
//! Akenine-Moeller 2014, "Dynamic ray stream traversal").

use super::block::Coordinate;
use super::context::Kernel;
use super::found::{Found, Mode, bits};
use super::leaf::{Projection, corners, project};
use super::node::{planes, test_planes};
use super::prepare::AT_A_TIME;
use super::ray::{KernelRay, MISS};
use super::walk::{WalkStack, walk};
use crate::accel::wide::{LEAF, WIDTH};
use crate::simd::{Simd, Singles};

/// The number of rays that share a traversal.
pub(super) const SIZE: usize = 64;

/// Entries between two reads of the cancel flag: well below a millisecond.
const POLL_INTERVAL: u32 = 256;

/// At a node that no more than this many rays need, each of them goes on alone. With 4 there was no gain.
const FEW: u32 = 2;

/// A pending child, the rays that need it, and the key of where the first of them enters it.
#[derive(Clone, Copy, Debug)]
struct Entry {
    rays: u64,
    child: u32,
    key: u32,
}

/// The memory of a stream.
#[derive(Debug, Default)]
pub(super) struct StreamMemory {
    rays: Vec<KernelRay>,
    /// The limits of the rays, which are read much more often than the rest.
    limits: Vec<[f32; WIDTH]>,
    stack: Vec<Entry>,
    /// The rays that may hit triangles of a leaf.
    possible: Vec<(Projection, u32)>,
    alone: WalkStack,
}

/// Casts the rays of at most [`SIZE`] rows.
#[inline(always)]
pub(super) fn cast<S: Simd, C: Coordinate, M: Mode>(
    kernel: &Kernel<C>,
    rows: std::ops::Range<usize>,
    memory: &mut StreamMemory,
    found: &mut Found,
) {
    memory.rays.resize(SIZE, KernelRay::default());
    memory.possible.resize(SIZE, Default::default());
    memory.limits.resize(SIZE / WIDTH, [0.0; WIDTH]);
    let mut live = 0u64;
    for first in (0..rows.len()).step_by(AT_A_TIME) {
        // Behind the last ray, it is prepared again.
        let slots: [usize; AT_A_TIME] = std::array::from_fn(|i| first + i);
        let of_slots = slots.map(|slot| rows.start + slot.min(rows.len() - 1));
        let prepared = kernel.prepare::<S>(of_slots, slots, &mut memory.rays);
        live |= u64::from(found.take_prepared(rows.start + first, rows.len() - first, prepared)) << first;
        if M::CLOSEST {
            memory.limits[first / WIDTH] = slots.map(|slot| memory.rays[slot].limit());
        }
    }
    if live == 0 {
        return;
    }
    let first = live.trailing_zeros() as usize;
    let StreamMemory { rays, limits, stack, possible, alone } = memory;
    let (Some(rays), Some(possible)) = (rays.first_chunk_mut::<SIZE>(), possible.first_chunk_mut::<SIZE>())
    else {
        return;
    };
    stack.clear();
    stack.push(Entry { rays: live, child: 0, key: 0 });
    let mut stream = Stream { kernel, rays, limits, stack, possible, alone, first, open: live };
    if stream.is_alike(live) {
        stream.traverse::<S, M, true>(found);
    } else {
        stream.traverse::<S, M, false>(found);
    }
    if M::ANY {
        bits(stream.open).for_each(|i| stream.rays[i].leaf = MISS);
    }
    bits(live).for_each(|i| found.finish(&stream.rays[i]));
}

/// A traversal.
struct Stream<'a, 'k, C> {
    kernel: &'a Kernel<'k, C>,
    rays: &'a mut [KernelRay; SIZE],
    limits: &'a mut [[f32; WIDTH]],
    stack: &'a mut Vec<Entry>,
    possible: &'a mut [(Projection, u32); SIZE],
    alone: &'a mut WalkStack,
    /// The first of the rays.
    first: usize,
    /// For [`Any`](super::found::Any): the rays without a hit.
    open: u64,
}

impl<C: Coordinate> Stream<'_, '_, C> {
    /// Whether rays are in one octant and have the same axes. Then they see a node and a leaf alike, so that its numbers are
    /// loaded once.
    fn is_alike(&self, rays: u64) -> bool {
        let view = |ray: &KernelRay| ([0, 1, 2].map(|axis| ray.upper_is_near(axis)), ray.axes[2]);
        let of_first = view(&self.rays[self.first]);
        bits(rays).all(|i| view(&self.rays[i]) == of_first)
    }

    #[inline(always)]
    fn traverse<S: Simd, M: Mode, const ALIKE: bool>(&mut self, found: &mut Found) {
        let mut popped = 0;
        while let Some(Entry { rays: mut mask, child, key }) = self.stack.pop() {
            popped += 1;
            if popped % POLL_INTERVAL == 0 && (self.kernel.block.is_cancelled() || found.is_full()) {
                return;
            }
            if M::ANY {
                mask &= self.open;
            } else if M::CLOSEST {
                mask &= not_before::<S>(self.limits, f32::from_bits(key & !15));
            }
            if mask == 0 {
                continue;
            }
            if child & LEAF != 0 {
                self.visit_leaf::<S, M, ALIKE>(mask, child & !LEAF, found);
            } else if mask.count_ones() <= FEW {
                self.visit_alone::<S, M>(mask, child, found);
            } else {
                self.visit_node::<S, ALIKE>(mask, child);
            }
        }
    }

    /// Visits a leaf: first tests all rays, without a branch that depends on the result, and then looks at those that may
    /// hit a triangle.
    #[inline(always)]
    fn visit_leaf<S: Simd, M: Mode, const ALIKE: bool>(&mut self, mask: u64, leaf: u32, found: &mut Found) {
        let block = &self.kernel.blocks[leaf as usize];
        let of_first = corners::<S, C>(block, self.rays[self.first].axes);
        let mut count = 0;
        for i in bits(mask) {
            let ray = &self.rays[i];
            let of_ray = if ALIKE { of_first } else { corners::<S, C>(block, ray.axes) };
            let projection = project::<S>(&of_ray, ray);
            self.possible[count] = (projection, i as u32);
            count += usize::from(projection.is_possible());
        }
        for (projection, i) in &self.possible[..count] {
            let i = *i as usize % SIZE;
            let ray = &mut self.rays[i];
            if M::CLOSEST {
                self.kernel.closest_in_leaf::<S>(projection, ray, leaf);
                self.limits[i / WIDTH][i % WIDTH] = ray.limit();
            } else if M::ANY {
                if self.kernel.any_in_leaf::<S, M>(projection, ray, leaf) {
                    self.open &= !(1 << i);
                }
            } else {
                self.kernel.all_in_leaf::<S>(projection, ray, leaf, found);
            }
        }
    }

    /// Visits a node and all below it, ray by ray.
    #[inline(always)]
    fn visit_alone<S: Simd, M: Mode>(&mut self, mask: u64, child: u32, found: &mut Found) {
        for i in bits(mask) {
            let ray = &mut self.rays[i];
            if walk::<S, C, M>(self.kernel, ray, child, self.alone, found) {
                self.open &= !(1 << i);
            }
            if M::CLOSEST {
                self.limits[i / WIDTH][i % WIDTH] = ray.limit();
            }
        }
    }

    /// Visits a node: pushes the children that any of the rays meet, the nearest last.
    #[inline(always)]
    fn visit_node<S: Simd, const ALIKE: bool>(&mut self, mask: u64, child: u32) {
        let node = &self.kernel.tree.nodes[child as usize];
        let mut hit_children = [0u8; SIZE];
        let mut nearest = S::F32x8::splat(f32::INFINITY);
        let of_first = planes::<S>(node, &self.rays[self.first]);
        for i in bits(mask) {
            let ray = &self.rays[i];
            let of_ray = if ALIKE { of_first } else { planes::<S>(node, ray) };
            let (children, enter) = test_planes::<S>(&of_ray, ray);
            hit_children[i] = children.bits();
            nearest = enter.lesser_where(children, nearest);
        }
        let met = nearest.is_less(S::F32x8::splat(f32::INFINITY));
        let rays_of = S::transpose_bits(&hit_children);
        let mut keys = [0; WIDTH];
        S::store_u32(S::descending(nearest, met), &mut keys);
        for &key in &keys[..met.bits().count_ones() as usize] {
            let slot = key as usize % WIDTH;
            self.stack.push(Entry { rays: rays_of[slot], child: node.children[slot], key: key - 8 });
        }
    }
}

/// The rays whose limits are not before a depth.
#[inline(always)]
fn not_before<S: Simd>(limits: &[[f32; WIDTH]], depth: f32) -> u64 {
    let depth = S::F32x8::splat(depth);
    let mask = |(i, limits): (usize, &[f32; WIDTH])| {
        u64::from(depth.is_at_most(S::F32x8::load(limits)).bits()) << (i * WIDTH)
    };
    limits.iter().enumerate().map(mask).fold(0, |all, mask| all | mask)
}
