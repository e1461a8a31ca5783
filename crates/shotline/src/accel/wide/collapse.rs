//! Decides how a binary tree is collapsed into a wide one of least cost, by dynamic programming over forests (Ylitie,
//! Karras and Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs").

use super::binary::{Forests, Subtree};
use super::bounds::Bounds;
use super::{LEAF_COST, WIDTH};

/// The costs of the forests that a subtree can become: entry `n - 1` for at most `n` trees.
pub(super) type Costs = [f32; WIDTH];

/// Returns the costs of the forests of a leaf: it is one tree.
pub(super) fn of_leaf(bounds: &Bounds) -> Costs {
    [bounds.half_area() * LEAF_COST; WIDTH]
}

/// Returns the best forests of a node with their costs, given those of its children.
pub(super) fn of_split(bounds: &Bounds, left: &Costs, right: &Costs) -> (Forests, Costs) {
    let (mut costs, mut split) = ([f32::INFINITY; WIDTH], [0; WIDTH]);
    for trees in 2..=WIDTH {
        for of_left in 1..trees {
            let cost = left[of_left - 1] + right[trees - of_left - 1];
            if cost < costs[trees - 1] {
                (costs[trees - 1], split[trees - 1]) = (cost, of_left as u8);
            }
        }
    }
    (costs[0], split[0]) = (costs[WIDTH - 1] + bounds.half_area(), split[WIDTH - 1]);
    for trees in 2..=WIDTH {
        if costs[trees - 2] <= costs[trees - 1] {
            (costs[trees - 1], split[trees - 1]) = (costs[trees - 2], 0);
        }
    }
    (Forests { left: split }, costs)
}

/// Appends the children of the wide node that a subtree becomes; a leaf at the root is its own child.
pub(super) fn children<'a>(tree: Subtree<'a>, out: &mut Vec<Subtree<'a>>) {
    match tree.split() {
        None => out.push(tree),
        Some(([left, right], forests)) => {
            let of_left = usize::from(forests.left[0]);
            append(left, of_left, out);
            append(right, WIDTH - of_left, out);
        }
    }
}

/// Appends the best forest of at most so many trees.
fn append<'a>(tree: Subtree<'a>, mut trees: usize, out: &mut Vec<Subtree<'a>>) {
    if let Some(([left, right], forests)) = tree.split() {
        while trees > 1 {
            let of_left = usize::from(forests.left[trees - 1]);
            if of_left > 0 {
                append(left, of_left, out);
                return append(right, trees - of_left, out);
            }
            trees -= 1;
        }
    }
    out.push(tree);
}
