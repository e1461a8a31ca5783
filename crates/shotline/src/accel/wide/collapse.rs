//! Collapses a binary tree into a wide one of least cost, by dynamic programming over forests (Ylitie, Karras and Laine
//! 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs").

use super::binary::{BinaryNode, ItemBox};
use super::{Frame, LEAF, LEAF_SIZE, NONE, Node, WIDTH, WideBvh};

/// The cost of a leaf, in units of that of a node.
const LEAF_COST: f32 = 0.8;

/// Returns the costs of the forests of a leaf: it is one tree.
pub(super) fn of_leaf(node: &mut BinaryNode) -> [f32; WIDTH] {
    [node.bounds.half_area() * LEAF_COST; WIDTH]
}

/// Returns the costs of the forests of a node, given those of its children: entry `n - 1` for at most `n` trees.
pub(super) fn of_node(node: &mut BinaryNode, left: &[f32; WIDTH], right: &[f32; WIDTH]) -> [f32; WIDTH] {
    let (mut costs, mut split) = ([f32::INFINITY; WIDTH], [0; WIDTH]);
    for trees in 2..=WIDTH {
        for of_left in 1..trees {
            let cost = left[of_left - 1] + right[trees - of_left - 1];
            if cost < costs[trees - 1] {
                (costs[trees - 1], split[trees - 1]) = (cost, of_left as u8);
            }
        }
    }
    (costs[0], split[0]) = (costs[WIDTH - 1] + node.bounds.half_area(), split[WIDTH - 1]);
    for trees in 2..=WIDTH {
        if costs[trees - 2] <= costs[trees - 1] {
            (costs[trees - 1], split[trees - 1]) = (costs[trees - 2], 0);
        }
    }
    node.forests.left = split;
    costs
}

/// Makes the wide tree; also returns the items of each leaf.
pub(super) fn collapse(
    frame: Frame,
    nodes: &[BinaryNode],
    items: &[ItemBox],
) -> (WideBvh, Vec<[u32; LEAF_SIZE]>) {
    let mut wide = Wide { nodes, items, out: Vec::new(), leaves: Vec::new() };
    let mut roots = Vec::with_capacity(WIDTH);
    wide.roots_of_node(0, &mut roots);
    let depth = wide.emit(&roots, 1);
    // Depth first, each node takes an entry and adds at most eight.
    let tree = WideBvh { frame, nodes: wide.out, stack_size: (WIDTH - 1) * depth + WIDTH + 1 };
    (tree, wide.leaves)
}

struct Wide<'a> {
    nodes: &'a [BinaryNode],
    items: &'a [ItemBox],
    out: Vec<Node>,
    leaves: Vec<[u32; LEAF_SIZE]>,
}

impl Wide<'_> {
    /// Appends the children of the wide node that a binary node becomes; a leaf at the root is its own child.
    fn roots_of_node(&self, node: usize, roots: &mut Vec<usize>) {
        let BinaryNode { left, forests, .. } = self.nodes[node];
        if left == 0 {
            roots.push(node);
            return;
        }
        self.roots_of_children(node, usize::from(forests.left[0]), WIDTH, roots);
    }

    fn roots_of_children(&self, node: usize, of_left: usize, trees: usize, roots: &mut Vec<usize>) {
        self.roots(node + 1, of_left, roots);
        self.roots(node + 2 * self.nodes[node].left as usize, trees - of_left, roots);
    }

    /// Appends the roots of the best forest of at most so many trees.
    fn roots(&self, node: usize, mut trees: usize, roots: &mut Vec<usize>) {
        let BinaryNode { left, forests, .. } = self.nodes[node];
        if left > 0 {
            while trees > 1 {
                let of_left = usize::from(forests.left[trees - 1]);
                if of_left > 0 {
                    return self.roots_of_children(node, of_left, trees, roots);
                }
                trees -= 1;
            }
        }
        roots.push(node);
    }

    /// Appends a node with its subtree; returns the depth.
    fn emit(&mut self, roots: &[usize], depth: usize) -> usize {
        let at = self.out.len();
        let mut node = Node { planes: [[0.0; WIDTH]; 6], children: [NONE; WIDTH] };
        for axis in 0..3 {
            node.planes[2 * axis] = [f32::INFINITY; WIDTH];
            node.planes[2 * axis + 1] = [f32::NEG_INFINITY; WIDTH];
        }
        self.out.push(node);
        let mut deepest = depth;
        for (slot, &root) in roots.iter().enumerate() {
            let BinaryNode { bounds, first, count, left, .. } = self.nodes[root];
            for axis in 0..3 {
                node.planes[2 * axis][slot] = bounds.low[axis];
                node.planes[2 * axis + 1][slot] = bounds.high[axis];
            }
            node.children[slot] = if left == 0 {
                let range = &self.items[first as usize..][..count as usize];
                let leaf = std::array::from_fn(|i| range.get(i).map_or(NONE, |b| b.item));
                self.leaves.push(leaf);
                LEAF | (self.leaves.len() - 1) as u32
            } else {
                let mut below = Vec::with_capacity(WIDTH);
                self.roots_of_node(root, &mut below);
                let index = self.out.len() as u32;
                deepest = deepest.max(self.emit(&below, depth + 1));
                index
            };
        }
        self.out[at] = node;
        deepest
    }
}
