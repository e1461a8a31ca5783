//! Where objects of equal priority claim the same stretch of a ray.

use shotline::crossing::GROUPING;
use shotline::query::{Caster, QueryError};
use shotline::ray::{Ray, Span};

/// A stretch claimed by two objects.
#[derive(Debug)]
pub struct Overlap {
    pub first: String,
    pub second: String,
    pub t_in: f64,
    pub t_out: f64,
    /// The sum of the bounds on the errors of both ends.
    pub t_err: f64,
}

impl Overlap {
    /// Whether it is more than one event: longer than the bounds of its ends.
    pub fn is_wide(&self) -> bool {
        self.t_out - self.t_in > GROUPING * self.t_err
    }
}

/// Every overlap on a ray that a query of segments would refuse. None are found in a world with a mesh that has no
/// inside.
///
/// # Errors
/// As [`Caster::overlaps`], but for such a mesh.
pub fn on_ray(caster: &mut Caster, ray: &Ray, span: Span) -> Result<Vec<Overlap>, QueryError> {
    let mut found = Vec::new();
    match caster.overlaps(ray, span, &mut found) {
        Ok(()) | Err(QueryError::NotASolid { .. }) => {}
        Err(error) => return Err(error),
    }
    let names = caster.world().object_names();
    let name = |object: u32| names[object as usize].clone();
    let named = found.iter().map(|o| Overlap {
        first: name(o.first),
        second: name(o.second),
        t_in: o.t_in,
        t_out: o.t_out,
        t_err: o.t_err,
    });
    Ok(named.collect())
}
