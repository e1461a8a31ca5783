//! Overlaps in the common boxes of two leaves, so that they are found however small they are in the whole scene.

use std::collections::HashMap;

use shotline::aabb::Aabb;
use shotline::compile::{ConflictCandidate, World};
use shotline::query::{Caster, QueryError};
use shotline::ray::Ray;

use super::axis_ray::axis_ray;
use super::extent::extent;
use super::on_ray::{Conflict, is_conflict_at, wide_conflicts};
use super::pairs::PairSet;
use crate::number::grouped;

/// The maximum number of comparisons of boxes.
const MAX_COMPARISONS: u64 = 1 << 25;

/// The minimum and maximum number of rays for each pair of leaves.
const MIN_RAYS: usize = 32;
const MAX_RAYS: usize = 1536;

/// The number of rays for all pairs if there are few pairs, and the maximum for all pairs.
const USUAL_RAYS: usize = 1 << 17;
const MAX_ALL_RAYS: usize = 1 << 20;

/// A limit on the work of rays. Beyond it, each pair gets only `MIN_RAYS` rays. Beyond `WORK_FACTOR` times as much, no
/// more rays are cast.
const WORK: u64 = 1 << 22;
const WORK_FACTOR: u64 = 16;

/// The work of a ray, and of each of its intervals inside parts: counts that no accelerator changes, so that every one
/// gives the same report.
const WORK_OF_RAY: u64 = 8;
const WORK_OF_INTERVAL: u64 = 8;

/// Casts rays through the common boxes of leaves of different objects, the largest box first, and adds the overlaps. It
/// skips pairs of objects that are known to overlap, and clips unbounded boxes to `bounds`. Returns what could not be
/// examined.
pub fn sample_leaf_pairs(world: &World, bounds: &Aabb, overlaps: &mut PairSet) -> Vec<String> {
    let mut candidates = world.conflict_candidates(MAX_ALL_RAYS / MIN_RAYS, MAX_COMPARISONS);
    let listed = candidates.pairs.len() as u64;
    candidates.pairs.iter_mut().filter(|m| !m.place.is_finite()).for_each(|m| {
        m.place = m.place.intersection(bounds);
    });
    // `sample_world` reports that two unbounded objects are not examined far away.
    candidates.pairs.retain(|m| m.place.min.cmplt(m.place.max).all() && m.place.is_finite());
    order_round_robin(&mut candidates.pairs);
    let mut sampler = Sampler { caster: Caster::new(world), rays: 0, work: 0, fewest_rays: false };
    let (examined, error) = sampler.sample_all(&candidates.pairs, overlaps);
    let error =
        error.or_else(|| estimate_extents(&mut sampler.caster, &candidates.pairs, bounds, overlaps).err());
    let outside = listed - candidates.pairs.len() as u64;
    let examined = examined as u64 + outside;
    let mut unexamined = Vec::new();
    if let Some(error) = error {
        unexamined.push(format!("overlaps where boxes of parts meet: a ray failed: {error}"));
    }
    if candidates.has_cut_lattices {
        let why = "of lattices of more than 65,536 cells only those near a corner were compared";
        unexamined.push(format!("overlaps of some parts: {why}"));
    }
    if examined < candidates.count || !candidates.complete {
        let at_least = if candidates.complete { "" } else { "at least " };
        let (examined, count) = (grouped(examined), grouped(candidates.count));
        unexamined.push(format!(
            "overlaps of some parts: of {at_least}{count} pairs of parts whose boxes meet, {examined} were examined"
        ));
    }
    unexamined
}

/// The maximum number of pairs whose extent is estimated.
const MAX_ESTIMATED: usize = 50;

/// Estimates how large overlaps and protrusions are: in the smallest place of a candidate around their points, or in `bounds`.
fn estimate_extents(
    caster: &mut Caster,
    candidates: &[ConflictCandidate],
    bounds: &Aabb,
    overlaps: &mut PairSet,
) -> Result<(), QueryError> {
    let volume = |b: &Aabb| b.size().element_product();
    for pair in overlaps.pairs_mut().take(MAX_ESTIMATED) {
        let is_around = |candidate: &&ConflictCandidate| {
            let Aabb { min, max } = candidate.place;
            let names = candidate.objects.map(|object| &caster.world().object_names()[object as usize]);
            candidate.kind == pair.kind
                && (names == [&pair.first, &pair.second] || names == [&pair.second, &pair.first])
                && min.cmple(pair.point).all()
                && pair.point.cmple(max).all()
        };
        let places = candidates.iter().filter(is_around).map(|candidate| candidate.place);
        let place = places.min_by(|a, b| volume(a).total_cmp(&volume(b))).unwrap_or(*bounds);
        pair.extent = extent(caster, (pair.kind, [&pair.first, &pair.second]), &place)?;
    }
    Ok(())
}

/// Orders pairs of leaves: the largest box of each pair of objects first, then the second of each, and so on.
fn order_round_robin(pairs: &mut Vec<ConflictCandidate>) {
    let volume = |m: &ConflictCandidate| m.place.size().element_product();
    pairs.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    let mut rounds: HashMap<[u32; 2], usize> = HashMap::new();
    let round = |m: &ConflictCandidate| {
        let round = rounds.entry(m.objects).or_insert(0);
        *round += 1;
        *round
    };
    let numbers: Vec<usize> = pairs.iter().map(round).collect();
    let mut numbered: Vec<(usize, ConflictCandidate)> = numbers.into_iter().zip(pairs.drain(..)).collect();
    numbered.sort_by_key(|(round, _)| *round);
    pairs.extend(numbered.into_iter().map(|(_, pair)| pair));
}

/// Casts the rays, and counts them and their work.
struct Sampler<'w> {
    caster: Caster<'w>,
    rays: usize,
    work: u64,
    /// Whether each pair gets only `MIN_RAYS` rays.
    fewest_rays: bool,
}

impl Sampler<'_> {
    /// Returns how many pairs were examined, and the error that ended the search early.
    fn sample_all(
        &mut self,
        pairs: &[ConflictCandidate],
        overlaps: &mut PairSet,
    ) -> (usize, Option<QueryError>) {
        let rays_per_pair = (USUAL_RAYS / pairs.len().max(1)).clamp(MIN_RAYS, MAX_RAYS);
        for (number, pair) in pairs.iter().enumerate() {
            let names = self.caster.world().object_names();
            let names = pair.objects.map(|object| names[object as usize].as_str());
            if overlaps.contains(pair.kind, names) {
                continue;
            }
            self.fewest_rays = self.work > WORK;
            if self.rays + MIN_RAYS > MAX_ALL_RAYS || self.work > WORK_FACTOR * WORK {
                return (number, None);
            }
            if let Err(error) = self.sample_pair(pair, rays_per_pair, names, overlaps) {
                // The other pairs would be as expensive.
                return (number, Some(error));
            }
        }
        (pairs.len(), None)
    }

    /// Casts rays along the axes through the place of a pair, until two objects with their names are found in conflict.
    fn sample_pair(
        &mut self,
        &ConflictCandidate { kind, place: bounds, .. }: &ConflictCandidate,
        rays: usize,
        names: [&str; 2],
        overlaps: &mut PairSet,
    ) -> Result<(), QueryError> {
        let max_work = WORK / (USUAL_RAYS / rays).max(1) as u64;
        let before = self.work;
        for i in 0..rays {
            let is_expensive = self.fewest_rays || self.work - before > max_work;
            if overlaps.contains(kind, names) || (is_expensive && i >= MIN_RAYS) {
                break;
            }
            let axis = i % 3;
            let Some(ray) = axis_ray(&bounds, axis, (i / 3) as u32) else { continue };
            for found in self.wide_conflicts(&ray, &bounds, axis)? {
                let p = ray.at(found.t_in.midpoint(found.t_out));
                if is_conflict_at(&mut self.caster, p, &bounds, axis)? {
                    overlaps.add(found.kind, [&found.first, &found.second], p);
                }
            }
        }
        Ok(())
    }

    /// The overlaps on a ray along an axis in a box that are longer than their error bounds.
    fn wide_conflicts(&mut self, ray: &Ray, bounds: &Aabb, axis: usize) -> Result<Vec<Conflict>, QueryError> {
        let (found, intervals) = wide_conflicts(&mut self.caster, ray, bounds, axis)?;
        self.rays += 1;
        self.work += WORK_OF_RAY + WORK_OF_INTERVAL * intervals as u64;
        Ok(found)
    }
}
