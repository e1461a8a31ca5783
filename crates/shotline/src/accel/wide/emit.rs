//! Makes the wide tree from the binary one.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::binary::{BinaryNode, Content, Part, Subtree};
use super::{EMPTY_PLANES, Frame, LEAF, LEAF_SIZE, NONE, Node, PARALLEL, WIDTH, WideBvh};
use crate::accel::collapse;

/// Makes the wide tree; also returns the items of each leaf.
pub(super) fn emit(frame: Frame, tree: &Part) -> (WideBvh, Vec<[u32; LEAF_SIZE]>) {
    let mut top = Emitter { left_out: Some(Vec::new()), ..Emitter::default() };
    top.emit(Subtree::Part(tree), 1);
    let left_out = top.left_out.take().unwrap_or_default();
    let below: Vec<Emitter> = left_out
        .par_iter()
        .map(|child| {
            let mut below = Emitter::default();
            below.emit(child.tree, child.depth);
            below
        })
        .collect();
    let mut depth = top.depth;
    let count = |of: fn(&Emitter) -> usize| of(&top) + below.iter().map(of).sum::<usize>();
    let (node_count, leaf_count) = (count(|e| e.nodes.len()), count(|e| e.leaves.len()));
    let (mut nodes, mut leaves) = (top.nodes, top.leaves);
    nodes.reserve_exact(node_count - nodes.len());
    leaves.reserve_exact(leaf_count - leaves.len());
    for (child, below) in left_out.iter().zip(below) {
        let (first_node, first_leaf) = (nodes.len() as u32, leaves.len() as u32);
        nodes[child.node].children[child.slot] = first_node;
        nodes.extend(below.nodes.into_iter().map(|node| moved(node, first_node, first_leaf)));
        leaves.extend(below.leaves);
        depth = depth.max(below.depth);
    }
    // Depth first, each node takes an entry and adds at most eight.
    let mut tree = WideBvh { frame, nodes, stack_size: (WIDTH - 1) * depth + WIDTH + 1, built_cost: 0.0 };
    tree.built_cost = tree.cost();
    (tree, leaves)
}

/// A node after so many more nodes and leaves.
fn moved(mut node: Node, nodes: u32, leaves: u32) -> Node {
    for child in node.children.iter_mut().filter(|child| **child != NONE) {
        *child += if *child & LEAF == 0 { nodes } else { leaves };
    }
    node
}

/// A child that another emitter makes: its parent and the slot there, and its depth.
struct Child<'a> {
    tree: Subtree<'a>,
    node: usize,
    slot: usize,
    depth: usize,
}

/// The nodes and leaves of a subtree, depth first.
#[derive(Default)]
struct Emitter<'a> {
    nodes: Vec<Node>,
    leaves: Vec<[u32; LEAF_SIZE]>,
    /// The largest depth of a node.
    depth: usize,
    /// If present, collects the subtrees of few items, which are not emitted.
    left_out: Option<Vec<Child<'a>>>,
}

impl<'a> Emitter<'a> {
    /// Appends a node with its subtree; `depth` is its depth.
    fn emit(&mut self, tree: Subtree<'a>, depth: usize) {
        let at = self.nodes.len();
        self.nodes.push(Node { planes: EMPTY_PLANES, children: [NONE; WIDTH] });
        self.depth = self.depth.max(depth);
        let mut children = Vec::with_capacity(WIDTH);
        collapse::children(tree, &mut children);
        for (slot, child) in children.into_iter().enumerate() {
            let BinaryNode { low, high, count, content } = *child.root();
            self.nodes[at].set_box(slot, [low, high]);
            if let Content::Leaf(items) = content {
                self.nodes[at].children[slot] = LEAF | self.leaves.len() as u32;
                self.leaves.push(items);
            } else if let Some(left_out) = self.left_out.as_mut().filter(|_| (count as usize) < PARALLEL) {
                left_out.push(Child { tree: child, node: at, slot, depth: depth + 1 });
            } else {
                self.nodes[at].children[slot] = self.nodes.len() as u32;
                self.emit(child, depth + 1);
            }
        }
    }
}
