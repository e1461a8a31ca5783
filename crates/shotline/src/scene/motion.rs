//! How objects move in an animation.

use super::{LocalTransform, Node, NodeId, Rotation, Scene};
use crate::math::{Affine, Vec3};

/// How an object moves in an animation: at constant speed, from its position in the scene. It is first rotated, then
/// translated, in the frame that the object is placed in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// The name of the object; all objects of that name move.
    pub object: String,
    /// The rotation at the end of the motion.
    pub rotate: Option<Rotation>,
    /// The point about which the object rotates; the origin if absent.
    pub about: Option<Vec3>,
    /// The translation at the end of the motion.
    pub translate: Option<Vec3>,
}

impl Motion {
    /// The transform after a fraction of the motion: 0 at the beginning, 1 at the end.
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
    /// Inserts transforms into each object that moves: above its shape, and above each part of its contents. Returns the new
    /// nodes, each with the index of its motion.
    pub fn set_in_motion(&mut self) -> Vec<(NodeId, usize)> {
        let mut moving = Vec::new();
        for i in 0..self.nodes.len() {
            let Node::Object { name, .. } = &self.nodes[i] else { continue };
            let Some(motion) = self.motions.iter().position(|m| m.object == *name) else { continue };
            let transform = self.motions[motion].at(0.0);
            let parts: Vec<NodeId> = self.nodes[i].children().collect();
            let add = |child| self.add(Node::Transform { transform, child });
            let new: Vec<NodeId> = parts.into_iter().map(add).collect();
            moving.extend(new.iter().map(|&node| (node, motion)));
            if let Node::Object { node, contents, .. } = &mut self.nodes[i] {
                *node = new[0];
                contents.copy_from_slice(&new[1..]);
            }
        }
        moving
    }
}
