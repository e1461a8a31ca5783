//! Bodies: a combination with all its leaves placed in one frame, under one accelerator.

use std::cmp::Reverse;
use std::ops::Range;
use std::sync::Arc;

use super::accel_choice::AccelChoice;
use super::built_leaves::{BuiltLeaf, BuiltLeaves};
use super::world::{Body, Leaf, SolidBody, SurfaceBody};
use super::{SceneError, Stats};
use crate::aabb::Aabb;
use crate::accel::{self, Items};
use crate::csg::{LeafBounds, Op, Program, Tree, TreeNode};
use crate::math::{Affine, ComposedTransform, ShiftedTransform, SingularTransform, TransformPair, Vec3};
use crate::region::Constraint;
use crate::scene::{Node, NodeId, Scene};
use crate::solid::{Parts, Solid};

/// Up to this many leaves are tested one after the other, which is cheaper than any accelerator.
const MAX_LEAVES_WITHOUT_ACCEL: usize = 8;

/// The input of building bodies, and the totals over all bodies built.
pub(super) struct BodyBuilder<'s> {
    pub scene: &'s Scene,
    pub leaves: &'s BuiltLeaves,
    pub choice: AccelChoice<'s>,
    /// Surfaces numbered so far.
    pub surfaces: u32,
    pub stats: Stats,
}

/// A leaf with the transform that places it.
struct PlacedLeaf {
    leaf: Leaf,
    body_from_local: Affine,
}

/// A pending step of flattening an expression.
enum Step {
    Enter(NodeId, ComposedTransform),
    Combine(Op, usize),
}

impl BodyBuilder<'_> {
    /// Builds the body of a solid, mesh or combination under a chain of transforms that is baked into it.
    pub(super) fn build(&mut self, node: NodeId, composed: &ComposedTransform) -> Result<Body, SceneError> {
        let first_surface = self.surfaces;
        if let Some(BuiltLeaf::Mesh(mesh)) = self.leaves.get(node)
            && !mesh.is_closed()
        {
            let mesh = mesh.clone();
            let placement = self.placed(node, composed)?;
            self.count_surfaces(&*mesh);
            let bounds = mesh.bounds().transformed(&placement.parent_from_local);
            return Ok(Body::Surface(SurfaceBody {
                mesh,
                local_from_body: placement.local_from_parent,
                bounds,
                first_surface,
            }));
        }
        let (tree, root, leaves) = self.flatten(node, composed)?;
        Ok(Body::Solid(finish(&tree, root, leaves, first_surface, self.choice.of(node))))
    }

    /// Flattens the expression over placed leaves. Shared nodes are expanded: each use is a leaf of its own.
    fn flatten(
        &mut self,
        node: NodeId,
        composed: &ComposedTransform,
    ) -> Result<(Tree, u32, Vec<PlacedLeaf>), SceneError> {
        let (mut tree, mut leaves) = (Tree::default(), Vec::new());
        let mut steps = vec![Step::Enter(node, *composed)];
        let mut done: Vec<u32> = Vec::new();
        while let Some(step) = steps.pop() {
            let new = match step {
                Step::Combine(op, count) => TreeNode::Op(op, done.split_off(done.len() - count)),
                Step::Enter(node, composed) => match self.scene.node(node) {
                    Node::Transform { transform, child } => {
                        steps.push(Step::Enter(*child, transform.inside(&composed)));
                        continue;
                    }
                    Node::Object { node, .. } => {
                        steps.push(Step::Enter(*node, composed));
                        continue;
                    }
                    Node::Csg { op, args } => {
                        enter_all(&mut steps, *op, args, &composed);
                        continue;
                    }
                    Node::Group { members } => {
                        enter_all(&mut steps, Op::Union, members, &composed);
                        continue;
                    }
                    Node::Lattice { .. } => {
                        let cells: Vec<(u32, Vec3, NodeId)> = self.scene.node(node).cells().collect();
                        steps.push(Step::Combine(Op::Union, cells.len()));
                        steps.extend(cells.into_iter().rev().map(|(_, shift, element)| {
                            Step::Enter(element, composed.then(&Affine::translation(shift)))
                        }));
                        continue;
                    }
                    Node::Solid { .. } | Node::Mesh { .. } => {
                        done.push(self.solid(node, &composed, &mut tree, &mut leaves)?);
                        continue;
                    }
                },
            };
            done.push(tree.nodes.len() as u32);
            tree.nodes.push(new);
        }
        let root = (tree.nodes.len() - 1) as u32;
        Ok((tree, root, leaves))
    }

    /// Adds the parts of a solid to the expression. Returns its node there.
    fn solid(
        &mut self,
        node: NodeId,
        composed: &ComposedTransform,
        tree: &mut Tree,
        leaves: &mut Vec<PlacedLeaf>,
    ) -> Result<u32, SceneError> {
        let placement = self.placed(node, composed)?;
        let number = leaves.last().map_or(0, |last| last.leaf.number + 1);
        let of_mesh;
        let (parts, kind) = match self.leaves.get(node) {
            Some(BuiltLeaf::Solid { parts, kind }) => (parts, *kind),
            Some(BuiltLeaf::Mesh(mesh)) => {
                of_mesh = Parts::Solid(mesh.clone(), mesh.surfaces());
                (&of_mesh, "mesh")
            }
            None => return Err(SceneError::at(node, "this node is not a solid".into())),
        };
        let first = leaves.len();
        let added = add_parts(parts, tree, &mut |solid, surfaces| {
            let leaf = Leaf {
                solid: solid.clone(),
                kind,
                number,
                surfaces,
                local_from_body: placement.local_from_parent,
                bounds: solid.bounds().transformed(&placement.parent_from_local),
                first_surface: 0,
            };
            leaves.push(PlacedLeaf { leaf, body_from_local: placement.parent_from_local });
            (leaves.len() - 1) as u32
        });
        for placed in &mut leaves[first..] {
            placed.leaf.first_surface = self.surfaces;
            self.count_surfaces(&*placed.leaf.solid);
        }
        Ok(added)
    }

    /// The placement of a node under a chain of transforms. Updates the worst condition number so far.
    pub fn placed(
        &mut self,
        node: NodeId,
        composed: &ComposedTransform,
    ) -> Result<TransformPair, SceneError> {
        let placement = composed.placement().map_err(|e| refused(node, e))?;
        self.stats.condition = self.stats.condition.max(placement.condition);
        Ok(placement)
    }

    /// As [`BodyBuilder::placed`], for a chain of transforms that is placed with many shifts.
    pub fn shifted(&mut self, node: NodeId, chain: &[Affine]) -> Result<ShiftedTransform, SceneError> {
        let (transform, condition) = ShiftedTransform::new(chain).map_err(|e| refused(node, e))?;
        self.stats.condition = self.stats.condition.max(condition);
        Ok(transform)
    }

    fn count_surfaces(&mut self, solid: &dyn Solid) {
        self.surfaces += solid.surfaces().len() as u32;
        self.stats.leaves += 1;
    }
}

/// The error of a node whose transforms together cannot be inverted.
fn refused(node: NodeId, why: SingularTransform) -> SceneError {
    SceneError::at(node, format!("all transforms above it together: {why}"))
        .with_hint("scale it less, or less unevenly, in the transforms above it")
}

/// Adds parts to an expression, and their solids by `add`, which returns their numbers. Returns the node of the parts.
fn add_parts(
    parts: &Parts,
    tree: &mut Tree,
    add: &mut impl FnMut(&Arc<dyn Solid>, &'static [&'static str]) -> u32,
) -> u32 {
    let (op, args) = match parts {
        Parts::Solid(solid, surfaces) => {
            tree.nodes.push(TreeNode::Leaf(add(solid, surfaces)));
            return (tree.nodes.len() - 1) as u32;
        }
        Parts::Union(args) => (Op::Union, args),
        Parts::Intersection(args) => (Op::Intersection, args),
        Parts::Difference(args) => (Op::Difference, args),
    };
    let args = args.iter().map(|part| add_parts(part, tree, add)).collect();
    tree.nodes.push(TreeNode::Op(op, args));
    (tree.nodes.len() - 1) as u32
}

fn enter_all(steps: &mut Vec<Step>, op: Op, args: &[NodeId], composed: &ComposedTransform) {
    steps.push(Step::Combine(op, args.len()));
    steps.extend(args.iter().rev().map(|&arg| Step::Enter(arg, *composed)));
}

fn finish(tree: &Tree, root: u32, placed: Vec<PlacedLeaf>, first_surface: u32, accel: &str) -> SolidBody {
    let program = Program::new(tree, root, placed.len());
    let own: Vec<Aabb> = placed.iter().map(|placed| placed.leaf.bounds).collect();
    let constraints = constraints(&program, &placed);
    let effective = program.effective_bounds(LeafBounds { boxes: &own, constraints: &constraints });
    let bounds = program.bounds(&effective);
    let mut leaves: Vec<Leaf> = placed.into_iter().map(|placed| placed.leaf).collect();
    for (leaf, b) in leaves.iter_mut().zip(&effective) {
        leaf.bounds = *b;
    }
    let accel = if leaves.len() > MAX_LEAVES_WITHOUT_ACCEL {
        accel::build(accel, Items { boxes: &effective, groups: Some(&operations(tree)) })
    } else {
        None
    };
    let has_mesh = leaves.iter().any(|leaf| leaf.solid.as_mesh().is_some());
    let takes_lanes = accel.is_none() && !has_mesh && program.takes_lanes();
    let takes_bundles = !has_mesh && accel.as_ref().is_some_and(|accel| accel.takes_beams());
    let takes_waves = takes_bundles
        && program.tally().is_some()
        && leaves.iter().all(|leaf| leaf.solid.in_lanes().is_some());
    SolidBody { leaves, program, accel, bounds, first_surface, takes_lanes, takes_bundles, takes_waves }
}

/// The constraints of unbounded leaves; empty where every leaf is bounded.
fn constraints(program: &Program, placed: &[PlacedLeaf]) -> Vec<Option<Constraint>> {
    let has_no_end = |placed: &PlacedLeaf| {
        let b = placed.leaf.bounds;
        !b.is_empty() && !b.is_finite() && placed.leaf.solid.surfaces().len() == 1
    };
    // A single leaf has no other operands that could reduce its box.
    if placed.len() < 2 || !placed.iter().any(has_no_end) {
        return Vec::new();
    }
    let constraint = |(number, placed): (u32, &PlacedLeaf)| {
        let leaf = Some(placed).filter(|placed| has_no_end(placed))?;
        let q = leaf.leaf.solid.quadric_matrix(0)?.rows;
        Constraint::new(q, &leaf.body_from_local, &leaf.leaf.local_from_body, program.is_taken(number))
    };
    (0..).zip(placed).map(constraint).collect()
}

/// The ranges of the leaves of all operations, outer operations first.
fn operations(tree: &Tree) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::with_capacity(tree.nodes.len());
    for node in &tree.nodes {
        let range = |arg: &u32| ranges[*arg as usize].clone();
        ranges.push(match node {
            TreeNode::Leaf(leaf) => *leaf..leaf + 1,
            TreeNode::Op(_, args) => match (args.first().map(range), args.last().map(range)) {
                (Some(first), Some(last)) => first.start..last.end,
                _ => 0..0,
            },
        });
    }
    ranges.retain(|range| range.len() > 1);
    ranges.sort_by_key(|range| (range.start, Reverse(range.end)));
    ranges
}

/// Whether a node in a group is placed as a body.
pub(super) fn is_body(node: &Node) -> bool {
    matches!(node, Node::Solid { .. } | Node::Mesh { .. } | Node::Csg { .. })
}
