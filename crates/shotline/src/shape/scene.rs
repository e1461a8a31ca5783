//! From objects to the arena of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use super::Object;
use super::part::{Part, What};
use crate::scene::{Node, NodeId, Scene};

impl Scene {
    /// The scene of some objects: each node becomes one node of the arena, however many places it has.
    pub fn of(objects: impl IntoIterator<Item = Object>) -> Scene {
        let roots: Vec<Arc<Part>> = objects.into_iter().map(Object::into_part).collect();
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
type Numbers = HashMap<*const Part, NodeId>;

/// Adds a node and all below it that is not there yet, children first. Without recursion.
fn add(scene: &mut Scene, root: &Arc<Part>, numbers: &mut Numbers) -> NodeId {
    // A node and how many of its children have been looked at: the way from the root to here.
    let mut way: Vec<(&Arc<Part>, usize)> = vec![(root, 0)];
    while let Some((part, next)) = way.last_mut() {
        if let Some(child) = part.children.get(*next) {
            *next += 1;
            if !numbers.contains_key(&Arc::as_ptr(child)) {
                way.push((child, 0));
            }
            continue;
        }
        let children = part.children.iter().map(|child| numbers[&Arc::as_ptr(child)]).collect();
        let id = scene.add(node(&part.what, children));
        if let Some(accel) = part.accel {
            scene.accels.insert(id, accel);
        }
        numbers.insert(Arc::as_ptr(part), id);
        way.pop();
    }
    numbers[&Arc::as_ptr(root)]
}

fn node(what: &What, children: Vec<NodeId>) -> Node {
    match what {
        What::Solid { kind, params } => Node::Solid { kind, params: params.clone() },
        What::Mesh(mesh) => Node::Mesh { mesh: mesh.clone(), file: None },
        What::Combination(op) => Node::Csg { op: *op, args: children },
        What::Group => Node::Group { members: children },
        What::Placed(transform) => Node::Transform { transform: *transform, child: children[0] },
        What::Object { name, material, priority } => Node::Object {
            name: name.clone(),
            material: material.clone(),
            priority: *priority,
            node: children[0],
        },
    }
}
