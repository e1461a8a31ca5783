//! A polygon turned about the z axis in flat sides.

use super::polyhedra::Turn;
use super::{Build, Kind, Param, constructors, profile};

pub(super) static KIND: Kind = Kind {
    name: "generic_polyhedra",
    summary: "a polygon turned about the z axis in flat sides, wholly or by an angle",
    interior: "between copies of the polygon at equal angles about z, the first at the angle phi0, joined by flat faces",
    params: &[
        Param::rows(
            "points",
            &["r", "z"],
            3,
            "the corners of the polygon, in either direction: the distance from the axis, and z",
        ),
        Param::count("sides", "the number of flat sides within the angle dphi, each below 180 degrees"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(|p| Turn::of(p)?.solid("points", &[profile::of_corners(&p.rows("points")?)?], 1.0)),
    examples: &[
        &[&[1.0, -1.0, 2.0, 0.0, 1.5, 1.0], &[8.0]],
        &[&[0.0, 0.0, 2.0, 0.0, 2.0, 0.5, 0.5, 1.0, 0.0, 2.0], &[3.0], &[20.0], &[250.0]],
        &[
            &[0.5, -1.0, 2.0, -1.5, 1.5, 0.0, 2.0, 1.0, 1.0, 0.5, 0.25, 2.0, 0.75, 0.25],
            &[4.0],
            &[-30.0],
            &[130.0],
        ],
    ],
};

constructors! {
    generic_polyhedra:
    /// The polygon with these corners turned about the z axis in so many flat sides. Each corner is its distance from the axis,
    /// and its z.
    fn generic_polyhedra(points: rows2, sides: number);
    /// The polygon turned by an angle, which the sides divide: it begins at phi0, in degrees from the x axis towards the y axis,
    /// and takes the angle dphi, above 0 and at most 360.
    fn generic_polyhedra_section(points: rows2, sides: number, phi0: number, dphi: number);
}
