//! Looks through a world with many rays for objects that get in each other's way.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::crossing::GROUPING;
use shotline::math::Vec3;
use shotline::query::{Caster, Hit, HitKind, QueryError};
use shotline::ray::{Ray, Span};

use crate::overlap;

/// What the rays have seen; each pair of objects once, in the order of their names.
#[derive(Debug)]
pub struct Survey {
    /// Objects of equal priority that overlap.
    pub overlaps: Vec<Pair>,
    /// Objects that have faces in one place.
    pub coincidences: Vec<Pair>,
}

/// Two objects that were seen to be in one place.
#[derive(Debug)]
pub struct Pair {
    pub first: String,
    pub second: String,
    /// The first point seen.
    pub point: Vec3,
    /// On how many rays.
    pub rays: usize,
}

/// Pairs by name. Which object is met first depends on the ray; a pair is one pair.
#[derive(Default)]
struct Pairs(BTreeMap<(String, String), Pair>);

impl Pairs {
    fn add(&mut self, a: &str, b: &str, point: Vec3) {
        let (first, second) = (a.min(b).to_string(), a.max(b).to_string());
        let key = (first.clone(), second.clone());
        self.0.entry(key).or_insert(Pair { first, second, point, rays: 0 }).rays += 1;
    }

    fn into_list(self) -> Vec<Pair> {
        self.0.into_values().collect()
    }
}

/// Rays along each axis.
const RAYS: u32 = 2048;

/// Casts rays along the axes, spread over the bounds; what is small may slip through. `None` if the bounds
/// have no end.
///
/// # Errors
/// [`QueryError`] if a ray costs too much.
pub fn survey(world: &World) -> Result<Option<Survey>, QueryError> {
    let bounds = world.bounds();
    if !bounds.is_empty() && !bounds.is_finite() {
        return Ok(None);
    }
    let (mut caster, mut hits) = (Caster::new(world), Vec::new());
    let (mut overlaps, mut coincidences) = (Pairs::default(), Pairs::default());
    for ray in (0..3).flat_map(|axis| (0..RAYS).filter_map(move |i| spread(&bounds, axis, i))) {
        for overlap in overlap::on_ray(&mut caster, &ray, Span::FORWARD)? {
            let point = ray.at(overlap.t_in.midpoint(overlap.t_out));
            overlaps.add(&overlap.first, &overlap.second, point);
        }
        hits.clear();
        caster.crossings(&ray, Span::FORWARD, &mut hits)?;
        for ((a, b), t) in coincidences_on_ray(&hits) {
            let names = world.object_names();
            coincidences.add(&names[a as usize], &names[b as usize], ray.at(t));
        }
    }
    Ok(Some(Survey { overlaps: overlaps.into_list(), coincidences: coincidences.into_list() }))
}

/// Pairs of objects whose surfaces the ray passes in one event, with the first such `t`. Where many are in
/// one place, each makes a pair with the next.
fn coincidences_on_ray(hits: &[Hit]) -> BTreeMap<(u32, u32), f64> {
    let (low, high) = (|h: &Hit| h.t - GROUPING * h.t_err, |h: &Hit| h.t + GROUPING * h.t_err);
    let mut pairs = BTreeMap::new();
    for event in hits.chunk_by(|a, b| low(b) <= high(a)) {
        let surfaces = event.iter().filter(|h| h.kind == HitKind::Surface);
        let mut objects: Vec<u32> = surfaces.map(|h| h.object).collect();
        objects.sort_unstable();
        objects.dedup();
        for pair in objects.windows(2) {
            pairs.entry((pair[0], pair[1])).or_insert(event[0].t);
        }
    }
    pairs
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
