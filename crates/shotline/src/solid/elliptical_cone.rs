//! The elliptical cone around the z axis, cut off by two caps.

use std::sync::Arc;

use super::capped::{CAPPED, Capped};
use super::form::{Form, squared};
use super::interval::Slab;
use super::{Build, Kind, Param, ParamError, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "elliptical_cone",
    summary: "the cone with an elliptical cross section and its apex on the z axis, from z0 to z1",
    interior: "(x / a)^2 + (y / b)^2 < ((apex - z) / height)^2, z0 < z < z1",
    params: &[
        Param::length("a", "the semi-axis along x at the height below the apex, positive"),
        Param::length("b", "the semi-axis along y there, positive"),
        Param::length("height", "how far below the apex the semi-axes are a and b, positive"),
        Param::length("apex", "the z of the apex, at least z1"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Solid(|p| {
        let (a, b, height) = (p.positive("a")?, p.positive("b")?, p.positive("height")?);
        let (z0, z1) = p.ascending("z0", "z1")?;
        let apex = p.at_least("apex", z1, "z1")?;
        let widest = (apex - z0) / height;
        let bounds =
            Aabb::new(Vec3::new(-a * widest, -b * widest, z0), Vec3::new(a * widest, b * widest, z1));
        if !bounds.is_finite() {
            let why = format!("is {height}, which makes the lower end wider than the largest number");
            return Err(ParamError { param: "height", why });
        }
        Ok(Arc::new(Capped {
            form: form(a, b, height, apex),
            caps: Some(Slab { axis: 2, low: z0, high: z1, surface: 1 }),
            bounds: bounds.widened(8.0),
            surfaces: CAPPED,
        }))
    }),
    examples: &[
        &[&[1.0], &[2.0], &[3.0], &[3.0], &[-1.0], &[1.0]],
        &[&[0.5], &[0.25], &[1.0], &[2.0], &[0.0], &[2.0]],
    ],
};

constructors! {
    elliptical_cone:
    /// The cone with its apex on the z axis, from z0 to z1; a height below the apex its semi-axes are a along x and b along y.
    fn elliptical_cone(a: number, b: number, height: number, apex: number, z0: number, z1: number);
}

/// `(x / a)^2 + (y / b)^2 - ((z - apex) / height)^2`.
fn form(a: f64, b: f64, height: f64, apex: f64) -> Form {
    let axes = [a, b, height];
    let shrink = axes.map(|x| 1.0 / power_of_two_below(x));
    let [xx, yy, zz] = [0, 1, 2].map(|i| squared(Dd::from(axes[i] * shrink[i]).recip()));
    Form { centre: Vec3::new(0.0, 0.0, apex), shrink: shrink.into(), square: [xx, yy, -zz], ..Form::ZERO }
}
