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
#[derive(Clone, Copy, Debug)]
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

/// The memory for sorting ends.
#[derive(Debug, Default)]
pub(super) struct EndsScratch {
    keys: Vec<(i64, u32)>,
    order: Vec<u32>,
}

/// All ends of the intervals in ascending order of `t`; at the same `t` in the order of the intervals in `by_path`, which lists
/// them by path.
pub(super) fn ends(
    intervals: &[Interval],
    by_path: &[(u64, u32)],
    scratch: &mut EndsScratch,
    out: &mut Vec<End>,
) {
    let EndsScratch { keys, order } = scratch;
    // An end is sorted by a key of a quarter of its size.
    keys.clear();
    order.clear();
    for (place, &(_, interval)) in (0..).zip(by_path) {
        let Interval { start, end, .. } = &intervals[interval as usize];
        keys.extend([(order_of(start.t), 2 * place), (order_of(end.t), 2 * place + 1)]);
        order.push(interval);
    }
    keys.sort_unstable();
    out.clear();
    out.extend(keys.iter().map(|&(_, end)| {
        let interval = order[end as usize / 2] as usize;
        let entering = end % 2 == 0;
        let crossing = if entering { intervals[interval].start } else { intervals[interval].end };
        End { crossing: Crossing { entering, ..crossing }, interval }
    }));
}

/// A whole number that is ordered as [`f64::total_cmp`] orders the numbers.
fn order_of(t: f64) -> i64 {
    let bits = t.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
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
