//! The paraboloid around the z axis, from its vertex to a cap.

use std::sync::Arc;

use super::capped::Capped;
use super::form::Form;
use super::{Build, Kind, Param, constructors};
use crate::math::{Dd, Vec3, power_of_two_below, two_prod, two_sum};

pub(super) static KIND: Kind = Kind {
    name: "paraboloid",
    summary: "the paraboloid around the z axis with its vertex at z0 and a radius at z1",
    interior: "x^2 + y^2 < radius^2 (z - z0) / (z1 - z0), z < z1",
    params: &[
        Param::length("radius", "the radius at z1, positive"),
        Param::length("z0", "the vertex"),
        Param::length("z1", "the upper end, closed by a disc, above z0"),
    ],
    build: Build::Solid(|p| {
        let radius = p.positive("radius")?;
        let (z0, z1) = p.ascending("z0", "z1")?;
        Ok(Arc::new(Capped::between(form(radius, z0, z1), z0, z1, radius)))
    }),
    examples: &[&[&[1.0], &[0.0], &[1.0]], &[&[0.12], &[-1.9], &[2.2]], &[&[50.0], &[3.0], &[3.5]]],
};

constructors! {
    paraboloid:
    /// The paraboloid around the z axis with its vertex at z0 and a radius at z1, where a disc closes it.
    fn paraboloid(radius: number, z0: number, z1: number);
}

/// `h (x^2 + y^2) - r^2 z`, with the vertex at `z = 0` and the radius `r` at height `h`.
fn form(radius: f64, z0: f64, z1: f64) -> Form {
    let (unit, unit_z) = (power_of_two_below(radius), power_of_two_below(z1 - z0));
    let h = two_sum(z1, -z0) * (1.0 / unit_z);
    let r = radius / unit;
    Form {
        centre: Vec3::new(0.0, 0.0, z0),
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
        square: [h, h, Dd::ZERO],
        linear: [Dd::ZERO, Dd::ZERO, two_prod(r, r) * -0.5],
        ..Form::ZERO
    }
}
