//! The traversal of one line in float64, which is the plain path.

use super::{LEAF, NONE, WIDTH, WideBvh};
use crate::aabb::BoxRay;
use crate::counters::Counters;
use crate::math::HALF_ULP;

/// The depth for which a stack needs no memory of its own.
const USUAL_STACK: usize = 128;

impl WideBvh {
    /// Visits leaves depth first, nearer ones first. Skips everything that begins after the `t` that `visit` returned
    /// last (initially the span's `t_max`). The planes of the nodes are farther out than those of the items, so a leaf
    /// is skipped only if [`BoxRay::enter_exit`] says so of the boxes of all its items.
    pub fn traverse(
        &self,
        ray: &BoxRay,
        counters: &mut Counters,
        mut visit: impl FnMut(u32, &mut Counters) -> f64,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut limit = ray.span().t_max();
        let mut stack = Vec::with_capacity(self.stack_size.min(USUAL_STACK));
        stack.push((ray.span().t_min(), 0));
        while let Some((t, child)) = stack.pop() {
            if t > limit {
                continue;
            }
            if child & LEAF != 0 {
                limit = visit(child & !LEAF, counters);
                continue;
            }
            let start = stack.len();
            self.push_children(child as usize, ray, limit, &mut stack);
            counters.boxes +=
                self.nodes[child as usize].children.iter().filter(|c| **c != NONE).count() as u64;
            // The nearest comes on top.
            stack[start..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        }
    }

    fn push_children(&self, node: usize, ray: &BoxRay, limit: f64, stack: &mut Vec<(f64, u32)>) {
        let (node, span) = (&self.nodes[node], ray.span());
        let (mut enter, mut exit) = ([span.t_min(); WIDTH], [span.t_max().min(limit); WIDTH]);
        for axis in 0..3 {
            let (slope, centre) = (ray.slope(axis), self.frame.centre[axis]);
            // The planes are off by the rounding of this sum; where the frame is far from the origin that may be more
            // than their padding.
            let slack = 4.0 * HALF_ULP * (centre.abs() + self.frame.size);
            let plane = |at: f32, slack: f64| f64::from(at) * self.frame.size + centre + slack;
            let (lower, upper) = (&node.planes[2 * axis], &node.planes[2 * axis + 1]);
            for slot in 0..WIDTH {
                let (low, high) = (plane(lower[slot], -slack), plane(upper[slot], slack));
                let (near, far) = if slope.ascends() { (low, high) } else { (high, low) };
                enter[slot] = enter[slot].max(slope.earliest(near));
                exit[slot] = exit[slot].min(slope.latest(far));
            }
        }
        for slot in 0..WIDTH {
            if node.children[slot] != NONE && enter[slot] <= exit[slot] {
                stack.push((enter[slot], node.children[slot]));
            }
        }
    }
}
