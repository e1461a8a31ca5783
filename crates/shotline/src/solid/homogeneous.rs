//! Quadrics as symmetric 4x4 matrices over homogeneous points (J. C. Hart, lecture on ray intersections;
//! Blinn 1984).

use crate::math::{Affine, Plane, Vec3};

/// A quadric `x^T Q x = 0` over points `x = [x y z 1]^T`, with a symmetric `Q`; negative in the interior.
///
/// Where points move by `T`, the quadric moves by `T^-T Q T^-1`, as `x^T Q x = (T x)^T (T^-T Q T^-1) (T x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homogeneous {
    /// `Q`, row by row.
    pub rows: [[f64; 4]; 4],
}

impl Homogeneous {
    /// The value `x^T Q x` at a point: of no particular unit, negative inside.
    pub fn evaluate(&self, p: Vec3) -> f64 {
        let v = self.polar(p);
        v[0] * p.x + v[1] * p.y + v[2] * p.z + v[3]
    }

    /// The row vector `2 x^T Q`. Its first three numbers are the gradient at `x`; at a point of the surface it
    /// is the tangent plane, pointing outward.
    pub fn tangent_plane(&self, p: Vec3) -> Plane {
        let v = self.polar(p).map(|x| 2.0 * x);
        Plane::new(Vec3::new(v[0], v[1], v[2]), v[3])
    }

    /// The quadric after its points have moved by `T`, given `T^-1`: `T^-T Q T^-1`.
    pub fn transformed(&self, inverse: &Affine) -> Homogeneous {
        let m = &inverse.rows;
        let t = [m[0], m[1], m[2], [0.0, 0.0, 0.0, 1.0]];
        let product = |i: usize, j: usize| {
            (0..4).map(|k| t[k][i] * (0..4).map(|l| self.rows[k][l] * t[l][j]).sum::<f64>()).sum()
        };
        // Filled from one triangle, so that the result is symmetric in every bit.
        Homogeneous { rows: std::array::from_fn(|i| std::array::from_fn(|j| product(i.min(j), i.max(j)))) }
    }

    /// The product `x^T Q`.
    fn polar(&self, p: Vec3) -> [f64; 4] {
        let q = &self.rows;
        std::array::from_fn(|j| p.x * q[0][j] + p.y * q[1][j] + p.z * q[2][j] + q[3][j])
    }
}
