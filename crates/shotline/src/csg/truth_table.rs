//! The truth table of a program with few leaves: the value of the expression for every set of leaves.

/// Maximum number of leaves of a program that has a table.
pub(super) const MAX_LEAVES: usize = 8;

/// One bit for each set of leaves. A set is itself a bit mask in which bit 2 stands for leaf 2.
#[derive(Clone, Copy, Debug)]
pub(super) struct TruthTable([u64; (1 << MAX_LEAVES) / 64]);

impl TruthTable {
    /// Builds the table of an expression over `leaf_count` leaves. `empty` is the value of the empty set; `after`
    /// toggles a leaf and returns the new value. Returns `None` for too many leaves.
    pub fn new(leaf_count: usize, empty: bool, mut after: impl FnMut(u32) -> bool) -> Option<TruthTable> {
        if leaf_count > MAX_LEAVES {
            return None;
        }
        let mut table = TruthTable([0; (1 << MAX_LEAVES) / 64]);
        let (mut leaves, mut value) = (0_usize, empty);
        // Gray code: from one set to the next a single leaf changes.
        for next in 1..=1_usize << leaf_count {
            table.0[leaves / 64] |= u64::from(value) << (leaves % 64);
            let leaf = next.trailing_zeros();
            if (leaf as usize) < leaf_count {
                value = after(leaf);
                leaves ^= 1 << leaf;
            }
        }
        Some(table)
    }

    /// The value where exactly the leaves of a set are inside.
    #[inline]
    pub fn value(&self, leaves: u32) -> bool {
        let leaves = leaves as usize % (1 << MAX_LEAVES);
        self.0[leaves / 64] >> (leaves % 64) & 1 == 1
    }

    /// The set of leaves that must all be inside for the expression to be true.
    pub fn needed(&self) -> u32 {
        let all = (1 << MAX_LEAVES) - 1;
        (0..=all).filter(|&leaves| self.value(leaves)).fold(all, |needed, leaves| needed & leaves)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Op, Program, ProgramState, Tree, TreeNode};
    use super::*;
    use crate::testkit::random::Random;

    fn random_tree(random: &mut Random, leaf_count: u32) -> Tree {
        let mut nodes: Vec<TreeNode> = (0..leaf_count).map(TreeNode::Leaf).collect();
        let mut open: Vec<u32> = (0..leaf_count).collect();
        while open.len() > 1 || nodes.len() == 1 {
            let take = (1 + random.below(3)).min(open.len());
            let args: Vec<u32> = (0..take).map(|_| open.swap_remove(random.below(open.len()))).collect();
            let op = [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
            let node = TreeNode::Op(op, args);
            nodes.push(node);
            open.push((nodes.len() - 1) as u32);
        }
        Tree { nodes }
    }

    #[test]
    fn tables_say_what_counters_count() {
        let mut random = Random::new(5);
        for case in 0..400 {
            let leaf_count = 1 + case % (MAX_LEAVES as u32 + 2);
            let tree = random_tree(&mut random, leaf_count);
            let program = Program::new(&tree, tree.nodes.len() as u32 - 1, leaf_count as usize);
            let mut plain = program.clone();
            plain.forget_table();
            let (mut fast, mut slow) = (ProgramState::default(), ProgramState::default());
            fast.reset(&program);
            slow.reset(&plain);
            let mut leaves = 0;
            for _ in 0..200 {
                let leaf = random.below(leaf_count as usize) as u32;
                fast.toggle(&program, leaf);
                slow.toggle(&plain, leaf);
                leaves ^= 1 << leaf;
                let value = slow.value(&plain);
                assert_eq!(fast.value(&program), value, "{tree:?} {leaves:b}");
                let lacks = |leaf: &u32| program.needs(*leaf) && leaves >> leaf & 1 == 0;
                assert!(!value || !(0..leaf_count).any(|leaf| lacks(&leaf)), "{tree:?} {leaves:b}");
            }
        }
        let leaves = || (0..3).map(TreeNode::Leaf);
        let of = |op| Tree { nodes: leaves().chain([TreeNode::Op(op, vec![0, 1, 2])]).collect() };
        let needs = |op| {
            let program = Program::new(&of(op), 3, 3);
            [0, 1, 2].map(|leaf| program.needs(leaf))
        };
        assert_eq!(needs(Op::Intersection), [true; 3]);
        assert_eq!(needs(Op::Difference), [true, false, false]);
        assert_eq!(needs(Op::Union), [false; 3]);
    }
}
