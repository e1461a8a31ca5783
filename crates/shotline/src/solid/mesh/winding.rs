//! From hits to crossings: the winding number along a line.
//!
//! A hit that enters adds one, a hit that leaves takes one away; inside is where the sum is not zero. For a
//! mesh that is wound inward the sum inside is negative, and the same rule holds.

use crate::crossing::Crossing;

/// Crossings whose `t` agree within so many times the sum of their bounds are one event.
const SAME_EVENT: f64 = 8.0;

/// What a hit adds to the winding number.
fn step(hit: &Crossing) -> i32 {
    if hit.entering { 1 } else { -1 }
}

/// What hits add to the winding number together.
pub(super) fn total(hits: &[Crossing]) -> i32 {
    hits.iter().map(step).sum()
}

/// The order of hits, which no accelerator can change.
pub(super) fn order(a: &Crossing, b: &Crossing) -> std::cmp::Ordering {
    a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive))
}

/// Turns the sorted hits from `start` on into crossings, where the winding number before them is known.
///
/// What lies before the hits becomes an entry at `-inf`, what lies behind them an exit at `inf`; so the
/// crossings alternate and are even whatever the hits are.
pub(super) fn to_crossings(out: &mut Vec<Crossing>, start: usize, before: i32) {
    let (mut kept, mut winding) = (start, before);
    for i in start..out.len() {
        let outside = winding == 0;
        winding += step(&out[i]);
        if outside != (winding == 0) {
            out[kept] = Crossing { entering: outside, ..out[i] };
            kept += 1;
        }
    }
    out.truncate(kept);
    if before != 0 {
        out.insert(start, Crossing::new(f64::NEG_INFINITY, 0.0, true, 0));
    }
    if winding != 0 {
        out.push(Crossing::new(f64::INFINITY, 0.0, false, 0));
    }
}

/// Whether the winding number between the events of sorted hits is 0, as before them, or `inside`.
pub(super) fn winds_once(hits: &[Crossing], inside: i32) -> bool {
    let (mut winding, mut reach) = (0, f64::NEG_INFINITY);
    hits.iter().all(|hit| {
        let sound = hit.t - SAME_EVENT * hit.t_err <= reach || winding == 0 || winding == inside;
        winding += step(hit);
        reach = reach.max(hit.t + SAME_EVENT * hit.t_err);
        sound
    })
}

/// The first event that takes a line from outside to inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FirstEntry {
    /// The number of hits up to the end of that event.
    pub(super) hits: usize,
    /// A later hit is a part of the event if its `t`, less [`SAME_EVENT`] times its bound, is not above this.
    pub(super) reach: f64,
}

/// Looks for the first entry in sorted hits, outside before them.
pub(super) fn first_entry(hits: &[Crossing]) -> Option<FirstEntry> {
    let (mut winding, mut reach) = (0, f64::NEG_INFINITY);
    for (i, hit) in hits.iter().enumerate() {
        let same_event = hit.t - SAME_EVENT * hit.t_err <= reach;
        if !same_event && winding != 0 {
            return Some(FirstEntry { hits: i, reach });
        }
        winding += step(hit);
        reach = reach.max(hit.t + SAME_EVENT * hit.t_err);
    }
    (winding != 0).then_some(FirstEntry { hits: hits.len(), reach })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crossing::is_alternating;

    fn hits(list: &[(f64, i32)]) -> Vec<Crossing> {
        list.iter().map(|&(t, step)| Crossing::new(t, 0.01, step > 0, 0)).collect()
    }

    fn crossings(list: &[(f64, i32)], before: i32) -> Vec<f64> {
        let mut out = hits(list);
        to_crossings(&mut out, 0, before);
        assert!(is_alternating(&out), "{out:?}");
        out.iter().map(|c| c.t).collect()
    }

    #[test]
    fn nested_shells_and_inward_ones_are_inside_too() {
        assert_eq!(crossings(&[(1.0, 1), (2.0, 1), (3.0, -1), (4.0, -1)], 0), [1.0, 4.0]);
        assert_eq!(crossings(&[(1.0, -1), (2.0, 1)], 0), [1.0, 2.0]);
        assert_eq!(crossings(&[(1.0, 1), (2.0, -1), (3.0, 1), (4.0, -1)], 0), [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn what_is_not_seen_lies_at_infinity() {
        assert_eq!(crossings(&[(1.0, -1)], 1), [f64::NEG_INFINITY, 1.0]);
        assert_eq!(crossings(&[(1.0, 1)], 0), [1.0, f64::INFINITY]);
        assert_eq!(crossings(&[], -1), [f64::NEG_INFINITY, f64::INFINITY]);
        assert_eq!(crossings(&[], 0), [0.0; 0]);
    }

    #[test]
    fn what_winds_once_may_do_otherwise_within_an_event() {
        let once = |list: &[(f64, i32)]| winds_once(&hits(list), 1);
        assert!(once(&[(1.0, 1), (2.0, 1), (2.05, -1), (3.0, -1)]));
        assert!(!once(&[(1.0, 1), (2.0, 1), (2.5, -1), (3.0, -1)]));
        assert!(!once(&[(1.0, -1), (2.0, 1)]) && winds_once(&hits(&[(1.0, -1), (2.0, 1)]), -1));
    }

    #[test]
    fn an_event_that_changes_nothing_is_passed_over() {
        let flap = [(1.0, 1), (1.05, -1)];
        assert_eq!(first_entry(&hits(&flap)), None);
        let entry = first_entry(&hits(&[flap[0], flap[1], (3.0, 1), (4.0, -1)])).unwrap();
        assert_eq!((entry.hits, entry.reach), (3, 3.08));
        let open = first_entry(&hits(&[(1.0, 1)])).unwrap();
        assert_eq!((open.hits, open.reach), (1, 1.08));
    }
}
