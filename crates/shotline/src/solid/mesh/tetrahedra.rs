//! Signed tetrahedra between triangles and a vertex of their own shell.
//!
//! The apex belongs to the shell, so that the size of the terms is that of the shell and not its distance from other
//! shells. Differences are exact and products are double-double; where the terms cancel so far that this leaves
//! less than a double holds, determinants are summed again as exact expansions.

use super::exact::{Expansion, Wide, minus};
use super::welded::Face;
use crate::math::{Dd, Vec3};

/// Relative rounding of a double-double determinant, with the sums of its terms: an upper bound.
const ROUNDING: f64 = 1.0 / (1u128 << 96) as f64;

/// A sum is kept if its doubt is less than this, relative.
const SURE: f64 = 1e-15;

/// The determinant of the differences of three corners from an apex, and a bound of its rounding error.
pub(super) fn determinant(apex: Vec3, corners: [Vec3; 3]) -> (Dd, f64) {
    let [u, v, w] = corners.map(|corner| minus(corner, apex));
    let (mut sum, mut size) = (Dd::ZERO, 0.0);
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        sum = sum + (u[j] * v[k] - u[k] * v[j]) * w[i];
        size += ((u[j].hi * v[k].hi).abs() + (u[k].hi * v[j].hi).abs()) * w[i].hi.abs();
    }
    (sum, size * ROUNDING)
}

/// The same within 1e-31, relative, with a bound of what summing it may add.
pub(super) fn exact_determinant(apex: Vec3, corners: [Vec3; 3]) -> (Dd, f64) {
    let [u, v, w]: [Wide; 3] = corners.map(|corner| minus(corner, apex));
    let value = Expansion::determinant(&u, &v, &w).value();
    (value, value.hi.abs() * ROUNDING)
}

/// Whether a sum of so many terms is right to a double, by the sum of the bounds of their errors.
pub(super) fn is_sure(sum: Dd, doubt: f64, terms: usize) -> bool {
    doubt * (terms as f64) <= SURE * sum.hi.abs()
}

/// The signed volume of faces, each seen from a vertex of its shell, which `apex` names; 0 where rounding leaves no sign.
///
/// Exact determinants are used where the quick ones leave it in doubt.
pub(super) fn signed_volume(
    faces: &[Face],
    mut apex: impl FnMut(&Face) -> u32,
    at: impl Fn(u32) -> Vec3,
) -> f64 {
    let mut total = |one: fn(Vec3, [Vec3; 3]) -> (Dd, f64)| {
        faces.iter().fold((Dd::ZERO, 0.0), |(sum, doubt), face| {
            let (volume, error) = one(at(apex(face)), face.corners.map(&at));
            (sum + volume, doubt + error)
        })
    };
    let (mut sum, mut doubt) = total(determinant);
    if !is_sure(sum, doubt, faces.len()) {
        (sum, doubt) = total(exact_determinant);
    }
    if doubt * (faces.len() as f64) < sum.hi.abs() { sum.hi / 6.0 } else { 0.0 }
}
