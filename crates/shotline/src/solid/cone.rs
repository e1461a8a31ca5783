//! The circular cone around the z axis, or its frustum, closed by caps.

use std::sync::Arc;

use super::capped::Capped;
use super::form::{Form, squared};
use super::{Build, Kind, Param, ParamError, constructors};
use crate::math::{Dd, Vec3, power_of_two_below, two_sum};

pub(super) static KIND: Kind = Kind {
    name: "cone",
    summary: "the cone or frustum around the z axis, of radius r0 at z0 and r1 at z1",
    interior: "x^2 + y^2 < r(z)^2, z0 < z < z1, with r(z) linear from r0 at z0 to r1 at z1; either may be 0",
    params: &[
        Param::length("r0", "the radius at z0; 0 for an apex"),
        Param::length("r1", "the radius at z1; 0 for an apex, but not both"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Solid(|p| {
        let (r0, r1) = (p.not_negative("r0")?, p.not_negative("r1")?);
        if r0 == 0.0 && r1 == 0.0 {
            return Err(ParamError { param: "r1", why: "is 0 like r0, but one must be positive".into() });
        }
        let (z0, z1) = p.ascending("z0", "z1")?;
        Ok(Arc::new(Capped::between(form(r0, r1, z0, z1), z0, z1, r0.max(r1))))
    }),
    examples: &[
        &[&[1.0], &[0.0], &[0.0], &[1.0]],
        &[&[0.0], &[2.5], &[-3.0], &[-2.0]],
        &[&[0.12], &[0.115], &[0.4], &[1.9]],
        &[&[1e-3], &[4.0], &[-10.0], &[90.0]],
    ],
};

constructors! {
    cone:
    /// The cone or frustum around the z axis, of radius r0 at z0 and r1 at z1; one of the radii may be 0.
    fn cone(r0: number, r1: number, z0: number, z1: number);
}

/// `h^2 (x^2 + y^2) - (h n + (w - n) z)^2`, with the narrow radius `n` at `z = 0` and the wide radius `w` at
/// height `h`. The form contains no quotient, so the slope is not rounded. The centre is the narrow end because
/// near an apex all terms are as small as the distance from it.
pub(super) fn form(r0: f64, r1: f64, z0: f64, z1: f64) -> Form {
    let (narrow, wide, centre, upward) = if r0 <= r1 { (r0, r1, z0, 1.0) } else { (r1, r0, z1, -1.0) };
    let (unit, unit_z) = (power_of_two_below(wide), power_of_two_below(z1 - z0));
    let h = two_sum(z1, -z0) * (1.0 / unit_z);
    let widening = two_sum(wide, -narrow) * (1.0 / unit);
    let at_centre = h * (narrow / unit);
    Form {
        centre: Vec3::new(0.0, 0.0, centre),
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
        square: [squared(h), squared(h), -squared(widening)],
        linear: [Dd::ZERO, Dd::ZERO, -(at_centre * widening) * upward],
        constant: -squared(at_centre),
        ..Form::ZERO
    }
}
