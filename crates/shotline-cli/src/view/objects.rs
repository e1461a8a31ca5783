//! The scene graph, for a page that opens it node by node: expanded at once it may have billions of nodes.

use serde_json::{Value, json};
use shotline::scene::{Node, NodeId, Op, Scene};

/// The nodes in one answer.
const MOST: usize = 200;

/// The nodes below a node, or the roots, from an index on.
pub fn children(scene: &Scene, of: Option<u32>, from: usize) -> Result<Value, String> {
    let below: Vec<NodeId> = match of {
        None => scene.objects.clone(),
        Some(id) if (id as usize) < scene.nodes.len() => below(scene, NodeId(id)).collect(),
        Some(id) => return Err(format!("the scene has no node {id}")),
    };
    let nodes: Vec<Value> = below.iter().skip(from).take(MOST).map(|&id| entry(scene, id)).collect();
    Ok(json!({ "nodes": nodes, "count": below.len(), "from": from }))
}

/// The objects whose names contain a text, in any case of letters.
pub fn find(scene: &Scene, text: &str) -> Value {
    let wanted = text.to_lowercase();
    let mut seen = std::collections::HashSet::new();
    let found = (0..).map(NodeId).zip(&scene.nodes).filter(|(_, node)| match node {
        Node::Object { name, .. } => name.to_lowercase().contains(&wanted) && seen.insert(name.as_str()),
        _ => false,
    });
    let found: Vec<NodeId> = found.map(|(id, _)| id).collect();
    let nodes: Vec<Value> = found.iter().take(MOST).map(|&id| entry(scene, id)).collect();
    json!({ "nodes": nodes, "count": found.len() })
}

/// The nodes below a node, without the transforms above them.
fn below(scene: &Scene, id: NodeId) -> impl Iterator<Item = NodeId> {
    scene.node(untransformed(scene, id)).children()
}

/// The first node below transforms.
fn untransformed(scene: &Scene, mut id: NodeId) -> NodeId {
    while let Node::Transform { child, .. } = scene.node(id) {
        id = *child;
    }
    id
}

fn entry(scene: &Scene, placed: NodeId) -> Value {
    let id = untransformed(scene, placed);
    let node = scene.node(id);
    let (kind, name) = match node {
        Node::Solid { kind, .. } => (kind.name, None),
        Node::Mesh { file, .. } => ("mesh", file.as_ref().map(|file| file.name.as_str())),
        Node::Csg { op: Op::Union, .. } => ("union", None),
        Node::Csg { op: Op::Intersection, .. } => ("intersection", None),
        Node::Csg { op: Op::Difference, .. } => ("difference", None),
        Node::Group { .. } => ("group", None),
        Node::Lattice { .. } => ("lattice", None),
        Node::Transform { .. } => ("transform", None),
        Node::Object { name, .. } => ("object", Some(name.as_str())),
    };
    let label = scene.labels.get(&placed).map(String::as_str).filter(|label| !label.is_empty());
    let material = match node {
        Node::Object { material, .. } => material.as_deref(),
        _ => None,
    };
    let color = scene.materials.iter().find(|(name, _)| Some(name.as_str()) == material);
    json!({
        "id": id.0,
        "kind": kind,
        "name": name,
        "label": label,
        "material": material,
        "color": color.and_then(|(_, material)| material.color),
        "children": node.children().count(),
    })
}
