//! The traversal of one line in float64, which is the plain path.

use super::{LEAF, NONE, WideBvh};
use crate::aabb::BoxRay;
use crate::counters::Counters;

impl WideBvh {
    /// Visits leaves depth first, nearer ones first. Skips everything that begins after the `t` that `visit` returned
    /// last (initially the span's `t_max`). The boxes of the nodes are padded by more than any rounding here, so a leaf
    /// is skipped only if [`BoxRay::enter_exit`] says so of the boxes of all its items. `pending` is memory for the nodes
    /// and leaves that are still to be visited.
    pub fn traverse(
        &self,
        ray: &BoxRay,
        counters: &mut Counters,
        pending: &mut Vec<(f64, u32)>,
        mut visit: impl FnMut(u32, &mut Counters) -> f64,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut limit = ray.span().t_max();
        let ray = ray.relative_to(self.frame.centre, self.frame.size);
        pending.clear();
        pending.push((ray.span().t_min(), 0));
        while let Some((t, child)) = pending.pop() {
            if t > limit {
                continue;
            }
            if child & LEAF != 0 {
                limit = visit(child & !LEAF, counters);
                continue;
            }
            let (node, start) = (&self.nodes[child as usize], pending.len());
            let [enter, exit] = ray.enter_exit_eight(&node.planes);
            // Unused slots come last.
            for (slot, &child) in node.children.iter().take_while(|child| **child != NONE).enumerate() {
                counters.boxes += 1;
                if enter[slot] <= exit[slot].min(limit) {
                    pending.push((enter[slot], child));
                }
            }
            // The nearest comes on top.
            pending[start..].sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        }
    }
}
