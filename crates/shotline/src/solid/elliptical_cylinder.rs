//! The elliptical cylinder around the z axis, closed by two caps.

use std::sync::Arc;

use super::capped::{CAPPED, Capped};
use super::form::Form;
use super::interval::Slab;
use super::{Build, Kind, Param, constructors, ellipsoid};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3};

pub(super) static KIND: Kind = Kind {
    name: "elliptical_cylinder",
    summary: "the cylinder around the z axis whose cross section is an ellipse, from z0 to z1",
    interior: "(x / a)^2 + (y / b)^2 < 1, z0 < z < z1",
    params: &[
        Param::length("a", "the semi-axis along x, positive"),
        Param::length("b", "the semi-axis along y, positive"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Solid(|p| {
        let (a, b) = (p.positive("a")?, p.positive("b")?);
        let (z0, z1) = p.ascending("z0", "z1")?;
        Ok(Arc::new(Capped {
            form: form(a, b),
            caps: Some(Slab { axis: 2, low: z0, high: z1, surface: 1 }),
            bounds: Aabb::new(Vec3::new(-a, -b, z0), Vec3::new(a, b, z1)),
            surfaces: CAPPED,
        }))
    }),
    examples: &[&[&[1.0], &[2.0], &[-1.0], &[1.0]], &[&[3.0], &[0.1], &[0.5], &[7.0]]],
};

constructors! {
    elliptical_cylinder:
    /// The cylinder around the z axis with the semi-axes a along x and b along y, from z0 to z1.
    fn elliptical_cylinder(a: number, b: number, z0: number, z1: number);
}

/// `(x / a)^2 + (y / b)^2 - 1`, independent of z.
fn form(a: f64, b: f64) -> Form {
    let Form { shrink, square: [xx, yy, _], constant, .. } = ellipsoid::form(Vec3::new(a, b, 1.0));
    Form { shrink: Vec3::new(shrink.x, shrink.y, 0.0), square: [xx, yy, Dd::ZERO], constant, ..Form::ZERO }
}
