//! The binary tree that is built first.

use super::LEAF_SIZE;
use super::bounds::Bounds;
use crate::accel::collapse::{self, Forests};

/// A node of the binary tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub low: [f32; 3],
    pub high: [f32; 3],
    /// How many items its leaves have.
    pub count: u32,
    pub content: Content,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// The items, then [`super::NONE`].
    Leaf([u32; LEAF_SIZE]),
    /// The left child follows; `right` is the index of the other one in its [`Part::Whole`].
    Split { right: u32, forests: Forests },
}

impl BinaryNode {
    #[inline(always)]
    pub fn new(bounds: &Bounds, count: usize, content: Content) -> BinaryNode {
        let [low, high] = bounds.corners();
        BinaryNode { low, high, count: count as u32, content }
    }
}

/// A part of the binary tree. Its division into parts depends on the numbers of items only, so the tree is the same for
/// any number of threads.
#[derive(Debug)]
pub(super) enum Part {
    /// A node with many items, and its children, which different threads may have built.
    Split(BinaryNode, Box<[Part; 2]>),
    /// A subtree with few items, depth first.
    Whole(Vec<BinaryNode>),
}

/// A node of the binary tree, and through it the subtree below.
#[derive(Clone, Copy, Debug)]
pub(super) enum Subtree<'a> {
    Part(&'a Part),
    Node(&'a [BinaryNode], usize),
}

impl<'a> Subtree<'a> {
    pub fn root(self) -> &'a BinaryNode {
        match self {
            Subtree::Part(Part::Split(node, _)) => node,
            Subtree::Part(Part::Whole(nodes)) => &nodes[0],
            Subtree::Node(nodes, index) => &nodes[index],
        }
    }
}

impl collapse::Subtree for Subtree<'_> {
    fn split(self) -> Option<([Self; 2], Forests)> {
        let Content::Split { right, forests } = self.root().content else { return None };
        let of_nodes = |nodes, index| [Subtree::Node(nodes, index + 1), Subtree::Node(nodes, right as usize)];
        let children = match self {
            Subtree::Part(Part::Split(_, children)) => children.each_ref().map(Subtree::Part),
            Subtree::Part(Part::Whole(nodes)) => of_nodes(nodes, 0),
            Subtree::Node(nodes, index) => of_nodes(nodes, index),
        };
        Some((children, forests))
    }
}
