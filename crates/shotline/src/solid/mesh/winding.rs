//! From hits to crossings: the winding number along a line.
//!
//! A hit that enters adds one, a hit that leaves subtracts one; inside is where the sum is not zero. In a mesh that is
//! wound inward the sum inside is negative, and the same rule holds.

use super::mesh_hit::MeshHit;
use crate::crossing::{Crossing, GROUPING};

/// The change of the winding number at a hit.
pub(crate) fn step(hit: &Crossing) -> i32 {
    if hit.entering { 1 } else { -1 }
}

/// The total change of the winding number over hits.
pub(super) fn total(hits: &[Crossing]) -> i32 {
    hits.iter().map(step).sum()
}

/// The order of hits. It does not depend on the accelerator.
pub(super) fn order(a: &Crossing, b: &Crossing) -> std::cmp::Ordering {
    a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive))
}

/// Turns the sorted hits from `start` on into crossings; `before` is the winding number before them.
///
/// If the line is inside before the hits, an entry at `-inf` is added; if it is inside behind them, an exit at `inf`.
/// So the crossings always alternate and are even in number.
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

/// Makes crossings of all sorted hits from some point of the line on, with the number of the hit of each; those at
/// infinity have none. Behind the last hit the line is outside.
pub(crate) fn hits_to_crossings(
    hits: &[MeshHit],
    crossings: &mut Vec<Crossing>,
    sources: &mut Vec<Option<u32>>,
) {
    let mut winding = -hits.iter().map(|hit| step(&hit.crossing)).sum::<i32>();
    if winding != 0 {
        crossings.push(Crossing::new(f64::NEG_INFINITY, 0.0, true, 0));
        sources.push(None);
    }
    for (i, hit) in (0..).zip(hits) {
        let outside = winding == 0;
        winding += step(&hit.crossing);
        if outside != (winding == 0) {
            crossings.push(Crossing { entering: outside, ..hit.crossing });
            sources.push(Some(i));
        }
    }
}

/// Returns the winding numbers on the front and the back of a triangle: those before and behind the event of sorted
/// hits that it belongs to, where the number before all hits is 0. `None` if the triangle is not hit.
pub(super) fn sides_of(hits: &[Crossing], primitive: u32) -> Option<[i32; 2]> {
    let (mut winding, mut before, mut reach) = (0, 0, f64::NEG_INFINITY);
    let mut found = None;
    for hit in hits {
        if hit.t - GROUPING * hit.t_err > reach {
            if found.is_some() {
                break;
            }
            before = winding;
        }
        winding += step(hit);
        reach = reach.max(hit.t + GROUPING * hit.t_err);
        if hit.primitive == primitive {
            found = Some(hit.entering);
        }
    }
    found.map(|entering| if entering { [before, winding] } else { [winding, before] })
}

/// The hits that decide the first boundary of a span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FirstEntry {
    /// Their number, counted from the first hit.
    pub(super) hits: usize,
    /// A later hit belongs to them if its `t`, less [`GROUPING`] times its bound, is at most this.
    pub(super) reach: f64,
}

/// Finds in sorted hits the first event that leads inside and reaches to `t_min`. The line is outside before all hits.
///
/// An event that ends before `t_min` counts only if no later event reaches back to `t_min`: then the span begins
/// inside. Otherwise a later event decides. Returns `None` if no event leads inside.
pub(super) fn first_entry(hits: &[Crossing], t_min: f64) -> Option<FirstEntry> {
    let (mut winding, mut reach) = (0, f64::NEG_INFINITY);
    for i in 0..=hits.len() {
        // Bounds differ, so a hit farther on may reach back further than the next one.
        let begin_behind = |t: f64| hits[i..].iter().all(|hit| hit.t - GROUPING * hit.t_err > t);
        if winding != 0 && begin_behind(reach.max(t_min)) {
            return Some(FirstEntry { hits: i, reach: reach.max(t_min) });
        }
        if let Some(hit) = hits.get(i) {
            winding += step(hit);
            reach = reach.max(hit.t + GROUPING * hit.t_err);
        }
    }
    None
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
    fn the_sides_of_a_face_are_those_of_its_event() {
        let numbered = |list: &[(f64, i32)]| -> Vec<Crossing> {
            (0..).zip(hits(list)).map(|(i, hit)| Crossing { primitive: i, ..hit }).collect()
        };
        let list = numbered(&[(1.0, 1), (2.0, 1), (2.05, -1), (3.0, -1)]);
        let sides: Vec<_> = (0..5).map(|i| sides_of(&list, i)).collect();
        assert_eq!(sides, [Some([0, 1]), Some([1, 1]), Some([1, 1]), Some([0, 1]), None]);
        assert_eq!(sides_of(&numbered(&[(1.0, -1), (2.0, 1)]), 1), Some([-1, 0]));
    }

    fn first(list: &[(f64, i32)], t_min: f64) -> Option<(usize, f64)> {
        first_entry(&hits(list), t_min).map(|entry| (entry.hits, entry.reach))
    }

    #[test]
    fn an_event_that_changes_nothing_is_passed_over() {
        let flap = [(1.0, 1), (1.05, -1)];
        assert_eq!(first(&flap, 0.0), None);
        assert_eq!(first(&[flap[0], flap[1], (3.0, 1), (4.0, -1)], 0.0), Some((3, 3.08)));
        assert_eq!(first(&[(1.0, 1)], 0.0), Some((1, 1.08)));
    }

    /// Events before the span are examined because they may reach into it; a wall among them is not the first entry.
    #[test]
    fn a_wall_before_the_span_is_not_the_first_entry() {
        let wall = [(1.0, 1), (2.0, -1)];
        assert_eq!(first(&wall, 3.0), None);
        assert_eq!(first(&[wall[0], wall[1], (4.0, 1), (5.0, -1)], 3.0), Some((3, 4.08)));
        // Within the wall the span begins inside, unless the end of the wall reaches into the span.
        assert_eq!(first(&wall, 1.5), Some((1, 1.5)));
        assert_eq!(first(&wall, 1.95), None);
        assert_eq!(first(&[wall[0], wall[1], (2.05, 1), (3.0, -1)], 2.03), Some((3, 2.13)));
        assert_eq!(first(&[(1.0, 1)], 3.0), Some((1, 3.0)));
    }

    #[test]
    fn a_later_hit_with_a_wide_bound_belongs_to_the_event() {
        let mut list = hits(&[(1.0, 1), (2.0, 1), (2.5, -1), (2.6, -1)]);
        assert_eq!(first_entry(&list, 0.0).map(|entry| entry.hits), Some(1));
        list[2].t_err = 0.2;
        assert_eq!(first_entry(&list, 0.0).map(|entry| entry.hits), None);
    }
}
