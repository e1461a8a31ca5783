//! The graph as a whole: that every number names a node, that there is no cycle, which parts are shared.

use super::SceneError;
use crate::scene::{Node, NodeId, Scene};

/// A checked graph.
pub(super) struct Graph {
    /// Every node that can be reached, children before parents.
    pub postorder: Vec<NodeId>,
    /// Whether a node is placed on more than one way from the root. What is below a combination is not
    /// placed by itself.
    shared: Vec<bool>,
}

/// The children of a node, in order.
pub(super) fn children(node: &Node) -> &[NodeId] {
    match node {
        Node::Solid { .. } | Node::Mesh { .. } => &[],
        Node::Csg { args, .. } => args,
        Node::Group { members } => members,
        Node::Transform { child, .. } => std::slice::from_ref(child),
        Node::Object { node, .. } => std::slice::from_ref(node),
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    New,
    /// On the way from a root to where the search is.
    Open,
    Done,
}

impl Graph {
    pub(super) fn of(scene: &Scene) -> Result<Graph, Vec<SceneError>> {
        check_numbers(scene)?;
        let postorder = search(scene)?;
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

fn check_numbers(scene: &Scene) -> Result<(), Vec<SceneError>> {
    let is_there = |id: &NodeId| (id.0 as usize) < scene.nodes.len();
    let mut errors = Vec::new();
    for id in roots(scene).filter(|id| !is_there(id)) {
        errors.push(SceneError::general(format!("there is no node number {}", id.0)));
    }
    for (i, node) in (0..).zip(&scene.nodes) {
        for id in children(node).iter().filter(|id| !is_there(id)) {
            errors.push(SceneError::at(NodeId(i), format!("there is no node number {}", id.0)));
        }
    }
    for &id in scene.objects.iter().filter(|id| is_there(id)) {
        if !matches!(scene.node(id), Node::Object { .. }) {
            errors.push(SceneError::at(id, "the roots of a scene must be objects".into()));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// Depth-first search with an explicit stack; every cycle found is an error that names its nodes.
fn search(scene: &Scene) -> Result<Vec<NodeId>, Vec<SceneError>> {
    let mut marks = vec![Mark::New; scene.nodes.len()];
    let mut postorder = Vec::new();
    let mut errors = Vec::new();
    // A node and how many of its children have been looked at: the way from a root to here.
    let mut way: Vec<(NodeId, usize)> = Vec::new();
    for root in roots(scene) {
        if marks[root.0 as usize] == Mark::New {
            marks[root.0 as usize] = Mark::Open;
            way.push((root, 0));
        }
        while let Some((node, next)) = way.last_mut() {
            let Some(&child) = children(scene.node(*node)).get(*next) else {
                marks[node.0 as usize] = Mark::Done;
                postorder.push(*node);
                way.pop();
                continue;
            };
            *next += 1;
            match marks[child.0 as usize] {
                Mark::New => {
                    marks[child.0 as usize] = Mark::Open;
                    way.push((child, 0));
                }
                Mark::Open => errors.push(cycle_error(scene, &way, child)),
                Mark::Done => {}
            }
        }
    }
    if errors.is_empty() { Ok(postorder) } else { Err(errors) }
}

fn cycle_error(scene: &Scene, way: &[(NodeId, usize)], back_to: NodeId) -> SceneError {
    let start = way.iter().position(|(node, _)| *node == back_to).unwrap_or(0);
    let cycle: Vec<NodeId> = way[start..].iter().map(|(node, _)| *node).collect();
    let mut names: Vec<String> = cycle.iter().filter_map(|&node| def_name(scene, node)).collect();
    if names.is_empty() {
        names = cycle.iter().map(|node| format!("node {}", node.0)).collect();
    }
    names.push(names[0].clone());
    SceneError::at(back_to, format!("a part contains itself: {}", names.join(" -> ")))
        .with_hint("break the cycle: a shared part may not be used inside itself")
}

fn def_name(scene: &Scene, node: NodeId) -> Option<String> {
    scene.defs.iter().find(|(_, id)| *id == node).map(|(name, _)| format!("'{name}'"))
}

/// A node is shared if it is placed by several parents, or by one that is shared.
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
        shared[i] |= parents[i] > 1;
        if matches!(scene.node(*id), Node::Csg { .. }) {
            continue;
        }
        for child in children(scene.node(*id)) {
            let c = child.0 as usize;
            parents[c] += 1;
            reached[c] = true;
            shared[c] |= shared[i];
        }
    }
    shared
}
