//! The hyperboloid of one sheet around the z axis, closed by two caps.

use std::sync::Arc;

use super::capped::Capped;
use super::form::{Form, squared};
use super::{Build, Kind, Param, constructors};
use crate::math::{Dd, Vec3, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "hyperboloid",
    summary: "the hyperboloid of one sheet (x^2+y^2)/a^2 - z^2/c^2 < 1, from z0 to z1",
    interior: "(x^2 + y^2) / a^2 - z^2 / c^2 < 1, z0 < z < z1",
    params: &[
        Param::length("a", "the radius of the waist at z = 0, positive"),
        Param::length("c", "the height at which z^2/c^2 is 1, positive"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Solid(|p| {
        let (a, c) = (p.positive("a")?, p.positive("c")?);
        let (z0, z1) = p.ascending("z0", "z1")?;
        let widest = a * (1.0f64).hypot(z0.abs().max(z1.abs()) / c);
        let mut solid = Capped::between(form(a, c, 1.0), z0, z1, widest);
        solid.bounds = solid.bounds.widened(8.0);
        Ok(Arc::new(solid))
    }),
    examples: &[
        &[&[1.0], &[1.0], &[-1.0], &[1.0]],
        &[&[0.16], &[1.6], &[-0.3], &[3.0]],
        &[&[0.6], &[0.01], &[-3.0], &[0.6]],
        &[&[0.2], &[0.3], &[1.0], &[2.0]],
    ],
};

constructors! {
    hyperboloid:
    /// The hyperboloid of one sheet `(x^2+y^2)/a^2 - z^2/c^2 < 1`, from z0 to z1.
    fn hyperboloid(a: number, c: number, z0: number, z1: number);
}

/// `side ((x/a)^2 + (y/a)^2 - (z/c)^2) - 1` for `side` 1, which has one sheet around the axis. For `side` -1 the
/// same with the opposite sign of the constant, `(x/a)^2 + (y/a)^2 - (z/c)^2 + 1`, which has two sheets, up and
/// down the axis.
pub(super) fn form(a: f64, c: f64, side: f64) -> Form {
    let (unit, unit_z) = (power_of_two_below(a), power_of_two_below(c));
    let inverse_square = |x: f64| squared(Dd::from(x).recip());
    let (xx, zz) = (inverse_square(a / unit), -inverse_square(c / unit_z));
    Form {
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
        square: [xx, xx, zz],
        constant: Dd::from(-side),
        ..Form::ZERO
    }
}
