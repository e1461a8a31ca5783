//! The transforms of shapes and objects.

use super::node::ShapeNode;
use super::{Object, Shape};
use crate::math::{Affine, Vec3};
use crate::scene::{LocalTransform, Rotation};

/// The transforms of a type that can be placed.
macro_rules! transforms {
    ($type:ident) => {
        /// Transforms: each applies to the result so far, so they act in the order in which they are written. Compiling
        /// refuses transforms that flatten space or are not finite.
        impl $type {
            /// Moves by an offset.
            pub fn translate(&self, offset: impl Into<Vec3>) -> $type {
                self.placed(LocalTransform::translation(offset.into()))
            }

            /// Rotates by degrees about x, then y, then z. Quarter turns are exact.
            pub fn rotate(&self, degrees: impl Into<Vec3>) -> $type {
                self.placed(LocalTransform::rotation(Rotation::Xyz(degrees.into())))
            }

            /// Rotates by degrees about an axis through the origin, counter-clockwise seen from its tip. The length of
            /// the axis does not matter.
            pub fn rotate_about(&self, axis: impl Into<Vec3>, degrees: f64) -> $type {
                self.placed(LocalTransform::rotation(Rotation::About { axis: axis.into(), degrees }))
            }

            /// Scales about the origin by one factor. A negative factor reflects.
            pub fn scale(&self, factor: f64) -> $type {
                self.scale_axes(Vec3::splat(factor))
            }

            /// Scales about the origin by a factor along each axis. A negative factor reflects.
            pub fn scale_axes(&self, factors: impl Into<Vec3>) -> $type {
                self.placed(LocalTransform::scaling(factors.into()))
            }

            /// Applies an affine map, from the local coordinates to those of the parent.
            pub fn transform(&self, parent_from_local: Affine) -> $type {
                self.placed(LocalTransform::Matrix(parent_from_local))
            }
        }
    };
}

transforms!(Shape);
transforms!(Object);

impl Shape {
    fn placed(&self, transform: LocalTransform) -> Shape {
        Shape(ShapeNode::placed(&self.0, transform))
    }
}
