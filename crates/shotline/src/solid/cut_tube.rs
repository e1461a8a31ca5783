//! A sector of a tube around the z axis whose ends are cut at an angle.

use super::capped::Capped;
use super::form::Form;
use super::parts::Parts;
use super::sector::Sector;
use super::{Build, Kind, Param, ParamError, Params, constructors, cylinder, halfspace};
use crate::aabb::Aabb;
use crate::math::Vec3;

pub(super) static KIND: Kind = Kind {
    name: "cut_tube",
    summary: "the part of a tube around the z axis between two planes, which may be tilted",
    interior: "rmin^2 < x^2 + y^2 < rmax^2, behind the planes through (0, 0, z0) and (0, 0, z1) with the normals normal0 and normal1, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::length("rmin", "the inner radius; 0 for a solid cylinder"),
        Param::length("rmax", "the outer radius, above rmin"),
        Param::length("z0", "where the lower plane meets the z axis"),
        Param::length("z1", "where the upper plane meets it, above z0"),
        Param::direction("normal0", "the outward normal of the lower plane; its z is negative"),
        Param::direction("normal1", "the outward normal of the upper plane; its z is positive"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.5], &[1.0], &[-1.0], &[1.0], &[0.0, 0.0, -1.0], &[0.5, 0.0, 1.0]],
        &[&[0.0], &[1.0], &[-2.0], &[2.0], &[0.25, -0.5, -1.0], &[0.0, 0.75, 0.5], &[45.0], &[200.0]],
    ],
};

constructors! {
    cut_tube:
    /// The part of a tube around the z axis between two planes through (0, 0, z0) and (0, 0, z1), given by their outward normals.
    fn cut_tube(rmin: number, rmax: number, z0: number, z1: number, normal0: vector, normal1: vector);
    /// The part of it between two angles: it begins at phi0, in degrees from the x axis towards the y axis, and takes the angle
    /// dphi, above 0 and at most 360.
    fn cut_tube_sector(
        rmin: number,
        rmax: number,
        z0: number,
        z1: number,
        normal0: vector,
        normal1: vector,
        phi0: number,
        dphi: number
    );
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rmin = p.not_negative("rmin")?;
    let (_, rmax) = p.ascending("rmin", "rmax")?;
    let (z0, z1) = p.ascending("z0", "z1")?;
    let (low, high) = (p.vector("normal0")?, p.vector("normal1")?);
    for (param, normal, side, is) in [("normal0", low, -1.0, "negative"), ("normal1", high, 1.0, "positive")]
    {
        if normal.z * side <= 0.0 {
            let why = format!("is {normal}, but its z must be {is}");
            return Err(ParamError { param, why });
        }
    }
    let across = Vec3::new(rmax, rmax, f64::INFINITY);
    let wall = |radius: f64, bounds: Aabb, surfaces| {
        Parts::of(Capped::whole(cylinder::form(radius), bounds, surfaces))
    };
    let end = |normal: Vec3, z: f64, surfaces| {
        // About a point of the plane, so that its offset from the origin is not rounded.
        let plane = Form { centre: Vec3::new(0.0, 0.0, z), ..halfspace::form(normal, 0.0) };
        Parts::of(Capped::whole(plane, halfspace::bounds(normal, normal.z * z), surfaces))
    };
    let mut around = vec![end(low, z0, &["bottom"]), end(high, z1, &["top"])];
    around.extend(Sector::of(p)?.map(|sector| sector.parts()));
    let inner = (rmin > 0.0).then(|| wall(rmin, Aabb::EVERYTHING, &["inner"]));
    Ok(wall(rmax, Aabb::new(-across, across), &["outer"]).within(around).without(inner))
}
