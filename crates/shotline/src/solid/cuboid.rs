//! The axis-aligned box.

use std::sync::Arc;

use super::interval::{Interval, Slab};
use super::lanes::InLanes;
use super::{Build, Kind, Moments, Param, ParamError, Solid, constructors};
use crate::aabb::Aabb;
use crate::contact::{Contact, Sector, Sheet};
use crate::crossing::Crossing;
use crate::math::{Plane, Vec3};
use crate::ray::Line;
use crate::scratch::Scratch;

/// `min < p < max`: the intersection of three slabs.
#[derive(Debug)]
pub struct Cuboid {
    min: Vec3,
    max: Vec3,
}

pub(super) static KIND: Kind = Kind {
    name: "box",
    summary: "the box between two corners, along the axes",
    interior: "min < p < max",
    params: &[
        Param::lengths("min", "the lowest corner"),
        Param::lengths("max", "the highest corner, above min on every axis"),
    ],
    build: Build::Solid(|p| {
        let (min, max) = (p.vector("min")?, p.vector("max")?);
        if !min.cmplt(max).all() {
            let why = format!("is {max}, but must be greater than min = {min} on every axis");
            return Err(ParamError { param: "max", why });
        }
        Ok(Arc::new(Cuboid { min, max }))
    }),
    examples: &[
        &[&[-1.0, -1.0, -1.0], &[1.0, 1.0, 1.0]],
        &[&[0.1, -2.0, 3.0], &[0.7, 5.0, 3.001]],
        &[&[-0.5, 0.25, -1.0], &[-0.499999, 0.3, 1e3]],
    ],
};

constructors! {
    cuboid:
    /// The box between its lowest and its highest corner, along the axes: the kind `box`.
    fn cuboid(min: vector, max: vector);
}

impl Cuboid {
    fn slabs(&self) -> [Slab; 3] {
        [0, 1, 2].map(|axis| Slab::of_box(&self.min, &self.max, axis))
    }

    fn interval(&self, line: &Line) -> Option<Interval> {
        let [x, y, z] = self.slabs().map(|slab| slab.interval(line));
        x?.clip(y?)?.clip(z?)
    }
}

/// Returns the contact with the faces that contain the line, from its intervals and faces in the three slabs.
fn contact(slabs: [Option<(Interval, Option<Vec3>)>; 3], d: Vec3) -> Option<Contact> {
    let mut interval = Interval::ALL;
    let mut faces = Vec::new();
    for slab in slabs {
        let (between, face) = slab?;
        interval = interval.clip(between)?;
        faces.extend(face.map(Sheet::plane));
    }
    Some(interval.contact(Sector::behind(&faces, d)?))
}

impl Solid for Cuboid {
    fn bounds(&self) -> Aabb {
        Aabb::new(self.min, self.max)
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        if let Some(interval) = self.interval(line) {
            interval.push(out);
        }
    }

    fn contacts(&self, line: &Line, out: &mut Vec<Contact>, _scratch: &mut Scratch) {
        let slabs = self.slabs();
        if slabs.iter().any(|slab| slab.is_parallel(line)) {
            out.extend(contact(slabs.map(|slab| slab.closed_interval(line)), line.d));
        }
    }

    fn implicit(&self, p: Vec3, surface: u32, _primitive: u32) -> f64 {
        let axis = surface as usize / 2;
        if surface.is_multiple_of(2) { self.min[axis] - p[axis] } else { p[axis] - self.max[axis] }
    }

    fn normal(&self, _p: Vec3, surface: u32, _primitive: u32) -> Vec3 {
        let side = if surface.is_multiple_of(2) { -1.0 } else { 1.0 };
        Vec3::AXES[surface as usize / 2] * side
    }

    fn contains(&self, p: Vec3) -> bool {
        self.min.cmplt(p).all() && p.cmplt(self.max).all()
    }

    fn in_lanes(&self) -> Option<InLanes<'_>> {
        Some(InLanes::cuboid(&self.min, &self.max))
    }

    fn half_spaces(&self) -> Option<Vec<Plane>> {
        let pair =
            |i: usize| [Plane::new(Vec3::AXES[i], -self.max[i]), Plane::new(-Vec3::AXES[i], self.min[i])];
        Some((0..3).flat_map(pair).collect())
    }

    fn moments(&self) -> Option<Moments> {
        let size = self.max - self.min;
        Some(Moments::along_axes(size.element_product(), self.bounds().centre(), size * size / 12.0))
    }

    fn surfaces(&self) -> &'static [&'static str] {
        &["min x", "max x", "min y", "max y", "min z", "max z"]
    }
}
