//! A chain of hollow cones around the z axis, wholly or between two angles.

use super::{Build, Kind, Param, constructors, profile, revolved};

pub(super) static KIND: Kind = Kind {
    name: "polycone",
    summary: "a chain of hollow cones around the z axis: two radii at each of several planes across it",
    interior: "rmin(z)^2 < x^2 + y^2 < rmax(z)^2, with both radii linear in z between the planes, a sector of dphi degrees about z that begins at the angle phi0",
    params: &[
        Param::rows(
            "planes",
            &["z", "rmin", "rmax"],
            2,
            "the radii at planes of ascending or descending z; two planes at one z are a step",
        ),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(|p| revolved::parts("planes", &profile::of_planes(&p.rows("planes")?)?, p)),
    examples: &[
        &[&[-1.0, 0.5, 1.0, 0.0, 0.25, 2.0, 1.5, 1.0, 1.5]],
        // A solid one with apexes, steps and a sector.
        &[
            &[2.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.5, -1.0, 0.0, 0.5, -1.0, 0.0, 2.0, -2.0, 0.0, 0.0],
            &[45.0],
            &[200.0],
        ],
        // A bore with a step; a wall that closes.
        &[&[0.0, 0.5, 2.0, 1.0, 0.5, 2.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.5, 2.5, 1.25, 1.25], &[0.0], &[90.0]],
    ],
};

constructors! {
    polycone:
    /// The chain of hollow cones around the z axis with these planes, each of them z, rmin and rmax.
    fn polycone(planes: rows3);
    /// The part of it between two angles: it begins at phi0, in degrees from the x axis towards the y axis, and takes the angle
    /// dphi, above 0 and at most 360.
    fn polycone_section(planes: rows3, phi0: number, dphi: number);
}
