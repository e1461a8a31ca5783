//! The order of the nodes of a scene, and parts of it as scenes of their own.

use std::collections::{HashMap, HashSet};

use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::scene::{LocalTransform, Node, NodeId, Scene};

/// How much the lengths of axes may differ, and the cosines between them may be, relative to 1, in a similarity.
const ROUNDING: f64 = 1e-12;

/// Some nodes of a scene without cycles and all below them, children before parents.
pub fn postorder(scene: &Scene, roots: &[NodeId]) -> Vec<NodeId> {
    let mut seen = HashSet::new();
    let mut order = Vec::new();
    // Each node on the path from a root, with the number of its children that were visited.
    let mut path: Vec<(NodeId, usize)> = Vec::new();
    for root in roots {
        if seen.insert(*root) {
            path.push((*root, 0));
        }
        while let Some((node, next)) = path.last_mut() {
            match scene.node(*node).child(*next) {
                Some(child) => {
                    *next += 1;
                    if seen.insert(child) {
                        path.push((child, 0));
                    }
                }
                None => {
                    order.push(*node);
                    path.pop();
                }
            }
        }
    }
    order
}

/// A scene of one object: a shape of another scene, placed by transforms, outermost first.
pub fn scene_of_shape(scene: &Scene, shape: NodeId, placed: &[LocalTransform], name: &str) -> Scene {
    let mut part = Scene { accel: scene.accel, ..Scene::default() };
    let mut numbers: HashMap<NodeId, NodeId> = HashMap::new();
    for id in postorder(scene, &[shape]) {
        let new = part.add(with_children(scene.node(id), |child| numbers[&child]));
        if let Some(accel) = scene.accels.get(&id) {
            part.accels.insert(new, accel);
        }
        numbers.insert(id, new);
    }
    let place =
        |child, transform: &LocalTransform| part.add(Node::Transform { transform: *transform, child });
    let root = placed.iter().rev().fold(numbers[&shape], place);
    part.add_object(name, None, root);
    part
}

/// The same node with other children.
fn with_children(node: &Node, new: impl Fn(NodeId) -> NodeId) -> Node {
    let mut node = node.clone();
    let renumber = |ids: &mut Vec<NodeId>| ids.iter_mut().for_each(|id| *id = new(*id));
    match &mut node {
        Node::Solid { .. } | Node::Mesh { .. } => {}
        Node::Csg { args, .. } => renumber(args),
        Node::Group { members } => renumber(members),
        Node::Lattice { elements, .. } => renumber(elements),
        Node::Transform { child, .. } => *child = new(*child),
        Node::Object { node, contents, .. } => {
            *node = new(*node);
            renumber(contents);
        }
    }
    node
}

/// The matrix of transforms, outermost first.
pub fn matrix<'t>(transforms: impl IntoIterator<Item = &'t LocalTransform>) -> Affine {
    let inside = |frame, transform: &LocalTransform| transform.inside(&frame);
    let frame = transforms.into_iter().fold(ComposedTransform::IDENTITY, inside);
    frame.placement().map_or(Affine::IDENTITY, |pair| pair.parent_from_local)
}

/// By how much a transform enlarges everything, if that is the same in all directions.
pub fn scale_of_similarity(transform: &Affine) -> Option<f64> {
    let [x, y, z] = axes(transform);
    let scale = x.length();
    let are_equal = [y, z].iter().all(|axis| (axis.length() / scale - 1.0).abs() < ROUNDING);
    let are_square = [(x, y), (y, z), (z, x)].iter().all(|(a, b)| a.dot(*b).abs() < ROUNDING * scale * scale);
    (are_equal && are_square).then_some(scale)
}

/// By how much a transform enlarges lengths at most, or a little more.
pub fn stretch(matrix: &Affine) -> f64 {
    let largest = || axes(matrix).map(Vec3::length_squared).iter().sum::<f64>().sqrt();
    scale_of_similarity(matrix).unwrap_or_else(largest)
}

fn axes(transform: &Affine) -> [Vec3; 3] {
    [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| transform.vector(axis))
}
