//! The half-space behind a plane.

use std::sync::Arc;

use super::capped::Capped;
use super::form::Form;
use super::{Build, Kind, Param, ParamError, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "halfspace",
    summary: "the half-space normal . p < offset",
    interior: "normal . p < offset",
    params: &[
        Param::direction("normal", "out of the solid, of any length but 0"),
        Param::length("offset", "normal . p on the plane"),
    ],
    build: Build::Solid(|p| {
        let normal = p.vector("normal")?;
        if normal == Vec3::ZERO {
            return Err(ParamError { param: "normal", why: "is zero, but must have a direction".into() });
        }
        let offset = p.number("offset")?;
        Ok(Arc::new(Capped::whole(form(normal, offset), bounds(normal, offset), &["plane"])))
    }),
    examples: &[
        &[&[0.0, 0.0, 1.0], &[0.0]],
        &[&[0.3, -2.0, 0.7], &[1.25]],
        &[&[1e-9, 3e-9, -2e-9], &[-1e-9]],
    ],
};

constructors! {
    halfspace:
    /// The half-space `normal . p < offset`; the normal has any length but 0.
    fn halfspace(normal: vector, offset: number);
}

/// Returns the box: bounded on one side of an axis if the plane is perpendicular to that axis, otherwise
/// unbounded.
pub(super) fn bounds(normal: Vec3, offset: f64) -> Aabb {
    let mut bounds = Aabb::EVERYTHING;
    for axis in 0..3 {
        if normal.abs() == Vec3::AXES[axis] * normal[axis].abs() {
            let place = offset / normal[axis];
            if normal[axis] > 0.0 {
                bounds.max[axis] = place;
            } else {
                bounds.min[axis] = place;
            }
        }
    }
    bounds.widened(4.0)
}

/// `2 l x + k` with `l = normal / 2` and `k = -offset`, both divided by a power of two.
pub(super) fn form(normal: Vec3, offset: f64) -> Form {
    let unit = power_of_two_below(normal.abs().max_element());
    let linear = normal / unit * 0.5;
    Form {
        linear: [linear.x, linear.y, linear.z].map(Dd::from),
        constant: Dd::from(-offset / unit),
        ..Form::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_across_an_axis_bound_it() {
        assert_eq!(bounds(Vec3::new(1.0, 2.0, 0.0), 3.0), Aabb::EVERYTHING);
        let below = bounds(Vec3::new(0.0, -0.0, 2.0), 3.0);
        assert!(below.max.z >= 1.5 && below.max.z < 1.5 + 1e-14 && below.max.x == f64::INFINITY);
        let above = bounds(Vec3::new(0.0, -2.0, 0.0), 3.0);
        assert!(above.min.y <= -1.5 && above.min.y > -1.5 - 1e-14 && above.max.y == f64::INFINITY);
    }
}
