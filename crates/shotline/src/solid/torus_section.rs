//! A sector of a hollow torus around the z axis.

use super::parts::Parts;
use super::sector::Sector;
use super::torus::Torus;
use super::{Build, Kind, Param, ParamError, Params, constructors};

pub(super) static KIND: Kind = Kind {
    name: "torus_section",
    summary: "the part of a hollow torus around the z axis that lies between two angles about it",
    interior: "rmin^2 < (sqrt(x^2 + y^2) - R)^2 + z^2 < rmax^2, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::length("R", "the radius of the circle inside the tube, at least rmax"),
        Param::length("rmin", "the inner radius of the tube; 0 for a solid torus"),
        Param::length("rmax", "the outer radius of the tube, above rmin"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[&[1.0], &[0.25], &[0.5]],
        &[&[1.0], &[0.0], &[0.5], &[30.0], &[120.0]],
        &[&[2.0], &[0.5], &[0.75], &[-60.0], &[300.0]],
    ],
};

constructors! {
    torus_section:
    /// The hollow torus around the z axis: R is the radius of the circle inside the tube, which has two radii.
    fn hollow_torus(R: number, rmin: number, rmax: number);
    /// The part of a hollow torus between two angles: it begins at phi0, in degrees from the x axis towards the y axis, and takes
    /// the angle dphi, above 0 and at most 360.
    fn torus_section(R: number, rmin: number, rmax: number, phi0: number, dphi: number);
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let rmin = p.not_negative("rmin")?;
    let (_, rmax) = p.ascending("rmin", "rmax")?;
    // In a spindle torus the tube would overlap itself, and the inner one would not be inside the outer one.
    let major = p.at_least("R", rmax, "rmax")?;
    let outer = Parts::named(Torus::new(major, rmax)?, &["outer"]);
    let inner = if rmin > 0.0 { Some(Parts::named(Torus::new(major, rmin)?, &["inner"])) } else { None };
    let sector = Sector::of(p)?.map(|sector| sector.parts());
    Ok(outer.within(sector).without(inner))
}
