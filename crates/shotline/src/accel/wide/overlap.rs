//! The leaves whose boxes overlap a box.

use super::{LEAF, NONE, WIDTH, WideBvh};
use crate::aabb::Aabb;

impl WideBvh {
    /// Visits the leaves that may hold an item whose box overlaps a box within the bounds of the tree, until `visit`
    /// returns `false`. Returns whether it always returned `true`.
    pub fn visit_overlapping(&self, bounds: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let [low, high] = self.frame.outward(bounds);
        let overlaps = |planes: &[[f32; WIDTH]; 6], slot: usize| {
            (0..3).all(|axis| planes[2 * axis][slot] <= high[axis] && low[axis] <= planes[2 * axis + 1][slot])
        };
        let mut pending = Vec::with_capacity(self.stack_size);
        pending.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(index) = pending.pop() {
            let node = &self.nodes[index as usize];
            // Unused slots come last.
            for (slot, &child) in node.children.iter().take_while(|child| **child != NONE).enumerate() {
                if !overlaps(&node.planes, slot) {
                    continue;
                }
                if child & LEAF == 0 {
                    pending.push(child);
                } else if !visit(child & !LEAF) {
                    return false;
                }
            }
        }
        true
    }
}
