//! A sector of a spherical shell around the origin, cut by angles about the z axis and from it.

use super::capped::Capped;
use super::halfspace;
use super::parts::Parts;
use super::sector::Sector;
use super::{Build, Kind, Param, ParamError, Params, constructors, hyperboloid_shell, sphere};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, sin_cos_degrees_wide};

pub(super) static KIND: Kind = Kind {
    name: "sphere_section",
    summary: "the part of a spherical shell around the origin that lies between angles about the z axis and from it",
    interior: "rmin^2 < x^2 + y^2 + z^2 < rmax^2, a sector of dphi degrees about z that begins at the angle phi0, and of dtheta degrees from the z axis that begins at the angle theta0",
    params: &[
        Param::length("rmin", "the inner radius; 0 for a solid sphere"),
        Param::length("rmax", "the outer radius, above rmin"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes about z, in degrees, above 0 and at most 360")
            .or(&[360.0]),
        Param::angle("theta0", "where it begins, in degrees from the z axis").or(&[0.0]),
        Param::angle(
            "dtheta",
            "the angle that it takes from the z axis, in degrees; theta0 + dtheta is at most 180",
        )
        .or(&[180.0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.5], &[1.0]],
        &[&[0.0], &[1.0], &[20.0], &[100.0]],
        &[&[0.25], &[1.0], &[0.0], &[360.0], &[30.0], &[45.0]],
        &[&[0.5], &[1.5], &[-30.0], &[240.0], &[60.0], &[90.0]],
        &[&[0.0], &[2.0], &[0.0], &[360.0], &[90.0], &[90.0]],
        &[&[0.75], &[1.0], &[0.0], &[360.0], &[120.0], &[60.0]],
    ],
};

constructors! {
    sphere_section:
    /// The spherical shell around the origin between two radii.
    fn spherical_shell(rmin: number, rmax: number);
    /// The part of a spherical shell between angles, in degrees: it begins at phi0 from the x axis towards the y axis, and takes
    /// the angle dphi; it begins at theta0 from the z axis, and takes the angle dtheta.
    fn sphere_section(rmin: number, rmax: number, phi0: number, dphi: number, theta0: number, dtheta: number);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rmin = p.not_negative("rmin")?;
    let (_, rmax) = p.ascending("rmin", "rmax")?;
    let (theta0, dtheta) = (p.not_negative("theta0")?, p.positive("dtheta")?);
    let theta1 = theta0 + dtheta;
    if theta1 > 180.0 {
        let why = format!("is {dtheta}, but with theta0 = {theta0} it must be at most {}", 180.0 - theta0);
        return Err(ParamError { param: "dtheta", why });
    }
    let ball = |radius: f64, surfaces| {
        let bounds = Aabb::new(Vec3::splat(-radius), Vec3::splat(radius));
        Parts::of(Capped::whole(sphere::form(radius), bounds, surfaces))
    };
    let (mut kept, mut cut) = (Vec::new(), Vec::new());
    kept.extend(Sector::of(p)?.map(|sector| sector.parts()));
    cut.extend((rmin > 0.0).then(|| ball(rmin, &["inner"])));
    let (first, angle) = (sin_cos_degrees_wide(theta0), sin_cos_degrees_wide(dtheta));
    // The sum of two angles, without rounding it.
    let last = [first.0 * angle.1 + first.1 * angle.0, first.1 * angle.1 - first.0 * angle.0];
    match cone_at([first.0, first.1], rmax, NEAR) {
        Cone::None => {}
        Cone::Plane => kept.push(half(Vec3::Z, NEAR)),
        Cone::Upper(cone) => cut.push(cone),
        Cone::Lower(cone) => kept.push(cone),
    }
    match cone_at(last, rmax, FAR) {
        Cone::None => {}
        Cone::Plane => kept.push(half(Vec3::NEG_Z, FAR)),
        Cone::Upper(cone) => kept.push(cone),
        Cone::Lower(cone) => cut.push(cone),
    }
    Ok(ball(rmax, &["outer"]).within(kept).without(cut))
}

/// The names of the surfaces at the first and the last angle from the z axis: of a side, and of two caps, which are at the
/// apex and outside the sphere.
const NEAR: &[&str] = &["near", "near", "near"];
const FAR: &[&str] = &["far", "far", "far"];

/// Sines and cosines below this are 0 but for their rounding.
const NO_ANGLE: f64 = 1e-30;

/// The cone of an angle from the z axis, around the half of the axis that is nearer to it.
enum Cone {
    /// The angle is 0 or 180 degrees.
    None,
    /// It is 90 degrees.
    Plane,
    Upper(Parts),
    Lower(Parts),
}

/// The cone at an angle from the z axis, given by its sine and cosine.
fn cone_at([s, c]: [Dd; 2], rmax: f64, surfaces: &'static [&'static str]) -> Cone {
    if s.hi.abs() < NO_ANGLE {
        return Cone::None;
    }
    if c.hi.abs() < NO_ANGLE {
        return Cone::Plane;
    }
    let tangent = s * c.recip();
    let tangent = if c.hi > 0.0 { tangent } else { -tangent };
    let height = 2.0 * rmax;
    let nappe = |z0: f64, z1: f64| {
        let cone = hyperboloid_shell::form(0.0, tangent);
        Parts::named(Capped::between(cone, z0, z1, tangent.hi * height * 1.5), surfaces)
    };
    if c.hi > 0.0 { Cone::Upper(nappe(0.0, height)) } else { Cone::Lower(nappe(-height, 0.0)) }
}

/// The half-space behind the plane through the centre with a normal.
fn half(normal: Vec3, surfaces: &'static [&'static str]) -> Parts {
    Parts::named(
        Capped::whole(halfspace::form(normal, 0.0), halfspace::bounds(normal, 0.0), &["plane"]),
        surfaces,
    )
}
