//! Where objects of equal priority claim the same stretch of a ray.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::math::Vec3;
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

/// Two objects that were seen to overlap.
#[derive(Debug)]
pub struct Pair {
    pub first: String,
    pub second: String,
    /// A point in both.
    pub point: Vec3,
    /// On how many rays they overlap.
    pub rays: usize,
}

/// Rays along each axis.
const RAYS: u32 = 2048;

/// Looks for overlaps with rays along the axes, spread over the bounds; a small overlap may slip through.
/// `None` if the bounds have no end.
pub fn survey(world: &World) -> Option<Vec<Pair>> {
    let bounds = world.bounds();
    if !bounds.is_empty() && !bounds.is_finite() {
        return None;
    }
    let mut caster = Caster::new(world);
    let mut pairs: BTreeMap<(String, String), Pair> = BTreeMap::new();
    for ray in (0..3).flat_map(|axis| (0..RAYS).filter_map(move |i| spread(&bounds, axis, i))) {
        for overlap in on_ray(&mut caster, &ray, Span::FORWARD) {
            let point = ray.at(overlap.t_in.midpoint(overlap.t_out));
            let Overlap { first, second, .. } = overlap;
            // Which is entered first depends on the ray; a pair is one pair.
            let key = if first <= second { (first, second) } else { (second, first) };
            let (first, second) = key.clone();
            pairs.entry(key).or_insert(Pair { first, second, point, rays: 0 }).rays += 1;
        }
    }
    Some(pairs.into_values().collect())
}

/// The i-th ray along an axis through a box. The points are spread by the additive sequence of the plastic
/// number (M. Roberts, 2018), which has no rows that could run along a model's own.
fn spread(bounds: &Aabb, axis: usize, i: u32) -> Option<Ray> {
    const STEPS: [f64; 2] = [0.7548776662466927, 0.5698402909980532];
    let size = bounds.size();
    let mut origin = bounds.min;
    for (k, step) in STEPS.iter().enumerate() {
        let across = (axis + 1 + k) % 3;
        origin[across] += size[across] * (0.5 + step * f64::from(i)).fract();
    }
    origin[axis] -= size[axis].max(f64::MIN_POSITIVE);
    let mut direction = Vec3::ZERO;
    direction[axis] = 1.0;
    Ray::new(origin, direction).ok()
}
