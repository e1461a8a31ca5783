//! The intervals of a ray inside bodies, and the events in which they begin and end.

use crate::crossing::{Crossing, are_coincident};

/// An interval inside one body, between two of its boundaries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub start: Crossing,
    pub end: Crossing,
    pub object: u32,
    pub path: u64,
}

/// One end of an interval.
pub(super) struct End {
    pub crossing: Crossing,
    pub interval: usize,
}

/// Whether intervals follow each other, and each of their ends is an event of its own: then the sweep would return each as a
/// segment. So it is for almost every ray through one object.
pub(super) fn are_apart(intervals: &[Interval]) -> bool {
    let is_apart = |interval: &Interval| !are_coincident(&interval.start, &interval.end);
    intervals.iter().all(is_apart)
        && intervals.windows(2).all(|pair| !are_coincident(&pair[0].end, &pair[1].start))
}

/// All ends of the intervals in ascending order of `t`; at the same `t` in the order of the paths.
pub(super) fn ends(intervals: &[Interval]) -> Vec<End> {
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
pub(super) fn events(ends: &[End]) -> impl Iterator<Item = &[End]> {
    ends.chunk_by(|a, b| are_coincident(&a.crossing, &b.crossing)).flat_map(|chain| {
        let low = chain.iter().map(|e| e.crossing.low()).fold(f64::NEG_INFINITY, f64::max);
        let high = chain.iter().map(|e| e.crossing.high()).fold(f64::INFINITY, f64::min);
        chain.chunk_by(move |a, b| {
            let abut = a.interval != b.interval && a.crossing.entering != b.crossing.entering;
            low <= high || abut || a.crossing.t == b.crossing.t
        })
    })
}
