//! Combinations of a few leaves along lines in lanes: every end of an interval is judged against every interval, without
//! sorting, as sets of lanes. The boundaries are those of the [`Sweep`](super::Sweep).
//!
//! Lanes are left open where events form a chain, or may be at an end of the span. The caller sweeps their lines alone.

use arrayvec::ArrayVec;

use super::op::Op;
use super::program::Program;
use crate::crossing::GROUPING;
use crate::lanes::{EndLanes, IntervalLanes};
use crate::math::HALF_ULP;
use crate::ray::Span;
use crate::simd::Doubles;

/// The most leaves of a combination.
const MAX_LEAVES: usize = 8;

/// The most events of a line: each leaf has up to two intervals.
const MAX_EVENTS: usize = 4 * MAX_LEAVES;

/// A set of lanes for each event.
type ByEvent = [u8; MAX_EVENTS];

/// The lanes that are inside before each event, those that are inside after it, and those that are inside at the start of
/// the span.
#[derive(Clone, Copy, Debug)]
struct Sets {
    before: ByEvent,
    after: ByEvent,
    start: u8,
}

/// How an event lies to each other one.
#[derive(Clone, Copy, Debug)]
struct Order {
    /// The lanes in which it comes before the other.
    before: ByEvent,
    /// The lanes in which it comes after the other.
    after: ByEvent,
}

/// The end of an interval of a leaf, as [`Event`](super::Event).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneEvent<F> {
    pub t: F,
    pub t_err: F,
    pub surface: F,
    /// The interval in which it is one event with others. Where it lies before its box it is no event: the leaf counts from
    /// just before the box, or from the start of the span. Infinity where it does not exist.
    low: F,
    high: F,
    pub leaf: u32,
    pub entering: bool,
    /// The lanes in which it is an event, and those in which it is within the span.
    live: u8,
    within: u8,
    /// The lanes in which it is one event with another.
    shared: u8,
}

/// The events of the leaves of one combination.
#[derive(Debug)]
pub(crate) struct LaneEvents<F> {
    all: ArrayVec<LaneEvent<F>, MAX_EVENTS>,
    order: ArrayVec<Order, MAX_EVENTS>,
    /// The lanes that cannot be judged: an event may be at the start of the span, or an entry may be in its box with its exit
    /// before it.
    undecided: u8,
    /// For each lane the least `low` of events that may be at the end of the span.
    doubt: F,
    /// The lanes in which two events are one.
    shared: u8,
    span: Span,
    /// Where the lines leave the boxes of all leaves; infinite if that is not known.
    exit: F,
}

/// The boundaries of lines in lanes, as masks of the lanes that have them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundaries {
    /// The lanes inside at the start of the span, and those inside at its end.
    pub starts: u8,
    pub ends: u8,
    /// For each event the lanes in which it is a boundary.
    pub events: ByEvent,
    /// The lanes that are left open.
    pub open: u8,
    sets: Sets,
}

impl<F: Doubles> LaneEvents<F> {
    #[inline(always)]
    pub fn new(span: Span) -> LaneEvents<F> {
        let doubt = F::splat(f64::INFINITY);
        LaneEvents {
            all: ArrayVec::new_const(),
            order: ArrayVec::new_const(),
            undecided: 0,
            doubt,
            shared: 0,
            span,
            exit: doubt,
        }
    }

    /// Sets where the lines leave the boxes of all leaves. A line that is outside there has no boundary behind.
    #[inline(always)]
    pub fn end_at(&mut self, exit: F) {
        self.exit = exit;
    }

    /// Adds an interval of a leaf, whose box the lines enter at `box_enter`. Leaves come in order.
    #[inline(always)]
    pub fn add(&mut self, leaf: u32, interval: &IntervalLanes<F>, box_enter: F) {
        if interval.lanes != 0 {
            let [_, entry_counts] = self.add_end((leaf, true), &interval.enter, interval.lanes, box_enter);
            let [exit_is_before, _] = self.add_end((leaf, false), &interval.exit, interval.lanes, box_enter);
            // An exit before the box with an entry that may be in it: the sweep would toggle them in the wrong order.
            self.undecided |= entry_counts & exit_is_before;
        }
    }

    /// Adds the end of an interval. Returns the lanes in which it lies before the box, and those in which it is an event.
    #[inline(always)]
    fn add_end(
        &mut self,
        (leaf, entering): (u32, bool),
        end: &EndLanes<F>,
        lanes: u8,
        box_enter: F,
    ) -> [u8; 2] {
        let (infinity, t_min) = (F::splat(f64::INFINITY), F::splat(self.span.t_min()));
        let EndLanes { t, t_err, surface } = *end;
        let reach = F::splat(GROUPING) * t_err;
        let (low, high) = ((t - reach).greater(box_enter), t + reach);
        // What lies before the box only changes the state where the box begins: it comes before what begins there.
        let before = high.is_less(box_enter) & lanes;
        let live = lanes & !before & t.is_less(infinity);
        let just_before = box_enter - box_enter.abs() * F::splat(HALF_ULP);
        let has_begun = box_enter.is_at_most(t_min);
        let ahead = (-infinity).where_set(has_begun, just_before).where_set(before, infinity);
        let (low, high) = (low.where_set(live, ahead), high.greater(low).where_set(live, ahead));
        let is_late = before & !has_begun & box_enter.is_at_most(F::splat(0.0));
        self.undecided |= is_late | live & !(t_min.is_less(low) & t_min.is_less(t));
        let t_max = F::splat(self.span.t_max());
        let before_end = high.is_less(t_max);
        let at_end = live & !before_end & low.is_at_most(t_max);
        if at_end != 0 {
            self.doubt = low.where_set(at_end, infinity).lesser(self.doubt);
        }
        let mut shared = 0;
        let mut order = Order { before: [0; MAX_EVENTS], after: [0; MAX_EVENTS] };
        let own = self.all.len();
        for (i, (other, other_order)) in self.all.iter_mut().zip(&mut self.order).enumerate() {
            let (before, after) = (high.is_less(other.low), other.high.is_less(low));
            (order.before[i], order.after[i]) = (before, after);
            (other_order.before[own], other_order.after[own]) = (after, before);
            let is_one = live & other.live & !(before | after);
            shared |= is_one;
            other.shared |= is_one;
        }
        self.order.push(order);
        self.shared |= shared;
        let within = live & before_end;
        self.all.push(LaneEvent { t, t_err, surface, low, high, leaf, entering, live, within, shared });
        [before, live]
    }

    /// The lanes in which something up to some `t` cannot be judged here.
    #[inline(always)]
    fn doubtful(&self, up_to: F) -> u8 {
        let infinity = F::splat(f64::INFINITY);
        let mut doubt = self.doubt;
        if self.shared != 0 {
            for (event, order) in self.all.iter().zip(&self.order) {
                let (mut low, mut high) = (event.low, event.high);
                for (i, other) in self.all.iter().enumerate() {
                    let is_one = event.shared & other.live & !(order.before[i] | order.after[i]);
                    low = other.low.greater(low).where_set(is_one, low);
                    high = other.high.lesser(high).where_set(is_one, high);
                }
                // A chain: two events that are one with this one are not one.
                let chain = event.shared & high.is_less(low);
                doubt = event.low.where_set(chain, infinity).lesser(doubt);
            }
        }
        self.undecided | doubt.is_at_most(up_to) & doubt.is_less(infinity)
    }

    /// The lanes inside the combination before and after each event, and at the start of the span.
    #[inline(always)]
    fn sets(&self, program: &Program) -> Sets {
        let nothing = Sets { before: [0; MAX_EVENTS], after: [0; MAX_EVENTS], start: 0 };
        let mut leaves: ArrayVec<Sets, MAX_LEAVES> = ArrayVec::new_const();
        (0..program.leaf_count()).for_each(|_| leaves.push(nothing));
        let t_min = F::splat(self.span.t_min());
        for (events, orders) in self.all.chunks_exact(2).zip(self.order.chunks_exact(2)) {
            let ([enter, exit], [enter_order, exit_order]) = (events, orders) else { continue };
            let set = &mut leaves[enter.leaf as usize];
            for i in 0..MAX_EVENTS {
                // Inside before an event: entered before it, and not left before it. Inside after it: not entered after it, and
                // left after it.
                set.before[i] |= enter_order.before[i] & !exit_order.before[i];
                set.after[i] |= !enter_order.after[i] & exit_order.after[i];
            }
            set.start |= enter.high.is_less(t_min) & !exit.high.is_less(t_min);
        }
        if program.leaf_count() == 1 { leaves[0] } else { program.value_of_sets(&leaves) }
    }

    /// The lanes in which each event changes the value, and the lanes in which none of the events that are one goes along
    /// with the change. Of those that do, only the representative counts, as in the sweep.
    #[inline(always)]
    fn changes(&self, program: &Program, sets: &Sets) -> (ByEvent, u8) {
        let (mut changes, mut unusual) = ([0; MAX_EVENTS], 0);
        for (i, event) in self.all.iter().enumerate() {
            changes[i] = (sets.before[i] ^ sets.after[i]) & event.within;
        }
        unusual |= self.stop_at_exit(sets, &mut changes);
        if self.shared == 0 {
            return (changes, unusual);
        }
        let goes_along = |i: usize| {
            let event = &self.all[i];
            let is_along = event.entering != program.is_subtracted(event.leaf);
            if is_along { sets.after[i] } else { !sets.after[i] }
        };
        for (i, (event, order)) in self.all.iter().zip(&self.order).enumerate() {
            let mut rivals = changes[i] & event.shared;
            // Events ascend by leaf and by `t`, which decide where bounds are equal.
            for (j, other) in self.all[..i].iter().enumerate() {
                let are_one = rivals & changes[j] & !(order.before[j] | order.after[j]);
                if are_one != 0 {
                    let (this, that) = (goes_along(i), goes_along(j));
                    let that_is_less = that & (!this | other.t_err.is_at_most(event.t_err));
                    changes[i] &= !(are_one & that_is_less);
                    changes[j] &= !(are_one & !that_is_less);
                    rivals &= changes[i];
                }
            }
        }
        for (i, event) in self.all.iter().enumerate() {
            unusual |= changes[i] & event.shared & !goes_along(i);
        }
        (changes, unusual)
    }

    /// Removes the changes of lines that are outside behind the boxes of all leaves. Returns the lanes in which that depends
    /// on which events are one.
    #[inline(always)]
    fn stop_at_exit(&self, sets: &Sets, changes: &mut ByEvent) -> u8 {
        let (infinity, mut unusual) = (F::splat(f64::INFINITY), 0);
        let mut stop = infinity;
        for (i, event) in self.all.iter().enumerate() {
            let enters_behind = changes[i] & sets.after[i] & self.exit.is_less(event.low);
            stop = event.low.where_set(enters_behind, infinity).lesser(stop);
            unusual |= enters_behind & event.shared;
        }
        for (changes, event) in changes.iter_mut().zip(&self.all) {
            *changes &= event.low.is_less(stop);
        }
        unusual
    }

    /// The first boundary of each lane, up to its limit.
    #[inline(always)]
    pub fn first(&self, program: &Program, lanes: u8, limit: F, surfaces_only: bool) -> Boundaries {
        let sets = self.sets(program);
        let starts = if surfaces_only { 0 } else { sets.start & lanes & !self.undecided };
        let (mut events, unusual) = self.changes(program, &sets);
        let infinite = F::splat(f64::INFINITY);
        let (mut first, mut high) = (infinite, infinite);
        for (i, event) in self.all.iter().enumerate() {
            let nearer = events[i] & event.t.is_less(first);
            (first, high) = (event.t.where_set(nearer, first), event.high.where_set(nearer, high));
        }
        // Not only up to the limit: a crossing may have its `t` before its box, and so before its `low`.
        let open = lanes & !starts & (unusual | self.doubtful(high));
        let found = lanes & !starts & !open & first.is_less(infinite) & first.is_at_most(limit);
        let mut odd = 0;
        for (i, event) in self.all.iter().enumerate() {
            // No two boundaries of a lane have the same `t`.
            events[i] &= found & event.t.is_at_most(first);
            // The line must be inside where it exits. It may not be where underflow has made a bound too small.
            odd |= events[i] & !(sets.after[i] ^ sets.start);
            events[i] &= !odd;
        }
        Boundaries { starts, events, ends: 0, open: open | odd, sets }
    }

    /// All boundaries of each lane.
    #[inline(always)]
    pub fn all(&self, program: &Program, lanes: u8) -> Boundaries {
        let sets = self.sets(program);
        let (mut events, unusual) = self.changes(program, &sets);
        let open = lanes & (unusual | self.doubtful(F::splat(self.span.t_max())));
        let decided = lanes & !open;
        let starts = sets.start & decided;
        let mut ends = starts;
        for events in &mut events[..self.all.len()] {
            *events &= decided;
            ends ^= *events;
        }
        Boundaries { starts, events, ends, open, sets }
    }

    /// The events, in the order of [`Boundaries::events`].
    #[inline(always)]
    pub fn events(&self) -> &[LaneEvent<F>] {
        &self.all
    }
}

impl Boundaries {
    /// The lanes that are inside after an event.
    #[inline(always)]
    pub fn after(&self, event: usize) -> u8 {
        self.sets.after[event]
    }
}

impl Program {
    /// Whether it has few leaves, and no operations without operands.
    pub(crate) fn takes_lanes(&self) -> bool {
        self.leaves.len() <= MAX_LEAVES
            && self.nodes.len() <= 2 * MAX_LEAVES
            && self.nodes.iter().all(|node| node.arity > 0)
    }

    /// The value of the expression, given the sets of each leaf.
    #[inline(always)]
    fn value_of_sets(&self, leaves: &[Sets]) -> Sets {
        let mut nodes: ArrayVec<Sets, { 2 * MAX_LEAVES }> = ArrayVec::new_const();
        for node in &self.nodes {
            let neutral = if node.op == Op::Union { 0 } else { u8::MAX };
            nodes.push(Sets { before: [neutral; MAX_EVENTS], after: [neutral; MAX_EVENTS], start: neutral });
        }
        for (link, set) in self.leaves.iter().zip(leaves) {
            let node = link.node as usize;
            nodes[node].join(set, self.nodes[node].op, link.first);
        }
        for i in (1..self.nodes.len()).rev() {
            let (value, link) = (nodes[i], self.nodes[i].link);
            let node = link.node as usize;
            nodes[node].join(&value, self.nodes[node].op, link.first);
        }
        nodes[0]
    }
}

impl Sets {
    /// Joins an operand to the value of a node.
    #[inline(always)]
    fn join(&mut self, operand: &Sets, op: Op, is_first: bool) {
        match op {
            Op::Union => self.combine(operand, |a, b| a | b),
            Op::Difference if !is_first => self.combine(operand, |a, b| a & !b),
            _ => self.combine(operand, |a, b| a & b),
        }
    }

    #[inline(always)]
    fn combine(&mut self, operand: &Sets, combined: impl Fn(u8, u8) -> u8) {
        for i in 0..MAX_EVENTS {
            self.before[i] = combined(self.before[i], operand.before[i]);
            self.after[i] = combined(self.after[i], operand.after[i]);
        }
        self.start = combined(self.start, operand.start);
    }
}
