//! The general quadric; bounded if it is an ellipsoid.

use std::sync::Arc;

use super::capped::Capped;
use super::form::Form;
use super::{Build, Kind, Param, ParamError, constructors, definite};
use crate::math::{Dd, Vec3, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "quadric",
    summary: "the quadric A x2 + B y2 + C z2 + D xy + E xz + F yz + G x + H y + I z + J < 0",
    interior: "A x^2 + B y^2 + C z^2 + D xy + E xz + F yz + G x + H y + I z + J < 0",
    params: &[Param::coefficients("coeffs", &[0, 0, 0, 0, 0, 0, 1, 1, 1, 2], "A to J, not all zero")],
    build: Build::Solid(|p| {
        let coeffs = p.coefficients("coeffs")?;
        if coeffs.iter().all(|x| *x == 0.0) {
            return Err(ParamError { param: "coeffs", why: "are all zero, but one must not be".into() });
        }
        let form = form(coeffs);
        let bounds = definite::bounds(&form);
        Ok(Arc::new(Capped::whole(form, bounds, &["quadric"])))
    }),
    examples: &[
        &[&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]],
        &[&[1.3, 2.8, 1.6, 0.2, -2.8, 0.2, -0.3, 0.4, 0.3, -1.0]],
        &[&[0.2, -0.7, -0.5, 1.3, 0.8, -0.2, -0.4, 0.5, 0.4, -0.3]],
        &[&[2.0, 1.0, 3.0, 1.0, -0.5, 0.25, -8.0, 4.0, -12.0, 20.0]],
        &[&[1.0, 0.0, 2.0, 0.0, 1.0, 0.0, -2.0, 0.0, 1.0, 0.5]],
        &[&[1.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0]],
        &[&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -2.0, 0.5, 3.0]],
        &[&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]],
    ],
};

constructors! {
    quadric:
    /// The quadric `A x2 + B y2 + C z2 + D xy + E xz + F yz + G x + H y + I z + J < 0`, by its coefficients A to J.
    fn quadric(coeffs: coefficients);
}

/// Divides all coefficients by one power of four. The form is centred at the origin, wherever the quadric lies,
/// because its coefficients are exact there. A power of four keeps the proportions the same if the quadric is
/// scaled by two. Axes that no coefficient names are removed: a component of a line along them must not make the others
/// look small.
fn form(coeffs: [f64; 10]) -> Form {
    let root = power_of_two_below(coeffs.iter().fold(0.0, |m: f64, x| m.max(x.abs())).sqrt());
    let [a, b, c, d, e, f, g, h, i, j] = coeffs.map(|x| x / root / root);
    let proportions = proportions(Vec3::new(a, b, c));
    let counts = |of_axis: [f64; 4]| if of_axis == [0.0; 4] { 0.0 } else { 1.0 };
    let shrink = proportions * Vec3::new(counts([a, d, e, g]), counts([b, d, f, h]), counts([c, e, f, i]));
    let half = |x: f64, y: f64, z: f64| (Vec3::new(x, y, z) * 0.5).to_array().map(Dd::from);
    let per = 1.0 / proportions;
    let square = Vec3::new(a, b, c) * per * per;
    let (cross_per, linear) =
        (Vec3::new(per.y * per.z, per.x * per.z, per.x * per.y), Vec3::new(g, h, i) * per);
    Form {
        shrink,
        square: square.to_array().map(Dd::from),
        cross: (d != 0.0 || e != 0.0 || f != 0.0)
            .then(|| half(f * cross_per.x, e * cross_per.y, d * cross_per.z)),
        linear: half(linear.x, linear.y, linear.z),
        constant: Dd::from(j),
        ..Form::ZERO
    }
}

/// Powers of two in the proportions of the square roots of the diagonal, which for an axis-aligned quadric are
/// those of the shape. All 1 if a square is missing.
fn proportions(square: Vec3) -> Vec3 {
    let root = square.abs().map(f64::sqrt);
    if root.min_element() > 0.0 { root.map(power_of_two_below) } else { Vec3::ONE }
}
