//! Where objects of equal priority claim the same stretch of a ray.

use shotline::query::{Caster, Overlaps, QueryError};
use shotline::ray::{Ray, Span};

/// A stretch claimed by two objects.
#[derive(Debug)]
pub struct Overlap {
    pub first: String,
    pub second: String,
    pub t_in: f64,
    pub t_out: f64,
}

/// Every overlap on a ray that a query of segments would refuse, found by asking again behind each. None are
/// found where the ray meets a mesh without an inside.
pub fn on_ray(caster: &mut Caster, ray: &Ray, span: Span) -> Vec<Overlap> {
    let (mut found, mut rest) = (Vec::new(), span);
    while let Err(QueryError::Overlap { first, second, t_in, t_out }) =
        caster.segments(ray, rest, Overlaps::Error, &mut Vec::new())
    {
        found.push(Overlap { first, second, t_in, t_out });
        match Span::new(t_out, span.t_max()) {
            Ok(behind) if t_out > rest.t_min() => rest = behind,
            _ => break,
        }
    }
    found
}
