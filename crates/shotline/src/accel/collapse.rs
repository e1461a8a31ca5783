//! Decides how a binary tree is collapsed into one of up to eight children a node, of least cost, by dynamic programming
//! over forests (Ylitie, Karras and Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide
//! BVHs").

/// The number of children of a node.
pub(super) const WIDTH: usize = 8;

/// The costs of the forests that a subtree can become: entry `n - 1` for at most `n` trees.
pub(super) type Costs = [f32; WIDTH];

/// How a subtree is divided into forests of at most so many trees: `left[n - 1]` of `n` trees belong to the left
/// child, or 0 if `n - 1` trees are better. The first entry says it for a node with [`WIDTH`] children.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forests {
    left: [u8; WIDTH],
}

/// A node of a binary tree, and through it the subtree below.
pub(super) trait Subtree: Copy {
    /// The children of a node that is split, and how it is divided into forests.
    fn split(self) -> Option<([Self; 2], Forests)>;
}

/// Returns the costs of the forests of a leaf, given its own: it is one tree.
#[inline(always)]
pub(super) fn of_leaf(cost: f32) -> Costs {
    [cost; WIDTH]
}

/// Returns the best forests of a node with their costs, given its own and those of its children.
#[inline(always)]
pub(super) fn of_split(cost: f32, left: &Costs, right: &Costs) -> (Forests, Costs) {
    // All numbers of trees at once. Fewer than none are too few for the right child.
    let mut of_right = [f32::INFINITY; 2 * WIDTH];
    of_right[WIDTH..].copy_from_slice(right);
    let (mut costs, mut split) = ([f32::INFINITY; WIDTH], [0; WIDTH]);
    for of_left in 1..WIDTH {
        for i in 0..WIDTH {
            let sum = left[of_left - 1] + of_right[WIDTH - of_left + i];
            let is_less = sum < costs[i];
            costs[i] = if is_less { sum } else { costs[i] };
            split[i] = if is_less { of_left as u32 } else { split[i] };
        }
    }
    (costs[0], split[0]) = (costs[WIDTH - 1] + cost, split[WIDTH - 1]);
    for trees in 2..=WIDTH {
        if costs[trees - 2] <= costs[trees - 1] {
            (costs[trees - 1], split[trees - 1]) = (costs[trees - 2], 0);
        }
    }
    (Forests { left: split.map(|of_left| of_left as u8) }, costs)
}

/// Appends the children of the wide node that a subtree becomes; a leaf at the root is its own child.
pub(super) fn children<T: Subtree>(tree: T, out: &mut Vec<T>) {
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
fn append<T: Subtree>(tree: T, mut trees: usize, out: &mut Vec<T>) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn no_other_division_of_the_trees_costs_less() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let mut costs = || {
                let mut costs: Costs = std::array::from_fn(|_| random.number(1.0, 9.0) as f32);
                costs.sort_by(|a, b| b.total_cmp(a));
                costs
            };
            let (left, right) = (costs(), costs());
            let (forests, found) = of_split(2.0, &left, &right);
            let cost = |trees: usize, of_left: usize| left[of_left - 1] + right[trees - of_left - 1];
            let least =
                |trees: usize| (1..trees).map(|of_left| cost(trees, of_left)).fold(f32::INFINITY, f32::min);
            assert_eq!(found[0], least(WIDTH) + 2.0);
            assert_eq!(cost(WIDTH, usize::from(forests.left[0])), least(WIDTH));
            for trees in 2..=WIDTH {
                assert_eq!(found[trees - 1], least(trees).min(found[trees - 2]));
                let of_left = usize::from(forests.left[trees - 1]);
                assert!(of_left == 0 || cost(trees, of_left) == found[trees - 1]);
            }
        }
    }
}
