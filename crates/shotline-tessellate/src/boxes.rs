//! Boxes around the nodes of a scene, each in its own coordinates.

use std::collections::HashMap;

use shotline::aabb::Aabb;
use shotline::compile::InvalidScene;
use shotline::scene::{Node, NodeId, Scene};

use crate::graph::{matrix, postorder, scene_of_shape};

/// Boxes around some nodes and those below them, down to solids, meshes and combinations.
pub fn boxes(scene: &Scene, nodes: &[NodeId]) -> Result<HashMap<NodeId, Aabb>, InvalidScene> {
    let mut boxes = HashMap::new();
    let mut todo = nodes.to_vec();
    let mut entered = Vec::new();
    // What is in a combination needs no box.
    while let Some(id) = todo.pop() {
        if boxes.insert(id, Aabb::EMPTY).is_none() {
            entered.push(id);
            if !matches!(scene.node(id), Node::Csg { .. }) {
                todo.extend(scene.node(id).children());
            }
        }
    }
    for id in postorder(scene, &entered) {
        if boxes.contains_key(&id) {
            let found = box_of(scene, id, &boxes)?;
            boxes.insert(id, found);
        }
    }
    Ok(boxes)
}

/// The box around a node from those around its children.
fn box_of(scene: &Scene, id: NodeId, boxes: &HashMap<NodeId, Aabb>) -> Result<Aabb, InvalidScene> {
    Ok(match scene.node(id) {
        Node::Transform { transform, child } => boxes[child].transformed(&matrix([transform])),
        Node::Group { members } => members.iter().fold(Aabb::EMPTY, |all, member| all.union(&boxes[member])),
        _ => scene_of_shape(scene, id, &[], "").compile()?.bounds(),
    })
}
