//! How objects move in an animation.

use super::{LocalTransform, Node, NodeId, Rotation, Scene};
use crate::math::{Affine, Vec3};

/// How an object moves in an animation: evenly, from where the scene puts it. First it turns, then it is shifted,
/// in the frame that the object stands in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The name of the object; all of that name move.
    pub object: String,
    /// How far it has turned in the end.
    pub rotate: Option<Rotation>,
    /// The point about which it turns; the origin if absent.
    pub about: Option<Vec3>,
    /// How far it has gone in the end.
    pub translate: Option<Vec3>,
}

impl Motion {
    /// Where a share of the motion has brought it: 0 at the beginning, 1 at the end.
    pub fn at(&self, share: f64) -> LocalTransform {
        let about = self.about.unwrap_or(Vec3::ZERO);
        let gone = self.translate.unwrap_or(Vec3::ZERO) * share;
        let turn = match self.rotate {
            None => Affine::IDENTITY,
            Some(Rotation::Xyz(degrees)) => Affine::rotation_xyz(degrees * share),
            Some(Rotation::About { axis, degrees }) => Affine::rotation_about(axis, degrees * share),
        };
        let turned = turn.then_after(&Affine::translation(-about));
        LocalTransform::Matrix(Affine::translation(about + gone).then_after(&turned))
    }
}

impl Scene {
    /// Puts a transform into each object that moves: answers these nodes, each with the number of its motion.
    pub fn set_in_motion(&mut self) -> Vec<(NodeId, usize)> {
        let mut moving = Vec::new();
        for i in 0..self.nodes.len() {
            let Node::Object { name, node, .. } = &self.nodes[i] else { continue };
            let (moved, child) = (self.motions.iter().position(|m| m.object == *name), *node);
            let Some(motion) = moved else { continue };
            let new = self.add(Node::Transform { transform: self.motions[motion].at(0.0), child });
            if let Node::Object { node, .. } = &mut self.nodes[i] {
                *node = new;
            }
            moving.push((new, motion));
        }
        moving
    }
}
