//! Segments: the intervals of a ray inside objects, with overlaps resolved. The cost for `n` intervals is
//! `O(n log n)`, however they are nested.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use super::{Overlap, Overlaps, QueryError, Segment};
use crate::budget::Budget;
use crate::compile::World;
use crate::crossing::{Crossing, are_coincident};
use crate::math::length;
use crate::ray::Ray;

/// An interval inside one body, between two of its boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub start: Crossing,
    pub end: Crossing,
    pub object: u32,
    pub path: u64,
}

/// One end of an interval.
struct End {
    crossing: Crossing,
    interval: usize,
}

/// A segment whose end is not known yet.
struct Owned {
    start: f64,
    /// The interval that owns it now.
    interval: usize,
    /// The path of all intervals of the segment; `None` if they have several.
    path: Option<u64>,
}

/// The memory of a sweep over intervals; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct SegmentScratch {
    active: BTreeSet<Rank>,
}

/// Converts the intervals of all bodies to segments, ascending, and returns the number of overlaps of equal priority.
/// The result is invalid if the budget has ended.
pub(super) fn resolve(
    world: &World,
    ray: &Ray,
    intervals: &[Interval],
    overlaps: Overlaps,
    scratch: &mut SegmentScratch,
    budget: &mut Budget,
    out: &mut Vec<Segment>,
) -> Result<u64, QueryError> {
    let segment = segment_of(world, ray);
    if out.try_reserve(intervals.len()).is_err() {
        return Err(QueryError::OutOfMemory);
    }
    if overlaps == Overlaps::All {
        let first = out.len();
        out.extend(intervals.iter().map(|i| segment(i.start.t, i.end.t, i.object, Some(i.path))));
        out[first..].sort_by(|a, b| a.t_in.total_cmp(&b.t_in).then(a.path.cmp(&b.path)));
        return Ok(0);
    }
    if are_apart(intervals) {
        out.extend(intervals.iter().map(|i| segment(i.start.t, i.end.t, i.object, Some(i.path))));
        return Ok(0);
    }
    sweep(world, ray, intervals, overlaps, scratch, budget, out)
}

/// Makes the segment from `start` to `end` of an object on a ray.
fn segment_of(world: &World, ray: &Ray) -> impl Fn(f64, f64, u32, Option<u64>) -> Segment {
    let step = length(ray.direction());
    move |t_in, t_out, object, path| Segment {
        t_in,
        t_out,
        length: (t_out - t_in) * step,
        object,
        material: world.object_material(object),
        path,
    }
}

/// Determines which interval owns each part of the ray, event by event.
fn sweep(
    world: &World,
    ray: &Ray,
    intervals: &[Interval],
    overlaps: Overlaps,
    scratch: &mut SegmentScratch,
    budget: &mut Budget,
    out: &mut Vec<Segment>,
) -> Result<u64, QueryError> {
    let segment = segment_of(world, ray);
    let mut sweep = Ownership::new(world, intervals, scratch);
    let mut owned: Option<Owned> = None;
    let mut overlap_count = 0;
    for event in events(&ends(intervals)) {
        if !budget.step() {
            break;
        }
        let before = owned.as_ref().map(|owned| owned.interval);
        sweep.apply(event);
        let after = sweep.owner();
        if let Some(owner) = after
            && let Some(rival) = sweep.rival(owner)
        {
            overlap_count += 1;
            if overlaps == Overlaps::Error {
                return Err(sweep.overlap(owner, rival, event[0].crossing.t, 0.0).error(world));
            }
        }
        if let (Some(owned), Some(after)) = (&mut owned, after)
            && intervals[owned.interval].object == intervals[after].object
        {
            // Intervals of one object are joined.
            owned.interval = after;
            owned.path = owned.path.filter(|path| *path == intervals[after].path);
            continue;
        }
        if before.is_none() && after.is_none() {
            continue;
        }
        // The interval's own end if it is part of the event, otherwise the first end of the event.
        let t_of = |interval: Option<usize>| {
            let own = event.iter().find(|e| Some(e.interval) == interval);
            own.unwrap_or(&event[0]).crossing.t
        };
        if let Some(Owned { start, interval, path }) = owned.take() {
            let stops = event.iter().any(|e| e.interval == interval);
            let end = t_of(if stops { before } else { after });
            if start < end {
                out.push(segment(start, end, intervals[interval].object, path));
            }
        }
        owned = after.map(|interval| {
            let begins = event.iter().any(|e| e.interval == interval);
            let start = t_of(if begins { after } else { before });
            Owned { start, interval, path: Some(intervals[interval].path) }
        });
    }
    Ok(overlap_count)
}

/// Whether intervals follow each other, and each of their ends is an event of its own: then the sweep would return each as a
/// segment. So it is for almost every ray through one object.
fn are_apart(intervals: &[Interval]) -> bool {
    let is_apart = |interval: &Interval| !are_coincident(&interval.start, &interval.end);
    intervals.iter().all(is_apart)
        && intervals.windows(2).all(|pair| !are_coincident(&pair[0].end, &pair[1].start))
}

/// Appends the overlaps of equal priority, ascending and disjoint. Each is between the two intervals that rank
/// highest where it begins, and ends where the first of them ends. Invalid if the budget has ended.
pub(super) fn overlaps(
    world: &World,
    intervals: &[Interval],
    scratch: &mut SegmentScratch,
    budget: &mut Budget,
    out: &mut Vec<Overlap>,
) {
    let mut sweep = Ownership::new(world, intervals, scratch);
    let mut reported_to = f64::NEG_INFINITY;
    for event in events(&ends(intervals)) {
        if !budget.step() {
            return;
        }
        sweep.apply(event);
        if event.last().is_none_or(|last| last.crossing.t < reported_to) {
            continue;
        }
        if let Some(owner) = sweep.owner()
            && let Some(rival) = sweep.rival(owner)
        {
            let t_err = event.iter().map(|end| end.crossing.t_err).fold(0.0, f64::max);
            let overlap = sweep.overlap(owner, rival, event[0].crossing.t.max(reported_to), t_err);
            reported_to = overlap.t_out;
            out.push(overlap);
        }
    }
}

/// All ends of the intervals in ascending order of `t`; at the same `t` in the order of the paths.
fn ends(intervals: &[Interval]) -> Vec<End> {
    let mut ends: Vec<End> = Vec::with_capacity(2 * intervals.len());
    for (interval, i) in intervals.iter().enumerate() {
        let end =
            |crossing: Crossing, entering| End { crossing: Crossing { entering, ..crossing }, interval };
        ends.extend([end(i.start, true), end(i.end, false)]);
    }
    let path = |e: &End| intervals[e.interval].path;
    ends.sort_by(|a, b| a.crossing.t.total_cmp(&b.crossing.t).then(path(a).cmp(&path(b))));
    ends
}

/// Groups sorted ends into events. In a chain, the first end does not coincide with the last. Then ends of different
/// intervals and opposite directions, which may be a common face, are one event; but the two ends of a single
/// interval are not, so that no interval is lost.
fn events(ends: &[End]) -> impl Iterator<Item = &[End]> {
    ends.chunk_by(|a, b| are_coincident(&a.crossing, &b.crossing)).flat_map(|chain| {
        let low = chain.iter().map(|e| e.crossing.low()).fold(f64::NEG_INFINITY, f64::max);
        let high = chain.iter().map(|e| e.crossing.high()).fold(f64::INFINITY, f64::min);
        chain.chunk_by(move |a, b| {
            let abut = a.interval != b.interval && a.crossing.entering != b.crossing.entering;
            low <= high || abut || a.crossing.t == b.crossing.t
        })
    })
}

/// The rank of an interval: by priority, then the later object in the scene, then the lower path. The last field is
/// the index of the interval; intervals of one path follow each other along the ray.
type Rank = (i32, u32, Reverse<u64>, usize);

/// Determines which interval owns the ray after an event.
struct Ownership<'a> {
    world: &'a World,
    intervals: &'a [Interval],
    /// The intervals that contain the ray after the event.
    active: &'a mut BTreeSet<Rank>,
}

impl<'a> Ownership<'a> {
    fn new(world: &'a World, intervals: &'a [Interval], scratch: &'a mut SegmentScratch) -> Ownership<'a> {
        // A ray that ended with an error may have left entries.
        if !scratch.active.is_empty() {
            scratch.active.clear();
        }
        Ownership { world, intervals, active: &mut scratch.active }
    }

    fn rank(&self, interval: usize) -> Rank {
        let Interval { object, path, .. } = self.intervals[interval];
        (self.world.object_priority(object), object, Reverse(path), interval)
    }

    fn apply(&mut self, event: &[End]) {
        // An interval that begins and ends in the same event is inserted and removed here: it has no length.
        for end in event.iter().filter(|end| end.crossing.entering) {
            self.active.insert(self.rank(end.interval));
        }
        for end in event.iter().filter(|end| !end.crossing.entering) {
            self.active.remove(&self.rank(end.interval));
        }
    }

    /// The interval of the highest rank.
    fn owner(&self) -> Option<usize> {
        self.active.last().map(|(.., interval)| *interval)
    }

    /// The interval of the highest rank among those of other objects with the owner's priority.
    fn rival(&self, owner: usize) -> Option<usize> {
        let (priority, object, ..) = self.rank(owner);
        let lowest_of_owner = (priority, object, Reverse(u64::MAX), 0);
        let (p, .., rival) = self.active.range(..lowest_of_owner).next_back()?;
        (*p == priority).then_some(*rival)
    }

    /// The overlap of two intervals that begins at `t`; `t_err` is the error bound of `t`.
    fn overlap(&self, a: usize, b: usize, t: f64, t_err: f64) -> Overlap {
        let (a, b) = (&self.intervals[a], &self.intervals[b]);
        let (first, second) = if (a.start.t, a.object) <= (b.start.t, b.object) { (a, b) } else { (b, a) };
        let end = if a.end.t <= b.end.t { &a.end } else { &b.end };
        let t_err = t_err + end.t_err;
        Overlap { first: first.object, second: second.object, t_in: t, t_out: end.t, t_err }
    }
}

impl Overlap {
    fn error(self, world: &World) -> QueryError {
        let name = |object: u32| world.object_names()[object as usize].clone();
        let Overlap { first, second, t_in, t_out, .. } = self;
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
                let (mut scratch, mut budget) = (SegmentScratch::default(), Budget::default());
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
