//! The graph as a whole: checks that every number refers to a node and that there is no cycle, and finds shared
//! nodes.

use std::collections::HashMap;

use super::SceneError;
use crate::scene::{Node, NodeId, Scene};

/// A checked graph.
pub(super) struct Graph {
    /// Every reachable node, children before parents.
    pub postorder: Vec<NodeId>,
    /// Whether a node is compiled by itself, to be placed on more than one path from the roots: lattices are, and what they
    /// hold. A node below a combination is not placed by itself.
    shared: Vec<bool>,
}

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    New,
    /// On the path from a root to the current node, at this index.
    Open(usize),
    Done,
}

impl Graph {
    pub(super) fn of(scene: &Scene) -> Result<Graph, Vec<SceneError>> {
        check_numbers(scene)?;
        let postorder = search(scene)?;
        check_roots(scene)?;
        check_contents(scene, &postorder)?;
        let shared = find_shared(scene, &postorder);
        Ok(Graph { postorder, shared })
    }

    pub(super) fn is_shared(&self, node: NodeId) -> bool {
        self.shared[node.0 as usize]
    }
}

fn roots(scene: &Scene) -> impl Iterator<Item = NodeId> {
    scene.objects.iter().copied().chain(scene.defs.iter().map(|(_, node)| *node))
}

/// Checks that the contents of objects are objects and groups of them.
fn check_contents(scene: &Scene, postorder: &[NodeId]) -> Result<(), Vec<SceneError>> {
    let mut holds_objects_only = vec![false; scene.nodes.len()];
    let mut errors = Vec::new();
    for &id in postorder {
        let holds = |id: &NodeId| holds_objects_only[id.0 as usize];
        let of_node = match scene.node(id) {
            Node::Object { contents, .. } => {
                let wrong = contents.iter().find(|part| !holds(part));
                errors.extend(wrong.map(|&part| {
                    SceneError::at(part, "the contents of an object are objects and groups of them".into())
                        .with_hint("give the shape a name and a material, as an object of its own")
                }));
                true
            }
            Node::Group { members } | Node::Lattice { elements: members, .. } => members.iter().all(holds),
            Node::Transform { child, .. } => holds(child),
            Node::Solid { .. } | Node::Mesh { .. } | Node::Csg { .. } => false,
        };
        holds_objects_only[id.0 as usize] = of_node;
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

fn check_numbers(scene: &Scene) -> Result<(), Vec<SceneError>> {
    let is_there = |id: &NodeId| (id.0 as usize) < scene.nodes.len();
    let mut errors = Vec::new();
    for id in roots(scene).filter(|id| !is_there(id)) {
        errors.push(SceneError::general(format!("there is no node number {}", id.0)));
    }
    for (i, node) in (0..).zip(&scene.nodes) {
        for id in node.children().filter(|id| !is_there(id)) {
            errors.push(SceneError::at(NodeId(i), format!("there is no node number {}", id.0)));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// Checks that the roots are objects, which may be transformed. There are no cycles.
fn check_roots(scene: &Scene) -> Result<(), Vec<SceneError>> {
    let is_object = |mut id: NodeId| {
        while let Node::Transform { child, .. } = scene.node(id) {
            id = *child;
        }
        matches!(scene.node(id), Node::Object { .. })
    };
    let wrong = scene.objects.iter().filter(|&&id| !is_object(id));
    let errors: Vec<_> =
        wrong.map(|&id| SceneError::at(id, "the roots of a scene must be objects".into())).collect();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// Maximum number of cycles that are reported; a file can have millions.
const MAX_REPORTED_CYCLES: usize = 100;

/// Depth-first search with an explicit stack. Returns the nodes in postorder, or an error for each cycle that names
/// its nodes.
fn search(scene: &Scene) -> Result<Vec<NodeId>, Vec<SceneError>> {
    let mut marks = vec![Mark::New; scene.nodes.len()];
    let mut postorder = Vec::new();
    let mut errors = Vec::new();
    // If a node has several names, the first is used: in reversed order it is inserted last.
    let names = scene.defs.iter().rev().map(|(name, id)| (*id, name.as_str())).collect();
    // The path from a root to the current node: each node with the number of its children that have been visited.
    let mut path: Vec<(NodeId, usize)> = Vec::new();
    for root in roots(scene) {
        if marks[root.0 as usize] == Mark::New {
            marks[root.0 as usize] = Mark::Open(0);
            path.push((root, 0));
        }
        while let Some((node, next)) = path.last_mut() {
            let Some(child) = scene.node(*node).child(*next) else {
                marks[node.0 as usize] = Mark::Done;
                postorder.push(*node);
                path.pop();
                continue;
            };
            *next += 1;
            match marks[child.0 as usize] {
                Mark::New => {
                    marks[child.0 as usize] = Mark::Open(path.len());
                    path.push((child, 0));
                }
                Mark::Open(start) => {
                    errors.push(cycle_error(&names, &path[start..]));
                    if errors.len() >= MAX_REPORTED_CYCLES {
                        return Err(errors);
                    }
                }
                Mark::Done => {}
            }
        }
    }
    if errors.is_empty() { Ok(postorder) } else { Err(errors) }
}

/// Maximum number of names in the report of a cycle; a longer cycle is cut after its first names.
const MAX_REPORTED_NAMES: usize = 12;

/// Describes a cycle by the names of its nodes, or by their numbers if none of them has a name.
fn cycle_error(names: &HashMap<NodeId, &str>, cycle: &[(NodeId, usize)]) -> SceneError {
    let back_to = cycle[0].0;
    let named = || cycle.iter().filter_map(|(id, _)| names.get(id));
    let (mut reported, count): (Vec<String>, usize) = match named().count() {
        0 => (
            cycle.iter().take(MAX_REPORTED_NAMES).map(|(id, _)| format!("node {}", id.0)).collect(),
            cycle.len(),
        ),
        count => (named().take(MAX_REPORTED_NAMES).map(|name| format!("'{name}'")).collect(), count),
    };
    let first = reported[0].clone();
    if count > reported.len() {
        reported.push(format!("{} more", count - reported.len()));
    }
    reported.push(first);
    SceneError::at(back_to, format!("a part contains itself: {}", reported.join(" -> ")))
        .with_hint("break the cycle: a shared part may not be used inside itself")
}

/// Finds shared nodes: lattices, those with several parents, and those with a parent that is shared. Operands of
/// combinations do not count.
fn find_shared(scene: &Scene, postorder: &[NodeId]) -> Vec<bool> {
    let mut parents = vec![0u32; scene.nodes.len()];
    let mut reached = vec![false; scene.nodes.len()];
    let mut shared = vec![false; scene.nodes.len()];
    for root in &scene.objects {
        parents[root.0 as usize] += 1;
        reached[root.0 as usize] = true;
    }
    for id in postorder.iter().rev() {
        let i = id.0 as usize;
        if !reached[i] {
            continue;
        }
        shared[i] |= parents[i] > 1 || matches!(scene.node(*id), Node::Lattice { .. });
        if matches!(scene.node(*id), Node::Csg { .. }) {
            continue;
        }
        for child in scene.node(*id).children() {
            let c = child.0 as usize;
            parents[c] += 1;
            reached[c] = true;
            shared[c] |= shared[i];
        }
    }
    shared
}
