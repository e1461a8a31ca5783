//! Ownership: which instance of an object owns each part of a ray.
//!
//! Where several instances contain a point, the one of the highest priority owns it; of equal priorities, one that is in
//! another displaces it. If neither is in the other, they overlap, and the one that is placed later owns the point: at the
//! first object that is not around both, as a search from the outermost object down to the innermost finds it. What an object that clips contains counts only inside it. The cost for `n` intervals is
//! `O(n log n)` without clipping, however they are nested; clipping adds the number of intervals that stick out.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::instances::{Instance, Instances, NONE, is_in};
use super::interval_ends::{End, Interval, are_apart, ends, events};
use super::{Conflict, ConflictKind, Overlaps, QueryError, Segment};
use crate::budget::Budget;
use crate::compile::World;
use crate::crossing::Crossing;
use crate::math::length;
use crate::ray::Ray;

/// The memory of a sweep over intervals; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct OwnershipScratch<'w> {
    instances: Instances<'w>,
    /// The instance of each interval.
    of_interval: Vec<u32>,
    /// For each instance the number of intervals that contain the ray, and whether its contents count.
    inside: Vec<u32>,
    counts: Vec<bool>,
    /// The intervals that contain the ray, by instance, if anything clips.
    present: BTreeSet<(u32, usize)>,
    /// Those that count, by rank.
    ranked: BTreeSet<Rank>,
    /// Those that overlap the one that ranks next below.
    overlapping: BTreeSet<Rank>,
}

/// The rank of an interval: by priority, then the later instance, which comes after those that it is in, then the lower path. The
/// last field is the index of the interval; intervals of one path follow each other along the ray.
type Rank = (i32, u32, Reverse<u64>, usize);

/// The interval that owns the ray, and the one that ranks highest of those that it overlaps.
type Pair = (usize, usize);

/// Converts the intervals of all bodies to segments, ascending, and returns the number of overlaps of equal priority.
/// The result is invalid if the budget has ended.
pub(super) fn resolve<'w>(
    world: &'w World,
    ray: &Ray,
    intervals: &[Interval],
    overlaps: Overlaps,
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    out: &mut Vec<Segment>,
) -> Result<u64, QueryError> {
    if out.try_reserve(intervals.len()).is_err() {
        return Err(QueryError::OutOfMemory);
    }
    let first = out.len();
    let segment = segment_of(world, ray);
    let whole = |i: &Interval| segment(i.start.t, i.end.t, i);
    if overlaps == Overlaps::All {
        out.extend(intervals.iter().map(whole));
        out[first..].sort_by(|a, b| a.t_in.total_cmp(&b.t_in).then(a.path.cmp(&b.path)));
        return Ok(0);
    }
    if !world.clips() && are_apart(intervals) {
        out.extend(intervals.iter().map(whole));
        return Ok(0);
    }
    sweep(world, ray, intervals, overlaps, scratch, budget, out)
}

/// Makes the segment from `start` to `end` of an interval on a ray.
fn segment_of(world: &World, ray: &Ray) -> impl Fn(f64, f64, &Interval) -> Segment {
    let step = length(ray.direction());
    move |t_in, t_out, &Interval { object, path, .. }| Segment {
        t_in,
        t_out,
        length: (t_out - t_in) * step,
        object,
        material: world.object_material(object),
        path,
    }
}

/// Determines which interval owns each part of the ray, event by event.
fn sweep<'w>(
    world: &'w World,
    ray: &Ray,
    intervals: &[Interval],
    overlaps: Overlaps,
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    out: &mut Vec<Segment>,
) -> Result<u64, QueryError> {
    let segment = segment_of(world, ray);
    let mut sweep = Ownership::new(world, intervals, scratch);
    // The start of a segment whose end is not known yet, and the interval that owns it now.
    let mut owned: Option<(f64, usize)> = None;
    let mut overlap_count = 0;
    let ends = ends(intervals);
    let mut events = events(&ends);
    while let Some(event) = events.next() {
        if !budget.step() {
            break;
        }
        let before = owned.map(|(_, interval)| interval);
        sweep.apply(event);
        let after = sweep.owner();
        if let Some(pair) = sweep.overlapping_pair() {
            overlap_count += 1;
            if overlaps == Overlaps::Error {
                let begin = t_of_pair(event, pair);
                let is_last = |sweep: &mut Ownership, event: &[End]| {
                    sweep.apply(event);
                    sweep.overlapping_pair() != Some(pair)
                };
                let last = events.find(|event| is_last(&mut sweep, event)).unwrap_or(event);
                return Err(sweep.overlap(pair, begin, t_of_pair(last, pair)).error(world));
            }
        }
        if let (Some((start, before)), Some(after)) = (owned, after)
            && intervals[before].path == intervals[after].path
        {
            // Intervals of one body that touch are joined.
            owned = Some((start, after));
            continue;
        }
        // The interval's own end if it is part of the event, otherwise the first end of the event.
        let t_of = |interval: Option<usize>| {
            let own = event.iter().find(|e| Some(e.interval) == interval);
            own.unwrap_or(&event[0]).crossing.t
        };
        if let Some((start, interval)) = owned.take() {
            let stops = event.iter().any(|e| e.interval == interval);
            let end = t_of(if stops { before } else { after });
            if start < end {
                out.push(segment(start, end, &intervals[interval]));
            }
        }
        owned = after.map(|interval| {
            let begins = event.iter().any(|e| e.interval == interval);
            (t_of(if begins { after } else { before }), interval)
        });
    }
    Ok(overlap_count)
}

/// Appends the overlaps of equal priority, which are ascending and disjoint, and the protrusions. Each overlap is between the
/// interval that owns the ray and the one that ranks highest of those that it overlaps. Invalid if the budget has ended.
pub(super) fn conflicts<'w>(
    world: &'w World,
    intervals: &[Interval],
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    out: &mut Vec<Conflict>,
) {
    let mut sweep = Ownership::new(world, intervals, scratch);
    // The pair that overlaps now, and where it has begun to.
    let mut overlapping: Option<(Pair, Crossing)> = None;
    let mut protruding = BTreeMap::new();
    for event in events(&ends(intervals)) {
        if !budget.step() {
            return;
        }
        sweep.apply(event);
        if world.clips() {
            sweep.protrusions(event, &mut protruding, out);
        }
        let now = sweep.overlapping_pair();
        if let Some((pair, begin)) = overlapping.take_if(|(pair, _)| now != Some(*pair)) {
            out.push(sweep.overlap(pair, begin, t_of_pair(event, pair)));
        }
        if overlapping.is_none() {
            overlapping = now.map(|pair| (pair, t_of_pair(event, pair)));
        }
    }
}

/// The end of one of two intervals in an event; if neither ends there, the first end.
fn t_of_pair(event: &[End], (a, b): Pair) -> Crossing {
    let own = event.iter().find(|end| end.interval == a || end.interval == b);
    own.unwrap_or(&event[0]).crossing
}

fn t_err_of(event: &[End]) -> f64 {
    event.iter().map(|end| end.crossing.t_err).fold(0.0, f64::max)
}

/// Which of the bodies that contain a point count: the others are in instances that clip and do not contain it. The first
/// result is the one that owns the point.
pub(super) fn at_point<'w>(
    world: &'w World,
    bodies: &[(u64, u32)],
    scratch: &mut OwnershipScratch<'w>,
) -> Vec<(u64, u32)> {
    let here = Crossing::new(0.0, 0.0, true, 0);
    let interval = |&(path, object): &(u64, u32)| Interval { start: here, end: here, object, path };
    let intervals: Vec<Interval> = bodies.iter().map(interval).collect();
    let mut sweep = Ownership::new(world, &intervals, scratch);
    let event: Vec<End> = (0..intervals.len()).map(|interval| End { crossing: here, interval }).collect();
    sweep.apply(&event);
    sweep.memory.ranked.iter().rev().map(|(.., interval)| bodies[*interval]).collect()
}

/// Determines which interval owns the ray after an event.
struct Ownership<'a, 'w> {
    world: &'w World,
    intervals: &'a [Interval],
    memory: &'a mut OwnershipScratch<'w>,
}

impl<'a, 'w> Ownership<'a, 'w> {
    fn new(
        world: &'w World,
        intervals: &'a [Interval],
        memory: &'a mut OwnershipScratch<'w>,
    ) -> Ownership<'a, 'w> {
        // A ray that ended with an error may have left entries.
        memory.present.clear();
        memory.ranked.clear();
        memory.overlapping.clear();
        memory.instances.begin(world);
        memory.of_interval.clear();
        memory.of_interval.resize(intervals.len(), NONE);
        let mut by_path: Vec<usize> = (0..intervals.len()).collect();
        by_path.sort_unstable_by_key(|&interval| intervals[interval].path);
        for interval in by_path {
            let instance = memory.instances.of_path(world, intervals[interval].path);
            memory.of_interval[interval] = instance;
        }
        let count = memory.instances.finish().len();
        memory.inside.clear();
        memory.inside.resize(count, 0);
        memory.counts.clear();
        memory.counts.resize(count, false);
        Ownership { world, intervals, memory }
    }

    fn instances(&self) -> &[Instance] {
        self.memory.instances.all()
    }

    /// The instance of an interval.
    fn instance(&self, interval: usize) -> u32 {
        self.memory.of_interval[interval]
    }

    fn rank(&self, interval: usize) -> Rank {
        let Interval { object, path, .. } = self.intervals[interval];
        (self.world.object_priority(object), self.instance(interval), Reverse(path), interval)
    }

    fn apply(&mut self, event: &[End]) {
        // An interval that begins and ends in the same event is inserted and removed here: it has no length.
        for end in event.iter().filter(|end| end.crossing.entering) {
            self.enter(end.interval);
        }
        for end in event.iter().filter(|end| !end.crossing.entering) {
            self.leave(end.interval);
        }
        if self.world.clips() {
            for instance in self.touched(event) {
                self.settle(instance);
            }
        }
    }

    fn enter(&mut self, interval: usize) {
        if self.world.clips() {
            let instance = self.instance(interval);
            self.memory.inside[instance as usize] += 1;
            self.memory.present.insert((instance, interval));
        } else {
            self.insert(self.rank(interval));
        }
    }

    fn leave(&mut self, interval: usize) {
        self.remove(self.rank(interval));
        if self.world.clips() {
            let instance = self.instance(interval);
            self.memory.inside[instance as usize] -= 1;
            self.memory.present.remove(&(instance, interval));
        }
    }

    /// The instances of an event, each after those that it is in.
    fn touched(&self, event: &[End]) -> Vec<u32> {
        let mut touched: Vec<u32> = event.iter().map(|end| self.instance(end.interval)).collect();
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    /// Decides which intervals of an instance count, and of what it contains if that has changed.
    fn settle(&mut self, instance: u32) {
        let end = self.instances()[instance as usize].end;
        let counts = self.memory.inside[instance as usize] > 0 && self.contents_count(instance);
        let has_changed = std::mem::replace(&mut self.memory.counts[instance as usize], counts) != counts;
        let last = if has_changed { end } else { instance };
        let present = self.memory.present.range((instance, 0)..(last + 1, 0));
        for (instance, interval) in present.copied().collect::<Vec<_>>() {
            let counts = self.contents_count(instance);
            self.memory.counts[instance as usize] = counts;
            if counts {
                self.insert(self.rank(interval));
            } else {
                self.remove(self.rank(interval));
            }
        }
    }

    /// Whether the ray is in all instances around an instance that clip.
    fn contents_count(&self, instance: u32) -> bool {
        let clip = self.instances()[instance as usize].clip;
        clip == NONE || self.memory.counts[clip as usize]
    }

    fn insert(&mut self, rank: Rank) {
        if !self.memory.ranked.insert(rank) {
            return;
        }
        let (below, above) = self.neighbours(rank);
        self.compare(below, Some(rank));
        self.compare(Some(rank), above);
    }

    fn remove(&mut self, rank: Rank) {
        if !self.memory.ranked.remove(&rank) {
            return;
        }
        self.memory.overlapping.remove(&rank);
        let (below, above) = self.neighbours(rank);
        self.compare(below, above);
    }

    /// What ranks next below and next above.
    fn neighbours(&self, rank: Rank) -> (Option<Rank>, Option<Rank>) {
        let ranked = &self.memory.ranked;
        let above = ranked.range((std::ops::Bound::Excluded(rank), std::ops::Bound::Unbounded)).next();
        (ranked.range(..rank).next_back().copied(), above.copied())
    }

    /// Notes whether an interval overlaps the one that ranks next below. Of the intervals of the highest priority, some
    /// overlap if and only if two neighbours do: otherwise each is in the next one.
    fn compare(&mut self, below: Option<Rank>, rank: Option<Rank>) {
        let Some(rank) = rank else { return };
        if below.is_some_and(|below| self.do_overlap(below, rank)) {
            self.memory.overlapping.insert(rank);
        } else {
            self.memory.overlapping.remove(&rank);
        }
    }

    fn do_overlap(&self, below: Rank, above: Rank) -> bool {
        let [outer, inner] = [below, above].map(|(.., interval)| self.instance(interval));
        below.0 == above.0 && outer != inner && !is_in(self.instances(), inner, outer)
    }

    /// The interval of the highest rank.
    fn owner(&self) -> Option<usize> {
        self.memory.ranked.last().map(|(.., interval)| *interval)
    }

    /// The interval of the highest rank among those that overlap the owner.
    fn rival(&self, owner: usize) -> Option<usize> {
        let rank = self.memory.overlapping.last()?;
        let (below, _) = self.neighbours(*rank);
        let owner = self.intervals[owner].object;
        let is_of_owner = rank.0 == self.world.object_priority(owner);
        below.filter(|_| is_of_owner).map(|(.., interval)| interval)
    }

    /// The pair that overlaps now.
    fn overlapping_pair(&self) -> Option<Pair> {
        let owner = self.owner()?;
        self.rival(owner).map(|rival| (owner, rival))
    }

    /// The overlap of a pair from one crossing to another.
    fn overlap(&self, (a, b): Pair, begin: Crossing, end: Crossing) -> Conflict {
        let (a, b) = (&self.intervals[a], &self.intervals[b]);
        let (first, second) = if (a.start.t, a.object) <= (b.start.t, b.object) { (a, b) } else { (b, a) };
        Conflict {
            kind: ConflictKind::Overlap,
            first: first.object,
            second: second.object,
            t_in: begin.t,
            t_out: end.t,
            t_err: begin.t_err + end.t_err,
        }
    }

    /// Notes which intervals begin to protrude in an event: they are outside the innermost instance around theirs that clips.
    /// Appends those that end to do so.
    fn protrusions(
        &self,
        event: &[End],
        protruding: &mut BTreeMap<usize, (f64, f64)>,
        out: &mut Vec<Conflict>,
    ) {
        let (t, t_err) = (event[0].crossing.t, t_err_of(event));
        let mut affected: Vec<usize> = event.iter().map(|end| end.interval).collect();
        for instance in self.touched(event) {
            let end = self.instances()[instance as usize].end;
            affected
                .extend(self.memory.present.range((instance, 0)..(end + 1, 0)).map(|(_, interval)| interval));
        }
        affected.sort_unstable();
        affected.dedup();
        for interval in affected {
            let instance = self.instance(interval);
            let Instance { object, clip, .. } = self.instances()[instance as usize];
            let is_present = self.memory.present.contains(&(instance, interval));
            if is_present && clip != NONE && self.memory.inside[clip as usize] == 0 {
                protruding.entry(interval).or_insert((t, t_err));
            } else if let Some((t_in, t_in_err)) = protruding.remove(&interval) {
                let second = self.instances()[clip as usize].object;
                let t_err = t_err + t_in_err;
                out.push(Conflict {
                    kind: ConflictKind::Protrusion,
                    first: object,
                    second,
                    t_in,
                    t_out: t,
                    t_err,
                });
            }
        }
    }
}

impl Conflict {
    fn error(self, world: &World) -> QueryError {
        let name = |object: u32| world.object_names()[object as usize].clone();
        let Conflict { first, second, t_in, t_out, .. } = self;
        QueryError::Overlap { first: name(first), second: name(second), t_in, t_out }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::Scene;
    use crate::shape::{Object, Shape};
    use crate::testkit::random::Random;

    /// Intervals whose ends coincide, abut, and lie apart: those that are apart give the segments of the sweep.
    #[test]
    fn intervals_that_are_apart_need_no_sweep() {
        let ball = |name: &str| Object::new(name, Shape::sphere(1.0).expect("a ball"));
        let world = Scene::of([ball("a"), ball("b")]).compile().expect("a world");
        let ray = Ray::new(Vec3::ZERO, Vec3::new(0.0, 3.0, 4.0)).expect("a ray");
        let mut random = Random::new(3);
        let mut apart = 0;
        for _ in 0..20_000 {
            let mut t = random.number(-1.0, 1.0);
            let mut next = |entering: bool, random: &mut Random| {
                let t_err = [0.0, 1e-16, 1e-9][random.below(3)];
                t += [0.0, 1e-9, 1e-8, 2e-8, 1.0, 1.0, 1.0][random.below(7)];
                Crossing::new(t, t_err, entering, 0)
            };
            let mut interval = |_| {
                let (start, end) = (next(true, &mut random), next(false, &mut random));
                Interval { start, end, object: random.below(2) as u32, path: random.below(2) as u64 }
            };
            let intervals: Vec<Interval> = (0..4).map(&mut interval).collect();
            apart += usize::from(are_apart(&intervals));
            for overlaps in [Overlaps::Priority, Overlaps::Error] {
                let (mut scratch, mut budget) = (OwnershipScratch::default(), Budget::default());
                budget.begin(1000);
                let (mut found, mut expected) = (Vec::new(), Vec::new());
                let of_sweep =
                    sweep(&world, &ray, &intervals, overlaps, &mut scratch, &mut budget, &mut expected);
                let outcome =
                    resolve(&world, &ray, &intervals, overlaps, &mut scratch, &mut budget, &mut found);
                assert_eq!((outcome, &found), (of_sweep, &expected), "{intervals:?}");
            }
        }
        assert!(apart > 1000 && apart < 19_000, "{apart}");
    }
}
