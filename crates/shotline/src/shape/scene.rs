//! Converts objects to the nodes of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use super::Object;
use super::node::{NodeKind, ShapeNode};
use crate::scene::{Node, NodeId, Scene};

impl Scene {
    /// A scene of objects. Each node of a shape becomes one node of the scene, however often it is used.
    pub fn of(objects: impl IntoIterator<Item = Object>) -> Scene {
        let roots: Vec<Arc<ShapeNode>> = objects.into_iter().map(Object::into_node).collect();
        let mut scene = Scene::default();
        let mut numbers = HashMap::new();
        for root in &roots {
            let id = add(&mut scene, root, &mut numbers);
            scene.objects.push(id);
        }
        scene
    }
}

/// The ids of the nodes that have been added, by address. The roots keep all nodes alive, so addresses are unique.
type Numbers = HashMap<*const ShapeNode, NodeId>;

/// Adds a node after those of its descendants that have not been added yet. Not recursive, since nodes may be deep.
fn add(scene: &mut Scene, root: &Arc<ShapeNode>, numbers: &mut Numbers) -> NodeId {
    // The path from the root: each node with the number of its children that have been visited.
    let mut stack: Vec<(&Arc<ShapeNode>, usize)> = vec![(root, 0)];
    while let Some((node, next)) = stack.last_mut() {
        if let Some(child) = node.children.get(*next) {
            *next += 1;
            if !numbers.contains_key(&Arc::as_ptr(child)) {
                stack.push((child, 0));
            }
            continue;
        }
        let children = node.children.iter().map(|child| numbers[&Arc::as_ptr(child)]).collect();
        let id = scene.add(scene_node(&node.kind, children));
        if let Some(accel) = node.accel {
            scene.accels.insert(id, accel);
        }
        numbers.insert(Arc::as_ptr(node), id);
        stack.pop();
    }
    numbers[&Arc::as_ptr(root)]
}

fn scene_node(kind: &NodeKind, children: Vec<NodeId>) -> Node {
    match kind {
        NodeKind::Solid { kind, params } => Node::Solid { kind, params: params.clone() },
        NodeKind::Mesh(mesh) => Node::Mesh { mesh: mesh.clone(), file: None },
        NodeKind::Combination(op) => Node::Csg { op: *op, args: children },
        NodeKind::Group => Node::Group { members: children },
        NodeKind::Lattice { lattice, table } => {
            Node::Lattice { lattice: *lattice, elements: children, table: table.clone() }
        }
        NodeKind::Placed(transform) => Node::Transform { transform: *transform, child: children[0] },
        NodeKind::Object { name, material, priority, clip } => Node::Object {
            name: name.clone(),
            material: material.clone(),
            priority: *priority,
            node: children[0],
            contents: children[1..].to_vec(),
            clip: *clip,
        },
    }
}
