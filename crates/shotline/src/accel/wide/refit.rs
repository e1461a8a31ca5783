//! Refitting to items that have moved: the boxes are computed again from the leaves up, and the tree keeps its
//! structure.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{EMPTY_PLANES, Frame, LEAF, LEAF_COST, NONE, Node, WIDTH, WideBvh};
use crate::aabb::Aabb;

/// A refit fails where the cost of the tree exceeds this multiple of its cost as built. A random ray takes time in
/// proportion to the cost. A refit saves about 0.35 us for each triangle (dragon, one thread), which is about the time of
/// one random ray. So at this growth a build pays off from about two rays for each triangle on.
const MAX_COST_GROWTH: f64 = 1.5;

/// How many nodes a thread takes at a time.
const CHUNK: usize = 1024;

impl WideBvh {
    /// The tree with the same structure over items that have moved, now within given bounds; `leaf_box` returns the box
    /// around the items of a leaf. Returns `None` if the tree would become too slow; the caller must rebuild it.
    pub fn refitted(&self, bounds: &Aabb, leaf_box: impl Fn(u32) -> Aabb + Sync) -> Option<WideBvh> {
        let frame = Frame::of(bounds);
        let with_leaves = |node: &Node| {
            let mut node = Node { planes: EMPTY_PLANES, children: node.children };
            for (slot, child) in node.children.into_iter().enumerate() {
                if child != NONE && child & LEAF != 0 {
                    node.set_box(slot, frame.outward(&leaf_box(child & !LEAF)));
                }
            }
            node
        };
        let mut nodes: Vec<Node> = self.nodes.par_iter().with_min_len(CHUNK).map(with_leaves).collect();
        // Every node comes before its children.
        for index in (0..nodes.len()).rev() {
            for slot in 0..WIDTH {
                let child = nodes[index].children[slot];
                if child & LEAF == 0 {
                    let child_box = nodes[child as usize].bounds();
                    nodes[index].set_box(slot, child_box);
                }
            }
        }
        let tree = WideBvh { frame, nodes, ..*self };
        (tree.cost() <= MAX_COST_GROWTH * self.built_cost).then_some(tree)
    }

    /// The surface area heuristic: the expected number of nodes and leaves that a random line through the root's box
    /// meets, a leaf counted by its cost.
    pub(super) fn cost(&self) -> f64 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        let of_slot = |node: &Node, slot: usize| match node.children[slot] {
            NONE => 0.0,
            child if child & LEAF != 0 => half_area(node.child_box(slot)) * f64::from(LEAF_COST),
            _ => half_area(node.child_box(slot)),
        };
        let of_node = |node: &Node| (0..WIDTH).map(|slot| of_slot(node, slot)).sum::<f64>();
        self.nodes.iter().map(of_node).sum::<f64>() / half_area(root.bounds())
    }
}

fn half_area([low, high]: [[f32; 3]; 2]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis: usize| f64::from(high[axis]) - f64::from(low[axis]));
    x * y + y * z + z * x
}
