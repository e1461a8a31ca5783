//! Looks through a world with many rays for objects that get in each other's way.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::crossing::GROUPING;
use shotline::math::Vec3;
use shotline::measure::object_bounds;
use shotline::query::{Caster, Hit, HitKind};
use shotline::ray::{Ray, Span};

use crate::{close, overlap};

/// What the rays have seen; each pair of objects once, in the order of their names.
#[derive(Debug, Default)]
pub struct Survey {
    /// Objects of equal priority that overlap.
    pub overlaps: Vec<Pair>,
    /// Objects that have faces in one place.
    pub coincidences: Vec<Pair>,
    /// What could not be looked at, for people.
    pub unexamined: Vec<String>,
    /// How many rays were cast, if they were fewer than usual.
    pub few_rays: Option<usize>,
    /// Of each object, by its number, whether a ray met it.
    pub met: Vec<bool>,
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
pub struct Pairs(BTreeMap<(String, String), Pair>);

impl Pairs {
    pub fn add(&mut self, a: &str, b: &str, point: Vec3) {
        let (first, second) = (a.min(b).to_string(), a.max(b).to_string());
        let key = (first.clone(), second.clone());
        self.0.entry(key).or_insert(Pair { first, second, point, rays: 0 }).rays += 1;
    }

    pub fn has(&self, a: &str, b: &str) -> bool {
        self.0.contains_key(&(a.min(b).to_string(), a.max(b).to_string()))
    }

    fn into_list(self) -> Vec<Pair> {
        self.0.into_values().collect()
    }
}

/// Rays along each axis.
const RAYS: u32 = 2048;

/// Where rays meet so many parts that this many crossings are found, fewer rays have to do, but so many at least.
const MOST_CROSSINGS: usize = 1 << 22;
const LEAST_RAYS: usize = 300;

/// Pairs of objects without an end that are named, at most.
const NAMED: usize = 5;

/// Casts rays along the axes, spread over the box of all objects that have an end, and then through the common boxes of
/// parts whose boxes meet; what is small may slip through.
///
/// An object without an end is cut by that box. So it is seen where it overlaps one that has an end; where it overlaps
/// another without an end is seen if that is near by, and reported as unexamined otherwise.
pub fn survey(world: &World) -> Survey {
    let mut met_objects = vec![false; world.object_names().len()];
    let objects = match object_bounds(world) {
        Ok(objects) => objects,
        // What was not looked for is not missed.
        Err(error) => {
            met_objects.fill(true);
            return Survey { unexamined: vec![error.to_string()], met: met_objects, ..Survey::default() };
        }
    };
    if world.path_count() <= 1 {
        // A single part cannot overlap another, and rays through a mesh of long thin triangles are slow.
        let unexamined = unexamined(world, &objects, &Pairs::default());
        return Survey { unexamined, met: met_objects, ..Survey::default() };
    }
    let (mut caster, mut hits) = (Caster::new(world), Vec::new());
    let (mut overlaps, mut coincidences) = (Pairs::default(), Pairs::default());
    let bounds = surveyed(&objects);
    let (mut rays, mut met, mut few_rays, mut given_up) = (0, 0, None, None);
    // Any number of rays from the first on is spread evenly, so the survey may end early.
    for ray in (0..RAYS).flat_map(|i| (0..3).filter_map(move |axis| spread(&bounds, axis, i))) {
        if met > MOST_CROSSINGS && rays >= LEAST_RAYS {
            few_rays = Some(rays);
            break;
        }
        rays += 1;
        hits.clear();
        let seen = overlap::on_ray(&mut caster, &ray, Span::FORWARD);
        let seen = seen.and_then(|seen| caster.crossings(&ray, Span::FORWARD, &mut hits).map(|()| seen));
        let seen = match seen {
            Ok(seen) => seen,
            Err(error) => {
                // The other rays would cost as much.
                given_up = Some(format!("a ray was given up: {error}"));
                break;
            }
        };
        met += hits.len();
        hits.iter().for_each(|hit| met_objects[hit.object as usize] = true);
        for overlap in seen {
            let point = ray.at(overlap.t_in.midpoint(overlap.t_out.min(f64::MAX)));
            let point = if point.is_finite() { point } else { ray.at(overlap.t_in) };
            overlaps.add(&overlap.first, &overlap.second, point);
        }
        for ((a, b), t) in coincidences_on_ray(&hits) {
            let names = world.object_names();
            coincidences.add(&names[a as usize], &names[b as usize], ray.at(t));
        }
    }
    let close = if given_up.is_none() { close::look(world, &bounds, &mut overlaps) } else { Vec::new() };
    let mut unexamined = unexamined(world, &objects, &overlaps);
    unexamined.extend(given_up.into_iter().chain(close));
    let (overlaps, coincidences) = (overlaps.into_list(), coincidences.into_list());
    Survey { overlaps, coincidences, unexamined, few_rays, met: met_objects }
}

fn is_endless(bounds: &Aabb) -> bool {
    !bounds.is_empty() && !bounds.is_finite()
}

/// The box that rays are spread over: of the objects that have an end, and of the sides that others have.
fn surveyed(objects: &[Aabb]) -> Aabb {
    let mut b = objects.iter().filter(|b| b.is_finite()).fold(Aabb::EMPTY, |all, b| all.union(b));
    for other in objects.iter().filter(|b| is_endless(b)) {
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
        // Where nothing tells where to look: about the origin. Where all sides are one plane: on both sides of it.
        if b.min[axis] > b.max[axis] {
            (b.min[axis], b.max[axis]) = (0.0, 0.0);
        }
        if b.min[axis] == b.max[axis] {
            (b.min[axis], b.max[axis]) = (b.min[axis] - size, b.max[axis] + size);
        }
    }
    if objects.iter().all(Aabb::is_empty) { Aabb::EMPTY } else { b }
}

/// Pairs of objects without an end that were not seen to overlap, but might do so far away.
fn unexamined(world: &World, objects: &[Aabb], seen: &Pairs) -> Vec<String> {
    let endless: Vec<u32> = (0..).zip(objects).filter(|(_, b)| is_endless(b)).map(|(i, _)| i).collect();
    let name = |object: u32| world.object_names()[object as usize].as_str();
    let (mut out, mut more) = (Vec::new(), 0);
    for (i, &a) in endless.iter().enumerate() {
        for &b in &endless[i + 1..] {
            let common = objects[a as usize].intersection(&objects[b as usize]);
            let apart = !common.min.cmplt(common.max).all();
            if apart || world.object_priority(a) != world.object_priority(b) || seen.has(name(a), name(b)) {
                continue;
            }
            if out.len() < NAMED {
                out.push(format!("'{}' and '{}' have no end: far away they might overlap", name(a), name(b)));
            } else {
                more += 1;
            }
        }
    }
    if more > 0 {
        out.push(format!("{more} more pairs of objects that have no end"));
    }
    out
}

/// Cosine of the angle between the normals of two faces in one place, at least.
const PARALLEL: f64 = 1.0 - 1e-6;

/// Pairs of objects that have faces with parallel normals in one event of the ray, with the first such `t`. Surfaces that
/// intersect each other do not count. Where many objects are in one place, each makes a pair with the next.
fn coincidences_on_ray(hits: &[Hit]) -> BTreeMap<(u32, u32), f64> {
    let (low, high) = (|h: &Hit| h.t - GROUPING * h.t_err, |h: &Hit| h.t + GROUPING * h.t_err);
    let mut pairs = BTreeMap::new();
    for event in hits.chunk_by(|a, b| low(b) <= high(a)) {
        let of = |object: u32| event.iter().filter(move |h| h.kind == HitKind::Surface && h.object == object);
        let mut objects: Vec<u32> = event.iter().map(|h| h.object).collect();
        objects.sort_unstable();
        objects.dedup();
        for pair in objects.windows(2) {
            let along = |a: &Hit| of(pair[1]).any(|b| a.normal.dot(b.normal).abs() >= PARALLEL);
            if of(pair[0]).any(along) {
                pairs.entry((pair[0], pair[1])).or_insert(event[0].t);
            }
        }
    }
    pairs
}

/// The i-th ray along an axis through a box. The points are spread by the additive sequence of the plastic
/// number (M. Roberts, 2018), which has no rows that could run along a model's own.
pub fn spread(bounds: &Aabb, axis: usize, i: u32) -> Option<Ray> {
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
