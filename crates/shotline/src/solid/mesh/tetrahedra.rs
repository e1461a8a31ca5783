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
use crate::math::{Dd, Real, Vec3};
use crate::simd::{Doubles, Simd, Task, dispatch};

/// An upper bound on the relative rounding error of a double-double determinant, including the sum of its terms.
const ROUNDING: f64 = 1.0 / (1u128 << 96) as f64;

/// A sum is accepted if its relative error bound is less than this.
const ACCURATE: f64 = 1e-15;

/// The determinant of the differences of three corners from an apex, and a bound on its rounding error.
#[inline(always)]
pub(super) fn determinant(apex: Vec3, corners: [Vec3; 3]) -> (Dd, f64) {
    let [u, v, w] = corners.map(|corner| minus(corner, apex));
    let mut size = 0.0;
    for (i, height) in w.into_iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        size += ((u[j].hi * v[k].hi).abs() + (u[k].hi * v[j].hi).abs()) * height.hi.abs();
    }
    (determinant_of(&u, &v, &w), size * ROUNDING)
}

/// The same of one tetrahedron in each lane.
#[inline(always)]
fn determinants<D: Doubles>([apex, a, b, c]: [[D; 3]; 4]) -> (Dd<D>, D) {
    let (u, v, w) = (minus(a, apex), minus(b, apex), minus(c, apex));
    let mut size = D::splat(0.0);
    for (i, height) in w.into_iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        size = size + ((u[j].hi * v[k].hi).abs() + (u[k].hi * v[j].hi).abs()) * height.hi.abs();
    }
    (determinant_of(&u, &v, &w), size * D::splat(ROUNDING))
}

/// The determinant of three vectors.
#[inline(always)]
fn determinant_of<T: Real>(u: &Wide<T>, v: &Wide<T>, w: &Wide<T>) -> Dd<T> {
    let zero = T::splat(0.0);
    let mut sum = Dd { hi: zero, lo: zero };
    for (i, height) in w.iter().enumerate() {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        sum = sum + (u[j] * v[k] - u[k] * v[j]) * *height;
    }
    sum
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

/// The signed volume of faces, each as seen from the vertex of its shell that `apex` returns; 0 if rounding hides the
/// sign.
///
/// Exact determinants are used if the error bound of the fast ones is too large.
pub(super) fn signed_volume(
    faces: &[Face],
    apex: impl Fn(&Face) -> u32 + Sync,
    at: impl Fn(u32) -> Vec3 + Sync,
) -> f64 {
    let corners = |face: &Face| {
        let [a, b, c] = face.corners.map(&at);
        [at(apex(face)), a, b, c]
    };
    let add = |(sum, doubt): (Dd, f64), (more, error): (Dd, f64)| (sum + more, doubt + error);
    // Chunks do not depend on the number of threads, and are summed in order.
    let total = |of_chunk: &(dyn Fn(&[Face]) -> (Dd, f64) + Sync)| {
        let sums: Vec<(Dd, f64)> = faces.par_chunks(CHUNK).map(of_chunk).collect();
        sums.into_iter().fold((Dd::ZERO, 0.0), add)
    };
    let (mut sum, mut doubt) = total(&|faces| dispatch(SumOf { faces, corners: &corners }));
    if !is_accurate(sum, doubt, faces.len()) {
        let exact = |face: &Face| {
            let [apex, a, b, c] = corners(face);
            exact_determinant(apex, [a, b, c])
        };
        (sum, doubt) = total(&|faces| faces.iter().map(exact).fold((Dd::ZERO, 0.0), add));
    }
    if doubt * (faces.len() as f64) < sum.hi.abs() { sum.hi / 6.0 } else { 0.0 }
}

/// The sum of the determinants of faces, and of the bounds of their errors.
struct SumOf<'a, C> {
    faces: &'a [Face],
    /// Returns the apex and the corners of a face.
    corners: &'a C,
}

/// So many sums are made, each of every so many faces, however many the registers hold.
const SUMS: usize = 8;

impl<C: Fn(&Face) -> [Vec3; 4]> Task for SumOf<'_, C> {
    type Output = (Dd, f64);

    #[inline(always)]
    fn run<S: Simd>(self) -> (Dd, f64) {
        let zero = S::Wide::splat(0.0);
        let parts = SUMS / S::Wide::LANES;
        let mut sums = [(Dd { hi: zero, lo: zero }, zero); 2];
        for faces in self.faces.chunks(SUMS) {
            let mut coordinates = [[0.0; SUMS]; 12];
            for (lane, face) in faces.iter().enumerate() {
                let corners = (self.corners)(face).map(|v| v.to_array());
                for (i, x) in corners.as_flattened().iter().enumerate() {
                    coordinates[i][lane] = *x;
                }
            }
            for (part, (sum, doubt)) in sums.iter_mut().enumerate().take(parts) {
                let mut corners = [[zero; 3]; 4];
                for (i, coordinates) in coordinates.iter().enumerate() {
                    corners[i / 3][i % 3] = S::Wide::load_some(coordinates, part * S::Wide::LANES);
                }
                let (volume, error) = determinants(corners);
                (*sum, *doubt) = (*sum + volume, *doubt + error);
            }
        }
        let mut total = (Dd::ZERO, 0.0);
        for (sum, doubt) in sums.into_iter().take(parts) {
            let (hi, lo, doubt) = (sum.hi.store(), sum.lo.store(), doubt.store());
            for lane in 0..S::Wide::LANES {
                total = (total.0 + Dd { hi: hi[lane], lo: lo[lane] }, total.1 + doubt[lane]);
            }
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Portable;
    use crate::testkit::random::Random;

    #[test]
    fn sums_have_the_same_bits_by_all_instructions_and_are_right() {
        let mut random = Random::new(6);
        for count in [0, 1, 7, 8, 9, 1000] {
            let face = |number| Face { number, corners: [0, 1, 2].map(|k| 3 * number + k) };
            let faces: Vec<Face> = (0..count).map(face).collect();
            let vertices: Vec<Vec3> = (0..3 * count).map(|_| random.point(-1.0, 1.0)).collect();
            let corners = |face: &Face| {
                let [a, b, c] = face.corners.map(|v| vertices[v as usize]);
                [vertices[0], a, b, c]
            };
            let sum_of = || SumOf { faces: &faces, corners: &corners };
            let (sum, doubt) = dispatch(sum_of());
            assert_eq!(Portable::call(sum_of()), (sum, doubt));
            let exact = faces.iter().map(|face| {
                let [apex, a, b, c] = corners(face);
                exact_determinant(apex, [a, b, c]).0
            });
            let error = (exact.fold(Dd::ZERO, |sum, term| sum + term) - sum).hi.abs();
            assert!(error <= doubt * f64::from(count) && doubt < 1e-24, "{count}: {error} {doubt}");
        }
    }
}
