//! Ownership: which instance of an object owns each part of a ray.
//!
//! Where several instances contain a point, the one of the highest priority owns it; of equal priorities, one that is in
//! another displaces it. If neither is in the other, they overlap, and the one that is placed later owns the point: at the
//! first object that is not around both, as a search from the outermost object down to the innermost finds it. What an object
//! that clips contains counts only inside it. The cost for `n` intervals is `O(n log n)` without clipping, however they are
//! nested; clipping adds the number of intervals that stick out.

use std::collections::BTreeMap;
use std::ops::Range;

use super::instances::{Instance, NONE};
use super::interval_ends::{End, EndsScratch, Interval, ends, events};
use super::ordered_set::OrderedSet;
use super::ranks::Ranks;
use super::{Conflict, ConflictKind, QueryError};
use crate::budget::Budget;
use crate::compile::World;
use crate::crossing::Crossing;

/// The memory of a sweep over intervals; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct OwnershipScratch<'w> {
    ranks: Ranks<'w>,
    /// For each instance the number of intervals that contain the ray, and whether its contents count.
    inside: Vec<u32>,
    counts: Vec<bool>,
    /// The places of the intervals that contain the ray, if anything clips.
    present: OrderedSet,
    /// The ranks of those that count.
    ranked: OrderedSet,
    /// The ranks of those that overlap the one that ranks next below.
    overlapping: OrderedSet,
    touched: Vec<u32>,
    /// The places of intervals that have begun or ceased to count since this was cleared, if that is asked for.
    pub(super) changed: Vec<u32>,
    pub(super) notes_changes: bool,
    pub(super) ends: Vec<End>,
    of_ends: EndsScratch,
}

/// The interval that owns the ray, and the one that ranks highest of those that it overlaps.
pub(super) type Pair = (usize, usize);

/// Appends the overlaps of equal priority, which are ascending and disjoint, and the protrusions. Each overlap is between the
/// interval that owns the ray and the one that ranks highest of those that it overlaps. Invalid if the budget has ended.
pub(super) fn conflicts<'w>(
    world: &'w World,
    intervals: &[Interval],
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    out: &mut Vec<Conflict>,
) {
    let sorted = Ownership::sorted_ends(world, intervals, scratch);
    let mut sweep = Ownership::new(world, intervals, scratch);
    // The pair that overlaps now, and where it has begun to.
    let mut overlapping: Option<(Pair, Crossing)> = None;
    let mut protruding = BTreeMap::new();
    for event in events(&sorted) {
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
    scratch.ends = sorted;
}

/// The end of one of two intervals in an event; if neither ends there, the first end.
pub(super) fn t_of_pair(event: &[End], (a, b): Pair) -> Crossing {
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
    scratch.ranks.begin(world, &intervals);
    let mut sweep = Ownership::new(world, &intervals, scratch);
    let event: Vec<End> = (0..intervals.len()).map(|interval| End { crossing: here, interval }).collect();
    sweep.apply(&event);
    let ranked = &sweep.memory.ranked;
    let descending = std::iter::successors(ranked.last(), |&rank| ranked.below(rank));
    descending.map(|rank| bodies[sweep.interval_ranked(rank)]).collect()
}

/// Determines which interval owns the ray after an event.
pub(super) struct Ownership<'a, 'w> {
    world: &'w World,
    intervals: &'a [Interval],
    memory: &'a mut OwnershipScratch<'w>,
}

impl<'a, 'w> Ownership<'a, 'w> {
    /// Determines the ranks of the intervals. Returns their ends in order, in memory that is given back by the caller.
    pub(super) fn sorted_ends(
        world: &'w World,
        intervals: &[Interval],
        memory: &mut OwnershipScratch<'w>,
    ) -> Vec<End> {
        memory.ranks.begin(world, intervals);
        let mut sorted = std::mem::take(&mut memory.ends);
        ends(intervals, &memory.ranks.by_path, &mut memory.of_ends, &mut sorted);
        sorted
    }

    /// Begins in front of all intervals, whose ranks are known.
    pub(super) fn new(
        world: &'w World,
        intervals: &'a [Interval],
        memory: &'a mut OwnershipScratch<'w>,
    ) -> Ownership<'a, 'w> {
        for set in [&mut memory.present, &mut memory.ranked, &mut memory.overlapping] {
            set.begin(intervals.len());
        }
        let count = memory.ranks.instances.all().len();
        memory.inside.clear();
        memory.inside.resize(count, 0);
        memory.counts.clear();
        memory.counts.resize(count, false);
        Ownership { world, intervals, memory }
    }

    fn instances(&self) -> &[Instance] {
        self.memory.ranks.instances.all()
    }

    /// The instance of an interval.
    fn instance(&self, interval: usize) -> u32 {
        self.memory.ranks.instance_at(self.memory.ranks.place_of(interval))
    }

    fn interval_ranked(&self, rank: u32) -> usize {
        self.memory.ranks.interval_at(self.memory.ranks.place_ranked(rank))
    }

    pub(super) fn apply(&mut self, event: &[End]) {
        // An interval that begins and ends in the same event is inserted and removed here: it has no length.
        for end in event.iter().filter(|end| end.crossing.entering) {
            self.enter(end.interval);
        }
        for end in event.iter().filter(|end| !end.crossing.entering) {
            self.leave(end.interval);
        }
        if self.world.clips() {
            let touched = self.touched(event);
            touched.iter().for_each(|&instance| self.settle(instance));
            self.memory.touched = touched;
        }
    }

    fn enter(&mut self, interval: usize) {
        let place = self.memory.ranks.place_of(interval);
        if self.world.clips() {
            let instance = self.memory.ranks.instance_at(place);
            self.memory.inside[instance as usize] += 1;
            self.memory.present.insert(place);
        } else {
            self.insert(place);
        }
    }

    fn leave(&mut self, interval: usize) {
        let place = self.memory.ranks.place_of(interval);
        self.remove(place);
        if self.world.clips() {
            let instance = self.memory.ranks.instance_at(place);
            self.memory.inside[instance as usize] -= 1;
            self.memory.present.remove(place);
        }
    }

    /// The instances of an event, each after those that it is in.
    fn touched(&mut self, event: &[End]) -> Vec<u32> {
        let mut touched = std::mem::take(&mut self.memory.touched);
        touched.clear();
        touched.extend(event.iter().map(|end| self.instance(end.interval)));
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
        let mut places = self.memory.ranks.places_of(instance, last);
        while let Some(place) = self.next_present(&places) {
            places.start = place + 1;
            let instance = self.memory.ranks.instance_at(place);
            let counts = self.contents_count(instance);
            self.memory.counts[instance as usize] = counts;
            if counts {
                self.insert(place);
            } else {
                self.remove(place);
            }
        }
    }

    /// The first place of some whose interval contains the ray.
    fn next_present(&self, places: &Range<u32>) -> Option<u32> {
        let is_one = !places.is_empty();
        is_one.then(|| self.memory.present.at_or_above(places.start))?.filter(|place| *place < places.end)
    }

    /// Whether the ray is in all instances around an instance that clip.
    fn contents_count(&self, instance: u32) -> bool {
        let clip = self.instances()[instance as usize].clip;
        clip == NONE || self.memory.counts[clip as usize]
    }

    /// Counts the interval at a place.
    fn insert(&mut self, place: u32) {
        let rank = self.memory.ranks.rank_of(place);
        if self.memory.ranked.insert(rank) {
            self.note_change(place);
            let (below, above) = (self.memory.ranked.below(rank), self.memory.ranked.above(rank));
            self.compare(below, Some(rank));
            self.compare(Some(rank), above);
        }
    }

    fn remove(&mut self, place: u32) {
        let rank = self.memory.ranks.rank_of(place);
        if self.memory.ranked.remove(rank) {
            self.note_change(place);
            self.memory.overlapping.remove(rank);
            let (below, above) = (self.memory.ranked.below(rank), self.memory.ranked.above(rank));
            self.compare(below, above);
        }
    }

    fn note_change(&mut self, place: u32) {
        if self.memory.notes_changes {
            self.memory.changed.push(place);
        }
    }

    /// Passes the intervals that have begun or ceased to count, each with whether it counts now, and forgets them.
    pub(super) fn take_changes(&mut self, mut take: impl FnMut(usize, bool)) {
        let OwnershipScratch { changed, ranks, ranked, .. } = &mut *self.memory;
        changed.sort_unstable();
        changed.dedup();
        for place in changed.drain(..) {
            take(ranks.interval_at(place), ranked.contains(ranks.rank_of(place)));
        }
    }

    /// Notes whether an interval overlaps the one that ranks next below. Of the intervals of the highest priority, some
    /// overlap if and only if two neighbours do: otherwise each is in the next one.
    fn compare(&mut self, below: Option<u32>, rank: Option<u32>) {
        let Some(rank) = rank else { return };
        if below.is_some_and(|below| self.do_overlap(below, rank)) {
            self.memory.overlapping.insert(rank);
        } else {
            self.memory.overlapping.remove(rank);
        }
    }

    fn do_overlap(&self, below: u32, above: u32) -> bool {
        let ranks = &self.memory.ranks;
        let [outer, inner] = [below, above].map(|rank| ranks.place_ranked(rank));
        ranks.is_apart(inner, outer) && self.priority(below) == self.priority(above)
    }

    fn priority(&self, rank: u32) -> i32 {
        self.world.object_priority(self.intervals[self.interval_ranked(rank)].object)
    }

    /// The interval of the highest rank.
    pub(super) fn owner(&self) -> Option<usize> {
        self.memory.ranked.last().map(|rank| self.interval_ranked(rank))
    }

    /// The pair that overlaps now: the owner, and the interval of the highest rank among those that overlap it.
    pub(super) fn overlapping_pair(&self) -> Option<Pair> {
        let rank = self.memory.overlapping.last()?;
        let owner = self.memory.ranked.last()?;
        let below = self.memory.ranked.below(rank)?;
        let is_of_owner = self.priority(rank) == self.priority(owner);
        is_of_owner.then(|| (self.interval_ranked(owner), self.interval_ranked(below)))
    }

    /// The overlap of a pair from one crossing to another.
    pub(super) fn overlap(&self, (a, b): Pair, begin: Crossing, end: Crossing) -> Conflict {
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
        &mut self,
        event: &[End],
        protruding: &mut BTreeMap<usize, (f64, f64)>,
        out: &mut Vec<Conflict>,
    ) {
        let (t, t_err) = (event[0].crossing.t, t_err_of(event));
        let mut affected: Vec<usize> = event.iter().map(|end| end.interval).collect();
        let touched = self.touched(event);
        for &instance in &touched {
            let mut places = self.memory.ranks.places_of(instance, self.instances()[instance as usize].end);
            while let Some(place) = self.next_present(&places) {
                places.start = place + 1;
                affected.push(self.memory.ranks.interval_at(place));
            }
        }
        self.memory.touched = touched;
        affected.sort_unstable();
        affected.dedup();
        for interval in affected {
            let instance = self.instance(interval);
            let Instance { object, clip, .. } = self.instances()[instance as usize];
            let is_present = self.memory.present.contains(self.memory.ranks.place_of(interval));
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
    pub(super) fn error(self, world: &World) -> QueryError {
        let name = |object: u32| world.object_names()[object as usize].clone();
        let Conflict { first, second, t_in, t_out, .. } = self;
        QueryError::Overlap { first: name(first), second: name(second), t_in, t_out }
    }
}
