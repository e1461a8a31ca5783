//! Ends of intervals of lines in lanes as events of sorted lists.

use crate::crossing::{Crossing, GROUPING};
use crate::csg::{ListedEvent, Program};
use crate::lanes::EndLanes;
use crate::simd::Doubles;

/// The events of the ends of an interval in some lanes.
pub(super) struct EndEvents<F: Doubles> {
    low: F::Array,
    high: F::Array,
    /// The lanes in which it is an event, and those in which it lies before the box of its leaf.
    pub events: u8,
    pub before: u8,
}

impl<F: Doubles> EndEvents<F> {
    /// The events in the lanes of a mask, whose lines enter the box of the leaf at `enter`: as [`crate::csg::Event::new`].
    #[inline(always)]
    pub fn new(end: &EndLanes<F>, enter: F, of: u8) -> EndEvents<F> {
        let reach = F::splat(GROUPING) * end.t_err;
        let high = end.t + reach;
        let before = high.is_less(enter) & of;
        let low = (end.t - reach).greater(enter);
        let high = F::splat(f64::NEG_INFINITY).where_set(before, high.greater(low));
        let events = of & !before & end.t.is_less(F::splat(f64::INFINITY));
        EndEvents { low: enter.where_set(before, low).store(), high: high.store(), events, before }
    }

    /// What is added to the list of the line of a lane.
    #[inline(always)]
    pub fn listed(&self, lane: usize, number: u32, step: i32) -> ListedEvent {
        ListedEvent { low: self.low[lane], high: self.high[lane], number, step }
    }
}

/// The representative of coincident events, as the sweep chooses it, given the leaf and the crossing of each number.
pub(super) fn representative(
    group: &[ListedEvent],
    program: &Program,
    entering: bool,
    of: impl Fn(u32) -> (u32, Crossing),
) -> Option<u32> {
    let goes_along = |event: &&ListedEvent| {
        let (leaf, crossing) = of(event.number);
        !event.is_before_box() && (crossing.entering != program.is_subtracted(leaf)) == entering
    };
    let order = |a: &&ListedEvent, b: &&ListedEvent| {
        let ((leaf, a), (other, b)) = (of(a.number), of(b.number));
        a.t_err.total_cmp(&b.t_err).then(leaf.cmp(&other)).then(a.t.total_cmp(&b.t))
    };
    group.iter().filter(goes_along).min_by(order).map(|event| event.number)
}
