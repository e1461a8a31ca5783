//! The part of an ellipsoid between two planes across the z axis.

use std::sync::Arc;

use super::capped::{CAPPED, Capped};
use super::interval::Slab;
use super::{Build, Kind, Param, ParamError, constructors, ellipsoid};
use crate::aabb::Aabb;
use crate::math::Vec3;

pub(super) static KIND: Kind = Kind {
    name: "ellipsoid_section",
    summary: "the part from z0 to z1 of the ellipsoid of three semi-axes around the origin",
    interior: "sum of (p_i / a_i)^2 < 1, z0 < z < z1",
    params: &[
        Param::lengths("semi_axes", "along x, y and z, positive"),
        Param::length("z0", "the lower end, below the semi-axis along z"),
        Param::length("z1", "the upper end, above z0 and above minus the semi-axis along z"),
    ],
    build: Build::Solid(|p| {
        let axes = p.vector("semi_axes")?;
        if axes.min_element() <= 0.0 {
            return Err(ParamError { param: "semi_axes", why: format!("are {axes}, but must be positive") });
        }
        let (z0, z1) = p.ascending("z0", "z1")?;
        for (param, z, side) in [("z0", z0, 1.0), ("z1", z1, -1.0)] {
            if side * z >= axes.z {
                let why = format!("is {z}, which is beyond the end of the ellipsoid at {}", side * axes.z);
                return Err(ParamError { param, why });
            }
        }
        let (low, high) =
            (Vec3::new(-axes.x, -axes.y, z0.max(-axes.z)), Vec3::new(axes.x, axes.y, z1.min(axes.z)));
        Ok(Arc::new(Capped {
            form: ellipsoid::form(axes),
            caps: Some(Slab { axis: 2, low: z0, high: z1, surface: 1 }),
            bounds: Aabb::new(low, high),
            surfaces: CAPPED,
        }))
    }),
    examples: &[
        &[&[1.0, 2.0, 3.0], &[-1.0], &[2.0]],
        &[&[1.0, 1.0, 1.0], &[-5.0], &[0.25]],
        &[&[2.0, 0.5, 1.0], &[0.5], &[0.75]],
    ],
};

constructors! {
    ellipsoid_section:
    /// The part from z0 to z1 of the ellipsoid around the origin with its semi-axes along x, y and z.
    fn ellipsoid_section(semi_axes: vector, z0: number, z1: number);
}
