//! The sweep over a list of events that is complete and sorted: that of [`Sweep`](super::Sweep), without a queue.
//!
//! It decides what is usual: events alone, and coincident events that are not a chain. A list with anything else is left
//! to the sweep.

use super::event::HitKind;
use crate::ray::Span;

/// An event of a list. The caller finds its crossing by its number.
#[derive(Clone, Copy, Debug)]
pub struct ListedEvent {
    /// The ends of the interval in which it coincides with others, as of [`Event`](super::Event). The upper end is
    /// -infinity for a crossing that only changes the state, at `low`.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// Its number.
    pub number: u32,
    /// What it adds to a [`Tally`](super::Tally).
    pub step: i32,
}

impl ListedEvent {
    /// Whether it only changes the state: the crossing lies before the box of its leaf.
    pub fn is_before_box(&self) -> bool {
        self.high == f64::NEG_INFINITY
    }

    /// Inserts it into a sorted list, in which most others come before it. What only changes the state comes before the
    /// events that begin there.
    #[inline]
    pub fn insert_into(self, list: &mut Vec<ListedEvent>) {
        let mut at = list.len();
        list.push(self);
        while at > 0 && self.is_before(&list[at - 1]) {
            list[at] = list[at - 1];
            at -= 1;
        }
        list[at] = self;
    }

    #[inline]
    fn is_before(&self, other: &ListedEvent) -> bool {
        self.low < other.low || (self.low == other.low && self.is_before_box() && !other.is_before_box())
    }
}

/// A boundary that the sweep has found in a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListedBoundary {
    /// The kind.
    pub kind: HitKind,
    /// Whether the ray enters the result.
    pub entering: bool,
    /// The number of the event whose crossing it is; meaningless without a surface.
    pub number: u32,
}

/// What a list is swept for: the expression and the crossings.
pub trait ListedCrossings {
    /// Toggles the leaf of an event. Returns the value of the expression behind it.
    fn toggle(&mut self, event: &ListedEvent) -> bool;
    /// The `t` of the crossing of an event.
    fn t(&self, number: u32) -> f64;
    /// Among coincident events that change the result in the given direction, the number of the representative, as the
    /// sweep chooses it; `None` if there is no such event.
    fn representative(&self, group: &[ListedEvent], entering: bool) -> Option<u32>;
}

/// The sweep over the list of one ray. The list may grow between two calls, behind what has been swept.
#[derive(Clone, Copy, Debug)]
pub struct ListSweep {
    span: Span,
    /// The value of the expression behind what has been swept.
    now: bool,
    /// Whether the ray was inside the result after the last event.
    inside: bool,
    begun: bool,
    /// The next event.
    next: usize,
}

/// Events that coincide.
struct Group {
    end: usize,
    high: f64,
    are_chain: bool,
}

impl Group {
    /// The events that coincide with the one at `start`, of those before `end`.
    #[inline]
    fn of(events: &[ListedEvent], start: usize, end: f64) -> Group {
        let first = &events[start];
        let (mut high, mut least_high, mut last_low, mut i) = (first.high, first.high, first.low, start + 1);
        while let Some(event) = events.get(i).filter(|event| event.low <= high && event.low < end) {
            if !event.is_before_box() {
                (high, least_high) = (event.high.max(high), event.high.min(least_high));
                last_low = event.low;
            }
            i += 1;
        }
        Group { end: i, high, are_chain: last_low > least_high }
    }
}

impl ListSweep {
    /// Begins a list, given the value of the expression before all events.
    pub fn new(span: Span, value: bool) -> ListSweep {
        ListSweep { span, now: value, inside: false, begun: false, next: 0 }
    }

    /// Appends the boundaries that are certain if no further event begins before `up_to`. Returns `false` if the list is left
    /// to the sweep.
    #[inline]
    pub fn advance<C: ListedCrossings>(
        &mut self,
        events: &[ListedEvent],
        up_to: f64,
        crossings: &mut C,
        out: &mut Vec<ListedBoundary>,
    ) -> bool {
        // What begins behind the span does not count.
        let end = self.span.t_max().next_up();
        while let Some(first) = events.get(self.next).filter(|event| event.low < up_to && event.low < end) {
            if first.is_before_box() {
                self.now = crossings.toggle(first);
                self.next += 1;
                continue;
            }
            let group = Group::of(events, self.next, end);
            if group.high >= up_to {
                break;
            }
            let some = &events[self.next..group.end];
            self.next = group.end;
            if group.are_chain || !self.classify(some, crossings, out) {
                return false;
            }
        }
        true
    }

    /// Appends the boundaries that are left. Returns `false` if the list is left to the sweep.
    #[inline]
    pub fn finish<C: ListedCrossings>(
        &mut self,
        events: &[ListedEvent],
        crossings: &mut C,
        out: &mut Vec<ListedBoundary>,
    ) -> bool {
        if !self.advance(events, f64::INFINITY, crossings, out) || self.has_more(events) {
            return false;
        }
        self.begin(out);
        if self.inside {
            self.inside = false;
            out.push(span_end(HitKind::End));
        }
        true
    }

    /// Whether there are events that reach to infinity.
    #[inline]
    fn has_more(&self, events: &[ListedEvent]) -> bool {
        events.get(self.next).is_some_and(|event| event.low <= self.span.t_max())
    }

    /// Evaluates the state before the first event.
    #[inline]
    fn begin(&mut self, out: &mut Vec<ListedBoundary>) {
        if !self.begun && self.now {
            self.inside = true;
            out.push(span_end(HitKind::Start));
        }
        self.begun = true;
    }

    /// Evaluates events that coincide. Returns `false` if they are unusual.
    #[inline]
    fn classify<C: ListedCrossings>(
        &mut self,
        group: &[ListedEvent],
        crossings: &mut C,
        out: &mut Vec<ListedBoundary>,
    ) -> bool {
        let [t_min, t_max] = [self.span.t_min(), self.span.t_max()];
        if group[0].low <= t_min {
            return false;
        }
        for event in &group[1..] {
            if event.is_before_box() {
                self.now = crossings.toggle(event);
            }
        }
        self.begin(out);
        for event in group.iter().filter(|event| !event.is_before_box()) {
            self.now = crossings.toggle(event);
        }
        if self.now == self.inside {
            return true;
        }
        let number =
            if group.len() == 1 { Some(group[0].number) } else { crossings.representative(group, self.now) };
        let Some(number) = number else { return false };
        let (t, entering) = (crossings.t(number), self.now);
        if t < t_max || (t == t_max && !entering) {
            self.inside = entering;
            out.push(ListedBoundary { kind: HitKind::Surface, entering, number });
        }
        t >= t_min
    }
}

/// A boundary where the span begins or ends inside.
fn span_end(kind: HitKind) -> ListedBoundary {
    ListedBoundary { kind, entering: kind == HitKind::Start, number: 0 }
}

#[cfg(test)]
mod tests {
    use super::super::{Event, EventKind, Op, Program, ProgramState, Sweep, Tally, Tree, TreeNode};
    use super::*;
    use crate::crossing::Crossing;
    use crate::testkit::random::Random;

    /// The crossings of the leaves, each with its leaf.
    struct Lists<'a> {
        program: &'a Program,
        all: Vec<(u32, Crossing)>,
        tally: Option<Tally>,
        state: ProgramState,
    }

    impl ListedCrossings for Lists<'_> {
        fn toggle(&mut self, event: &ListedEvent) -> bool {
            self.state.toggle(self.program, self.all[event.number as usize].0);
            let value = self.state.value(self.program);
            if let Some(tally) = &mut self.tally {
                tally.add(event.step);
                assert_eq!(tally.value(), value);
            }
            value
        }

        fn t(&self, number: u32) -> f64 {
            self.all[number as usize].1.t
        }

        fn representative(&self, group: &[ListedEvent], entering: bool) -> Option<u32> {
            let goes_along = |event: &&ListedEvent| {
                let (leaf, crossing) = self.all[event.number as usize];
                !event.is_before_box() && (crossing.entering != self.program.is_subtracted(leaf)) == entering
            };
            let order = |event: &&ListedEvent| {
                let (leaf, crossing) = self.all[event.number as usize];
                (crossing.t_err.to_bits(), leaf, crossing.t.to_bits())
            };
            group.iter().filter(goes_along).min_by_key(order).map(|event| event.number)
        }
    }

    /// A chain of like operations, or operations in two levels.
    fn program(random: &mut Random, leaf_count: usize) -> Program {
        let mut nodes: Vec<TreeNode> = (0..leaf_count as u32).map(TreeNode::Leaf).collect();
        let op = |random: &mut Random| [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
        let mut open: Vec<u32> = (0..leaf_count as u32).collect();
        if random.below(2) == 0 {
            nodes.push(TreeNode::Op(op(random), open.split_off(leaf_count / 2)));
            open.push(leaf_count as u32);
        }
        nodes.push(TreeNode::Op(op(random), open));
        let root = nodes.len() as u32 - 1;
        Program::new(&Tree { nodes }, root, leaf_count)
    }

    /// What lists decide is what the sweep finds.
    #[test]
    fn lists_are_swept_as_events_one_by_one() {
        let mut random = Random::new(61);
        let (mut decided, mut boundaries, mut flat) = (0, 0, 0);
        for case in 0..6000 {
            let program = program(&mut random, 9 + case % 4);
            let span = [Span::FORWARD, Span::new(1.5, 7.0).expect("a span")][random.below(2)];
            let step = [0.5, 1e-9, 4e-15][random.below(3)];
            let (mut all, mut list) = (Vec::new(), Vec::new());
            for leaf in 0..program.leaf_count() as u32 {
                let enter = span.t_min().max([0.0, 1.0, 2.0][random.below(3)]);
                let from = random.below(9) as f64 - 1.0 + step * random.below(4) as f64;
                let to = from + [1.0, step][random.below(2)] * (1 + random.below(6)) as f64;
                let ends = [(from, true), (to, false)].map(|(t, entering)| {
                    let crossing = Crossing::new(t, t.abs() * 1e-16, entering, 0);
                    (Event::new(leaf, EventKind::Membership, crossing, enter), crossing)
                });
                for (event, crossing) in ends.into_iter().filter(|_| random.below(8) > 0 || leaf > 2) {
                    let (low, high) = event.map_or((enter, f64::NEG_INFINITY), |e| (e.low, e.high()));
                    let step = if crossing.entering { program.step(leaf) } else { -program.step(leaf) };
                    let number = all.len() as u32;
                    all.push((leaf, crossing));
                    ListedEvent { low, high, number, step }.insert_into(&mut list);
                }
            }
            let mut sweep = Sweep::default();
            sweep.begin(&program, span);
            for event in list.iter().filter(|event| event.low <= span.t_max()) {
                let (leaf, crossing) = all[event.number as usize];
                let kind = EventKind::Membership;
                if event.is_before_box() {
                    sweep.advance(&program, event.low);
                    sweep.apply(&program, leaf, kind);
                } else {
                    sweep.push(&program, Event { low: event.low, leaf, kind, crossing });
                }
            }
            sweep.finish(&program);
            let expected: Vec<_> = std::iter::from_fn(|| sweep.pop()).collect();
            let mut state = ProgramState::default();
            state.reset(&program);
            let is_whole = all.len() == 2 * program.leaf_count();
            let tally = program.tally().filter(|_| is_whole);
            flat += usize::from(tally.is_some());
            let mut lists = Lists { program: &program, all, tally, state };
            let mut found = Vec::new();
            let mut sweep = ListSweep::new(span, lists.state.value(&program));
            // In steps, as a list that grows.
            let mut steps = [0.5, 2.0, 3.25, 6.0].into_iter();
            if steps.all(|up_to| sweep.advance(&list, up_to, &mut lists, &mut found))
                && sweep.finish(&list, &mut lists, &mut found)
            {
                decided += 1;
                boundaries += found.len();
                assert_eq!(found.len(), expected.len(), "case {case}: {list:?} {found:?} {expected:?}");
                for (found, expected) in found.iter().zip(&expected) {
                    assert_eq!((found.kind, found.entering), (expected.kind, expected.entering));
                    if found.kind == HitKind::Surface {
                        let (leaf, crossing) = lists.all[found.number as usize];
                        assert_eq!((leaf, crossing), (expected.leaf, expected.crossing), "case {case}");
                    }
                }
            }
        }
        assert!(decided > 3000 && boundaries > 4000 && flat > 1000, "{decided} {boundaries} {flat}");
    }
}
