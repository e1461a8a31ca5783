//! The sphere around the origin.

use std::sync::Arc;

use super::capped::Capped;
use super::form::Form;
use super::{Build, Kind, Param, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, power_of_two_below, two_prod};

pub(super) static KIND: Kind = Kind {
    name: "sphere",
    summary: "the sphere of a radius around the origin",
    interior: "x^2 + y^2 + z^2 < radius^2",
    params: &[Param::length("radius", "the radius, positive")],
    build: Build::Solid(|p| {
        let radius = p.positive("radius")?;
        let bounds = Aabb::new(Vec3::splat(-radius), Vec3::splat(radius));
        Ok(Arc::new(Capped::whole(form(radius), bounds, &["sphere"])))
    }),
    examples: &[&[&[1.0]], &[&[1e-3]], &[&[1e6]]],
};

constructors! {
    sphere:
    /// The sphere of a radius around the origin.
    fn sphere(radius: number);
}

/// `x^2 + y^2 + z^2 - r^2`.
pub(super) fn form(radius: f64) -> Form {
    let unit = power_of_two_below(radius);
    let r = radius / unit;
    Form {
        shrink: Vec3::splat(1.0 / unit),
        square: [Dd::from(1.0); 3],
        constant: -two_prod(r, r),
        ..Form::ZERO
    }
}
