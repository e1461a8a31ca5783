//! The crate's representation of quadrics: a symmetric form in coordinates of the solid's own size.

use super::quadric_matrix::QuadricMatrix;
use crate::math::{Dd, Vec3};

/// The function `x M x + 2 l x + k` of `x = (p - centre) * shrink`. It is negative in the interior.
///
/// The coordinates `x` are of order 1 on the solid, whatever its size and proportions. So nothing overflows, and
/// the closest approach to the centre is a good point of expansion. They are exact because `shrink` holds powers
/// of two. A component 0 of `shrink` removes an axis from the form (the axis of a cylinder). The coefficients are
/// in double-double, because a rounded parameter would describe a different solid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Form {
    pub centre: Vec3,
    pub shrink: Vec3,
    /// The diagonal of `M`.
    pub square: [Dd; 3],
    /// The off-diagonal entries of `M`: `yz`, `xz`, `xy`. `None` for axis-aligned forms, which most are.
    pub cross: Option<[Dd; 3]>,
    pub linear: [Dd; 3],
    pub constant: Dd,
}

impl Form {
    /// The form that is zero everywhere, in the coordinates of the solid's frame.
    pub const ZERO: Form = Form {
        centre: Vec3::ZERO,
        shrink: Vec3::ONE,
        square: [Dd::ZERO; 3],
        cross: None,
        linear: [Dd::ZERO; 3],
        constant: Dd::ZERO,
    };

    /// Whether the form has only squares and a constant.
    pub fn is_about_its_centre(&self) -> bool {
        self.cross.is_none() && self.linear.iter().all(|x| x.hi == 0.0)
    }

    /// Whether it is of the second degree.
    pub fn is_curved(&self) -> bool {
        self.cross.is_some() || self.square.iter().any(|x| x.hi != 0.0)
    }

    /// Whether each axis counts.
    pub fn counts(&self) -> [bool; 3] {
        self.shrink.to_array().map(|shrink| shrink != 0.0)
    }

    /// The value at a point of the solid's frame.
    pub fn value(&self, p: Vec3) -> f64 {
        let x = (p - self.centre) * self.shrink;
        x.dot(self.apply(x) + 2.0 * rounded(&self.linear)) + self.constant.hi
    }

    /// The gradient at a point of the solid's frame.
    pub fn gradient(&self, p: Vec3) -> Vec3 {
        let x = (p - self.centre) * self.shrink;
        2.0 * (self.apply(x) + rounded(&self.linear)) * self.shrink
    }

    /// The product `M v`.
    pub fn apply(&self, v: Vec3) -> Vec3 {
        multiply(rounded(&self.square), self.cross.map(|c| rounded(&c)), v)
    }

    /// The product of the absolute values of `M` and `v`: the scale of the rounding error of `M v`.
    pub fn apply_abs(&self, v: Vec3) -> Vec3 {
        multiply(rounded(&self.square).abs(), self.cross.map(|c| rounded(&c).abs()), v.abs())
    }

    /// The product `M v` in double-double.
    pub fn apply_wide(&self, v: [Dd; 3]) -> [Dd; 3] {
        let ([xx, yy, zz], [yz, xz, xy], [x, y, z]) = (self.square, self.cross.unwrap_or_default(), v);
        [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
    }

    /// The same function over homogeneous points of the solid's frame.
    pub fn quadric_matrix(&self) -> QuadricMatrix {
        let ([xx, yy, zz], [yz, xz, xy]) = (self.square, self.cross.unwrap_or_default());
        let (k, c) = (self.shrink, self.centre);
        let m = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let m = |i: usize, j: usize| m[i][j] * k[i] * k[j];
        // x = p - c turns the linear part into l - M c and adds c M c - 2 l c to the constant.
        let l: [Dd; 3] =
            std::array::from_fn(|i| (0..3).fold(self.linear[i] * k[i], |sum, j| sum - m(i, j) * c[j]));
        let constant = (0..3).fold(self.constant, |sum, i| sum - (l[i] + self.linear[i] * k[i]) * c[i]);
        let row = |i: usize| [m(i, 0).hi, m(i, 1).hi, m(i, 2).hi, l[i].hi];
        QuadricMatrix { rows: [row(0), row(1), row(2), [l[0].hi, l[1].hi, l[2].hi, constant.hi]] }
    }
}

/// The coefficients rounded to f64.
pub(super) fn rounded(v: &[Dd; 3]) -> Vec3 {
    Vec3::new(v[0].hi, v[1].hi, v[2].hi)
}

/// The product of a symmetric matrix, given by its diagonal and its entries `yz`, `xz`, `xy`, with a vector.
fn multiply(square: Vec3, cross: Option<Vec3>, v: Vec3) -> Vec3 {
    let Some(cross) = cross else { return square * v };
    Vec3::new(
        square.x * v.x + cross.z * v.y + cross.y * v.z,
        cross.z * v.x + square.y * v.y + cross.x * v.z,
        cross.y * v.x + cross.x * v.y + square.z * v.z,
    )
}

/// The square of a number, rounded to double-double.
pub(super) fn squared(x: Dd) -> Dd {
    x * x
}
