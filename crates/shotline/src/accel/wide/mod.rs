//! A bounding volume hierarchy of up to eight children a node, for the kernel that casts blocks of rays at a mesh.
//!
//! Boxes are float32, in the tree's own frame, and rounded outwards: see [`Frame`]. A node is 256 bytes, so that one
//! ray tests its eight boxes with a few vector instructions (Wald, Benthin and Boulos 2008, "Getting rid of packets").

mod binary;
mod binned;
mod bins;
mod bounds;
mod cut;
mod emit;
mod frame;
mod overlap;
mod partition;
mod refit;
mod spatial;
#[cfg(test)]
mod tests;
mod traverse;

pub(crate) use binned::build;
pub(crate) use frame::{Frame, PAD};
pub(crate) use spatial::build_with_spatial_splits;

/// The number of children of a node.
pub(crate) const WIDTH: usize = super::collapse::WIDTH;

/// The largest number of items in a leaf.
pub(crate) const LEAF_SIZE: usize = 4;

/// Subtrees of at least this many items are built by several threads.
const PARALLEL: usize = 4096;

/// Deeper nodes are halved by count, so that no chain of nodes exhausts the stack.
const MAX_HEURISTIC_DEPTH: usize = 64;

/// The cost of a leaf, in units of that of a node.
const LEAF_COST: f32 = 0.8;

/// Marks a child that is a leaf. The other bits are the index of the leaf.
pub(crate) const LEAF: u32 = 1 << 31;

/// A slot of a leaf, or of a node, that is not used.
pub(crate) const NONE: u32 = u32::MAX;

/// A node: the boxes of its children, plane by plane, and the children. An unused slot has an empty box.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(256))]
pub(crate) struct Node {
    /// For each axis the lower and then the upper plane of every child.
    pub planes: [[f32; WIDTH]; 6],
    pub children: [u32; WIDTH],
}

/// The planes of a node without children.
const EMPTY_PLANES: [[f32; WIDTH]; 6] = {
    let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
    [low, high, low, high, low, high]
};

impl Node {
    fn set_box(&mut self, slot: usize, [low, high]: [[f32; 3]; 2]) {
        for axis in 0..3 {
            self.planes[2 * axis][slot] = low[axis];
            self.planes[2 * axis + 1][slot] = high[axis];
        }
    }

    fn child_box(&self, slot: usize) -> [[f32; 3]; 2] {
        [0, 1].map(|side| [0, 1, 2].map(|axis| self.planes[2 * axis + side][slot]))
    }

    /// The box around all children.
    fn bounds(&self) -> [[f32; 3]; 2] {
        let low = |axis: usize| self.planes[2 * axis].iter().copied().fold(f32::INFINITY, f32::min);
        let high = |axis: usize| self.planes[2 * axis + 1].iter().copied().fold(f32::NEG_INFINITY, f32::max);
        [[0, 1, 2].map(low), [0, 1, 2].map(high)]
    }
}

/// The hierarchy. A tree of a single leaf has one node.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideBvh {
    pub frame: Frame,
    /// The root comes first, and every node before its children.
    pub nodes: Vec<Node>,
    /// An upper bound on the number of entries of a depth-first traversal's stack.
    pub stack_size: usize,
    /// The cost by the surface area heuristic when it was built.
    built_cost: f64,
}
