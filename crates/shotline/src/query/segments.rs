//! Segments: the stretches inside objects, with overlaps resolved.

use super::{Overlaps, QueryError, Segment};
use crate::compile::World;
use crate::crossing::{Crossing, together};
use crate::math::length;
use crate::ray::Ray;

/// A stretch inside one body; ends with `t` and its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub start: (f64, f64),
    pub end: (f64, f64),
    pub object: u32,
    pub path: u64,
}

/// One end of an interval.
struct End {
    crossing: Crossing,
    interval: usize,
}

/// Turns the intervals of all bodies into segments, ascending, and answers how many overlaps of equal
/// priority there were.
pub(super) fn resolve(
    world: &World,
    ray: &Ray,
    intervals: Vec<Interval>,
    overlaps: Overlaps,
    out: &mut Vec<Segment>,
) -> Result<u64, QueryError> {
    let segment = |start: f64, end: f64, of: &Interval| Segment {
        t_in: start,
        t_out: end,
        length: (end - start) * length(ray.direction()),
        object: of.object,
        material: world.object_material(of.object),
        path: of.path,
    };
    if overlaps == Overlaps::All {
        let mut all: Vec<Segment> = intervals.iter().map(|i| segment(i.start.0, i.end.0, i)).collect();
        all.sort_by(|a, b| a.t_in.total_cmp(&b.t_in).then(a.path.cmp(&b.path)));
        out.append(&mut all);
        return Ok(0);
    }
    let mut sweep = Ownership { world, intervals: &intervals, active: Vec::new(), overlaps: 0 };
    let mut owned: Option<(f64, usize)> = None;
    for event in ends(&intervals).chunk_by(|a, b| together(&a.crossing, &b.crossing)) {
        let before = owned.map(|(_, interval)| interval);
        sweep.apply(event);
        let after = sweep.owner(event[0].crossing.t, overlaps)?;
        if same_owner(&intervals, before, after) {
            continue;
        }
        // The end of the one that stops or begins here, where the event holds it.
        let t_of = |interval: Option<usize>| {
            let own = event.iter().find(|e| Some(e.interval) == interval);
            own.unwrap_or(&event[0]).crossing.t
        };
        if let Some((start, interval)) = owned {
            let stops = event.iter().any(|e| e.interval == interval);
            let end = t_of(if stops { before } else { after });
            out.push(segment(start, end, &intervals[interval]));
        }
        owned = after.map(|interval| {
            let begins = event.iter().any(|e| e.interval == interval);
            (t_of(if begins { after } else { before }), interval)
        });
    }
    Ok(sweep.overlaps)
}

/// All ends in the order of the events that they make.
fn ends(intervals: &[Interval]) -> Vec<End> {
    let mut ends: Vec<End> = Vec::with_capacity(2 * intervals.len());
    for (interval, i) in intervals.iter().enumerate() {
        let end = |(t, err), entering| End { crossing: Crossing::new(t, err, entering, 0), interval };
        ends.extend([end(i.start, true), end(i.end, false)]);
    }
    let path = |e: &End| intervals[e.interval].path;
    ends.sort_by(|a, b| a.crossing.t.total_cmp(&b.crossing.t).then(path(a).cmp(&path(b))));
    ends
}

/// Stretches of one object join.
fn same_owner(intervals: &[Interval], a: Option<usize>, b: Option<usize>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => intervals[a].object == intervals[b].object,
        _ => false,
    }
}

/// Who owns the stretch after an event.
struct Ownership<'a> {
    world: &'a World,
    intervals: &'a [Interval],
    active: Vec<usize>,
    overlaps: u64,
}

impl Ownership<'_> {
    fn apply(&mut self, event: &[End]) {
        for end in event {
            if end.crossing.entering {
                self.active.push(end.interval);
            } else {
                self.active.retain(|&i| i != end.interval);
            }
        }
    }

    /// The highest priority owns; at equal priority the later object in the scene does, if it may.
    fn owner(&mut self, t: f64, overlaps: Overlaps) -> Result<Option<usize>, QueryError> {
        let rank = |&i: &usize| {
            let interval = &self.intervals[i];
            (self.world.object_priority(interval.object), interval.object, std::cmp::Reverse(interval.path))
        };
        let Some(&owner) = self.active.iter().max_by_key(|i| rank(i)) else { return Ok(None) };
        let rival = self.active.iter().copied().find(|other| {
            let (a, b) = (rank(&owner), rank(other));
            a.0 == b.0 && a.1 != b.1
        });
        if let Some(rival) = rival {
            self.overlaps += 1;
            if overlaps == Overlaps::Error {
                return Err(self.overlap_error(owner, rival, t));
            }
        }
        Ok(Some(owner))
    }

    fn overlap_error(&self, a: usize, b: usize, t: f64) -> QueryError {
        let (a, b) = (&self.intervals[a], &self.intervals[b]);
        let (first, second) = if (a.start.0, a.object) <= (b.start.0, b.object) { (a, b) } else { (b, a) };
        let name = |i: &Interval| self.world.object_names()[i.object as usize].clone();
        QueryError::Overlap { first: name(first), second: name(second), t_in: t, t_out: a.end.0.min(b.end.0) }
    }
}
