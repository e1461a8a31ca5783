//! Solids of every kind, from the examples that the kinds declare.

use crate::aabb::Aabb;
use crate::scene::{LocalTransform, Node, NodeId, Scene};
use crate::solid::{KINDS, Params};

/// Tries to vary an example before it is taken as it is.
const TRIES: usize = 4;

/// Adds a solid of one of all kinds: an example of which every number is multiplied by a factor of its own, as long as
/// that makes a solid. Returns its bounds too.
pub(super) fn add_varied(
    scene: &mut Scene,
    mut pick: impl FnMut(usize) -> usize,
    mut factor: impl FnMut() -> f64,
) -> (NodeId, Aabb) {
    let kind = KINDS[pick(KINDS.len())];
    let example = kind.examples[pick(kind.examples.len())];
    for tries in 0..=TRIES {
        let mut vary = |x: &f64| if tries < TRIES { x * factor() } else { *x };
        let numbers: Vec<Vec<f64>> =
            example.iter().map(|value| value.iter().map(&mut vary).collect()).collect();
        let values: Vec<&[f64]> = numbers.iter().map(Vec::as_slice).collect();
        let params = Params::of(kind, &values);
        if let Ok(solid) = (kind.build)(&params) {
            return (scene.add(Node::Solid { kind, params }), solid.bounds());
        }
    }
    panic!("{} refuses its own example {example:?}", kind.name)
}

/// Places a bounded solid about the origin so that its box has a half-size; any other stays where it is.
pub(super) fn place(scene: &mut Scene, (node, bounds): (NodeId, Aabb), size: f64) -> NodeId {
    let half = 0.5 * bounds.size().max_element();
    if !(half > 0.0 && half.is_finite()) {
        return node;
    }
    let factor = size / half;
    let transform = LocalTransform::Steps {
        scale: Some(crate::math::Vec3::splat(factor)),
        rotate: None,
        translate: Some(-factor * bounds.centre()),
    };
    scene.add(Node::Transform { transform, child: node })
}
