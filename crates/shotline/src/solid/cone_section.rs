//! A sector of a hollow cone around the z axis.

use super::capped::Capped;
use super::form::Form;
use super::parts::Parts;
use super::sector::Sector;
use super::{Build, Kind, Param, ParamError, Params, cone, constructors, cylinder};
use crate::aabb::Aabb;

pub(super) static KIND: Kind = Kind {
    name: "cone_section",
    summary: "the part of a hollow cone around the z axis that lies between two angles about it",
    interior: "rmin(z)^2 < x^2 + y^2 < rmax(z)^2, z0 < z < z1, with both radii linear in z, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::length("rmin0", "the inner radius at z0; 0 for an apex, or with rmin1 = 0 for a solid cone"),
        Param::length("rmax0", "the outer radius at z0, at least rmin0"),
        Param::length("rmin1", "the inner radius at z1"),
        Param::length("rmax1", "the outer radius at z1, at least rmin1; above it at one of the ends"),
        Param::length("z0", "the lower end"),
        Param::length("z1", "the upper end, above z0"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[0.5], &[1.0], &[0.75], &[1.5], &[-1.0], &[1.0]],
        &[&[0.0], &[1.0], &[0.0], &[0.5], &[0.0], &[2.0], &[30.0], &[100.0]],
        &[&[0.25], &[0.5], &[0.0], &[1.0], &[-0.5], &[0.5], &[-45.0], &[270.0]],
        &[&[0.5], &[1.0], &[0.5], &[2.0], &[1.0], &[1.5], &[0.0], &[180.0]],
        &[&[0.0], &[0.0], &[0.5], &[1.0], &[-1.0], &[1.0]],
    ],
};

constructors! {
    cone_section:
    /// The hollow cone around the z axis, of radii rmin0 and rmax0 at z0, and rmin1 and rmax1 at z1.
    fn hollow_cone(rmin0: number, rmax0: number, rmin1: number, rmax1: number, z0: number, z1: number);
    /// The part of a hollow cone between two angles: it begins at phi0, in degrees from the x axis towards the y axis, and
    /// takes the angle dphi, above 0 and at most 360.
    fn cone_section(
        rmin0: number,
        rmax0: number,
        rmin1: number,
        rmax1: number,
        z0: number,
        z1: number,
        phi0: number,
        dphi: number
    );
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let [rmin0, rmin1] = [p.not_negative("rmin0")?, p.not_negative("rmin1")?];
    let [rmax0, rmax1] = [p.at_least("rmax0", rmin0, "rmin0")?, p.at_least("rmax1", rmin1, "rmin1")?];
    if rmin0 == rmax0 && rmin1 == rmax1 {
        let why = format!("is {rmax1} like rmin1, and rmax0 like rmin0, but one must be greater");
        return Err(ParamError { param: "rmax1", why });
    }
    let (z0, z1) = p.ascending("z0", "z1")?;
    let outer = Capped::between(form(rmax0, rmax1, z0, z1), z0, z1, rmax0.max(rmax1));
    let outer = Parts::named(outer, &["outer", "bottom", "top"]);
    // Between the caps the inner cone has one nappe.
    let inner = (rmin0 > 0.0 || rmin1 > 0.0)
        .then(|| Parts::of(Capped::whole(form(rmin0, rmin1, z0, z1), Aabb::EVERYTHING, &["inner"])));
    let sector = Sector::of(p)?.map(|sector| sector.parts());
    Ok(outer.within(sector).without(inner))
}

fn form(r0: f64, r1: f64, z0: f64, z1: f64) -> Form {
    if r0 == r1 { cylinder::form(r0) } else { cone::form(r0, r1, z0, z1) }
}
