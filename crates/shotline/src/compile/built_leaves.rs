//! Builds and checks each node by itself: builds leaf solids, and checks transforms and combinations.

use std::sync::Arc;

use super::SceneError;
use super::accel_choice::AccelChoice;
use super::graph::Graph;
use crate::math::ComposedTransform;
use crate::scene::{Node, NodeId, Scene};
use crate::solid::Parts;
use crate::solid::mesh::{MeshError, MeshSolid, Weld};

/// A combination of more leaves than this is rejected before it is built.
const MAX_LEAVES: u64 = 4_000_000;

/// The same limit for nodes, with shared nodes counted at every use: nested groups can be large without any leaf.
const MAX_NODES: u64 = 10 * MAX_LEAVES;

/// A leaf of the graph, built.
#[derive(Clone, Debug)]
pub(super) enum BuiltLeaf {
    Solid { parts: Parts, kind: &'static str },
    Mesh(Arc<MeshSolid>),
}

/// The leaves by node number.
#[derive(Debug)]
pub(super) struct BuiltLeaves {
    leaves: Vec<BuiltLeaf>,
    /// For each node the number of its leaf, or [`NO_LEAF`]: most nodes of large scenes are no leaves.
    numbers: Vec<u32>,
}

const NO_LEAF: u32 = u32::MAX;

/// What a combination needs to know of its operands.
#[derive(Clone, Copy, Default)]
struct SubtreeSummary {
    leaves: u64,
    /// The number of all nodes, including the node itself.
    nodes: u64,
    object: Option<NodeId>,
    open_mesh: Option<NodeId>,
    /// Whether an error in a combination below has been reported. It is not reported again for each combination
    /// above.
    reported: bool,
}

impl BuiltLeaves {
    /// Builds every reachable leaf, and reports everything that is wrong with any node.
    pub(super) fn build(
        scene: &Scene,
        graph: &Graph,
        choice: AccelChoice,
    ) -> Result<BuiltLeaves, Vec<SceneError>> {
        let mut out = BuiltLeaves { leaves: Vec::new(), numbers: vec![NO_LEAF; scene.nodes.len()] };
        let mut below = vec![SubtreeSummary::default(); scene.nodes.len()];
        let mut errors = Vec::new();
        for &id in &graph.postorder {
            let node = scene.node(id);
            match build_leaf(node, id, choice) {
                Ok(Some(leaf)) => out.add(id, leaf),
                Ok(None) => {}
                Err(error) => errors.push(error),
            }
            let found = gather(node, id, &below, out.get(id));
            let before = errors.len();
            check(scene, &out, id, &found, &mut errors);
            let reported = errors.len() > before && matches!(node, Node::Csg { .. });
            below[id.0 as usize] =
                if reported { SubtreeSummary { reported, ..SubtreeSummary::default() } } else { found };
        }
        if errors.is_empty() { Ok(out) } else { Err(errors) }
    }

    pub(super) fn get(&self, id: NodeId) -> Option<&BuiltLeaf> {
        self.leaves.get(self.numbers[id.0 as usize] as usize)
    }

    fn add(&mut self, id: NodeId, leaf: BuiltLeaf) {
        self.numbers[id.0 as usize] = self.leaves.len() as u32;
        self.leaves.push(leaf);
    }
}

fn build_leaf(node: &Node, id: NodeId, choice: AccelChoice) -> Result<Option<BuiltLeaf>, SceneError> {
    match node {
        Node::Solid { kind, params } => match kind.build(params) {
            Ok(parts) => Ok(Some(BuiltLeaf::Solid { parts, kind: kind.name })),
            Err(e) => {
                let message = format!("{}: {} {}", kind.name, e.param, e.why);
                Err(SceneError { param: Some(e.param), ..SceneError::at(id, message) })
            }
        },
        Node::Mesh { mesh, file } => match MeshSolid::new(mesh.clone(), choice.of(id)) {
            Ok(solid) => Ok(Some(BuiltLeaf::Mesh(Arc::new(solid)))),
            Err(e) => {
                let name = file.as_ref().map_or("mesh", |file| &file.name);
                let e = match (e, file.as_ref().and_then(|file| file.weld)) {
                    // Readers reject a file without faces, so welding must have removed all of them.
                    (MeshError::Empty, Some(Weld::Within(within))) if mesh.faces.is_empty() => {
                        MeshError::Collapsed { within }
                    }
                    (e, _) => e,
                };
                Err(SceneError { param: Some("file"), ..SceneError::at(id, format!("{name}: {e}")) })
            }
        },
        _ => Ok(None),
    }
}

fn gather(node: &Node, id: NodeId, below: &[SubtreeSummary], leaf: Option<&BuiltLeaf>) -> SubtreeSummary {
    let mut out = SubtreeSummary { nodes: 1, ..SubtreeSummary::default() };
    let uses = node.element_uses();
    for (number, child) in node.children().enumerate() {
        let b = &below[child.0 as usize];
        let times = uses.as_ref().map_or(1, |uses| uses[number]);
        if times == 0 {
            continue;
        }
        out.leaves = out.leaves.saturating_add(b.leaves.saturating_mul(times));
        out.nodes = out.nodes.saturating_add(b.nodes.saturating_mul(times));
        out.reported |= b.reported;
        out.object = out.object.or(b.object);
        out.open_mesh = out.open_mesh.or(b.open_mesh);
    }
    match (node, leaf) {
        (Node::Object { .. }, _) => out.object = Some(id),
        (_, Some(BuiltLeaf::Mesh(mesh))) if !mesh.is_closed() => {
            out = SubtreeSummary { leaves: 1, open_mesh: Some(id), ..out };
        }
        (_, Some(BuiltLeaf::Solid { parts, .. })) => out.leaves = parts.count() as u64,
        (Node::Mesh { .. }, _) => out.leaves = 1,
        _ => {}
    }
    out
}

fn check(
    scene: &Scene,
    leaves: &BuiltLeaves,
    id: NodeId,
    below: &SubtreeSummary,
    errors: &mut Vec<SceneError>,
) {
    match scene.node(id) {
        Node::Csg { args, .. } if args.is_empty() => {
            errors.push(SceneError::at(id, "a combination needs at least one operand".into()));
        }
        Node::Csg { .. } => check_combination(leaves, id, below, errors),
        Node::Transform { transform, .. } if transform.is_clearly_invertible() => {}
        Node::Transform { transform, .. } if !transform.is_finite() => {
            let hint = "check for a division by zero, and for an axis of length 0";
            let message = "the transform has a number that is not finite".into();
            errors.push(SceneError::at(id, message).with_hint(hint));
        }
        Node::Transform { transform, .. } => {
            if let Err(e) = transform.inside(&ComposedTransform::IDENTITY).placement() {
                let hint = if e.is_beyond_range() {
                    "check the scale: numbers are between 1e-308 and 1e308"
                } else {
                    "a transform must not flatten space: check for a zero scale or equal rows"
                };
                errors.push(SceneError::at(id, e.to_string()).with_hint(hint));
            }
        }
        Node::Object { name, material: Some(material), .. }
            if !scene.materials.iter().any(|(known, _)| known == material) =>
        {
            let message =
                format!("object '{name}' is made of '{material}', which is not among the materials");
            errors.push(SceneError { param: Some("material"), ..SceneError::at(id, message) });
        }
        _ => {}
    }
}

fn check_combination(leaves: &BuiltLeaves, id: NodeId, below: &SubtreeSummary, errors: &mut Vec<SceneError>) {
    if let Some(object) = below.object {
        let message = "an object cannot be an operand of a combination".into();
        errors.push(SceneError::at(object, message).with_hint("use its node without name and material"));
    }
    if let Some(mesh) = below.open_mesh {
        let why = match leaves.get(mesh) {
            Some(BuiltLeaf::Mesh(mesh)) => mesh.topology().why_open(),
            _ => String::new(),
        };
        let message = format!("a mesh that is not closed cannot be combined with others: {why}");
        let hint = "close the holes in the program that made it, or use it as an object of its own";
        errors.push(SceneError { param: Some("file"), ..SceneError::at(mesh, message).with_hint(hint) });
    }
    let too_many = [("leaves", below.leaves, MAX_LEAVES), ("nodes", below.nodes, MAX_NODES)];
    if let Some((what, count, most)) =
        too_many.into_iter().find(|(_, count, most)| count > most && !below.reported)
    {
        let message = format!("a combination of {count} {what}; at most {most} are accepted");
        errors.push(
            SceneError::at(id, message)
                .with_hint("outside of combinations, groups place shared parts without limit"),
        );
    }
}
