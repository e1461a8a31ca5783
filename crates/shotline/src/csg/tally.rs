//! The value of a program as a sum: each leaf that is inside adds its step, and the program is true where the sum is positive.
//!
//! A union counts its operands, and an intersection those that are missing. An operand that is a combination itself has a sum
//! too, whose bounds say by how much the other operands have to count: more than it can make up for. So chains of operations
//! have sums, and operations of two combinations have none.

use super::Op;

/// The sum of a program along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Tally {
    sum: i32,
}

impl Tally {
    /// Whether the ray is inside.
    #[inline]
    pub fn value(self) -> bool {
        self.sum > 0
    }

    /// Adds the step of a leaf that is entered, or its negative.
    #[inline]
    pub fn add(&mut self, step: i32) {
        self.sum += step;
    }
}

/// The sum outside of all leaves, and what entering a leaf adds to it.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    start: i32,
    /// For each node the step of the first operand of a difference, and of other operands.
    steps: Vec<[i32; 2]>,
}

/// Where an operand of an operation is: the number of the operation, and whether it is the first of a difference.
pub(super) type Place = (u32, bool);

/// The largest sum.
const MOST: i64 = 1 << 30;

/// The sum of one node: outside of all leaves, and its bounds.
#[derive(Clone, Copy, Debug, Default)]
struct NodeSum {
    start: i64,
    least: i64,
    most: i64,
    /// The steps of its leaves.
    steps: [i64; 2],
    /// The operand that is a combination, and whether the sum has that of its complement.
    child: Option<(usize, bool)>,
}

impl Sums {
    /// The sums of a program, if it has them: of its operations, parents before their children, each with its place, and of
    /// the places of its leaves.
    pub(super) fn of(operations: &[(Op, Place)], leaves: impl Iterator<Item = Place>) -> Option<Sums> {
        let mut counts = vec![[0_i64; 2]; operations.len()];
        leaves.for_each(|(node, is_first)| counts[node as usize][usize::from(!is_first)] += 1);
        let mut sums = vec![NodeSum::default(); operations.len()];
        let mut children: Vec<Option<usize>> = vec![None; operations.len()];
        for (node, &(op, (parent, _))) in operations.iter().enumerate().rev() {
            let child = children[node].map(|child| (child, sums[child], operations[child].1.1));
            sums[node] = NodeSum::of(op, counts[node], child)?;
            let has_several = node > 0 && children[parent as usize].replace(node).is_some();
            if has_several || sums[node].most > MOST || sums[node].least < -MOST {
                return None;
            }
        }
        let mut steps = vec![[0; 2]; sums.len()];
        let (mut next, mut sign) = (Some(0), 1);
        while let Some(node) = next {
            steps[node] = sums[node].steps.map(|step| (sign * step) as i32);
            next = sums[node].child.map(|(child, _)| child);
            sign *= if sums[node].child.is_some_and(|(_, is_negated)| is_negated) { -1 } else { 1 };
        }
        Some(Sums { start: sums[0].start as i32, steps })
    }

    pub(super) fn tally(&self) -> Tally {
        Tally { sum: self.start }
    }

    #[inline]
    pub(super) fn step(&self, node: u32, is_first: bool) -> i32 {
        self.steps[node as usize][usize::from(!is_first)]
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(self.steps.as_slice())
    }
}

impl NodeSum {
    /// The sum of a node by the numbers of its leaves (first and other operands), and its operand that is a combination.
    fn of(op: Op, [firsts, others]: [i64; 2], child: Option<(usize, NodeSum, bool)>) -> Option<NodeSum> {
        let leaves = firsts + others;
        let Some((number, of_child, is_first)) = child else {
            return Some(match op {
                Op::Union => NodeSum { most: leaves, steps: [1; 2], ..NodeSum::default() },
                Op::Intersection => {
                    let start = 1 - leaves;
                    NodeSum { start, least: start, most: 1, steps: [1; 2], child: None }
                }
                Op::Difference => {
                    NodeSum { least: -others, most: firsts, steps: [1, -1], ..NodeSum::default() }
                }
            });
        };
        let is_negated = op == Op::Difference && !is_first;
        let NodeSum { start, least, most, .. } = if is_negated { of_child.complement() } else { of_child };
        let child = Some((number, is_negated));
        Some(match op {
            // An operand that is inside makes up for the least sum.
            Op::Union => {
                let step = 1 - least;
                NodeSum { start, least, most: most + step * leaves, steps: [step; 2], child }
            }
            // One that is outside takes more than the greatest.
            Op::Intersection => {
                let out = most * leaves;
                NodeSum { start: start - out, least: least - out, most, steps: [most; 2], child }
            }
            Op::Difference => {
                let out = most * firsts;
                let least = least - out - most * others;
                NodeSum { start: start - out, least, most, steps: [most, -most], child }
            }
        })
    }

    /// The sum of what is outside.
    fn complement(self) -> NodeSum {
        NodeSum { start: 1 - self.start, least: 1 - self.most, most: 1 - self.least, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Program, ProgramState, Tree, TreeNode};
    use super::*;
    use crate::testkit::random::Random;

    /// A random expression over leaves that are used once.
    fn random_tree(random: &mut Random, depth: usize, tree: &mut Tree, leaves: &mut u32) -> u32 {
        let node = if depth == 0 || random.below(3) == 0 {
            *leaves += 1;
            TreeNode::Leaf(*leaves - 1)
        } else {
            let op = [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
            // Mostly one operand is a combination.
            let composite = random.below(4);
            let count = 1 + random.below(4);
            let args = (0..count).map(|i| {
                let deep = i == composite || random.below(8) == 0;
                random_tree(random, if deep { depth - 1 } else { 0 }, tree, leaves)
            });
            TreeNode::Op(op, args.collect())
        };
        tree.nodes.push(node);
        (tree.nodes.len() - 1) as u32
    }

    #[test]
    fn sums_have_the_sign_of_the_program() {
        let mut random = Random::new(12);
        let mut with_sums = [0; 2];
        for _ in 0..4000 {
            let (mut tree, mut leaves) = (Tree::default(), 0);
            let root = random_tree(&mut random, 5, &mut tree, &mut leaves);
            let program = Program::new(&tree, root, leaves as usize);
            let Some(mut tally) = program.tally() else {
                with_sums[0] += 1;
                continue;
            };
            with_sums[1] += usize::from(tree.nodes.len() > leaves as usize + 2);
            let mut state = ProgramState::default();
            state.reset(&program);
            let mut inside = vec![false; leaves as usize];
            for _ in 0..40 {
                let leaf = random.below(leaves as usize);
                inside[leaf] ^= true;
                let step = program.step(leaf as u32);
                tally.add(if inside[leaf] { step } else { -step });
                state.toggle(&program, leaf as u32);
                assert_eq!(tally.value(), state.value(&program), "{tree:?} {inside:?}");
            }
        }
        assert!(with_sums.iter().all(|count| *count > 100), "{with_sums:?}");
    }

    /// Steps double with each change of the operation: a long chain has no sums, rather than wrong ones.
    #[test]
    fn long_chains_of_changing_operations_have_no_sums() {
        let (mut tree, mut leaves) = (Tree { nodes: vec![TreeNode::Leaf(0)] }, 1);
        for level in 0..100 {
            tree.nodes.push(TreeNode::Leaf(leaves));
            let at = tree.nodes.len() as u32;
            let op = [Op::Union, Op::Intersection][level % 2];
            tree.nodes.push(TreeNode::Op(op, vec![at - 2, at - 1]));
            leaves += 1;
        }
        let program = Program::new(&tree, tree.nodes.len() as u32 - 1, leaves as usize);
        assert!(program.tally().is_none());
    }
}
