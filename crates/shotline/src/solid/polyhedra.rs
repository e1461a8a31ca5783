//! A chain of hollow pyramids around the z axis: a polygon of sides instead of each circle of a polycone.

use super::faces::Faces;
use super::parts::Parts;
use super::{Build, Kind, Param, ParamError, Params, constructors, profile};
use crate::math::{Vec3, sin_cos_degrees_wide};
use crate::polygon::{Ring, triangulate};

pub(super) static KIND: Kind = Kind {
    name: "polyhedra",
    summary: "a chain of hollow pyramids around the z axis: the distances of the sides from it at each of several planes across it",
    interior: "a polycone of which each circle is a polygon of so many sides around it, with the first corner at the angle phi0",
    params: &[
        Param::rows(
            "planes",
            &["z", "rmin", "rmax"],
            2,
            "the distances of the inner and the outer sides from the axis at planes of ascending or descending z; two planes at one z are a step",
        ),
        Param::count("sides", "the number of flat sides within the angle dphi, each below 180 degrees"),
        Param::angle("phi0", "where the part begins, in degrees from the x axis towards the y axis")
            .or(&[0.0]),
        Param::angle("dphi", "the angle that it takes, in degrees, above 0 and at most 360").or(&[360.0]),
    ],
    build: Build::Parts(|p| {
        let turn = Turn::of(p)?;
        turn.solid("planes", &profile::of_planes(&p.rows("planes")?)?, turn.corner_per_side())
    }),
    examples: &[
        &[&[-1.0, 0.5, 1.0, 0.0, 0.25, 2.0, 1.5, 1.0, 1.5], &[6.0]],
        &[&[-1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0], &[5.0], &[10.0], &[250.0]],
        &[&[2.0, 0.5, 2.0, 0.0, 0.5, 2.0, 0.0, 1.0, 2.0, -1.0, 1.0, 1.0], &[1.0], &[-40.0], &[80.0]],
    ],
};

constructors! {
    polyhedra:
    /// The chain of hollow pyramids around the z axis with these planes, each of them z and the distances of the inner and the
    /// outer sides from the axis.
    fn polyhedra(planes: rows3, sides: number);
    /// The part of it between two angles, which the sides divide: it begins at phi0, in degrees from the x axis towards the y
    /// axis, and takes the angle dphi, above 0 and at most 360.
    fn polyhedra_section(planes: rows3, sides: number, phi0: number, dphi: number);
}

/// At most this many sides are accepted, far more than anyone needs.
const MAX_SIDES: f64 = 65536.0;
/// At most this many vertices are accepted.
const MAX_VERTICES: usize = 1 << 24;

/// A turn about the z axis in equal steps.
pub(super) struct Turn {
    phi0: f64,
    dphi: f64,
    sides: usize,
}

impl Turn {
    /// The turn of the parameters `phi0`, `dphi` and `sides`.
    pub fn of(p: &Params) -> Result<Turn, ParamError> {
        let (phi0, dphi, sides) = (p.number("phi0")? % 360.0, p.number("dphi")?, p.number("sides")?);
        let error = |param, why| Err(ParamError { param, why });
        if !(dphi > 0.0 && dphi <= 360.0) {
            return error("dphi", format!("is {dphi}, but must be above 0 and at most 360"));
        }
        if !(1.0..=MAX_SIDES).contains(&sides) || sides.fract() != 0.0 {
            return error("sides", format!("is {sides}, but must be a whole number from 1 to {MAX_SIDES}"));
        }
        if dphi / sides >= 180.0 {
            let least = (dphi / 180.0).floor() + 1.0;
            return error("sides", format!("is {sides}, but must be at least {least} for dphi = {dphi}"));
        }
        Ok(Turn { phi0, dphi, sides: sides as usize })
    }

    /// How much further than its middle a corner of a side is from the axis.
    fn corner_per_side(&self) -> f64 {
        let (_, cos) = sin_cos_degrees_wide(self.dphi / (2 * self.sides) as f64);
        cos.recip().hi
    }

    /// The solid with the polygons of a parameter at the corners of the turn. The distances of their corners from the axis are
    /// multiplied by a factor.
    pub fn solid(&self, param: &'static str, rings: &[Ring], factor: f64) -> Result<Parts, ParamError> {
        let corners: usize = rings.iter().map(|ring| ring.corners.len()).sum();
        if corners.saturating_mul(self.sides + 1) > MAX_VERTICES {
            let why = format!("have {corners} corners, too many with {} sides: use fewer sides", self.sides);
            return Err(ParamError { param, why });
        }
        let directions = self.directions();
        let mut faces = Faces::default();
        rings.iter().for_each(|ring| self.add(ring, factor, &directions, &mut faces));
        faces.finish(param)
    }

    /// Whether it ends where it began.
    fn is_whole(&self) -> bool {
        self.dphi == 360.0
    }

    /// The directions of the corners.
    fn directions(&self) -> Vec<[f64; 2]> {
        let direction = |step: usize| {
            let (s, c) = sin_cos_degrees_wide(self.phi0 + self.dphi * step as f64 / self.sides as f64);
            [c.hi, s.hi]
        };
        (0..if self.is_whole() { self.sides } else { self.sides + 1 }).map(direction).collect()
    }

    /// Adds the faces of one polygon.
    fn add(&self, ring: &Ring, factor: f64, directions: &[[f64; 2]], faces: &mut Faces) {
        let corners: Vec<Vec<u32>> = ring
            .corners
            .iter()
            .map(|[r, z]| {
                // A corner on the axis stays where it is.
                let turned = if *r == 0.0 { &directions[..1] } else { directions };
                let vertex = |[c, s]: &[f64; 2]| faces.vertex(Vec3::new(r * factor * c, r * factor * s, *z));
                turned.iter().map(vertex).collect()
            })
            .collect();
        let at = |corner: usize, step: usize| {
            let turned = &corners[corner % corners.len()];
            turned[step % turned.len()]
        };
        for edge in 0..corners.len() {
            for step in 0..self.sides {
                faces.add(&[at(edge, step), at(edge, step + 1), at(edge + 1, step + 1), at(edge + 1, step)]);
            }
        }
        if self.is_whole() {
            return;
        }
        let flat: Vec<Vec3> = ring.corners.iter().map(|[r, z]| Vec3::new(*r, *z, 0.0)).collect();
        let cut = triangulate(&flat).triangles;
        faces.add_triangles(cut.iter().map(|face| face.map(|i| at(i as usize, 0))));
        faces.add_triangles(cut.iter().map(|[a, b, c]| [*a, *c, *b].map(|i| at(i as usize, self.sides))));
    }
}
