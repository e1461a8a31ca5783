//! A search of a whole world, by many rays, for objects that overlap and for coincident faces.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::crossing::GROUPING;
use shotline::measure::object_bounds;
use shotline::query::{Caster, ConflictKind, Hit, HitKind, QueryError};
use shotline::ray::{Ray, Span};

use super::axis_ray::axis_ray;
use super::leaf_pairs::sample_leaf_pairs;
use super::on_ray::{conflicts_on_ray, is_conflict_at};
use super::pairs::{ObjectPair, PairSet};

/// What the rays have found.
#[derive(Debug, Default)]
pub struct SamplingReport {
    /// Objects of equal priority that overlap, then objects that stick out of others, in the order of their names.
    pub overlaps: Vec<ObjectPair>,
    /// Objects that have coincident faces, in the order of their names.
    pub coincidences: Vec<ObjectPair>,
    /// What could not be examined, as text.
    pub unexamined: Vec<String>,
    /// How many rays were cast, if fewer than usual.
    pub few_rays: Option<usize>,
    /// For each object, by its number, whether a ray met it.
    pub met: Vec<bool>,
}

/// Rays along each axis.
const RAYS: u32 = 2048;

/// The number of crossings after which no more rays are cast, if at least `MIN_RAYS` were cast.
const MAX_CROSSINGS: usize = 1 << 22;
const MIN_RAYS: usize = 300;

/// The maximum number of pairs of unbounded objects that are named.
const MAX_NAMED: usize = 5;

/// Casts rays along the axes, spread over the box of all bounded objects, and then through the common boxes of leaves
/// whose boxes meet. Small overlaps can be missed.
///
/// Unbounded objects are clipped to that box. So an overlap with a bounded object is found. An overlap of two unbounded
/// objects is found if it is near that box; otherwise the pair is reported as unexamined.
pub fn sample_world(world: &World) -> SamplingReport {
    let mut met = vec![false; world.object_names().len()];
    let objects = match object_bounds(world) {
        Ok(objects) => objects,
        // No ray is cast, so no object is reported as not met.
        Err(error) => {
            met.fill(true);
            return SamplingReport { unexamined: vec![error.to_string()], met, ..SamplingReport::default() };
        }
    };
    if world.path_count() <= 1 {
        // A single instance cannot overlap another, and rays through a mesh of long thin triangles are slow.
        let unexamined = unexamined_pairs(world, &objects, &PairSet::default());
        return SamplingReport { unexamined, met, ..SamplingReport::default() };
    }
    let bounds = sampled_box(&objects);
    let mut sampler = Sampler::new(world, met);
    let (few_rays, error) = match sampler.cast_along_axes(&bounds) {
        Ok(few_rays) => (few_rays, None),
        Err(error) => (None, Some(format!("a ray failed: {error}"))),
    };
    let Sampler { mut overlaps, coincidences, met, .. } = sampler;
    let of_leaves =
        if error.is_none() { sample_leaf_pairs(world, &bounds, &mut overlaps) } else { Vec::new() };
    let mut unexamined = unexamined_pairs(world, &objects, &overlaps);
    unexamined.extend(error.into_iter().chain(of_leaves));
    let (overlaps, coincidences) = (overlaps.into_list(), coincidences.into_list());
    SamplingReport { overlaps, coincidences, unexamined, few_rays, met }
}

/// Casts rays through a world and collects what they find.
struct Sampler<'w> {
    caster: Caster<'w>,
    hits: Vec<Hit>,
    overlaps: PairSet,
    coincidences: PairSet,
    met: Vec<bool>,
}

impl<'w> Sampler<'w> {
    fn new(world: &'w World, met: Vec<bool>) -> Sampler<'w> {
        Sampler {
            caster: Caster::new(world),
            hits: Vec::new(),
            overlaps: PairSet::default(),
            coincidences: PairSet::default(),
            met,
        }
    }

    /// Returns how many rays were cast, if fewer than usual.
    fn cast_along_axes(&mut self, bounds: &Aabb) -> Result<Option<usize>, QueryError> {
        let (mut rays, mut crossings) = (0, 0);
        // The first n rays are spread evenly for every n, so the loop can end early.
        let ray_along = |axis: usize, i: u32| axis_ray(bounds, axis, i).map(|ray| (axis, ray));
        for (axis, ray) in (0..RAYS).flat_map(|i| (0..3).filter_map(move |axis| ray_along(axis, i))) {
            if crossings > MAX_CROSSINGS && rays >= MIN_RAYS {
                return Ok(Some(rays));
            }
            rays += 1;
            // An error ends the loop: the other rays would be as expensive.
            crossings += self.cast(&ray, axis, bounds)?;
        }
        Ok(None)
    }

    /// Returns the number of crossings of a ray along an axis.
    fn cast(&mut self, ray: &Ray, axis: usize, bounds: &Aabb) -> Result<usize, QueryError> {
        self.hits.clear();
        let (overlaps, _) = conflicts_on_ray(&mut self.caster, ray, Span::FORWARD)?;
        self.caster.crossings(ray, Span::FORWARD, &mut self.hits)?;
        self.hits.iter().for_each(|hit| self.met[hit.object as usize] = true);
        for overlap in overlaps {
            let point = ray.at(overlap.t_in.midpoint(overlap.t_out.min(f64::MAX)));
            let point = if point.is_finite() { point } else { ray.at(overlap.t_in) };
            let names = [overlap.first.as_str(), overlap.second.as_str()];
            let is_in_box = bounds.contains(point);
            if self.overlaps.contains(overlap.kind, names)
                || !is_in_box
                || is_conflict_at(&mut self.caster, point, bounds, axis)?
            {
                self.overlaps.add(overlap.kind, names, point);
            }
        }
        let names = self.caster.world().object_names();
        for ((a, b), t) in coincidences_on_ray(&self.hits) {
            let names = [a, b].map(|object| names[object as usize].as_str());
            self.coincidences.add(ConflictKind::Overlap, names, ray.at(t));
        }
        Ok(self.hits.len())
    }
}

fn is_unbounded(bounds: &Aabb) -> bool {
    !bounds.is_empty() && !bounds.is_finite()
}

/// The box over which rays are spread: around the bounded objects, and around the finite sides of the others.
fn sampled_box(objects: &[Aabb]) -> Aabb {
    let mut b = objects.iter().filter(|b| b.is_finite()).fold(Aabb::EMPTY, |all, b| all.union(b));
    for other in objects.iter().filter(|b| is_unbounded(b)) {
        for axis in 0..3 {
            for side in [other.min[axis], other.max[axis]].into_iter().filter(|x| x.is_finite()) {
                b.min[axis] = b.min[axis].min(side);
                b.max[axis] = b.max[axis].max(side);
            }
        }
    }
    let size = (0..3).map(|axis| b.max[axis] - b.min[axis]).filter(|s| s.is_finite()).fold(0.0, f64::max);
    let size = if size > 0.0 { size } else { 1.0 };
    for axis in 0..3 {
        // Without any finite side the box is around the origin. If all sides are in one plane, the box is on both sides
        // of it.
        if b.min[axis] > b.max[axis] {
            (b.min[axis], b.max[axis]) = (0.0, 0.0);
        }
        if b.min[axis] == b.max[axis] {
            (b.min[axis], b.max[axis]) = (b.min[axis] - size, b.max[axis] + size);
        }
    }
    if objects.iter().all(Aabb::is_empty) { Aabb::EMPTY } else { b }
}

/// Pairs of unbounded objects that were not found to overlap, but could overlap far away.
fn unexamined_pairs(world: &World, objects: &[Aabb], known: &PairSet) -> Vec<String> {
    let unbounded: Vec<u32> = (0..).zip(objects).filter(|(_, b)| is_unbounded(b)).map(|(i, _)| i).collect();
    let name = |object: u32| world.object_names()[object as usize].as_str();
    let (mut out, mut more) = (Vec::new(), 0);
    for (i, &a) in unbounded.iter().enumerate() {
        for &b in &unbounded[i + 1..] {
            let common = objects[a as usize].intersection(&objects[b as usize]);
            let are_apart = !common.min.cmplt(common.max).all();
            let may_overlap = world.object_priority(a) == world.object_priority(b);
            if are_apart || !may_overlap || known.contains(ConflictKind::Overlap, [name(a), name(b)]) {
                continue;
            }
            if out.len() < MAX_NAMED {
                out.push(format!(
                    "'{}' and '{}' are unbounded: they might overlap far away",
                    name(a),
                    name(b)
                ));
            } else {
                more += 1;
            }
        }
    }
    if more > 0 {
        out.push(format!("{more} more pairs of unbounded objects"));
    }
    out
}

/// The smallest cosine of the angle between the normals of coincident faces.
const MIN_COSINE: f64 = 1.0 - 1e-6;

/// Pairs of objects that have faces with parallel normals in one event of the ray, with the first such `t`. Surfaces
/// that intersect each other do not count. Where many objects coincide, each makes a pair with the next.
fn coincidences_on_ray(hits: &[Hit]) -> BTreeMap<(u32, u32), f64> {
    let (low, high) = (|h: &Hit| h.t - GROUPING * h.t_err, |h: &Hit| h.t + GROUPING * h.t_err);
    let mut pairs = BTreeMap::new();
    for event in hits.chunk_by(|a, b| low(b) <= high(a)) {
        let of = |object: u32| event.iter().filter(move |h| h.kind == HitKind::Surface && h.object == object);
        let mut objects: Vec<u32> = event.iter().map(|h| h.object).collect();
        objects.sort_unstable();
        objects.dedup();
        for pair in objects.windows(2) {
            let is_parallel = |a: &Hit| of(pair[1]).any(|b| a.normal.dot(b.normal).abs() >= MIN_COSINE);
            if of(pair[0]).any(is_parallel) {
                pairs.entry((pair[0], pair[1])).or_insert(event[0].t);
            }
        }
    }
    pairs
}
