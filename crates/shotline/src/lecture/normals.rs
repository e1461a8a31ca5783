//! Normals under affine maps without an inverse.

use crate::math::{Affine, Vec3};

/// The direction of a transformed normal by the adjugate alone, `sign(|S|) adj(S)^T n`.
///
/// It is parallel to `(T^-1)^T n`, points outward under reflections too, and needs no division. Production code uses
/// `(T^-1)^T n` ([`Affine::covector`] of the inverse).
pub fn normal_by_adjugate(map: &Affine, n: Vec3) -> Vec3 {
    let a = map.adjugate();
    let c = |j: usize| n.x * a[0][j] + n.y * a[1][j] + n.z * a[2][j];
    Vec3::new(c(0), c(1), c(2)) * map.determinant().signum()
}
