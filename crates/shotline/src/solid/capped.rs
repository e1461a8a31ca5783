//! The implementation of most kinds: the interior of one quadric, optionally cut off by two planes.

use std::f64::consts::PI;

use super::form::{Form, rounded};
use super::interval::{Interval, Slab};
use super::lanes::InLanes;
use super::quadric_matrix::QuadricMatrix;
use super::{Moments, Solid, definite};
use crate::aabb::Aabb;
use crate::contact::{Contact, Sector, Sheet};
use crate::crossing::Crossing;
use crate::math::{Affine, Plane, Vec3};
use crate::ray::Line;
use crate::scratch::Scratch;

/// The surface names of a quadric between two planes. A quadric without caps has only one surface.
pub(super) const CAPPED: &[&str] = &["side", "bottom", "top"];

/// The set where a form is negative, restricted to `z0 < z < z1` if there are caps.
#[derive(Debug)]
pub(super) struct Capped {
    pub form: Form,
    pub caps: Option<Slab>,
    pub bounds: Aabb,
    pub surfaces: &'static [&'static str],
}

impl Capped {
    /// A quadric without caps.
    pub fn whole(form: Form, bounds: Aabb, surfaces: &'static [&'static str]) -> Capped {
        Capped { form, caps: None, bounds, surfaces }
    }

    /// A quadric around the z axis between `z0` and `z1`, of at most the given radius.
    pub fn between(form: Form, z0: f64, z1: f64, radius: f64) -> Capped {
        let bounds = Aabb::new(Vec3::new(-radius, -radius, z0), Vec3::new(radius, radius, z1));
        let caps = Some(Slab { axis: 2, low: z0, high: z1, surface: 1 });
        Capped { form, caps, bounds, surfaces: CAPPED }
    }
}

impl Solid for Capped {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        let between = match &self.caps {
            None => Some(Interval::ALL),
            Some(caps) => caps.interval(line),
        };
        let Some(between) = between else { return };
        for inside in self.form.inside(line).into_iter().flatten() {
            if let Some(interval) = inside.clip(between) {
                interval.push(out);
            }
        }
    }

    fn contacts(&self, line: &Line, out: &mut Vec<Contact>, _scratch: &mut Scratch) {
        let caps = self.caps.map_or(Some((Interval::ALL, None)), |caps| caps.closed_interval(line));
        let Some((between, cap)) = caps else { return };
        let mut push = |side: Interval, sector: Option<Sector>| {
            out.extend(side.clip(between).zip(sector).map(|(interval, sector)| interval.contact(sector)));
        };
        if let Some(sides) = self.form.sides(line) {
            sides.into_iter().for_each(|side| push(side.interval, side.sector(cap, line.d)));
        } else if let Some(cap) = cap {
            let inside = self.form.inside(line).into_iter().flatten();
            inside.for_each(|interval| push(interval, Sector::behind(&[Sheet::plane(cap)], line.d)));
        }
    }

    fn is_clear_of_surface(&self, line: &Line, from: f64, to: f64) -> bool {
        self.caps.is_none() && self.form.is_clear_of_surface(line, [from, to])
    }

    fn implicit(&self, p: Vec3, surface: u32, _primitive: u32) -> f64 {
        match (surface, &self.caps) {
            (1, Some(caps)) => caps.low - p.z,
            (2, Some(caps)) => p.z - caps.high,
            _ => self.form.value(p),
        }
    }

    fn normal(&self, p: Vec3, surface: u32, _primitive: u32) -> Vec3 {
        match surface {
            1 => Vec3::NEG_Z,
            2 => Vec3::Z,
            _ => self.form.gradient(p),
        }
    }

    fn contains(&self, p: Vec3) -> bool {
        self.caps.is_none_or(|caps| caps.contains(p.z)) && self.form.value(p) < 0.0
    }

    fn surfaces(&self) -> &'static [&'static str] {
        self.surfaces
    }

    /// An ellipsoid, or a solid of revolution that may be stretched along y. For the latter, the squared radius at a height is
    /// minus the form's value on the axis, over the coefficient of `x^2`. The intervals of the axis that lie inside are
    /// integrated one by one.
    fn moments(&self) -> Option<Moments> {
        let Form { centre, shrink, square, constant, .. } = self.form;
        if self.caps.is_none() && !self.form.is_about_its_centre() {
            return definite::moments(&self.form);
        }
        if !self.bounds.is_finite() {
            return self.bounds.is_empty().then_some(Moments::EMPTY);
        }
        if self.caps.is_none() {
            let squares = (-constant.hi / rounded(&square)) / (shrink * shrink);
            let volume = 4.0 / 3.0 * PI * squares.to_array().map(f64::sqrt).iter().product::<f64>();
            return Some(Moments::along_axes(volume, centre, squares / 5.0));
        }
        let [across, stretched] = [0, 1].map(|i| square[i].hi * shrink[i] * shrink[i]);
        let square_of_radius = |z: f64| (-self.form.value(Vec3::new(0.0, 0.0, z)) / across).max(0.0);
        let mut ends = Vec::new();
        self.crossings(&Line::exact(Vec3::ZERO, Vec3::Z), &mut ends);
        let part = |ends: &[Crossing]| Moments::of_revolution(ends[0].t, ends[1].t, square_of_radius);
        let of_revolution = Moments::total(&ends.chunks_exact(2).map(part).collect::<Vec<_>>());
        if across == stretched {
            return Some(of_revolution);
        }
        Some(of_revolution.placed(&Affine::scaling(Vec3::new(1.0, (across / stretched).sqrt(), 1.0))))
    }

    fn half_spaces(&self) -> Option<Vec<Plane>> {
        let q = self.form.quadric_matrix().rows;
        let is_plane = self.caps.is_none() && (0..3).all(|i| (0..3).all(|j| q[i][j] == 0.0));
        is_plane.then(|| vec![Plane::new(2.0 * Vec3::new(q[0][3], q[1][3], q[2][3]), q[3][3])])
    }

    fn in_lanes(&self) -> Option<InLanes<'_>> {
        Some(InLanes::quadric(&self.form, self.caps.as_ref()))
    }

    fn quadric_matrix(&self, surface: u32) -> Option<QuadricMatrix> {
        (surface == 0).then(|| self.form.quadric_matrix())
    }
}
