//! Where the leaves of a program can matter, and the bounding box of its result.

use super::Op;
use super::program::{Link, Program};
use crate::aabb::Aabb;
use crate::region::{Constraint, enclose};

/// Maximum number of constraints that are combined.
const MAX_CONSTRAINTS: usize = 512;

/// Maximum number of unbounded leaves whose boxes are refined one by one.
const MAX_LEAVES: usize = 4096;

/// The input from which the bounds are computed.
#[derive(Clone, Copy, Debug)]
pub struct LeafBounds<'a> {
    /// The box of each leaf.
    pub boxes: &'a [Aabb],
    /// What else is known of the points of each leaf; `None` where its box says everything. For a leaf that is
    /// [taken](Program::is_taken), it is what is known of the points outside the leaf. May be empty if nothing is
    /// known of any leaf.
    pub constraints: &'a [Option<Constraint>],
}

/// The constraints that all points of a node satisfy, each with the leaf it comes from.
type NodeConstraints = Vec<(u32, Constraint)>;

impl Program {
    /// The boxes within which the leaves can matter: an operand counts only inside the bounds of the operands that it
    /// is intersected with or subtracted from. Empty for leaves that never matter.
    ///
    /// Unbounded operands are considered together: half-spaces that enclose a polytope, or cut off a cylinder or a
    /// cone, have finite boxes.
    pub fn effective_bounds(&self, leaves: LeafBounds) -> Vec<Aabb> {
        let node_constraints = self.node_constraints(leaves.constraints);
        let effective = self.within(leaves.boxes, &self.node_bounds(leaves.boxes, &node_constraints));
        if node_constraints.is_empty() || effective.iter().all(|b| b.is_empty() || b.is_finite()) {
            return effective;
        }
        let mut refinements_left = MAX_LEAVES;
        let mut refined = effective.clone();
        for (leaf, b) in (0..).zip(&mut refined) {
            if !b.is_empty() && !b.is_finite() && refinements_left > 0 {
                refinements_left -= 1;
                *b = self.leaf_bounds(leaf, *b, &node_constraints, leaves.constraints);
            }
        }
        if refined == effective {
            return effective;
        }
        // A union whose operands are bounded now also bounds its siblings.
        self.within(&refined, &self.node_bounds(&refined, &node_constraints))
    }

    /// The boxes of the nodes, each within those of its ancestors.
    fn node_bounds(&self, leaves: &[Aabb], node_constraints: &[NodeConstraints]) -> Vec<Aabb> {
        let mut bounds: Vec<Aabb> = self
            .nodes
            .iter()
            .map(|n| if n.op == Op::Intersection { Aabb::EVERYTHING } else { Aabb::EMPTY })
            .collect();
        for (link, own) in self.leaves.iter().zip(leaves) {
            self.gather(&mut bounds, link, *own);
        }
        for i in (0..self.nodes.len()).rev() {
            if let Some(node_constraints) =
                node_constraints.get(i).filter(|node_constraints| !node_constraints.is_empty())
            {
                bounds[i] = enclose(bounds[i], &node_constraints.iter().map(|(_, c)| c).collect::<Vec<_>>());
            }
            if i > 0 {
                let own = bounds[i];
                self.gather(&mut bounds, &self.nodes[i].link, own);
            }
        }
        for i in 1..self.nodes.len() {
            bounds[i] = bounds[i].intersection(&bounds[self.nodes[i].link.node as usize]);
        }
        bounds
    }

    /// The boxes of leaves, cut to the boxes of their nodes.
    fn within(&self, leaves: &[Aabb], nodes: &[Aabb]) -> Vec<Aabb> {
        let cut =
            leaves.iter().zip(&self.leaves).map(|(own, link)| own.intersection(&nodes[link.node as usize]));
        cut.map(|b| if b.is_empty() { Aabb::EMPTY } else { b }).collect()
    }

    /// Merges the box of an operand into that of its parent node.
    fn gather(&self, bounds: &mut [Aabb], link: &Link, own: Aabb) {
        let Some(node) = self.nodes.get(link.node as usize) else { return };
        let above = &mut bounds[link.node as usize];
        *above = match node.op {
            Op::Union => above.union(&own),
            Op::Intersection => above.intersection(&own),
            Op::Difference if link.first => own,
            Op::Difference => *above,
        };
    }

    /// The constraints of each node: its own, and those of operands that contain all of its points. Empty if no leaf
    /// has a constraint.
    fn node_constraints(&self, constraints: &[Option<Constraint>]) -> Vec<NodeConstraints> {
        if constraints.iter().all(Option::is_none) {
            return Vec::new();
        }
        let mut node_constraints: Vec<NodeConstraints> = vec![Vec::new(); self.nodes.len()];
        for ((leaf, link), constraint) in (0..).zip(&self.leaves).zip(constraints) {
            let Some(constraint) = constraint else { continue };
            let Some(node) = self.nodes.get(link.node as usize) else { continue };
            let own = &mut node_constraints[link.node as usize];
            let counts = node.op != Op::Union || node.arity == 1;
            if counts && own.len() < MAX_CONSTRAINTS {
                own.push((leaf, *constraint));
            }
        }
        for i in (1..self.nodes.len()).rev() {
            let link = self.nodes[i].link;
            let above = &self.nodes[link.node as usize];
            let passes = above.op == Op::Intersection || above.op == Op::Difference && link.first;
            if passes
                && node_constraints[i].len() + node_constraints[link.node as usize].len() <= MAX_CONSTRAINTS
            {
                let own = node_constraints[i].clone();
                node_constraints[link.node as usize].extend(own);
            }
        }
        node_constraints
    }

    /// The box of an unbounded leaf, cut by every constraint that must hold where the leaf matters.
    fn leaf_bounds(
        &self,
        leaf: u32,
        start: Aabb,
        node_constraints: &[NodeConstraints],
        constraints: &[Option<Constraint>],
    ) -> Aabb {
        let mut all: Vec<&Constraint> = Vec::new();
        let link = self.leaves[leaf as usize];
        if !self.is_taken(leaf) {
            all.extend(constraints[leaf as usize].as_ref());
        }
        let mut node = link.node;
        while let Some(node_constraints) = node_constraints.get(node as usize) {
            let others = node_constraints.iter().filter(|(of, _)| *of != leaf).map(|(_, c)| c);
            all.extend(others.take(MAX_CONSTRAINTS - all.len().min(MAX_CONSTRAINTS)));
            node = self.nodes[node as usize].link.node;
        }
        let b = enclose(start, &all);
        if b.is_empty() { Aabb::EMPTY } else { b }
    }

    /// Whether a difference takes the leaf from its first operand, even if that difference is itself subtracted.
    pub fn is_taken(&self, leaf: u32) -> bool {
        let link = self.leaves[leaf as usize];
        self.nodes[link.node as usize].op == Op::Difference && !link.first
    }

    /// Whether the result is the intersection of all leaves, with leaves that are [taken](Program::is_taken) replaced
    /// by their complements.
    pub fn is_conjunction(&self) -> bool {
        self.nodes.iter().all(|node| {
            let passes = match self.nodes.get(node.link.node as usize) {
                Some(above) => above.op == Op::Intersection || above.op == Op::Difference && node.link.first,
                None => true,
            };
            passes && (node.op != Op::Union || node.arity == 1)
        })
    }

    /// The box of the result, from the effective bounds of its leaves.
    pub fn bounds(&self, effective: &[Aabb]) -> Aabb {
        // Subtracted leaves add nothing to the box of the result.
        (0..)
            .zip(effective)
            .filter(|(leaf, _)| !self.is_subtracted(*leaf))
            .fold(Aabb::EMPTY, |b, (_, leaf)| b.union(leaf))
    }
}
