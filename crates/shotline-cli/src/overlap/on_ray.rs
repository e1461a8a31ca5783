//! Overlaps on one ray.

use shotline::crossing::GROUPING;
use shotline::query::{Caster, OverlapKind, QueryError};
use shotline::ray::{Ray, Span};

/// An interval of a ray that is inside two objects of equal priority, or inside one that sticks out of another there.
#[derive(Debug)]
pub struct Overlap {
    pub kind: OverlapKind,
    pub first: String,
    pub second: String,
    pub t_in: f64,
    pub t_out: f64,
    /// The sum of the error bounds of both ends.
    pub t_err: f64,
}

impl Overlap {
    /// Whether the interval is longer than the error bounds of its ends, so that it is more than one event.
    pub fn is_wide(&self) -> bool {
        self.t_out - self.t_in > GROUPING * self.t_err
    }
}

/// Every overlap and protrusion on a ray, and the number of intervals inside parts.
/// There are none in a world with a mesh that has no inside.
///
/// # Errors
/// As [`Caster::overlaps`], but not for such a mesh.
pub fn overlaps_on_ray(
    caster: &mut Caster,
    ray: &Ray,
    span: Span,
) -> Result<(Vec<Overlap>, usize), QueryError> {
    let mut found = Vec::new();
    let intervals = match caster.overlaps(ray, span, &mut found) {
        Ok(intervals) => intervals,
        Err(QueryError::NotASolid { .. }) => 0,
        Err(error) => return Err(error),
    };
    let names = caster.world().object_names();
    let name = |object: u32| names[object as usize].clone();
    let named = found.iter().map(|o| Overlap {
        kind: o.kind,
        first: name(o.first),
        second: name(o.second),
        t_in: o.t_in,
        t_out: o.t_out,
        t_err: o.t_err,
    });
    Ok((named.collect(), intervals))
}
