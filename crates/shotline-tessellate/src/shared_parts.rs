//! Objects that are one part in several places: it becomes a mesh once.

use std::collections::HashMap;

use shotline::math::{Affine, ComposedTransform, Vec3};
use shotline::scene::{LocalTransform, Node, NodeId, Scene};

/// How much the lengths of axes may differ, and the cosines between them may be, relative to 1, in a similarity.
const ROUNDING: f64 = 1e-12;

/// A part in a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedPart {
    pub part: NodeId,
    /// The transforms that place it, outermost first.
    pub transforms: Vec<LocalTransform>,
    /// By how much they enlarge it.
    pub scale: f64,
}

/// For each object of a scene, how it is placed, if others are of the same part and size.
pub fn shared_parts(scene: &Scene) -> Vec<Option<PlacedPart>> {
    let placed: Vec<Option<PlacedPart>> =
        scene.objects.iter().map(|root| placed_part(scene, *root)).collect();
    let key = |placed: &PlacedPart| (placed.part, placed.scale.to_bits());
    let mut uses: HashMap<(NodeId, u64), usize> = HashMap::new();
    placed.iter().flatten().for_each(|placed| *uses.entry(key(placed)).or_default() += 1);
    placed.into_iter().map(|placed| placed.filter(|placed| uses[&key(placed)] > 1)).collect()
}

/// How an object places its part, if that is by turning, moving, mirroring and enlarging it. An object that contains others has
/// none.
fn placed_part(scene: &Scene, root: NodeId) -> Option<PlacedPart> {
    let (mut part, mut transforms, mut is_in_object) = (root, Vec::new(), false);
    // Not longer than the scene: the nodes may have a cycle.
    for _ in &scene.nodes {
        match scene.node(part) {
            Node::Object { node, contents, .. } if contents.is_empty() && !is_in_object => {
                (part, is_in_object) = (*node, true);
            }
            Node::Transform { transform, child } => {
                transforms.push(*transform);
                part = *child;
            }
            _ => break,
        }
    }
    let frame = transforms.iter().fold(ComposedTransform::IDENTITY, |frame, step| step.inside(&frame));
    let scale = scale_of_similarity(&frame.placement().ok()?.parent_from_local)?;
    (is_in_object && !holds_object(scene, part)).then_some(PlacedPart { part, transforms, scale })
}

/// By how much a transform enlarges everything, if that is the same in all directions.
fn scale_of_similarity(transform: &Affine) -> Option<f64> {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| transform.vector(axis));
    let scale = x.length();
    let are_equal = [y, z].iter().all(|axis| (axis.length() / scale - 1.0).abs() < ROUNDING);
    let are_square = [(x, y), (y, z), (z, x)].iter().all(|(a, b)| a.dot(*b).abs() < ROUNDING * scale * scale);
    // Rounded, so that turned copies have one size.
    let rounded = (scale * 1e9).round() / 1e9;
    (are_equal && are_square).then_some(if rounded > 0.0 && scale < 1e6 { rounded } else { scale })
}

/// Whether there are objects in a part.
fn holds_object(scene: &Scene, part: NodeId) -> bool {
    let mut todo = vec![part];
    let mut seen = vec![false; scene.nodes.len()];
    while let Some(id) = todo.pop() {
        if !std::mem::replace(&mut seen[id.0 as usize], true) {
            if matches!(scene.node(id), Node::Object { .. }) {
                return true;
            }
            todo.extend(scene.node(id).children());
        }
    }
    false
}
