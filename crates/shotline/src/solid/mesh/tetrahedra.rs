//! Signed tetrahedra between triangles and a vertex of their own shell.
//!
//! The apex belongs to the shell, so the size of the terms depends on the size of the shell and not on its distance
//! from other shells. Differences are exact and products are double-double. Where the terms cancel so far that the sum
//! is less accurate than a double, the determinants are summed again as exact expansions.

use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

use super::distribute::CHUNK;
use super::exact::{Expansion, Wide, minus};
use super::welded::Face;
use crate::math::{Dd, Vec3};

/// An upper bound on the relative rounding error of a double-double determinant, including the sum of its terms.
const ROUNDING: f64 = 1.0 / (1u128 << 96) as f64;

/// How many terms of a sum are kept at a time.
const AT_A_TIME: usize = 1 << 18;

/// A sum is accepted if its relative error bound is less than this.
const ACCURATE: f64 = 1e-15;

/// The determinant of the differences of three corners from an apex, and a bound on its rounding error.
#[inline(always)]
pub(super) fn determinant(apex: Vec3, corners: [Vec3; 3]) -> (Dd, f64) {
    let [u, v, w] = corners.map(|corner| minus(corner, apex));
    let (mut sum, mut size) = (Dd::ZERO, 0.0);
    for (i, height) in w.into_iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        sum = sum + (u[j] * v[k] - u[k] * v[j]) * height;
        size += ((u[j].hi * v[k].hi).abs() + (u[k].hi * v[j].hi).abs()) * height.hi.abs();
    }
    (sum, size * ROUNDING)
}

/// The determinants of many apexes, each with its three corners.
#[multiversion::multiversion(targets("x86_64+avx+fma"))]
fn determinants(corners: &[[Vec3; 4]]) -> Vec<(Dd, f64)> {
    corners.iter().map(|[apex, a, b, c]| determinant(*apex, [*a, *b, *c])).collect()
}

/// The same with a relative error of at most 1e-31, and a bound on what summing it may add.
pub(super) fn exact_determinant(apex: Vec3, corners: [Vec3; 3]) -> (Dd, f64) {
    let [u, v, w]: [Wide; 3] = corners.map(|corner| minus(corner, apex));
    let value = Expansion::determinant(&u, &v, &w).value();
    (value, value.hi.abs() * ROUNDING)
}

/// Whether a sum of this many terms is accurate to a double, given the sum of the bounds of their errors.
pub(super) fn is_accurate(sum: Dd, doubt: f64, terms: usize) -> bool {
    doubt * (terms as f64) <= ACCURATE * sum.hi.abs()
}

/// Computes the determinants of tetrahedra, with bounds on their errors.
type Determinants = fn(&[[Vec3; 4]]) -> Vec<(Dd, f64)>;

/// The signed volume of faces, each as seen from the vertex of its shell that `apex` returns; 0 if rounding hides the
/// sign.
///
/// Exact determinants are used if the error bound of the fast ones is too large.
pub(super) fn signed_volume(
    faces: &[Face],
    apex: impl Fn(&Face) -> u32 + Sync,
    at: impl Fn(u32) -> Vec3 + Sync,
) -> f64 {
    let total = |determinants: Determinants| {
        let terms = |faces: &[Face]| {
            let corners = faces.iter().map(|face| {
                let [a, b, c] = face.corners.map(&at);
                [at(apex(face)), a, b, c]
            });
            determinants(&corners.collect::<Vec<_>>())
        };
        // In parallel, but summed in the order of the faces.
        faces.chunks(AT_A_TIME).fold((Dd::ZERO, 0.0), |sums, faces| {
            let terms: Vec<_> = faces.par_chunks(CHUNK).map(terms).collect();
            terms.iter().flatten().fold(sums, |(sum, doubt), (volume, error)| (sum + *volume, doubt + error))
        })
    };
    let (mut sum, mut doubt) = total(determinants);
    if !is_accurate(sum, doubt, faces.len()) {
        (sum, doubt) = total(|corners| {
            corners.iter().map(|[apex, a, b, c]| exact_determinant(*apex, [*a, *b, *c])).collect()
        });
    }
    if doubt * (faces.len() as f64) < sum.hi.abs() { sum.hi / 6.0 } else { 0.0 }
}
