//! Overlaps on one ray.

use shotline::aabb::Aabb;
use shotline::crossing::GROUPING;
use shotline::math::Vec3;
use shotline::query::{Caster, ConflictKind, QueryError};
use shotline::ray::{Ray, Span};

/// An interval of a ray that is inside two objects of equal priority, or inside one that sticks out of another there.
#[derive(Debug)]
pub struct Conflict {
    pub kind: ConflictKind,
    pub first: String,
    pub second: String,
    pub t_in: f64,
    pub t_out: f64,
    /// The sum of the error bounds of both ends.
    pub t_err: f64,
}

impl Conflict {
    /// Whether the interval is longer than the error bounds of its ends, so that it is more than one event.
    pub fn is_wide(&self) -> bool {
        self.t_out - self.t_in > GROUPING * self.t_err
    }
}

/// Every overlap and protrusion on a ray, and the number of intervals inside parts.
/// There are none in a world with a mesh that has no inside.
///
/// # Errors
/// As [`Caster::conflicts`], but not for such a mesh.
pub fn conflicts_on_ray(
    caster: &mut Caster,
    ray: &Ray,
    span: Span,
) -> Result<(Vec<Conflict>, usize), QueryError> {
    let mut found = Vec::new();
    let intervals = match caster.conflicts(ray, span, &mut found) {
        Ok(intervals) => intervals,
        Err(QueryError::NotASolid { .. }) => 0,
        Err(error) => return Err(error),
    };
    let names = caster.world().object_names();
    let name = |object: u32| names[object as usize].clone();
    let named = found.iter().map(|o| Conflict {
        kind: o.kind,
        first: name(o.first),
        second: name(o.second),
        t_in: o.t_in,
        t_out: o.t_out,
        t_err: o.t_err,
    });
    Ok((named.collect(), intervals))
}

/// The overlaps and protrusions on a ray along an axis, in a box, that are longer than their error bounds; and the number of
/// intervals inside parts.
///
/// # Errors
/// As [`conflicts_on_ray`].
pub fn wide_conflicts(
    caster: &mut Caster,
    ray: &Ray,
    bounds: &Aabb,
    axis: usize,
) -> Result<(Vec<Conflict>, usize), QueryError> {
    let from = bounds.min[axis] - ray.origin()[axis];
    let Ok(span) = Span::new(from, from + bounds.size()[axis]) else { return Ok((Vec::new(), 0)) };
    let (mut found, intervals) = conflicts_on_ray(caster, ray, span)?;
    found.retain(Conflict::is_wide);
    Ok((found, intervals))
}

/// Whether there is an overlap or a protrusion at a point of a box also along the other two axes. Where objects only touch, a
/// ray in the gap between rounding errors may be inside both of them for a long interval.
///
/// # Errors
/// As [`conflicts_on_ray`].
pub fn is_conflict_at(
    caster: &mut Caster,
    p: Vec3,
    bounds: &Aabb,
    known_axis: usize,
) -> Result<bool, QueryError> {
    for axis in (0..3).filter(|axis| *axis != known_axis) {
        let (mut origin, mut direction) = (p, Vec3::ZERO);
        origin[axis] = bounds.min[axis] - bounds.size()[axis];
        direction[axis] = 1.0;
        let Ok(ray) = Ray::new(origin, direction) else { return Ok(false) };
        let t = p[axis] - origin[axis];
        let (found, _) = wide_conflicts(caster, &ray, bounds, axis)?;
        if !found.iter().any(|o| o.t_in <= t && t <= o.t_out) {
            return Ok(false);
        }
    }
    Ok(true)
}
