//! Planes as row vectors, points as column vectors (J. C. Hart, lecture on ray intersections).
//!
//! A point lies in a plane where `n x = 0` with `n = [a b c d]` and `x = [x y z 1]^T`. When points move by
//! `T`, the incidence `n x = (n T^-1)(T x)` shows that planes move by `n T^-1`.

use super::{Affine, Vec3};

/// The plane `normal . p + offset = 0` as the row vector `[a b c d]`; not necessarily of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// `[a b c]`: pointing to the positive side.
    pub normal: Vec3,
    /// `d`.
    pub offset: f64,
}

impl Plane {
    /// The row vector `[a b c d]`.
    pub const fn new(normal: Vec3, offset: f64) -> Plane {
        Plane { normal, offset }
    }

    /// The plane through a point with a given normal.
    pub fn through(point: Vec3, normal: Vec3) -> Plane {
        Plane { normal, offset: -normal.dot(point) }
    }

    /// The product `n x` of the row vector with the point: zero in the plane, positive in front of it.
    /// It is a distance only where the normal has unit length.
    pub fn evaluate(&self, point: Vec3) -> f64 {
        self.normal.dot(point) + self.offset
    }

    /// The same plane after its points have moved by `T`, given `T^-1`: the row vector `n T^-1`.
    pub fn transformed(&self, inverse: &Affine) -> Plane {
        let m = &inverse.rows;
        let n = self.normal;
        let column = |j: usize| n.x * m[0][j] + n.y * m[1][j] + n.z * m[2][j];
        Plane { normal: Vec3::new(column(0), column(1), column(2)), offset: column(3) + self.offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::affine::tests::affine_strategy;
    use proptest::prelude::*;

    proptest! {
        /// Duality: a point lies in a plane exactly when the moved point lies in the moved plane.
        #[test]
        fn incidence_survives_a_transform(
            t in affine_strategy(),
            n in prop::array::uniform3(-2.0..2.0f64),
            p in prop::array::uniform3(-5.0..5.0f64),
        ) {
            let (n, p) = (Vec3::from(n), Vec3::from(p));
            let inverse = t.inverse().unwrap();
            let plane = Plane::through(p + Vec3::new(0.1, 0.2, 0.3), n);
            let before = plane.evaluate(p);
            let after = plane.transformed(&inverse).evaluate(t.point(p));
            let size = n.length() * (p.length() + 10.0) * t.condition();
            prop_assert!((before - after).abs() <= 1e-13 * size, "{before} {after}");
        }
    }
}
