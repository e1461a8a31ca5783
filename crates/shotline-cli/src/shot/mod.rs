//! The report of one ray: what it crosses and how much of each material it passes.

mod json;
mod text;

use shotline::compile::World;
use shotline::math::{Vec3, length, unit};
use shotline::query::{Caster, Hit, HitKind, Kinds, Limits, Overlaps, QueryError, Scope, Segment};
use shotline::ray::{Ray, Span};
use shotline::scene::Units;

use crate::overlap::{self, Overlap};

/// One ray, fully reported. Lengths are in world units.
#[derive(Debug)]
pub struct Shot {
    ray: Ray,
    span: Span,
    units: Option<Units>,
    crossings: Vec<Row>,
    totals: Vec<Total>,
    overlaps: Vec<Overlap>,
    /// Why there is no thickness, if there is none.
    refusal: Option<QueryError>,
}

/// One crossing.
#[derive(Debug)]
struct Row {
    hit: Hit,
    /// From the origin of the ray.
    distance: f64,
    /// `None` at infinity.
    point: Option<Vec3>,
    object: String,
    material: Option<String>,
    surface: Option<String>,
    path: String,
    /// The angle between the ray and the normal in degrees, from 0 (head on) to 90 (grazing).
    obliquity: Option<f64>,
    /// The length of the ray inside objects up to here.
    thickness: Option<f64>,
}

/// The length of the ray inside one material.
#[derive(Debug)]
struct Total {
    material: Option<String>,
    length: f64,
    segments: usize,
}

/// Crossings that a report may have: more than anybody reads.
const MOST: usize = 20_000;

impl Shot {
    /// Casts the ray. Of the crossings only the kinds in question are listed; lengths are those of all segments.
    ///
    /// # Errors
    /// If there is more to tell than anybody reads.
    pub fn new(
        world: &World,
        ray: Ray,
        span: Span,
        kinds: Kinds,
        units: Option<Units>,
    ) -> Result<Shot, QueryError> {
        let mut caster = Caster::new(world);
        caster.limit(Limits { crossings: MOST, ..Limits::default() });
        let (mut hits, mut segments) = (Vec::new(), Vec::new());
        caster.crossings(&ray, Scope { span, kinds }, &mut hits)?;
        let refusal = match caster.segments(&ray, span, Overlaps::Priority, &mut segments) {
            Ok(_) => None,
            Err(refusal @ QueryError::NotASolid { .. }) => Some(refusal),
            Err(error) => return Err(error),
        };
        let mut passed = Passed { segments: &segments, before: 0.0, step: length(ray.direction()) };
        let mut thickness = |t: f64| refusal.is_none().then(|| passed.until(t));
        let crossings = hits.iter().map(|hit| row(world, &ray, *hit, thickness(hit.t))).collect();
        let overlaps = overlap::on_ray(&mut caster, &ray, span)?;
        Ok(Shot { ray, span, units, crossings, totals: totals(world, &segments), overlaps, refusal })
    }
}

/// The length inside objects up to where the ray has been followed.
struct Passed<'a> {
    /// Those that do not end before: ascending and apart.
    segments: &'a [Segment],
    /// The length of those that do.
    before: f64,
    /// The length of the ray's direction.
    step: f64,
}

impl Passed<'_> {
    /// The length up to a `t` that is not below the last one asked about.
    fn until(&mut self, t: f64) -> f64 {
        while let Some((segment, rest)) = self.segments.split_first()
            && segment.t_out <= t
        {
            (self.before, self.segments) = (self.before + segment.length, rest);
        }
        self.before + self.segments.first().map_or(0.0, |s| (t - s.t_in).max(0.0) * self.step)
    }
}

fn row(world: &World, ray: &Ray, hit: Hit, thickness: Option<f64>) -> Row {
    let material = world.object_material(hit.object);
    Row {
        hit,
        distance: hit.t * length(ray.direction()),
        point: hit.t.is_finite().then(|| ray.at(hit.t)),
        object: name(world.object_names(), hit.object),
        material: material.map(|m| name(world.material_names(), m)),
        surface: hit.surface.map(|s| world.surface_name(s)),
        path: world.path_name(hit.path),
        obliquity: (hit.kind == HitKind::Surface).then(|| obliquity(ray.direction(), hit.normal)),
        thickness,
    }
}

fn name(names: &[String], number: u32) -> String {
    names.get(number as usize).cloned().unwrap_or_else(|| format!("#{number}"))
}

fn obliquity(direction: Vec3, normal: Vec3) -> f64 {
    let d = unit(direction);
    // The arc tangent keeps its digits at both ends, which the arc cosine does not.
    d.cross(normal).length().atan2(d.dot(normal).abs()).to_degrees()
}

/// The lengths by material, in the order of the scene; what has no material comes last.
fn totals(world: &World, segments: &[Segment]) -> Vec<Total> {
    let mut materials: Vec<Option<u32>> = segments.iter().map(|s| s.material).collect();
    materials.sort_by_key(|m| m.unwrap_or(u32::MAX));
    materials.dedup();
    let total = |material: Option<u32>| {
        let own = || segments.iter().filter(|s| s.material == material);
        Total {
            material: material.map(|m| name(world.material_names(), m)),
            length: own().map(|s| s.length).sum(),
            segments: own().count(),
        }
    };
    materials.into_iter().map(total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_survive_extreme_directions() {
        assert_eq!(obliquity(Vec3::X * 1e300, Vec3::NEG_X), 0.0);
        assert!((obliquity(Vec3::ONE * 1e-300, Vec3::X) - 54.735610317245346).abs() < 1e-12);
    }
}
