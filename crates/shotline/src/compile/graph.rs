//! The graph as a whole: that every number names a node, that there is no cycle, which parts are shared.

use std::collections::HashMap;

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

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    New,
    /// On the way from a root to where the search is, at this place.
    Open(usize),
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
        for id in node.children().iter().filter(|id| !is_there(id)) {
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

/// Cycles told of; a file can have millions.
const CYCLES_TOLD: usize = 100;

/// Depth-first search with an explicit stack; cycles found are errors that name their nodes.
fn search(scene: &Scene) -> Result<Vec<NodeId>, Vec<SceneError>> {
    let mut marks = vec![Mark::New; scene.nodes.len()];
    let mut postorder = Vec::new();
    let mut errors = Vec::new();
    // Of several names the first tells.
    let names = scene.defs.iter().rev().map(|(name, id)| (*id, name.as_str())).collect();
    // A node and how many of its children have been looked at: the way from a root to here.
    let mut way: Vec<(NodeId, usize)> = Vec::new();
    for root in roots(scene) {
        if marks[root.0 as usize] == Mark::New {
            marks[root.0 as usize] = Mark::Open(0);
            way.push((root, 0));
        }
        while let Some((node, next)) = way.last_mut() {
            let Some(&child) = scene.node(*node).children().get(*next) else {
                marks[node.0 as usize] = Mark::Done;
                postorder.push(*node);
                way.pop();
                continue;
            };
            *next += 1;
            match marks[child.0 as usize] {
                Mark::New => {
                    marks[child.0 as usize] = Mark::Open(way.len());
                    way.push((child, 0));
                }
                Mark::Open(place) => {
                    errors.push(cycle_error(&names, &way[place..]));
                    if errors.len() >= CYCLES_TOLD {
                        return Err(errors);
                    }
                }
                Mark::Done => {}
            }
        }
    }
    if errors.is_empty() { Ok(postorder) } else { Err(errors) }
}

/// Names told of a cycle; of a longer one the first are.
const NAMES_TOLD: usize = 12;

/// A cycle by the names of its parts, or its node numbers where no part has a name.
fn cycle_error(names: &HashMap<NodeId, &str>, cycle: &[(NodeId, usize)]) -> SceneError {
    let back_to = cycle[0].0;
    let named = || cycle.iter().filter_map(|(id, _)| names.get(id));
    let (mut told, count): (Vec<String>, usize) = match named().count() {
        0 => (cycle.iter().take(NAMES_TOLD).map(|(id, _)| format!("node {}", id.0)).collect(), cycle.len()),
        count => (named().take(NAMES_TOLD).map(|name| format!("'{name}'")).collect(), count),
    };
    let first = told[0].clone();
    if count > told.len() {
        told.push(format!("{} more", count - told.len()));
    }
    told.push(first);
    SceneError::at(back_to, format!("a part contains itself: {}", told.join(" -> ")))
        .with_hint("break the cycle: a shared part may not be used inside itself")
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
        for child in scene.node(*id).children() {
            let c = child.0 as usize;
            parents[c] += 1;
            reached[c] = true;
            shared[c] |= shared[i];
        }
    }
    shared
}
