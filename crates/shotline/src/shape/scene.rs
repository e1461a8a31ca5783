//! From objects to the arena of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use super::Object;
use super::node::{NodeKind, ShapeNode};
use crate::scene::{Node, NodeId, Scene};

impl Scene {
    /// The scene of some objects: each node becomes one node of the arena, however many places it has.
    pub fn of(objects: impl IntoIterator<Item = Object>) -> Scene {
        let roots: Vec<Arc<ShapeNode>> = objects.into_iter().map(Object::into_part).collect();
        let mut scene = Scene::default();
        let mut numbers = HashMap::new();
        for root in &roots {
            let id = add(&mut scene, root, &mut numbers);
            scene.objects.push(id);
        }
        scene
    }
}

/// The numbers of the nodes that have been added, by their addresses: the roots keep them all.
type Numbers = HashMap<*const ShapeNode, NodeId>;

/// Adds a node and all below it that is not there yet, children first. Without recursion.
fn add(scene: &mut Scene, root: &Arc<ShapeNode>, numbers: &mut Numbers) -> NodeId {
    // A node and how many of its children have been looked at: the stack from the root to here.
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
        let id = scene.add(scene_node(&node.what, children));
        if let Some(accel) = node.accel {
            scene.accels.insert(id, accel);
        }
        numbers.insert(Arc::as_ptr(node), id);
        stack.pop();
    }
    numbers[&Arc::as_ptr(root)]
}

fn scene_node(what: &NodeKind, children: Vec<NodeId>) -> Node {
    match what {
        NodeKind::Solid { kind, params } => Node::Solid { kind, params: params.clone() },
        NodeKind::Mesh(mesh) => Node::Mesh { mesh: mesh.clone(), file: None },
        NodeKind::Combination(op) => Node::Csg { op: *op, args: children },
        NodeKind::Group => Node::Group { members: children },
        NodeKind::Placed(transform) => Node::Transform { transform: *transform, child: children[0] },
        NodeKind::Object { name, material, priority } => Node::Object {
            name: name.clone(),
            material: material.clone(),
            priority: *priority,
            node: children[0],
        },
    }
}
