//! The sphere around the origin.

use std::sync::Arc;

use super::{Kind, Param, ParamType, Solid, Value};
use crate::aabb::Aabb;
use crate::crossing::Crossing;
use crate::math::{HALF_ULP, Vec3};
use crate::ray::Line;

/// `|p| < radius`.
#[derive(Debug)]
pub struct Sphere {
    radius: f64,
}

pub(super) static KIND: Kind = Kind {
    name: "sphere",
    summary: "the sphere of a radius around the origin",
    params: &[Param { name: "radius", ty: ParamType::Number, summary: "the radius, positive" }],
    build: |p| Ok(Arc::new(Sphere { radius: p.positive("radius")? })),
    examples: &[&[Value::Number(1.0)], &[Value::Number(1e-3)], &[Value::Number(1e6)]],
};

impl Solid for Sphere {
    fn bounds(&self) -> Aabb {
        Aabb::new(Vec3::splat(-self.radius), Vec3::splat(self.radius))
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        let dd = line.d.length_squared();
        let t0 = -line.o.dot(line.d) / dd;
        let p = line.at(t0);
        let reach = (self.radius - p.length()) * (self.radius + p.length());
        if reach <= 0.0 {
            return;
        }
        let half = (reach / dd).sqrt();
        let err = 8.0 * HALF_ULP * (t0.abs() + half);
        out.push(Crossing::new(t0 - half, err, true, 0));
        out.push(Crossing::new(t0 + half, err, false, 0));
    }

    fn implicit(&self, p: Vec3, _surface: u32, _primitive: u32) -> f64 {
        p.length_squared() - self.radius * self.radius
    }

    fn normal(&self, p: Vec3, _surface: u32, _primitive: u32) -> Vec3 {
        p
    }

    fn contains(&self, p: Vec3) -> bool {
        p.length() < self.radius
    }

    fn surfaces(&self) -> &'static [&'static str] {
        &["sphere"]
    }
}
