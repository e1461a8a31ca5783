//! The parts of a ray, each with the interval that owns it: segments, and what is seen first, are made of them.

use std::ops::ControlFlow;

use super::counted_parts::counted_parts;
use super::interval_ends::{End, Interval, are_apart, events};
use super::ownership::{Ownership, OwnershipScratch, t_of_pair};
use super::{Overlaps, QueryError, Segment};
use crate::budget::Budget;
use crate::compile::World;
use crate::math::length;
use crate::ray::Ray;

/// A part of a ray that one interval owns.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnedPart {
    pub interval: usize,
    /// The surfaces at which it begins and ends: those of its own interval, or of one that owns the ray before or after it.
    pub start: End,
    pub end: End,
    /// The numbers of the events in which it begins and ends.
    pub events: [usize; 2],
}

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
        if world.clips() {
            counted_parts(world, intervals, scratch, budget, segment, out);
        } else {
            out.extend(intervals.iter().map(whole));
        }
        out[first..].sort_by(|a, b| a.t_in.total_cmp(&b.t_in).then(a.path.cmp(&b.path)));
        return Ok(0);
    }
    if !world.clips() && are_apart(intervals) {
        out.extend(intervals.iter().map(whole));
        return Ok(0);
    }
    sweep(world, intervals, overlaps, scratch, budget, |part| {
        out.push(segment(part.start.crossing.t, part.end.crossing.t, &intervals[part.interval]));
        ControlFlow::Continue(())
    })
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

/// Determines which interval owns each part of the ray, event by event, and passes the parts to `take` in ascending order, until
/// it breaks.
pub(super) fn sweep<'w>(
    world: &'w World,
    intervals: &[Interval],
    overlaps: Overlaps,
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    mut take: impl FnMut(&OwnedPart) -> ControlFlow<()>,
) -> Result<u64, QueryError> {
    let sorted = Ownership::sorted_ends(world, intervals, scratch);
    let mut sweep = Ownership::new(world, intervals, scratch);
    // The start of a part whose end is not known yet, its event, and the interval that owns it now.
    let mut owned: Option<(End, usize, usize)> = None;
    let mut overlap_count = 0;
    let mut events = events(&sorted).enumerate();
    while let Some((number, event)) = events.next() {
        if !budget.step() {
            break;
        }
        let before = owned.map(|(.., interval)| interval);
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
                let last = events.find(|(_, event)| is_last(&mut sweep, event));
                let last = last.map_or(event, |(_, event)| event);
                return Err(sweep.overlap(pair, begin, t_of_pair(last, pair)).error(world));
            }
        }
        if let (Some((start, since, before)), Some(after)) = (owned, after)
            && intervals[before].path == intervals[after].path
        {
            // Intervals of one body that touch are joined.
            owned = Some((start, since, after));
            continue;
        }
        // The interval's own end if it is part of the event, otherwise the first end of the event.
        let end_of = |interval: Option<usize>| {
            let own = event.iter().find(|e| Some(e.interval) == interval);
            *own.unwrap_or(&event[0])
        };
        if let Some((start, since, interval)) = owned.take() {
            let stops = event.iter().any(|e| e.interval == interval);
            let end = end_of(if stops { before } else { after });
            let part = OwnedPart { interval, start, end, events: [since, number] };
            if start.crossing.t < end.crossing.t && take(&part).is_break() {
                break;
            }
        }
        owned = after.map(|interval| {
            let begins = event.iter().any(|e| e.interval == interval);
            (end_of(if begins { after } else { before }), number, interval)
        });
    }
    drop(events);
    scratch.ends = sorted;
    Ok(overlap_count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossing::Crossing;
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
                let segment = segment_of(&world, &ray);
                let of_sweep = sweep(&world, &intervals, overlaps, &mut scratch, &mut budget, |part| {
                    let [t_in, t_out] = [part.start, part.end].map(|end| end.crossing.t);
                    expected.push(segment(t_in, t_out, &intervals[part.interval]));
                    ControlFlow::Continue(())
                });
                let outcome =
                    resolve(&world, &ray, &intervals, overlaps, &mut scratch, &mut budget, &mut found);
                assert_eq!((outcome, &found), (of_sweep, &expected), "{intervals:?}");
            }
        }
        assert!(apart > 1000 && apart < 19_000, "{apart}");
    }
}
