//! Affine maps of space, their closed-form inverse through the adjugate, and their effect on normals.
//!
//! The inverse of `T = [S | x]` is `[S^-1 | -S^-1 x]` with `S^-1 = adj(S) / |S|`, the transposed matrix of cofactors
//! over the determinant (J. C. Hart, lecture on ray intersections). Products and inverses are needed only when a
//! scene is compiled, so they are computed in double-double and rounded once: the error of an entry of a stored
//! inverse is at most half an ulp.

use super::length::unit;
use super::power_of_two::power_of_two_near;
use super::singular_transform::{MAX_CONDITION, SingularTransform};
use super::{Dd, Vec3};

/// An affine map as a 3x4 matrix, row by row: `p -> S p + x`.
///
/// Named target-from-source: `world_from_local.point(p_local)` is a point of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The rows `[s_i0 s_i1 s_i2 x_i]`.
    pub rows: [[f64; 4]; 3],
}

impl Affine {
    /// The identity.
    pub const IDENTITY: Affine =
        Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// From 12 numbers, row by row.
    pub fn from_row_major(m: [f64; 12]) -> Affine {
        Affine { rows: [[m[0], m[1], m[2], m[3]], [m[4], m[5], m[6], m[7]], [m[8], m[9], m[10], m[11]]] }
    }

    /// A translation by `v`.
    pub fn translation(v: Vec3) -> Affine {
        let mut m = Affine::IDENTITY;
        (m.rows[0][3], m.rows[1][3], m.rows[2][3]) = (v.x, v.y, v.z);
        m
    }

    /// A scaling along the axes.
    pub fn scaling(v: Vec3) -> Affine {
        let mut m = Affine::IDENTITY;
        (m.rows[0][0], m.rows[1][1], m.rows[2][2]) = (v.x, v.y, v.z);
        m
    }

    /// Rotations by degrees about x, then y, then z: `Rz Ry Rx`. Quarter turns are exact.
    pub fn rotation_xyz(degrees: Vec3) -> Affine {
        let turn = |axis: usize, angle: f64| {
            let (s, c) = sin_cos_degrees(angle);
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut m = Affine::IDENTITY;
            (m.rows[i][i], m.rows[i][j], m.rows[j][i], m.rows[j][j]) = (c, -s, s, c);
            m
        };
        turn(2, degrees.z).then_after(&turn(1, degrees.y).then_after(&turn(0, degrees.x)))
    }

    /// The rotation by degrees about an axis of any length (Rodrigues); counter-clockwise with the axis pointing
    /// towards the viewer.
    pub fn rotation_about(axis: Vec3, degrees: f64) -> Affine {
        let (s, c) = sin_cos_degrees(degrees);
        let a = unit(axis);
        let v = 1.0 - c;
        Affine {
            rows: [
                [c + a.x * a.x * v, a.x * a.y * v - a.z * s, a.x * a.z * v + a.y * s, 0.0],
                [a.y * a.x * v + a.z * s, c + a.y * a.y * v, a.y * a.z * v - a.x * s, 0.0],
                [a.z * a.x * v - a.y * s, a.z * a.y * v + a.x * s, c + a.z * a.z * v, 0.0],
            ],
        }
    }

    /// The product `self * inner`: first `inner`, then `self`; each entry rounded once.
    pub fn then_after(&self, inner: &Affine) -> Affine {
        round(&compose(&widen(self), &widen(inner)))
    }

    /// Whether this is exactly the identity.
    pub fn is_identity(&self) -> bool {
        // All entries at once, without branches: this is called for each ray and each placement that the ray enters.
        let entries = self.rows.iter().flatten().zip(Affine::IDENTITY.rows.iter().flatten());
        entries.fold(true, |same, (a, b)| same & (a == b))
    }

    /// The image of a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        let r = |i: usize| {
            let m = &self.rows[i];
            m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]
        };
        Vec3::new(r(0), r(1), r(2))
    }

    /// The image of a direction.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        let r = |i: usize| {
            let m = &self.rows[i];
            m[0] * v.x + m[1] * v.y + m[2] * v.z
        };
        Vec3::new(r(0), r(1), r(2))
    }

    /// The row vector `n S`: with `self = T^-1` this is the normal `(T^-1)^T n` of the moved surface.
    pub fn covector(&self, n: Vec3) -> Vec3 {
        let m = &self.rows;
        let c = |j: usize| n.x * m[0][j] + n.y * m[1][j] + n.z * m[2][j];
        Vec3::new(c(0), c(1), c(2))
    }

    /// The determinant of the linear part.
    pub fn determinant(&self) -> f64 {
        determinant(&widen(self)).hi
    }

    /// The adjugate of the linear part (transposed cofactors): `|S| S^-1`, without a division.
    pub fn adjugate(&self) -> [[f64; 3]; 3] {
        adjugate(&widen(self)).map(|row| row.map(|x| x.hi))
    }

    /// The condition number of the linear part in the infinity norm, `|S| |S^-1|`; infinite if singular.
    pub fn condition(&self) -> f64 {
        let norm =
            |m: &[[f64; 3]; 3]| m.iter().map(|r| r.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
        let linear = self.rows.map(|r| [r[0], r[1], r[2]]);
        let size = linear.iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
        if size == 0.0 {
            return f64::INFINITY;
        }
        // Scaled to size 1 first, so that the cubes in the determinant neither overflow nor underflow.
        let unit = power_of_two_near(size);
        let scaled = Affine { rows: self.rows.map(|r| r.map(|x| x / unit)) };
        let scaled = widen(&scaled);
        let adjugate = adjugate(&scaled);
        let det = determinant_by(&scaled, &adjugate).hi;
        let adjugate = adjugate.map(|row| row.map(|x| x.hi));
        if det == 0.0 { f64::INFINITY } else { norm(&linear) / unit * (norm(&adjugate) / det.abs()) }
    }

    /// Whether the condition number is certainly far below [`MAX_CONDITION`], and every number far from overflow. Much
    /// faster than [`Affine::condition`], and true of nearly every transform.
    pub(crate) fn is_clearly_invertible(&self) -> bool {
        let m = self.rows.map(|r| [r[0], r[1], r[2]]);
        let largest =
            |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, |most: f64, x| most.max(x.abs()));
        let size = largest(&mut m.iter().flatten().copied());
        let reach = largest(&mut self.rows.iter().map(|r| r[3]));
        let minor = |r: usize, c: usize| m[1][r] * m[2][c] - m[1][c] * m[2][r];
        let determinant = m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1);
        // Cofactors are at most 2 where the entries are at most 1. There the error of the determinant is below 1e-14, so
        // the condition number is at most 3 * 6 / 0.99e-6.
        let is_moderate = (1e-90..1e90).contains(&size) && reach < 1e90;
        is_moderate
            && determinant.abs() > 1e-6 * size * size * size
            && self.rows.iter().flatten().all(|x| x.is_finite())
    }

    /// The inverse in closed form by the adjugate. Each entry is correctly rounded unless the condition number is
    /// extreme.
    ///
    /// # Errors
    /// [`SingularTransform`] if the condition number is above [`MAX_CONDITION`] or an entry is not finite.
    pub fn inverse(&self) -> Result<Affine, SingularTransform> {
        TransformPair::new(self).map(|p| p.local_from_parent)
    }
}

/// The matrix of a transformation node with its inverse. Rays are transformed by `local_from_parent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransformPair {
    /// `T`.
    pub parent_from_local: Affine,
    /// `T^-1`.
    pub local_from_parent: Affine,
    /// The condition number of `T`: the factor by which a relative error of a ray may grow.
    pub condition: f64,
}

impl TransformPair {
    /// The identity.
    pub const IDENTITY: TransformPair = TransformPair {
        parent_from_local: Affine::IDENTITY,
        local_from_parent: Affine::IDENTITY,
        condition: 1.0,
    };

    /// Inverts a transform.
    ///
    /// # Errors
    /// [`SingularTransform`] if the condition number is above [`MAX_CONDITION`] or an entry is not finite.
    pub fn new(parent_from_local: &Affine) -> Result<TransformPair, SingularTransform> {
        ComposedTransform::IDENTITY.then(parent_from_local).placement()
    }
}

/// A product of transforms in double-double. Only [`ComposedTransform::placement`] rounds it, so that equal chains
/// give equal bits and long chains do not accumulate rounding errors.
#[derive(Clone, Copy, Debug)]
pub struct ComposedTransform(pub(super) Wide);

impl ComposedTransform {
    /// The empty product.
    pub const IDENTITY: ComposedTransform = ComposedTransform([
        [Dd::ONE, Dd::ZERO, Dd::ZERO, Dd::ZERO],
        [Dd::ZERO, Dd::ONE, Dd::ZERO, Dd::ZERO],
        [Dd::ZERO, Dd::ZERO, Dd::ONE, Dd::ZERO],
    ]);

    /// The product with a further transform, which is applied before those so far.
    #[inline]
    pub fn then(&self, inner: &Affine) -> ComposedTransform {
        if inner.is_identity() { *self } else { ComposedTransform(compose(&self.0, &widen(inner))) }
    }

    /// Rounds the product and its inverse.
    ///
    /// # Errors
    /// [`SingularTransform`] if the condition number of the product is above [`MAX_CONDITION`] or an entry
    /// is not finite.
    pub fn placement(&self) -> Result<TransformPair, SingularTransform> {
        let parent_from_local = round(&self.0);
        if !parent_from_local.rows.iter().flatten().all(|x| x.is_finite()) {
            return Err(SingularTransform { condition: f64::NAN });
        }
        let condition = parent_from_local.condition();
        if condition.is_nan() || condition > MAX_CONDITION {
            return Err(SingularTransform { condition });
        }
        let local_from_parent = round(&inverse(&self.0));
        if !local_from_parent.rows.iter().flatten().all(|x| x.is_finite()) {
            return Err(SingularTransform { condition });
        }
        Ok(TransformPair { parent_from_local, local_from_parent, condition })
    }
}

pub(super) type Wide = [[Dd; 4]; 3];

pub(super) fn widen(m: &Affine) -> Wide {
    m.rows.map(|r| r.map(Dd::from))
}

pub(super) fn round(m: &Wide) -> Affine {
    Affine { rows: m.map(|r| r.map(|x| x.hi)) }
}

fn compose(outer: &Wide, inner: &Wide) -> Wide {
    let mut out = [[Dd::ZERO; 4]; 3];
    for (row, o) in out.iter_mut().zip(outer) {
        *row = std::array::from_fn(|j| dot([o[0], o[1], o[2]], [inner[0][j], inner[1][j], inner[2][j]]));
        row[3] = plus(row[3], o[3]);
    }
    out
}

/// The product. Most matrices have many zeros, and a product with zero needs no more than this test. One of zero and a
/// number that is not finite is not zero.
#[inline(always)]
fn times(a: Dd, b: Dd) -> Dd {
    if a.hi * b.hi == 0.0 && (a.hi == 0.0 || b.hi == 0.0) { Dd::ZERO } else { a * b }
}

/// The sum; that with zero needs no more than a test.
#[inline(always)]
pub(super) fn plus(a: Dd, b: Dd) -> Dd {
    if b.hi == 0.0 {
        a
    } else if a.hi == 0.0 {
        b
    } else {
        a + b
    }
}

#[inline(always)]
pub(super) fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))
}

/// Transposed cofactors: `adj[i][j]` is the minor of row `j`, column `i`; cyclic indices carry the sign.
fn adjugate(m: &Wide) -> [[Dd; 3]; 3] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let (r1, r2, c1, c2) = ((j + 1) % 3, (j + 2) % 3, (i + 1) % 3, (i + 2) % 3);
            plus(times(m[r1][c1], m[r2][c2]), -times(m[r1][c2], m[r2][c1]))
        })
    })
}

fn determinant(m: &Wide) -> Dd {
    determinant_by(m, &adjugate(m))
}

/// The determinant, given the adjugate.
fn determinant_by(m: &Wide, adjugate: &[[Dd; 3]; 3]) -> Dd {
    dot([m[0][0], m[0][1], m[0][2]], adjugate.map(|row| row[0]))
}

/// The inverse of a matrix whose condition has been checked.
fn inverse(m: &Wide) -> Wide {
    inverse_linear(m).map(|row| {
        let moved = dot(row, [m[0][3], m[1][3], m[2][3]]);
        [row[0], row[1], row[2], -moved]
    })
}

/// The linear part of the inverse.
pub(super) fn inverse_linear(m: &Wide) -> [[Dd; 3]; 3] {
    // A power of two scales the linear part to size 1 and is removed at the end, without rounding.
    let size = m.iter().flat_map(|r| &r[..3]).fold(0.0, |a: f64, x| a.max(x.hi.abs()));
    let unit = 1.0 / power_of_two_near(size);
    let scaled: Wide = m.map(|r| [r[0] * unit, r[1] * unit, r[2] * unit, r[3]]);
    let a = adjugate(&scaled);
    let over_det = determinant_by(&scaled, &a).recip();
    a.map(|row| row.map(|x| times(x, over_det) * unit))
}

/// Sine and cosine of an angle in degrees; exact at multiples of 90. Uses `libm`, so that every machine gets the same
/// bits.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = libm::fmod(degrees, 360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => (libm::sin(turn.to_radians()), libm::cos(turn.to_radians())),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Well-conditioned maps with rotation, scaling, shear, reflection and translation.
    pub(crate) fn affine_strategy() -> impl Strategy<Value = Affine> {
        let stretch = prop_oneof![0.2..4.0f64, -4.0..-0.2f64];
        (
            prop::array::uniform3(-180.0..180.0f64),
            prop::array::uniform3(stretch),
            -1.0..1.0f64,
            prop::array::uniform3(-10.0..10.0f64),
        )
            .prop_map(|(turn, stretch, shear, shift)| {
                let mut s = Affine::scaling(Vec3::from(stretch));
                s.rows[0][1] = shear;
                let m = Affine::rotation_xyz(Vec3::from(turn)).then_after(&s);
                Affine::translation(Vec3::from(shift)).then_after(&m)
            })
    }

    proptest! {
        #[test]
        fn inverse_undoes(t in affine_strategy(), p in prop::array::uniform3(-5.0..5.0f64)) {
            let p = Vec3::from(p);
            let back = t.inverse().unwrap().point(t.point(p));
            prop_assert!((back - p).length() <= 1e-13 * t.condition() * 20.0);
        }

        /// A moved normal stays perpendicular to moved tangents, and the adjugate gives the same direction.
        #[test]
        fn normals_stay_normal(
            t in affine_strategy(),
            n in prop::array::uniform3(-1.0..1.0f64),
            v in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let (n, v) = (Vec3::from(n), Vec3::from(v));
            prop_assume!(n.length() > 0.1);
            let tangent = v - n * (n.dot(v) / n.length_squared());
            let moved = t.inverse().unwrap().covector(n);
            prop_assert!(moved.dot(t.vector(tangent)).abs() <= 1e-13 * t.condition());
            let by_adjugate = crate::lecture::normals::normal_by_adjugate(&t, n);
            prop_assert!(moved.normalize().dot(by_adjugate.normalize()) > 1.0 - 1e-12);
        }
    }

    /// The product and the adjugate as they are written down, without a look at zeros.
    fn dense_product(outer: &Wide, inner: &Wide) -> Wide {
        let mut out = [[Dd::ZERO; 4]; 3];
        for (row, o) in out.iter_mut().zip(outer) {
            *row = std::array::from_fn(|j| o[0] * inner[0][j] + o[1] * inner[1][j] + o[2] * inner[2][j]);
            row[3] = row[3] + o[3];
        }
        out
    }

    fn dense_adjugate(m: &Wide) -> [[Dd; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let (r1, r2, c1, c2) = ((j + 1) % 3, (j + 2) % 3, (i + 1) % 3, (i + 2) % 3);
                m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
            })
        })
    }

    /// Products of random matrices, most of them with many zeros of either sign.
    #[test]
    fn zeros_that_are_passed_over_change_no_bit() {
        let mut random = crate::testkit::random::Random::new(31);
        let bits = |x: &Dd| [x.hi.to_bits(), (x.lo + 0.0).to_bits()];
        for case in 0..4000 {
            let mut matrix = || {
                Affine::from_row_major(std::array::from_fn(|_| match random.below(4 + case % 9) {
                    0 | 1 => 0.0,
                    2 => -0.0,
                    3 => 1.0,
                    4 => -1.0,
                    _ => random.number(-3.0, 3.0),
                }))
            };
            let mut product = widen(&matrix());
            for _ in 0..3 {
                let inner = widen(&matrix());
                let dense = dense_product(&product, &inner);
                product = compose(&product, &inner);
                assert!(product.iter().flatten().map(bits).eq(dense.iter().flatten().map(bits)), "{dense:?}");
                let (found, dense) = (adjugate(&product), dense_adjugate(&product));
                assert!(found.iter().flatten().map(bits).eq(dense.iter().flatten().map(bits)), "{dense:?}");
            }
        }
        let mut not_a_number = Affine::IDENTITY;
        not_a_number.rows[0][1] = f64::NAN;
        assert!(not_a_number.determinant().is_nan());
    }

    #[test]
    fn what_is_clearly_invertible_is_invertible() {
        let mut random = crate::testkit::random::Random::new(32);
        let mut clear = 0;
        for case in 0..20_000 {
            let thin = 10f64.powi(-(case % 16));
            let numbers: [f64; 12] = std::array::from_fn(|i| {
                random.number(-1.0, 1.0) * if (4..8).contains(&i) { thin } else { 1.0 }
            });
            let size = 10f64.powi(case % 37 * 10 - 180);
            let matrix = Affine::from_row_major(numbers.map(|x| x * size));
            if matrix.is_clearly_invertible() {
                clear += 1;
                assert!(TransformPair::new(&matrix).is_ok_and(|pair| pair.condition < 1e8), "{matrix:?}");
            }
        }
        assert!(clear > 2000, "{clear}");
        for broken in [f64::NAN, f64::INFINITY, 1e200] {
            for entry in 0..12 {
                let mut matrix = Affine::scaling(Vec3::splat(2.0));
                matrix.rows[entry / 4][entry % 4] = broken;
                assert!(!matrix.is_clearly_invertible(), "{matrix:?}");
            }
        }
    }

    #[test]
    fn powers_of_two_scale_the_inverse_exactly() {
        let t = Affine::rotation_xyz(Vec3::new(10.0, 20.0, 30.0));
        let k = 2f64.powi(200);
        let scaled = Affine { rows: t.rows.map(|r| r.map(|x| x * k)) };
        let (a, b) = (t.inverse().unwrap(), scaled.inverse().unwrap());
        for (x, y) in a.rows.iter().flatten().zip(b.rows.iter().flatten()) {
            assert_eq!(*x, *y * k);
        }
    }

    #[test]
    fn a_scale_whose_inverse_overflows_is_called_that() {
        let error = TransformPair::new(&Affine::scaling(Vec3::splat(1e-320))).unwrap_err();
        assert!(error.is_beyond_range());
        assert!(error.to_string().starts_with("the inverse of the transform is beyond the range"), "{error}");
        let flat = TransformPair::new(&Affine::scaling(Vec3::new(1.0, 1.0, 0.0))).unwrap_err();
        assert!(!flat.is_beyond_range() && flat.to_string().contains("singular"), "{flat}");
    }

    #[test]
    fn singular_maps_are_refused_with_their_condition() {
        let flat = Affine::scaling(Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(flat.inverse().unwrap_err().condition, f64::INFINITY);
        let nearly = Affine::scaling(Vec3::new(1.0, 1.0, 1e-15));
        assert!(nearly.inverse().unwrap_err().condition > 9e14);
        let mut broken = Affine::IDENTITY;
        broken.rows[1][1] = f64::NAN;
        assert!(broken.inverse().is_err());
    }

    #[test]
    fn quarter_turns_are_exact() {
        let t = Affine::rotation_xyz(Vec3::new(0.0, 0.0, 90.0));
        assert_eq!(t.point(Vec3::X), Vec3::Y);
        assert_eq!(Affine::rotation_xyz(Vec3::new(90.0, 0.0, 0.0)).point(Vec3::Y), Vec3::Z);
    }
}
