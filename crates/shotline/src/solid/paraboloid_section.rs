//! The part of a paraboloid of revolution between two radii.

use std::sync::Arc;

use super::capped::Capped;
use super::form::{Form, squared};
use super::{Build, Kind, Param, ParamError, constructors, cylinder};
use crate::math::{Dd, Vec3, power_of_two_below, two_sum};

pub(super) static KIND: Kind = Kind {
    name: "paraboloid_section",
    summary: "the part of a paraboloid around the z axis that has radius r0 at z0 and r1 at z1",
    interior: "x^2 + y^2 < r(z)^2, z0 < z < z1, with r(z)^2 linear from r0^2 at z0 to r1^2 at z1",
    params: &[
        Param::length("r0", "the radius at z0; 0 for the vertex"),
        Param::length("r1", "the radius at z1; 0 for the vertex, but not both"),
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
        &[&[0.5], &[1.0], &[-1.0], &[1.0]],
        &[&[2.0], &[0.0], &[0.0], &[3.0]],
        &[&[1.0], &[1.0], &[0.0], &[1.0]],
    ],
};

constructors! {
    paraboloid_section:
    /// The part of a paraboloid around the z axis that has radius r0 at z0 and r1 at z1; one of the radii may be 0.
    fn paraboloid_section(r0: number, r1: number, z0: number, z1: number);
}

/// `x^2 + y^2 - r(z)^2`, times the height.
fn form(r0: f64, r1: f64, z0: f64, z1: f64) -> Form {
    if r0 == r1 {
        return cylinder::form(r0);
    }
    let (unit, unit_z) = (power_of_two_below(r0.max(r1)), power_of_two_below(z1 - z0));
    let h = two_sum(z1, -z0) * (1.0 / unit_z);
    let (a, b) = (Dd::from(r0 / unit), Dd::from(r1 / unit));
    // The difference of the squares, without the cancellation of two products.
    let widening = (b - a) * (b + a);
    Form {
        centre: Vec3::new(0.0, 0.0, z0),
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
        square: [h, h, Dd::ZERO],
        linear: [Dd::ZERO, Dd::ZERO, widening * -0.5],
        constant: -(h * squared(a)),
        ..Form::ZERO
    }
}
