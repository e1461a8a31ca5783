//! Chooses the nodes that are written in `defs`, and their names: nodes that have a name already, nodes with several
//! parents, transforms of transforms (a node of a file has one transform), objects in place of a shape, and nodes at regular
//! depths of deep nesting, which readers would refuse otherwise.

use std::collections::{HashMap, HashSet};

use shotline::scene::{Node, NodeId, Scene};

/// The depth of nested nodes at which the next gets a name; each node takes at most three brackets.
const MAX_NESTING: usize = 500;

/// The names of a scene's shared nodes.
pub(super) struct Names {
    /// The entries of `defs`: the names of the scene, then new ones.
    pub(super) defs: Vec<(String, NodeId)>,
    /// The name by which a node is referred to.
    pub(super) of: HashMap<NodeId, String>,
}

impl Names {
    pub(super) fn of(scene: &Scene) -> Names {
        let mut names = Names { defs: Vec::new(), of: HashMap::new() };
        let mut taken: HashSet<String> = scene.defs.iter().map(|(name, _)| name.clone()).collect();
        for (name, id) in &scene.defs {
            names.of.entry(*id).or_insert_with(|| name.clone());
            names.defs.push((name.clone(), *id));
        }
        let mut free = (0..).map(|i| format!("part{i}"));
        for id in nameless(scene, &names.of) {
            let name = free.find(|name| taken.insert(name.clone())).unwrap_or_default();
            names.of.insert(id, name.clone());
            names.defs.push((name, id));
        }
        names
    }
}

/// The nodes without a name that need one, in the order of the traversal.
fn nameless(scene: &Scene, named: &HashMap<NodeId, String>) -> Vec<NodeId> {
    let mut visited: HashSet<NodeId> = HashSet::new();
    let mut found: Vec<NodeId> = Vec::new();
    let mut needs: HashSet<NodeId> = HashSet::new();
    let mut need = |id: NodeId, found: &mut Vec<NodeId>| {
        if !named.contains_key(&id) && needs.insert(id) {
            found.push(id);
        }
    };
    let mut todo: Vec<(NodeId, usize)> = scene.objects.iter().rev().map(|id| (*id, 0)).collect();
    todo.extend(scene.defs.iter().rev().map(|(_, id)| (*id, 0)));
    while let Some((id, mut depth)) = todo.pop() {
        if !visited.insert(id) {
            need(id, &mut found);
            continue;
        }
        if depth == MAX_NESTING {
            need(id, &mut found);
            depth = 0;
        }
        let node = scene.node(id);
        if let Node::Transform { child, .. } = node
            && matches!(scene.node(*child), Node::Transform { .. })
        {
            need(*child, &mut found);
        }
        if let Node::Object { node: shape, .. } = node
            && let Some(object) = object_in_place_of_a_shape(scene, *shape)
        {
            need(object, &mut found);
        }
        todo.extend(node.children().rev().map(|child| (child, depth + 1)));
    }
    found
}

/// The object that is the shape of another, perhaps transformed. A file can only refer to it there.
fn object_in_place_of_a_shape(scene: &Scene, shape: NodeId) -> Option<NodeId> {
    let id = match scene.node(shape) {
        Node::Transform { child, .. } => *child,
        _ => shape,
    };
    matches!(scene.node(id), Node::Object { .. }).then_some(id)
}
