//! The parts of a ray in which intervals count, also where others own it: for segments that keep all overlaps.

use super::Segment;
use super::interval_ends::{End, Interval, events};
use super::ownership::{Ownership, OwnershipScratch};
use crate::budget::Budget;
use crate::compile::World;

/// Appends a segment for each part of an interval that counts: contents of an object that clips count only inside it. The order is
/// that in which the parts end. The result is invalid if the budget has ended.
pub(super) fn counted_parts<'w>(
    world: &'w World,
    intervals: &[Interval],
    scratch: &mut OwnershipScratch<'w>,
    budget: &mut Budget,
    segment: impl Fn(f64, f64, &Interval) -> Segment,
    out: &mut Vec<Segment>,
) {
    scratch.notes_changes = true;
    let sorted = Ownership::sorted_ends(world, intervals, scratch);
    let mut sweep = Ownership::new(world, intervals, scratch);
    // Where the part of each interval begins that counts now.
    let mut begins: Vec<Option<f64>> = vec![None; intervals.len()];
    for event in events(&sorted) {
        if !budget.step() {
            break;
        }
        sweep.apply(event);
        sweep.take_changes(|interval, counts| match (begins[interval], counts) {
            (None, true) => begins[interval] = Some(t_of(event, interval)),
            (Some(begin), false) => {
                begins[interval] = None;
                let end = t_of(event, interval);
                if begin < end {
                    out.push(segment(begin, end, &intervals[interval]));
                }
            }
            _ => {}
        });
    }
    scratch.ends = sorted;
    scratch.notes_changes = false;
}

/// Where an interval begins or ceases to count in an event: at its own end, or else at the end of what clips it.
fn t_of(event: &[End], interval: usize) -> f64 {
    event.iter().find(|end| end.interval == interval).unwrap_or(&event[0]).crossing.t
}
