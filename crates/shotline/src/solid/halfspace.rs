//! The half-space behind a plane.

use std::sync::Arc;

use super::capped::Capped;
use super::form::{Form, power_of_two};
use super::{Kind, Param, ParamError, ParamType, Value};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3};

pub(super) static KIND: Kind = Kind {
    name: "halfspace",
    summary: "the half-space normal . p < offset",
    params: &[
        Param { name: "normal", ty: ParamType::Numbers(3), summary: "out of the solid, of any length but 0" },
        Param { name: "offset", ty: ParamType::Number, summary: "normal . p on the plane" },
    ],
    build: |p| {
        let normal = p.vector("normal")?;
        if normal == Vec3::ZERO {
            return Err(ParamError { param: "normal", why: "is zero, but must have a direction".into() });
        }
        let form = form(normal, p.number("offset")?);
        Ok(Arc::new(Capped::whole(form, Aabb::EVERYTHING, &["plane"])))
    },
    examples: &[
        &[Value::Vector([0.0, 0.0, 1.0]), Value::Number(0.0)],
        &[Value::Vector([0.3, -2.0, 0.7]), Value::Number(1.25)],
        &[Value::Vector([1e-9, 3e-9, -2e-9]), Value::Number(-1e-9)],
    ],
};

/// `2 l x + k` with `l = normal / 2` and `k = -offset`, both over a power of two.
fn form(normal: Vec3, offset: f64) -> Form {
    let unit = power_of_two(normal.abs().max_element());
    let linear = normal / unit * 0.5;
    Form {
        linear: [linear.x, linear.y, linear.z].map(Dd::from),
        constant: Dd::from(-offset / unit),
        ..Form::ZERO
    }
}
