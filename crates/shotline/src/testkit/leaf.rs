//! Solids of every kind, derived from the examples of the kinds.

use crate::aabb::Aabb;
use crate::scene::{LocalTransform, Node, NodeId, Scene};
use crate::solid::{KINDS, Params};

/// The number of attempts to vary an example before it is used unchanged.
const TRIES: usize = 4;

/// Adds a solid of a picked kind: one of its examples with every number multiplied by its own factor, if that is
/// a valid solid. Also returns its bounds.
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
        if let Ok(solid) = kind.build(&params) {
            return (scene.add(Node::Solid { kind, params }), solid.bounds());
        }
    }
    panic!("{} refuses its own example {example:?}", kind.name)
}

/// Places a bounded solid around the origin, scaled so that its box has the given half-size. Leaves an unbounded
/// solid unchanged.
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
