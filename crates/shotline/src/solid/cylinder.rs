//! The circular cylinder around the z axis, closed by two caps.

use std::sync::Arc;

use super::capped::Capped;
use super::form::Form;
use super::{Build, Kind, Param, constructors};
use crate::math::{Dd, Vec3, power_of_two_below, two_prod};

pub(super) static KIND: Kind = Kind {
    name: "cylinder",
    summary: "the cylinder of a radius around the z axis, from z0 to z1",
    interior: "x^2 + y^2 < radius^2, z0 < z < z1",
    params: &[
        Param::length("radius", "the radius, positive"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Solid(|p| {
        let radius = p.positive("radius")?;
        let (z0, z1) = p.ascending("z0", "z1")?;
        Ok(Arc::new(Capped::between(form(radius), z0, z1, radius)))
    }),
    examples: &[&[&[1.0], &[-1.0], &[1.0]], &[&[0.01], &[2.0], &[40.0]], &[&[300.0], &[-0.5], &[0.5]]],
};

constructors! {
    cylinder:
    /// The cylinder of a radius around the z axis, from z0 to z1.
    fn cylinder(radius: number, z0: number, z1: number);
}

/// `x^2 + y^2 - r^2`, independent of z.
pub(super) fn form(radius: f64) -> Form {
    let unit = power_of_two_below(radius);
    let r = radius / unit;
    Form {
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 0.0),
        square: [Dd::from(1.0), Dd::from(1.0), Dd::ZERO],
        constant: -two_prod(r, r),
        ..Form::ZERO
    }
}
