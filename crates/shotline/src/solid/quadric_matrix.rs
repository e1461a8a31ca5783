//! Quadrics as symmetric 4x4 matrices over homogeneous points (J. C. Hart, lecture on ray intersections;
//! Blinn 1984).

use crate::math::{Affine, Vec3};

/// A quadric `x^T Q x = 0` over points `x = [x y z 1]^T` with a symmetric `Q`. The value is negative in the
/// interior.
///
/// If points are mapped by `T`, the quadric becomes `T^-T Q T^-1`, as `x^T Q x = (T x)^T (T^-T Q T^-1) (T x)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadricMatrix {
    /// `Q`, row by row.
    pub rows: [[f64; 4]; 4],
}

impl QuadricMatrix {
    /// The value `x^T Q x` at a point. It has no particular unit and is negative inside.
    pub fn evaluate(&self, p: Vec3) -> f64 {
        let v = self.polar(p);
        v[0] * p.x + v[1] * p.y + v[2] * p.z + v[3]
    }

    /// Returns the quadric after its points were mapped by `T`, given `T^-1`: `T^-T Q T^-1`.
    pub fn transformed(&self, inverse: &Affine) -> QuadricMatrix {
        let m = &inverse.rows;
        let t = [m[0], m[1], m[2], [0.0, 0.0, 0.0, 1.0]];
        let product = |i: usize, j: usize| {
            (0..4).map(|k| t[k][i] * (0..4).map(|l| self.rows[k][l] * t[l][j]).sum::<f64>()).sum()
        };
        // Computed from one triangle, so that the result is symmetric in every bit.
        QuadricMatrix { rows: std::array::from_fn(|i| std::array::from_fn(|j| product(i.min(j), i.max(j)))) }
    }

    /// The product `x^T Q`.
    pub(crate) fn polar(&self, p: Vec3) -> [f64; 4] {
        let q = &self.rows;
        std::array::from_fn(|j| p.x * q[0][j] + p.y * q[1][j] + p.z * q[2][j] + q[3][j])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lecture::surfaces::tangent_plane;
    use crate::math::tests_support::affine_strategy;
    use crate::ray::Line;
    use crate::solid::{KINDS, Params, Solid};
    use proptest::prelude::*;
    use std::sync::Arc;

    /// All quadrics among the examples of all kinds.
    fn quadrics() -> Vec<(Arc<dyn Solid>, QuadricMatrix)> {
        let examples = KINDS.iter().flat_map(|k| k.examples.iter().map(|e| k.build(&Params::of(k, e))));
        let solids = examples.filter_map(|parts| parts.ok()?.single().cloned());
        solids.filter_map(|solid| solid.quadric_matrix(0).map(|q| (solid, q))).collect()
    }

    /// The scale of the rounding error of `x^T Q x`: the same with absolute values.
    fn size(q: &QuadricMatrix, p: Vec3) -> f64 {
        QuadricMatrix { rows: q.rows.map(|r| r.map(f64::abs)) }.evaluate(p.abs())
    }

    proptest! {
        #[test]
        fn values_and_gradients_are_the_affine_ones(p in prop::array::uniform3(-5.0..5.0f64)) {
            let p = Vec3::from(p);
            for (solid, q) in quadrics() {
                prop_assert!((q.evaluate(p) - solid.implicit(p, 0, 0)).abs() <= 1e-14 * size(&q, p));
                let (ours, theirs) = (tangent_plane(&q, p).normal, solid.normal(p, 0, 0));
                let step = 1e-3 * (1.0 + p.length());
                prop_assert!((ours - theirs).length() * step <= 1e-14 * size(&q, p.abs() + Vec3::ONE));
            }
        }

        #[test]
        fn moved_quadrics_vanish_where_moved_lines_cross(
            t in affine_strategy(),
            o in prop::array::uniform3(-5.0..5.0f64),
            aim in prop::array::uniform3(-0.5..0.5f64),
        ) {
            let inverse = t.inverse().unwrap();
            let line = Line::exact(Vec3::from(o), Vec3::from(aim) - Vec3::from(o));
            for (solid, q) in quadrics() {
                let moved = q.transformed(&inverse);
                let mut list = Vec::new();
                solid.crossings(&line, &mut list);
                for c in list.iter().filter(|c| c.surface == 0 && c.t.abs() < 10.0) {
                    let (p, moved_p) = (line.at(c.t), t.point(line.at(c.t)));
                    let size = size(&moved, moved_p) * t.condition();
                    prop_assert!(moved.evaluate(moved_p).abs() <= 1e-13 * size);
                    // The tangent plane moves with the points: `n T^-1`, whose normal is `(T^-1)^T n`.
                    let plane = tangent_plane(&q, p).transformed(&inverse);
                    let difference = plane.normal - tangent_plane(&moved, moved_p).normal;
                    prop_assert!(difference.length() <= 1e-12 * size);
                }
            }
        }
    }

    #[test]
    fn matrices_are_those_of_the_textbook() {
        let build = |name: &str, numbers: &[&[f64]]| {
            let kind = crate::solid::kind(name).unwrap();
            kind.build(&Params::of(kind, numbers)).unwrap().single().unwrap().quadric_matrix(0).unwrap().rows
        };
        let diagonal =
            |d: [f64; 4]| std::array::from_fn(|i| std::array::from_fn(|j| [0.0, d[i]][(i == j) as usize]));
        assert_eq!(build("sphere", &[&[1.5]]), diagonal([1.0, 1.0, 1.0, -2.25]));
        assert_eq!(build("ellipsoid", &[&[1.0, 2.0, 4.0]]), diagonal([1.0, 0.25, 0.0625, -1.0]));
        assert_eq!(build("cylinder", &[&[1.5], &[3.0], &[4.0]]), diagonal([1.0, 1.0, 0.0, -2.25]));
        assert_eq!(
            build("hyperboloid2", &[&[1.0], &[2.0], &[2.0], &[9.0]]),
            diagonal([1.0, 1.0, -0.25, 1.0])
        );
        let quadric = build("quadric", &[&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]]);
        let textbook =
            [[1.0, 2.0, 2.5, 3.5], [2.0, 2.0, 3.0, 4.0], [2.5, 3.0, 3.0, 4.5], [3.5, 4.0, 4.5, 10.0]];
        assert_eq!(quadric.map(|r| r.map(|x| x * 4.0)), textbook);
    }
}
