//! A boolean expression of any number of operands as a flat program of counters.
//!
//! Toggling a leaf changes the counter of its node. The change propagates upwards only while it changes the value of
//! a node. So a crossing costs what it changes, not the size of the expression.

use super::Op;
use super::tally::{Sums, Tally};
use super::truth_table::TruthTable;

/// A boolean expression as an arena. It is processed without recursion, so its depth is not limited by the call
/// stack.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// The nodes; arguments are indices.
    pub nodes: Vec<TreeNode>,
}

/// A node of a [`Tree`].
#[derive(Clone, Debug)]
pub enum TreeNode {
    /// A leaf, by number; each number occurs once in the tree.
    Leaf(u32),
    /// A combination of at least one argument.
    Op(Op, Vec<u32>),
}

const NONE: u32 = u32::MAX;

/// Where the value of a leaf or of a node is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Link {
    /// The node above; `NONE` for the root.
    pub node: u32,
    /// Whether it is the first operand of a difference.
    pub first: bool,
    /// Whether an odd number of differences subtracts it.
    subtracted: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ProgramNode {
    pub op: Op,
    pub arity: u32,
    pub link: Link,
}

/// The flat program. Chains of like operations are one node: `((A - B) - C) - D`, and also `A - (B | C)`.
#[derive(Clone, Debug)]
pub struct Program {
    /// Parents come before their children; the root is node 0.
    pub(super) nodes: Vec<ProgramNode>,
    pub(super) leaves: Vec<Link>,
    /// Replaces the counters where the leaves are few.
    table: Option<TruthTable>,
    /// The set of leaves that must all be inside for the result to be true, from the table; 0 without a table.
    needed: u32,
    sums: Option<Sums>,
}

impl Program {
    /// Flattens the expression below a root over leaves `0..leaf_count`.
    pub fn new(tree: &Tree, root: u32, leaf_count: usize) -> Program {
        let top = Link { node: NONE, first: false, subtracted: false };
        let op = match tree.nodes[root as usize] {
            TreeNode::Op(op, _) => op,
            // A single leaf is the only operand of a union.
            TreeNode::Leaf(_) => Op::Union,
        };
        let mut program = Program {
            nodes: vec![ProgramNode { op, arity: 0, link: top }],
            leaves: vec![top; leaf_count],
            table: None,
            needed: 0,
            sums: None,
        };
        let mut stack = vec![(root, Link { node: 0, first: op == Op::Difference, subtracted: false })];
        while let Some((node, link)) = stack.pop() {
            match &tree.nodes[node as usize] {
                TreeNode::Leaf(leaf) => {
                    program.leaves[*leaf as usize] = link;
                    program.nodes[link.node as usize].arity += 1;
                }
                TreeNode::Op(_, args) if args.len() == 1 => stack.push((args[0], link)),
                TreeNode::Op(op, args) => {
                    let link = program.node_for(*op, link);
                    for (i, &arg) in args.iter().enumerate().rev() {
                        let taken = *op == Op::Difference && i > 0;
                        // The arguments of a union that is merged into a difference keep the role of the union in it.
                        let first = if *op == Op::Difference { i == 0 } else { link.first };
                        stack.push((arg, Link { first, subtracted: link.subtracted ^ taken, ..link }));
                    }
                }
            }
        }
        let mut state = ProgramState::default();
        state.reset(&program);
        program.table = TruthTable::new(leaf_count, state.value(&program), |leaf| {
            state.toggle(&program, leaf);
            state.value(&program)
        });
        program.needed = program.table.map_or(0, |table| table.needed());
        let place = |link: &Link| (link.node, link.first);
        let operations: Vec<_> = program.nodes.iter().map(|node| (node.op, place(&node.link))).collect();
        program.sums = Sums::of(&operations, program.leaves.iter().map(place));
        program
    }

    /// Returns the link for the arguments of an operation. It leads to the node above if the operation is merged into
    /// it, otherwise to a new node, and has the role and the polarity of the arguments there.
    fn node_for(&mut self, op: Op, link: Link) -> Link {
        let joins = match (self.nodes[link.node as usize].op, op) {
            (Op::Union, Op::Union) | (Op::Intersection, Op::Intersection) => true,
            (Op::Difference, Op::Difference) => link.first,
            (Op::Difference, Op::Union) => !link.first,
            _ => false,
        };
        if joins {
            return link;
        }
        self.nodes[link.node as usize].arity += 1;
        self.nodes.push(ProgramNode { op, arity: 0, link });
        Link { node: (self.nodes.len() - 1) as u32, first: false, subtracted: link.subtracted }
    }

    /// Number of leaves.
    pub fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// What programs of the same form have in common: then they have the same value for the same leaves.
    pub(crate) fn form(&self) -> impl Eq + std::hash::Hash + '_ {
        (&self.nodes, &self.leaves)
    }

    /// Whether the leaf is subtracted, so that the result lies on the other side of its surface.
    pub fn is_subtracted(&self, leaf: u32) -> bool {
        self.leaves[leaf as usize].subtracted
    }

    /// Whether the result is known to be empty wherever the ray is outside a leaf: an operand of an intersection, or
    /// the only leaf. `false` means that this is not known.
    pub fn needs(&self, leaf: u32) -> bool {
        self.needed.checked_shr(leaf).is_some_and(|needed| needed & 1 == 1)
    }

    /// The value as a sum, where there is one; otherwise `None`.
    pub fn tally(&self) -> Option<Tally> {
        self.sums.as_ref().map(Sums::tally)
    }

    /// What entering a leaf adds to the [`Tally`] of a program that has one, and leaving it subtracts.
    pub fn step(&self, leaf: u32) -> i32 {
        let link = self.leaves[leaf as usize];
        self.sums.as_ref().map_or(0, |sums| sums.step(link.node, link.first))
    }

    /// Drops the table, so that the counters are used however few leaves there are.
    #[cfg(any(test, feature = "testkit"))]
    pub(crate) fn forget_table(&mut self) {
        (self.table, self.needed) = (None, 0);
    }

    /// Bytes used.
    pub fn memory(&self) -> usize {
        let sums = self.sums.as_ref().map_or(0, Sums::memory);
        size_of_val(self.nodes.as_slice()) + size_of_val(self.leaves.as_slice()) + sums
    }
}

/// The truth values of one program along one ray; reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub struct ProgramState {
    /// The set of leaves that are inside, if the program has a table; then the other fields are not used.
    inside_set: u32,
    leaf_inside: Vec<bool>,
    /// Number of operands that are inside, not counting the first operand of a difference.
    count: Vec<u32>,
    first_inside: Vec<bool>,
    /// Leaves to clear for the next ray.
    touched: Vec<u32>,
}

impl ProgramState {
    /// Prepares the state for a program, with every leaf outside.
    pub fn reset(&mut self, program: &Program) {
        if program.table.is_some() {
            self.inside_set = 0;
            return;
        }
        if self.leaf_inside.len() < program.leaves.len() {
            self.leaf_inside.resize(program.leaves.len(), false);
        }
        if self.count.len() < program.nodes.len() {
            self.count.resize(program.nodes.len(), 0);
            self.first_inside.resize(program.nodes.len(), false);
        }
    }

    /// Moves the leaves that this ray has toggled back outside.
    pub fn clear(&mut self, program: &Program) {
        self.inside_set = 0;
        while let Some(leaf) = self.touched.pop() {
            if self.leaf_inside[leaf as usize] {
                self.flip(program, leaf);
            }
        }
    }

    /// The value of the whole expression.
    #[inline]
    pub fn value(&self, program: &Program) -> bool {
        match &program.table {
            Some(table) => table.value(self.inside_set),
            None => self.node_value(program, 0),
        }
    }

    fn node_value(&self, program: &Program, node: usize) -> bool {
        match program.nodes[node].op {
            Op::Union => self.count[node] > 0,
            Op::Intersection => self.count[node] == program.nodes[node].arity,
            Op::Difference => self.first_inside[node] && self.count[node] == 0,
        }
    }

    /// Toggles a leaf.
    #[inline]
    pub fn toggle(&mut self, program: &Program, leaf: u32) {
        if program.table.is_some() {
            self.inside_set ^= 1 << leaf;
        } else {
            self.touched.push(leaf);
            self.flip(program, leaf);
        }
    }

    fn flip(&mut self, program: &Program, leaf: u32) {
        let value = &mut self.leaf_inside[leaf as usize];
        *value = !*value;
        let (mut now, mut link) = (*value, program.leaves[leaf as usize]);
        while link.node != NONE {
            let node = link.node as usize;
            let before = self.node_value(program, node);
            if link.first {
                self.first_inside[node] = now;
            } else if now {
                self.count[node] += 1;
            } else {
                self.count[node] -= 1;
            }
            let after = self.node_value(program, node);
            if after == before {
                return;
            }
            (now, link) = (after, program.nodes[node].link);
        }
    }
}
