//! A sector of a tube around the z axis that is twisted about it: straight lines that cross the axis at an angle, turned about
//! it. Its walls are hyperboloids, and its ends in angle hyperbolic paraboloids.

use super::capped::Capped;
use super::hyperboloid_shell::{form, tangent};
use super::parts::Parts;
use super::sector::Sector;
use super::{Build, Kind, Param, ParamError, Params, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, power_of_two_below};

pub(super) static KIND: Kind = Kind {
    name: "twisted_tube",
    summary: "the part of a tube around the z axis that lies between two angles, twisted about the axis so that its edges along it stay straight",
    interior: "rmin^2 < (x^2 + y^2) / (1 + (k z)^2) < rmax^2, z0 < z < z1, a sector of dphi degrees about z that begins at the angle phi0 + atan(k z), with k = tan(twist / 2) / max(|z0|, |z1|)",
    params: &[
        Param::length("rmin", "the inner radius at z = 0; 0 for none"),
        Param::length("rmax", "the outer radius at z = 0, above rmin"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
        Param::angle(
            "twist",
            "by how much it turns from z = -h to z = h, in degrees between -180 and 180; h is the greater of |z0| and |z1|",
        ),
        Param::angle("phi0", "where the part begins at z = 0, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.5], &[1.0], &[-1.0], &[1.0], &[60.0], &[-45.0], &[90.0]],
        &[&[0.0], &[1.5], &[-2.0], &[0.5], &[-100.0], &[30.0], &[200.0]],
        &[&[0.25], &[1.0], &[-1.0], &[1.0], &[90.0]],
        &[&[0.5], &[1.0], &[0.25], &[1.0], &[0.0], &[0.0], &[120.0]],
    ],
};

constructors! {
    twisted_tube:
    /// The tube around the z axis of these radii at z = 0, between hyperboloids whose straight lines turn by the angle twist, in
    /// degrees, from z = -h to z = h, where h is the greater of |z0| and |z1|.
    fn hyperboloid_tube(rmin: number, rmax: number, z0: number, z1: number, twist: number);
    /// The part of it between two angles, which turn with the height by the same angle: at z = 0 it begins at phi0, in degrees
    /// from the x axis towards the y axis, and takes the angle dphi, above 0 and at most 360.
    fn twisted_tube(rmin: number, rmax: number, z0: number, z1: number, twist: number, phi0: number, dphi: number);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rmin = p.not_negative("rmin")?;
    let (_, rmax) = p.ascending("rmin", "rmax")?;
    let (z0, z1) = p.ascending("z0", "z1")?;
    let twist = p.number("twist")?;
    if twist.abs() >= 180.0 {
        return Err(ParamError {
            param: "twist",
            why: format!("is {twist}, but must be between -180 and 180"),
        });
    }
    let height = z0.abs().max(z1.abs());
    let at_end = tangent(0.5 * twist);
    // The tangent of the stereo angle of a wall.
    let stereo = |r: f64| {
        let wide = at_end * Dd::from(r) * Dd::from(height).recip();
        if wide.hi < 0.0 { -wide } else { wide }
    };
    let mut outer = Capped::between(form(rmax, stereo(rmax)), z0, z1, rmax * libm::hypot(1.0, at_end.hi));
    outer.bounds = outer.bounds.widened(8.0);
    let inner = (rmin > 0.0)
        .then(|| Parts::of(Capped::whole(form(rmin, stereo(rmin)), Aabb::EVERYTHING, &["inner"])));
    let units = [rmax, height].map(power_of_two_below);
    let sector = Sector::of(p)?.map(|sector| sector.twisted(at_end * Dd::from(height).recip(), units));
    Ok(Parts::named(outer, &["outer", "bottom", "top"]).within(sector).without(inner))
}
