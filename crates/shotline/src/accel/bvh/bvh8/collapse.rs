//! Collapses a binary tree whose leaves have one item each.

use super::super::{Bvh, Node as BinaryNode};
use super::node::Node;
use crate::aabb::Aabb;
use crate::accel::collapse::{self, Costs, Forests, WIDTH};
use crate::accel::prim_ref::measure;

/// What a node costs beside the probability that a line meets it, so that there are few of them where all have the same
/// size or none.
const COST_OF_ANY: f32 = 1e-6;

/// A node of the binary tree.
#[derive(Clone, Copy)]
struct Subtree<'a> {
    bvh: &'a Bvh,
    /// The forests of all nodes of the tree.
    forests: &'a [Option<Forests>],
    index: u32,
}

impl Subtree<'_> {
    fn root(&self) -> &BinaryNode<Aabb> {
        &self.bvh.nodes[self.index as usize]
    }

    /// The item of a leaf.
    fn item(&self) -> Option<u32> {
        let node = self.root();
        (node.count > 0).then(|| self.bvh.items[node.first as usize])
    }
}

impl collapse::Subtree for Subtree<'_> {
    fn split(self) -> Option<([Self; 2], Forests)> {
        let (forests, first) = (self.forests[self.index as usize]?, self.root().first);
        Some(([first, first + 1].map(|index| Subtree { index, ..self }), forests))
    }
}

/// A node of the binary tree that becomes a child of one that has been emitted.
struct Task {
    index: u32,
    above: usize,
    slot: usize,
}

/// The nodes of the wide tree, each before its children.
pub(super) fn collapse(bvh: &Bvh) -> Vec<Node> {
    let (mut nodes, mut children) = (Vec::new(), Vec::with_capacity(WIDTH));
    let forests = forests(bvh);
    // Works depth first, so that nodes close in the tree are close in memory.
    let mut tasks = vec![Task { index: 0, above: 0, slot: 0 }];
    tasks.truncate(bvh.nodes.len());
    while let Some(Task { index, above, slot }) = tasks.pop() {
        let at = nodes.len();
        if at > 0 {
            let above: &mut Node = &mut nodes[above];
            above.children[slot] = at as u32;
        }
        children.clear();
        collapse::children(Subtree { bvh, forests: &forests, index }, &mut children);
        let mut node = Node::EMPTY;
        for child in children.iter().filter(|child| child.item().is_none()) {
            tasks.push(Task { index: child.index, above: at, slot: usize::from(node.count) });
            node.push(0, &child.root().bounds);
            node.nodes += 1;
        }
        for child in &children {
            if let Some(item) = child.item() {
                node.push(item, &child.root().bounds);
            }
        }
        nodes.push(node);
    }
    nodes
}

/// How each node of the binary tree is divided into forests; `None` for leaves. A node costs what the probability says
/// that a line meets it; an item costs nothing by itself.
fn forests(bvh: &Bvh) -> Vec<Option<Forests>> {
    let Some(root) = bvh.nodes.first() else { return Vec::new() };
    let measure = measure(&root.bounds);
    let whole = measure(&root.bounds);
    let mut forests = vec![None; bvh.nodes.len()];
    let mut costs: Vec<Costs> = vec![collapse::of_leaf(0.0); bvh.nodes.len()];
    // Children have larger indices than their parents.
    for (index, node) in bvh.nodes.iter().enumerate().rev() {
        if node.count == 0 {
            // The quotient of zeros is NaN, which counts as zero.
            let probability = (measure(&node.bounds) / whole).max(0.0) as f32;
            let [left, right] = [0, 1].map(|side| &costs[node.first as usize + side]);
            let (of_node, best) = collapse::of_split(probability + COST_OF_ANY, left, right);
            forests[index] = Some(of_node);
            costs[index] = best;
        }
    }
    forests
}
