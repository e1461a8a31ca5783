//! The space between two hyperboloids of one sheet around the z axis, given by their waists and stereo angles: straight lines
//! turned about the axis, as the wires of drift chambers.

use super::capped::Capped;
use super::form::{Form, squared};
use super::parts::Parts;
use super::{Build, Kind, Param, ParamError, Params, constructors, cylinder};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, power_of_two_below, sin_cos_degrees_wide, two_prod};

pub(super) static KIND: Kind = Kind {
    name: "hyperboloid_shell",
    summary: "the space between two hyperboloids of one sheet around the z axis, from z0 to z1",
    interior: "rmin^2 + (z tan(stereo_min))^2 < x^2 + y^2 < rmax^2 + (z tan(stereo_max))^2, z0 < z < z1",
    params: &[
        Param::length("rmin", "the inner radius at z = 0; 0 with a stereo angle of 0 for no hole"),
        Param::length("rmax", "the outer radius at z = 0, above rmin"),
        Param::angle(
            "stereo_min",
            "the angle between the straight lines of the inner surface and the z axis, in degrees, from 0 to below 90",
        ),
        Param::angle("stereo_max", "that of the outer surface, at least stereo_min"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.5], &[1.0], &[10.0], &[20.0], &[-1.0], &[1.0]],
        &[&[0.0], &[1.0], &[0.0], &[45.0], &[-2.0], &[1.0]],
        &[&[0.0], &[0.5], &[30.0], &[30.0], &[-1.0], &[2.0]],
        &[&[0.25], &[0.5], &[0.0], &[0.0], &[-1.0], &[1.0]],
    ],
};

constructors! {
    hyperboloid_shell:
    /// The space between two hyperboloids of one sheet around the z axis, given by their radii at z = 0 and their stereo angles in
    /// degrees, from z0 to z1.
    fn hyperboloid_shell(rmin: number, rmax: number, stereo_min: number, stereo_max: number, z0: number, z1: number);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rmin = p.not_negative("rmin")?;
    let (_, rmax) = p.ascending("rmin", "rmax")?;
    let stereo_min = p.not_negative("stereo_min")?;
    let stereo_max = p.at_least("stereo_max", stereo_min, "stereo_min")?;
    if stereo_max >= 90.0 {
        let why = format!("is {stereo_max}, but must be below 90");
        return Err(ParamError { param: "stereo_max", why });
    }
    let (z0, z1) = p.ascending("z0", "z1")?;
    let widest = libm::hypot(rmax, z0.abs().max(z1.abs()) * tangent(stereo_max).hi);
    let mut outer = Capped::between(form(rmax, tangent(stereo_max)), z0, z1, widest);
    outer.bounds = outer.bounds.widened(8.0);
    let outer = Parts::named(outer, &["outer", "bottom", "top"]);
    let inner = (rmin > 0.0 || stereo_min > 0.0)
        .then(|| Parts::of(Capped::whole(form(rmin, tangent(stereo_min)), Aabb::EVERYTHING, &["inner"])));
    Ok(outer.without(inner))
}

/// The tangent of an angle in degrees.
pub(super) fn tangent(degrees: f64) -> Dd {
    let (s, c) = sin_cos_degrees_wide(degrees);
    s * c.recip()
}

/// `x^2 + y^2 - r^2 - (z tangent)^2`, up to a positive factor: a hyperboloid; a cone if `r` is 0, a cylinder if the tangent
/// is. Not both are 0.
pub(super) fn form(r: f64, tangent: Dd) -> Form {
    if tangent.hi == 0.0 {
        return cylinder::form(r);
    }
    let unit = if r > 0.0 { power_of_two_below(r) } else { 1.0 };
    let unit_z = power_of_two_below(unit / tangent.hi);
    let r = r / unit;
    Form {
        shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
        square: [Dd::ONE, Dd::ONE, -squared(tangent * (unit_z / unit))],
        constant: -two_prod(r, r),
        ..Form::ZERO
    }
}
