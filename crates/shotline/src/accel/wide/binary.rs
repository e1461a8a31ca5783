//! The binary tree that is built first: boxes, items and nodes.

use super::WIDTH;

/// A box, or the centres of boxes, in the frame of the tree. The fourth components make it a vector register wide.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Bounds {
    pub low: [f32; 4],
    pub high: [f32; 4],
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { low: lesser(self.low, other.low), high: greater(self.high, other.high) }
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let size: [f32; 3] = std::array::from_fn(|i| self.high[i] - self.low[i]);
        size[0] * size[1] + size[1] * size[2] + size[2] * size[0]
    }
}

#[inline(always)]
fn lesser(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|i| if b[i] < a[i] { b[i] } else { a[i] })
}

#[inline(always)]
fn greater(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|i| if b[i] > a[i] { b[i] } else { a[i] })
}

/// An item and its box.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct ItemBox {
    pub low: [f32; 3],
    pub item: u32,
    pub high: [f32; 3],
    pub unused: u32,
}

impl ItemBox {
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        let [low, high] = [self.low, self.high].map(|[x, y, z]| [x, y, z, 0.0]);
        Bounds { low, high }
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn centre(&self) -> [f32; 4] {
        [self.low[0] + self.high[0], self.low[1] + self.high[1], self.low[2] + self.high[2], 0.0]
    }
}

/// A node of the binary tree. The subtree of `count` items has room for `2 count - 1` nodes: its root, the nodes of the
/// left subtree, and those of the right. So subtrees are built in place by different threads.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub bounds: Bounds,
    /// The range of items.
    pub first: u32,
    pub count: u32,
    /// How many items go left; 0 for a node that is not split.
    pub left: u32,
    /// How the wide tree divides it.
    pub forests: Forests,
}

impl BinaryNode {
    pub const UNUSED: BinaryNode =
        BinaryNode { bounds: Bounds::EMPTY, first: 0, count: 0, left: 0, forests: Forests::NONE };
}

/// How a subtree is divided into forests of at most so many trees: `left[n - 1]` of `n` trees belong to the left
/// child, or 0 if `n - 1` trees are better. The first entry says it for a node with [`WIDTH`] children.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forests {
    pub left: [u8; WIDTH],
}

impl Forests {
    pub const NONE: Forests = Forests { left: [0; WIDTH] };
}
