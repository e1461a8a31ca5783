//! The torus around the z axis.

mod approach;
#[cfg(test)]
mod oracle;
#[cfg(test)]
mod quick_tests;
mod search;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;
use std::sync::Arc;

use super::lanes::InLanes;
use super::{Build, Kind, Moments, Param, ParamError, Solid, constructors, ring};
use crate::aabb::Aabb;
use crate::crossing::Crossing;
use crate::math::Vec3;
use crate::ray::Line;

/// `(sqrt(x^2 + y^2) - R)^2 + z^2 < r^2`, a ring around the z axis.
///
/// `r = R` gives a horn torus and `r > R` a spindle torus, a body without a hole. The lemon in which a spindle
/// torus overlaps itself is part of the interior, and its boundary is not a surface.
///
/// The number of crossings is certain, except for tangents within rounding, for `r / R` down to about 1e-10.
#[derive(Clone, Debug)]
pub struct Torus {
    major: f64,
    minor: f64,
    /// Whether the quick path takes it.
    is_quick: bool,
}

pub(super) static KIND: Kind = Kind {
    name: "torus",
    summary: "the torus around the z axis; with r > R the inner lemon is inside, not a surface",
    interior: "(sqrt(x^2 + y^2) - R)^2 + z^2 < r^2",
    params: &[
        Param::length("R", "the radius of the circle inside the tube, positive"),
        Param::length("r", "the radius of the tube, positive"),
    ],
    build: Build::Solid(|p| Ok(Arc::new(Torus::new(p.positive("R")?, p.positive("r")?)?))),
    examples: &[
        &[&[1.0], &[0.3]],
        &[&[1.0], &[1e-4]],
        &[&[1.0], &[0.95]],
        &[&[1.0], &[1.0]],
        &[&[0.5], &[1.25]],
        &[&[3e-7], &[1e-7]],
        &[&[4e8], &[1e8]],
    ],
};

constructors! {
    torus:
    /// The torus around the z axis: R is the radius of the circle inside the tube, r the radius of the tube. With r > R
    /// the inner lemon is inside, not a surface.
    fn torus(R: number, r: number);
}

impl Torus {
    /// Creates a torus from the radius `R` of the circle inside the tube and the radius `r` of the tube.
    ///
    /// # Errors
    /// [`ParamError`] unless both radii are positive and finite, and their sum is finite.
    pub fn new(major: f64, minor: f64) -> Result<Torus, ParamError> {
        for (param, x) in [("R", major), ("r", minor)] {
            if !(x > 0.0 && x.is_finite()) {
                return Err(ParamError { param, why: format!("is {x}, but must be positive and finite") });
            }
        }
        if !(major + minor).is_finite() {
            return Err(ParamError { param: "R", why: "plus r is more than the largest number".into() });
        }
        Ok(Torus { major, minor, is_quick: ring::takes(major, minor) })
    }

    /// The radius `R` of the circle inside the tube and the radius `r` of the tube.
    pub fn radii(&self) -> (f64, f64) {
        (self.major, self.minor)
    }

    /// The distance from the circle inside the tube.
    fn distance_from_circle(&self, p: Vec3) -> f64 {
        libm::hypot(libm::hypot(p.x, p.y) - self.major, p.z)
    }
}

impl Solid for Torus {
    fn bounds(&self) -> Aabb {
        let reach = self.major + self.minor;
        let corner = Vec3::new(reach, reach, self.minor);
        Aabb::new(-corner, corner).widened(1.0)
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        if !(self.is_quick && ring::crossings(self.major, self.minor, line, out)) {
            search::crossings(self.major, self.minor, line, out);
        }
    }

    /// `(sqrt(x^2 + y^2) - R)^2 + z^2 - r^2`.
    fn implicit(&self, p: Vec3, _surface: u32, _primitive: u32) -> f64 {
        let distance = self.distance_from_circle(p);
        (distance - self.minor) * (distance + self.minor)
    }

    /// The vector from the nearest point of the circle inside the tube, scaled. At the tips of a spindle, along
    /// the axis.
    fn normal(&self, p: Vec3, _surface: u32, _primitive: u32) -> Vec3 {
        Vec3::from(ring::normals(self.major, p.to_array()))
    }

    fn in_lanes(&self) -> Option<InLanes<'_>> {
        self.is_quick.then(|| InLanes::ring(self.major, self.minor))
    }

    fn contains(&self, p: Vec3) -> bool {
        self.distance_from_circle(p) < self.minor
    }

    /// By Pappus's theorem. `None` for a spindle, whose lemon the formula would count twice.
    fn moments(&self) -> Option<Moments> {
        let (major2, minor2) = (self.major * self.major, self.minor * self.minor);
        let across = 0.5 * major2 + 0.375 * minor2;
        let volume = 2.0 * PI * PI * self.major * minor2;
        (self.minor <= self.major)
            .then(|| Moments::along_axes(volume, Vec3::ZERO, Vec3::new(across, across, 0.25 * minor2)))
    }

    fn surfaces(&self) -> &'static [&'static str] {
        &["torus"]
    }
}
