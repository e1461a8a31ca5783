//! Overlaps of objects looked for where their parts meet, however small that place is in the whole scene.

use std::collections::HashMap;

use shotline::aabb::Aabb;
use shotline::compile::{OverlapCandidate, World};
use shotline::math::Vec3;
use shotline::query::{Caster, QueryError};
use shotline::ray::{Ray, Span};

use crate::number::grouped;
use crate::overlap::{self, Overlap};
use crate::survey::{Pairs, spread};

/// Comparisons of boxes, at most.
const COMPARISONS: u64 = 1 << 25;

/// Rays for each pair of parts, at least and at most.
const LEAST_RAYS: usize = 32;
const MOST_RAYS: usize = 1536;

/// Rays for all pairs where they are few, and at most.
const USUAL_RAYS: usize = 1 << 17;
const ALL_RAYS: usize = 1 << 20;

/// Work of rays on boxes and solids. Beyond it each pair gets the fewest rays; beyond `TIMES` as much, no ray.
const WORK: u64 = 1 << 22;
const TIMES: u64 = 16;

/// Casts rays through the common boxes of parts of different objects, the largest box first, and adds the overlaps. It skips
/// pairs of objects that are known to overlap, and clips unbounded boxes to `bounds`. Returns what could not be examined.
pub fn look(world: &World, bounds: &Aabb, overlaps: &mut Pairs) -> Vec<String> {
    let mut candidates = world.overlap_candidates(ALL_RAYS / LEAST_RAYS, COMPARISONS);
    let kept = candidates.pairs.len() as u64;
    candidates.pairs.iter_mut().filter(|m| !m.common.is_finite()).for_each(|m| {
        m.common = m.common.intersection(bounds);
    });
    // The survey reports that two unbounded objects are not examined far away.
    candidates.pairs.retain(|m| m.common.min.cmplt(m.common.max).all() && m.common.is_finite());
    in_turns(&mut candidates.pairs);
    let mut look = Look { caster: Caster::new(world), rays: 0, work: 0, least: false };
    let (examined, error) = look.through_all(&candidates.pairs, overlaps);
    let beyond = kept - candidates.pairs.len() as u64;
    let examined = examined as u64 + beyond;
    let mut unexamined = Vec::new();
    if let Some(error) = error {
        unexamined.push(format!("overlaps where boxes of parts meet: a ray was given up: {error}"));
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

/// Orders pairs of parts: the largest box of each pair of objects first, then the second of each.
fn in_turns(pairs: &mut Vec<OverlapCandidate>) {
    let volume = |m: &OverlapCandidate| m.common.size().element_product();
    pairs.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
    let mut turns: HashMap<[u32; 2], usize> = HashMap::new();
    let turn = |m: &OverlapCandidate| {
        let turn = turns.entry(m.objects).or_insert(0);
        *turn += 1;
        *turn
    };
    let numbers: Vec<usize> = pairs.iter().map(turn).collect();
    let mut numbered: Vec<(usize, OverlapCandidate)> = numbers.into_iter().zip(pairs.drain(..)).collect();
    numbered.sort_by_key(|(turn, _)| *turn);
    pairs.extend(numbered.into_iter().map(|(_, pair)| pair));
}

/// Rays on their way through pairs.
struct Look<'w> {
    caster: Caster<'w>,
    rays: usize,
    work: u64,
    /// Whether pairs have no more rays than the least.
    least: bool,
}

impl Look<'_> {
    /// Returns how many pairs were examined, and why it ended early.
    fn through_all(
        &mut self,
        pairs: &[OverlapCandidate],
        overlaps: &mut Pairs,
    ) -> (usize, Option<QueryError>) {
        let each = (USUAL_RAYS / pairs.len().max(1)).clamp(LEAST_RAYS, MOST_RAYS);
        for (number, pair) in pairs.iter().enumerate() {
            let [a, b] =
                pair.objects.map(|object| self.caster.world().object_names()[object as usize].clone());
            if overlaps.has(&a, &b) {
                continue;
            }
            self.least = self.work > WORK;
            if self.rays + LEAST_RAYS > ALL_RAYS || self.work > TIMES * WORK {
                return (number, None);
            }
            if let Err(error) = self.through(&pair.common, each, [&a, &b], overlaps) {
                // The other pairs would cost as much.
                return (number, Some(error));
            }
        }
        (pairs.len(), None)
    }

    /// Casts rays along the axes through a box, until two objects are seen to overlap.
    fn through(
        &mut self,
        bounds: &Aabb,
        rays: usize,
        [a, b]: [&str; 2],
        overlaps: &mut Pairs,
    ) -> Result<(), QueryError> {
        let share = WORK / (USUAL_RAYS / rays).max(1) as u64;
        let before = self.work;
        for i in 0..rays {
            let expensive = self.least || self.work - before > share;
            if overlaps.has(a, b) || (expensive && i >= LEAST_RAYS) {
                break;
            }
            let axis = i % 3;
            let Some(ray) = spread(bounds, axis, (i / 3) as u32) else { continue };
            for found in self.wide(&ray, bounds, axis)? {
                let p = ray.at(found.t_in.midpoint(found.t_out));
                if self.is_overlap_at(p, bounds, axis)? {
                    overlaps.add(&found.first, &found.second, p);
                }
            }
        }
        Ok(())
    }

    /// The overlaps on a ray along an axis in a box that are longer than their bounds.
    fn wide(&mut self, ray: &Ray, bounds: &Aabb, axis: usize) -> Result<Vec<Overlap>, QueryError> {
        let from = bounds.min[axis] - ray.origin()[axis];
        let Ok(span) = Span::new(from, from + bounds.size()[axis]) else { return Ok(Vec::new()) };
        let mut found = overlap::on_ray(&mut self.caster, ray, span)?;
        found.retain(Overlap::is_wide);
        self.rays += 1;
        let work = self.caster.take_counters();
        self.work += work.boxes + work.cells + work.planes + work.primitive_tests + work.heap_pushes;
        Ok(found)
    }

    /// Whether objects overlap at a point along the other axes, too: where they only touch, a ray in the gap between
    /// rounding errors may run in both of them for long.
    fn is_overlap_at(&mut self, p: Vec3, bounds: &Aabb, seen: usize) -> Result<bool, QueryError> {
        for axis in (0..3).filter(|axis| *axis != seen) {
            let (mut origin, mut direction) = (p, Vec3::ZERO);
            origin[axis] = bounds.min[axis] - bounds.size()[axis];
            direction[axis] = 1.0;
            let Ok(ray) = Ray::new(origin, direction) else { return Ok(false) };
            let t = p[axis] - origin[axis];
            if !self.wide(&ray, bounds, axis)?.iter().any(|o| o.t_in <= t && t <= o.t_out) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
