//! Textbook formulas of surfaces.

use crate::math::{Plane, Vec3};
use crate::solid::{QuadricMatrix, torus::Torus};

/// The row vector `2 x^T Q`. Its first three numbers are the gradient at `x`. At a point of the surface it is the
/// tangent plane, with the normal pointing outward.
pub fn tangent_plane(quadric: &QuadricMatrix, p: Vec3) -> Plane {
    let v = quadric.polar(p).map(|x| 2.0 * x);
    Plane::new(Vec3::new(v[0], v[1], v[2]), v[3])
}

/// The textbook quartic of a torus, `(x^2 + y^2 + z^2 - r^2 - R^2)^2 + 4 R^2 (z^2 - r^2)`.
///
/// It is [`Solid::implicit`](crate::solid::Solid::implicit) times `(sqrt(x^2 + y^2) + R)^2 + z^2 - r^2`. The two have
/// the same sign, except in the lemon of a spindle torus, where the quartic is positive although the lemon is
/// interior. For thin tori the quartic loses digits that the implicit function keeps.
pub fn torus_quartic(torus: &Torus, p: Vec3) -> f64 {
    let (major, minor) = torus.radii();
    let (major2, minor2) = (major * major, minor * minor);
    let g = p.length_squared() - minor2 - major2;
    g * g + 4.0 * major2 * (p.z * p.z - minor2)
}
