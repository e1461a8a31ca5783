//! Tests a ray against the boxes of a node's children.

use super::found::Mode;
use super::ray::KernelRay;
use crate::accel::wide::{Node, WIDTH};
use crate::simd::{Simd, Singles};

/// The planes of a node, the nearer ones of each axis first, as rays of one octant see them.
#[derive(Clone, Copy)]
pub(super) struct Planes<F> {
    near: [F; 3],
    far: [F; 3],
}

/// Loads the planes of a node, as the octant of a ray sees them.
#[inline(always)]
pub(super) fn planes<S: Simd>(node: &Node, ray: &KernelRay) -> Planes<S::F32x8> {
    let plane = |axis: usize, upper: usize| S::F32x8::load(&node.planes[2 * axis + upper]);
    let [x, y, z] = [ray.upper_is_near(0), ray.upper_is_near(1), ray.upper_is_near(2)];
    Planes {
        near: [plane(0, x), plane(1, y), plane(2, z)],
        far: [plane(0, x ^ 1), plane(1, y ^ 1), plane(2, z ^ 1)],
    }
}

/// Returns a mask of the children whose boxes the ray may meet before its limit, and how far from the entry they begin.
///
/// No box that holds a hit is lost. On each axis, with exact origin `o` and slope `s`, a plane `p` is met at `(p - o)
/// / s`. Computed is `p r - o' r` with `r = (1 + a) / s`: the origin `o'` is off by half an ulp of float32, which is
/// `2^-25` because it is at most 1; `o' r` by `2^-24` of itself; the origin that the ray was moved to by less than
/// `2^-26`. So this is the exact quotient for a plane that is off by less than `2^-22`, the padding of the boxes, times
/// `1 + b` with `|b| < 2^-23 + 2^-46`, from the reciprocal and the last rounding. Where the exact intervals of a padded
/// box meet in some depth of at least 0, the computed bounds are therefore in order up to a factor of `(1 + b) / (1 -
/// b) < 1 + 2^-21`.
#[inline(always)]
pub(super) fn test_planes<S: Simd>(planes: &Planes<S::F32x8>, ray: &KernelRay) -> (S::F32x8, S::F32x8) {
    let splat = S::F32x8::splat;
    let depth = |planes: &[S::F32x8; 3], axis: usize| {
        planes[axis].mul_sub(splat(ray.reciprocal(axis)), splat(ray.offset(axis)))
    };
    let enter = depth(&planes.near, 0).greater(depth(&planes.near, 1)).greater(depth(&planes.near, 2));
    // Last, so that it is not -0.0, which would be greater than all other keys.
    let enter = enter.greater(splat(0.0));
    let exit = depth(&planes.far, 0).lesser(depth(&planes.far, 1));
    let exit = depth(&planes.far, 2).lesser(splat(ray.limit())).lesser(exit);
    const WIDEN: f32 = 1.0 + 1.0 / (1 << 21) as f32;
    (enter.is_at_most(exit.mul(splat(WIDEN))), enter)
}

/// The test of one ray.
#[inline(always)]
pub(super) fn test_node<S: Simd>(node: &Node, ray: &KernelRay) -> (S::F32x8, S::F32x8) {
    test_planes::<S>(&planes::<S>(node, ray), ray)
}

/// Pushes the children of a node that the ray meets onto a stack of some height, the nearest last if the nearest hit is
/// wanted; then `keys` is a stack of where they begin. Returns the new height.
#[inline(always)]
pub(super) fn push_met<S: Simd, M: Mode>(
    node: &Node,
    ray: &KernelRay,
    (pending, keys): (&mut [u32], &mut [u32]),
    height: usize,
) -> usize {
    let (met, enter) = test_node::<S>(node, ray);
    let (mask, children) = (met.bits(), S::load_u32(&node.children));
    if M::CLOSEST {
        let sorted = S::descending(enter, met);
        push_eight::<S>(S::permute(children, sorted), pending, height);
        push_eight::<S>(sorted, keys, height);
    } else {
        push_eight::<S>(S::compress(children, mask), pending, height);
    }
    height + mask.count_ones() as usize
}

/// Writes eight numbers onto a stack.
#[inline(always)]
pub(super) fn push_eight<S: Simd>(values: S::U32x8, stack: &mut [u32], at: usize) {
    if let Some(room) = stack.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<WIDTH>()) {
        S::store_u32(values, room);
    }
}
