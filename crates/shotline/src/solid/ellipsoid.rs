//! The axis-aligned ellipsoid around the origin.

use std::sync::Arc;

use super::capped::Capped;
use super::form::{Form, squared};
use super::{Build, Kind, Param, ParamError, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "ellipsoid",
    summary: "the ellipsoid of three semi-axes around the origin",
    interior: "sum of (p_i / a_i)^2 < 1",
    params: &[Param::lengths("semi_axes", "along x, y and z, positive")],
    build: Build::Solid(|p| {
        let axes = p.vector("semi_axes")?;
        if axes.min_element() <= 0.0 {
            return Err(ParamError { param: "semi_axes", why: format!("are {axes}, but must be positive") });
        }
        Ok(Arc::new(Capped::whole(form(axes), Aabb::new(-axes, axes), &["ellipsoid"])))
    }),
    examples: &[&[&[1.0, 2.0, 3.0]], &[&[1000.0, 1.0, 1.0]], &[&[1e-3, 0.7, 30.0]]],
};

constructors! {
    ellipsoid:
    /// The ellipsoid around the origin with its semi-axes along x, y and z.
    fn ellipsoid(semi_axes: vector);
}

/// `(x/a)^2 + (y/b)^2 + (z/c)^2 - 1`.
pub(super) fn form(axes: Vec3) -> Form {
    let shrink = Vec3::from(axes.to_array().map(|a| 1.0 / power_of_two_below(a)));
    let square = (axes * shrink).to_array().map(|a| squared(Dd::from(a).recip()));
    Form { shrink, square, constant: Dd::from(-1.0), ..Form::ZERO }
}
