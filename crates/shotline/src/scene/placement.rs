//! Transforms of nodes, stored as they were written.

use crate::math::{Affine, ComposedTransform, Vec3};

/// A rotation as written, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// About x, then y, then z.
    Xyz(Vec3),
    /// About an axis of any non-zero length.
    About {
        /// The axis.
        axis: Vec3,
        /// The angle in degrees, counter-clockwise seen from the tip of the axis.
        degrees: f64,
    },
}

/// A transform as written: parent from local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// A 3x4 matrix.
    Matrix(Affine),
    /// First the scale, then the rotation, then the translation.
    Steps {
        /// Factors along the local axes.
        scale: Option<Vec3>,
        /// The rotation.
        rotate: Option<Rotation>,
        /// The translation.
        translate: Option<Vec3>,
    },
}

impl LocalTransform {
    /// A scale alone.
    pub fn scaling(factors: Vec3) -> LocalTransform {
        LocalTransform::Steps { scale: Some(factors), rotate: None, translate: None }
    }

    /// A rotation alone.
    pub fn rotation(rotation: Rotation) -> LocalTransform {
        LocalTransform::Steps { scale: None, rotate: Some(rotation), translate: None }
    }

    /// A translation alone.
    pub fn translation(offset: Vec3) -> LocalTransform {
        LocalTransform::Steps { scale: None, rotate: None, translate: Some(offset) }
    }

    /// The product of a chain of outer transforms with this transform inside it.
    pub fn inside(&self, composed: &ComposedTransform) -> ComposedTransform {
        self.matrices().fold(*composed, |composed, m| composed.then(&m))
    }

    /// Whether all numbers of its matrices are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.matrices().all(|m| m.rows.iter().flatten().all(|x| x.is_finite()))
    }

    /// Whether [`Affine::is_clearly_invertible`] holds, by the one matrix that it is. Of several it is not known.
    pub(crate) fn is_clearly_invertible(&self) -> bool {
        let mut matrices = self.matrices();
        matches!((matrices.next(), matrices.next()), (Some(matrix), None) if matrix.is_clearly_invertible())
    }

    /// The matrices, outermost first; at most three.
    pub(crate) fn matrices(&self) -> impl Iterator<Item = Affine> {
        let matrices = match *self {
            LocalTransform::Matrix(m) => [Some(m), None, None],
            LocalTransform::Steps { scale, rotate, translate } => [
                translate.map(Affine::translation),
                rotate.map(|r| match r {
                    Rotation::Xyz(degrees) => Affine::rotation_xyz(degrees),
                    Rotation::About { axis, degrees } => Affine::rotation_about(axis, degrees),
                }),
                scale.map(Affine::scaling),
            ],
        };
        matrices.into_iter().flatten()
    }
}
