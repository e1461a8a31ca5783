//! The hyperboloid of two sheets around the z axis, closed by caps.

use std::sync::Arc;

use super::capped::Capped;
use super::{Build, Kind, Param, ParamError, constructors, hyperboloid};

pub(super) static KIND: Kind = Kind {
    name: "hyperboloid2",
    summary: "the hyperboloid of two sheets z^2/c^2 - (x^2+y^2)/a^2 > 1, from z0 to z1",
    interior: "z^2 / c^2 - (x^2 + y^2) / a^2 > 1, z0 < z < z1",
    params: &[
        Param::length("a", "the radius at z^2 = 2 c^2, positive"),
        Param::length("c", "the height of the vertices, positive"),
        Param::length("z0", "the lower end; below -c to take in the lower sheet"),
        Param::length("z1", "the upper end, above z0; above c to take in the upper sheet"),
    ],
    build: Build::Solid(|p| {
        let (a, c) = (p.positive("a")?, p.positive("c")?);
        let (z0, z1) = p.ascending("z0", "z1")?;
        if -c <= z0 && z1 <= c {
            return Err(ParamError {
                param: "z1",
                why: format!("is {z1}, but one of z0 < {} and z1 > {c} is needed to reach a sheet", -c),
            });
        }
        let reach = z0.abs().max(z1.abs()) / c;
        let widest = a * ((reach - 1.0) * (reach + 1.0)).sqrt();
        let mut solid = Capped::between(hyperboloid::form(a, c, -1.0), z0, z1, widest);
        // If only one sheet is included, the box begins at its vertex.
        if z0 >= -c {
            solid.bounds.min.z = z0.max(c);
        }
        if z1 <= c {
            solid.bounds.max.z = z1.min(-c);
        }
        solid.bounds = solid.bounds.widened(16.0);
        Ok(Arc::new(solid))
    }),
    examples: &[
        &[&[1.0], &[1.0], &[-3.0], &[3.0]],
        &[&[0.5], &[0.2], &[0.0], &[2.0]],
        &[&[3.0], &[0.01], &[-1.0], &[0.005]],
    ],
};

constructors! {
    hyperboloid2:
    /// The hyperboloid of two sheets `z^2/c^2 - (x^2+y^2)/a^2 > 1`, from z0 to z1; at least one of the ends lies
    /// beyond a vertex, at -c or c.
    fn hyperboloid2(a: number, c: number, z0: number, z1: number);
}
