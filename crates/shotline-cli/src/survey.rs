//! Looks through a world with many rays for objects that get in each other's way.

use std::collections::BTreeMap;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::crossing::GROUPING;
use shotline::math::Vec3;
use shotline::measure::{Range, object_bounds};
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

/// Rays along each axis that look for an object that may be empty, and for all of them together.
const RAYS_OF_OBJECT: u32 = 128;
const RAYS_OF_OBJECTS: usize = 1 << 16;

/// Where rays meet so many parts that this many crossings are found, fewer rays have to do, but so many at least.
const MOST_CROSSINGS: usize = 1 << 22;
const LEAST_RAYS: usize = 300;

/// Pairs of objects without an end that are named, at most.
const NAMED: usize = 5;

/// Casts rays along the axes, spread over the box of all objects that have an end, and over the common boxes of parts
/// whose boxes meet; what is small may slip through.
///
/// An object without an end is cut by that box. So it is seen where it overlaps one that has an end; where it overlaps
/// another without an end is seen if that is near by, and reported as unexamined otherwise.
pub fn survey(world: &World) -> Survey {
    let objects = match object_bounds(world) {
        Ok(objects) => objects,
        Err(error) => return Survey { unexamined: vec![error.to_string()], ..Survey::default() },
    };
    if world.path_count() <= 1 {
        // A single part cannot overlap another, and rays through a mesh of long thin triangles are slow.
        return Survey { unexamined: unexamined(world, &objects, &Pairs::default()), ..Survey::default() };
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
    let close = close::look(world, &mut overlaps);
    let mut unexamined = unexamined(world, &objects, &overlaps);
    unexamined.extend(given_up);
    unexamined.extend(close);
    Survey { overlaps: overlaps.into_list(), coincidences: coincidences.into_list(), unexamined, few_rays }
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

/// Objects that seem to be empty, each with the reason: the box has no volume, or no ray through it meets a surface.
pub fn empty(world: &World) -> Vec<(String, String)> {
    let Ok(objects) = object_bounds(world) else { return Vec::new() };
    let (mut caster, mut rays, mut found) = (Caster::new(world), 0, Vec::new());
    for (object, bounds) in (0..).zip(&objects).filter(|(_, bounds)| !is_endless(bounds)) {
        let name = world.object_names()[object as usize].clone();
        if bounds.is_empty() {
            found.push((name, "is empty: nothing is left of it".to_string()));
        } else if rays < RAYS_OF_OBJECTS && is_unseen(&mut caster, object, bounds, &mut rays) {
            let count = 3 * RAYS_OF_OBJECT;
            found.push((
                name,
                format!("is empty or very thin: none of {count} rays through its box meets it"),
            ));
        }
    }
    found
}

/// Whether no ray through its box meets an object.
fn is_unseen(caster: &mut Caster, object: u32, bounds: &Aabb, rays: &mut usize) -> bool {
    let mut hits = Vec::new();
    for ray in (0..RAYS_OF_OBJECT).flat_map(|i| (0..3).filter_map(move |axis| spread(bounds, axis, i))) {
        *rays += 1;
        hits.clear();
        let met = caster.crossings(&ray, Span::FORWARD, &mut hits);
        if met.is_err() || hits.iter().any(|hit: &Hit| hit.object == object) {
            return false;
        }
    }
    true
}

/// Why the volumes of objects are not numbers, where they overflow or underflow.
pub fn out_of_range(world: &World) -> Vec<String> {
    let objects = object_bounds(world).unwrap_or_default();
    let named = world.object_names().iter().zip(&objects).filter(|(_, bounds)| bounds.is_finite());
    named
        .filter_map(|(name, bounds)| {
            let range = match bounds.size().element_product() {
                volume if !volume.is_finite() => Range::TooLarge,
                _ if bounds.volume_vanishes() => Range::TooSmall,
                _ => return None,
            };
            Some(format!("the volume of '{name}', which may be too {range} for a 64-bit number"))
        })
        .collect()
}
