//! The report of one ray: its crossings, and its length in each material.

mod json;
mod text;

use shotline::compile::World;
use shotline::math::{Vec3, length, unit};
use shotline::query::{Caster, Hit, HitKind, Kinds, Limits, Overlaps, QueryError, Scope, Segment};
use shotline::ray::{Ray, Span};
use shotline::scene::Units;
use shotline_render::RayMark;

use crate::number::short;
use crate::overlap::{Conflict, conflicts_on_ray};

/// The full report of one ray. Lengths are in world units.
#[derive(Debug)]
pub struct ShootReport {
    ray: Ray,
    span: Span,
    units: Option<Units>,
    crossings: Vec<CrossingRow>,
    segments: Vec<Segment>,
    totals: Vec<MaterialTotal>,
    overlaps: Vec<Conflict>,
    /// Why there is no thickness, if there is none.
    no_thickness: Option<QueryError>,
}

/// One crossing.
#[derive(Debug)]
struct CrossingRow {
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
struct MaterialTotal {
    material: Option<String>,
    length: f64,
    segments: usize,
}

/// The maximum number of crossings of a report, far more than a user can read.
const MAX_CROSSINGS: usize = 20_000;

impl ShootReport {
    /// Casts the ray. Only crossings of the given kinds are listed; lengths are those of all segments.
    ///
    /// # Errors
    /// If the ray has more than [`MAX_CROSSINGS`] crossings.
    pub fn new(
        world: &World,
        ray: Ray,
        span: Span,
        kinds: Kinds,
        units: Option<Units>,
    ) -> Result<ShootReport, QueryError> {
        let mut caster = Caster::new(world);
        caster.limit(Limits { crossings: MAX_CROSSINGS, ..Limits::default() });
        let (mut hits, mut segments) = (Vec::new(), Vec::new());
        caster.crossings(&ray, Scope { span, kinds }, &mut hits)?;
        let no_thickness = match caster.segments(&ray, span, Overlaps::Priority, &mut segments) {
            Ok(_) => None,
            Err(no_thickness @ QueryError::NotASolid { .. }) => Some(no_thickness),
            Err(error) => return Err(error),
        };
        let mut accumulated = LengthInside { segments: &segments, ended: 0.0, step: length(ray.direction()) };
        let mut thickness = |t: f64| no_thickness.is_none().then(|| accumulated.until(t));
        let crossings = hits.iter().map(|hit| row(world, &ray, *hit, thickness(hit.t))).collect();
        let (overlaps, _) = conflicts_on_ray(&mut caster, &ray, span)?;
        Ok(ShootReport {
            ray,
            span,
            units,
            crossings,
            totals: totals(world, &segments),
            segments,
            overlaps,
            no_thickness,
        })
    }

    /// The parts of the ray inside objects; none if an object has no inside.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The crossings as they are drawn in a picture.
    pub fn marks(&self) -> Vec<RayMark> {
        let mark = |row: &CrossingRow| {
            let event = match (row.hit.kind, row.hit.entering) {
                (HitKind::Surface, true) => "into",
                (HitKind::Surface, false) => "out of",
                (_, true) => "begins in",
                (_, false) => "ends in",
            };
            // What t counts is a length only if the direction has length 1.
            let unit = self.units.filter(|_| row.distance.is_finite());
            let distance = unit.map_or_else(String::new, |unit| format!(" ({} {unit})", short(row.distance)));
            RayMark {
                t: row.hit.t,
                label: format!("t = {}{distance}  {event} {}", short(row.hit.t), row.object),
            }
        };
        self.crossings.iter().map(mark).collect()
    }
}

/// Accumulates the length of the ray inside objects.
struct LengthInside<'a> {
    /// The segments that end later: ascending and disjoint.
    segments: &'a [Segment],
    /// The length of the segments that have ended.
    ended: f64,
    /// The length of the ray's direction.
    step: f64,
}

impl LengthInside<'_> {
    /// The length up to a `t`, which must not be below that of the call before.
    fn until(&mut self, t: f64) -> f64 {
        while let Some((segment, rest)) = self.segments.split_first()
            && segment.t_out <= t
        {
            (self.ended, self.segments) = (self.ended + segment.length, rest);
        }
        self.ended + self.segments.first().map_or(0.0, |s| (t - s.t_in).max(0.0) * self.step)
    }
}

fn row(world: &World, ray: &Ray, hit: Hit, thickness: Option<f64>) -> CrossingRow {
    let material = world.object_material(hit.object);
    CrossingRow {
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
    // The arc tangent is accurate at both ends, and the arc cosine is not.
    d.cross(normal).length().atan2(d.dot(normal).abs()).to_degrees()
}

/// The lengths by material, in the order of the scene; the total of objects without a material is last.
fn totals(world: &World, segments: &[Segment]) -> Vec<MaterialTotal> {
    let mut materials: Vec<Option<u32>> = segments.iter().map(|s| s.material).collect();
    materials.sort_by_key(|m| m.unwrap_or(u32::MAX));
    materials.dedup();
    let total = |material: Option<u32>| {
        let of_material = || segments.iter().filter(|s| s.material == material);
        MaterialTotal {
            material: material.map(|m| name(world.material_names(), m)),
            length: of_material().map(|s| s.length).sum(),
            segments: of_material().count(),
        }
    };
    materials.into_iter().map(total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_of_extreme_directions_are_accurate() {
        assert_eq!(obliquity(Vec3::X * 1e300, Vec3::NEG_X), 0.0);
        assert!((obliquity(Vec3::ONE * 1e-300, Vec3::X) - 54.735610317245346).abs() < 1e-12);
    }
}
