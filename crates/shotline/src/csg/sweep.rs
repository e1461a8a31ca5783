//! The sweep: takes crossings of leaves in ascending order and returns boundaries of the combination.
//!
//! Crossings that coincide within their error bounds are one event: all of them are toggled, then the expression is
//! evaluated once. So tangents, shared faces and flush holes leave nothing, at any scale. In a chain of events, each
//! coincides with the next but the first does not coincide with the last; `chain.rs` resolves chains.

use std::collections::VecDeque;

use super::chain;
use super::contact::{Contacts, OneSided, OrderExchange};
use super::event::{Boundary, Event, EventKind, HitKind};
use super::{Program, ProgramState};
use crate::contact::Contact;
use crate::math::Vec3;
use crate::ray::Span;

/// The state of one sweep; reused from ray to ray.
#[derive(Debug)]
pub struct Sweep {
    span: Span,
    state: ProgramState,
    contacts: Contacts,
    group: Vec<Event>,
    /// The highest and the lowest of the upper ends of the events in the group.
    group_high: f64,
    first_high: f64,
    /// Boundaries of a chain; kept only to reuse the memory.
    chain: Vec<Boundary>,
    /// Whether the ray was inside the result after the last event.
    inside: bool,
    begun: bool,
    out: VecDeque<Boundary>,
}

impl Default for Sweep {
    fn default() -> Sweep {
        Sweep {
            span: Span::FORWARD,
            state: ProgramState::default(),
            contacts: Contacts::default(),
            group: Vec::new(),
            group_high: f64::NEG_INFINITY,
            first_high: f64::INFINITY,
            chain: Vec::new(),
            inside: false,
            begun: false,
            out: VecDeque::new(),
        }
    }
}

impl Sweep {
    /// Begins a ray.
    pub fn begin(&mut self, program: &Program, span: Span) {
        self.span = span;
        self.state.reset(program);
        self.group.clear();
        self.inside = false;
        self.begun = false;
        self.out.clear();
    }

    /// Ends a ray. Must be called before the next ray begins.
    pub fn end(&mut self, program: &Program) {
        self.state.clear(program);
        self.contacts.clear();
    }

    /// Adds a contact of a leaf; must be called before its events are added. The contact and the ray's direction are
    /// in the frame of the body. The ray enters the leaf's bounds at `enter`. Appends the points where borders of the
    /// contact's sector exchange their order with borders of other sectors.
    pub fn add_contact(
        &mut self,
        leaf: u32,
        contact: &Contact,
        direction: Vec3,
        enter: f64,
        order_exchanges: &mut Vec<OrderExchange>,
    ) -> EventKind {
        EventKind::Contact(self.contacts.add(leaf, contact, direction, enter, order_exchanges))
    }

    /// Applies a crossing to the state without making it an event of its own. The caller does so for crossings that
    /// lie before everything that matters.
    pub fn apply(&mut self, program: &Program, leaf: u32, kind: EventKind) {
        match kind {
            EventKind::Membership => self.state.toggle(program, leaf),
            EventKind::Contact(sector) => self.contacts.toggle(sector),
            EventKind::OrderExchange => {}
        }
    }

    /// Whether the ray is inside the result on one side of a `t`, which is computed from the events of the group. All
    /// events before it must have been applied.
    fn value(&mut self, program: &Program, side: impl FnOnce(&[Event]) -> OneSided) -> bool {
        if self.contacts.is_empty() {
            self.state.value(program)
        } else {
            self.contacts.value(program, &mut self.state, side(&self.group))
        }
    }

    /// Adds the next event. Its `low` must not be below that of earlier events.
    pub fn push(&mut self, program: &Program, event: Event) {
        self.advance(program, event.low);
        let high = event.high();
        if self.group.is_empty() {
            (self.group_high, self.first_high) = (high, high);
        } else {
            (self.group_high, self.first_high) = (self.group_high.max(high), self.first_high.min(high));
        }
        self.group.push(event);
    }

    /// Declares that no event below `low` will follow.
    pub fn advance(&mut self, program: &Program, low: f64) {
        if !self.group.is_empty() && low > self.group_high {
            self.classify_group(program);
        }
    }

    /// Whether the ray is outside the result after all events so far, and no event is waiting to be evaluated.
    pub fn is_outside(&mut self, program: &Program) -> bool {
        let t_min = self.span.t_min();
        self.group.is_empty()
            && !self.inside
            && (self.begun || !self.value(program, |_| OneSided::After(t_min)))
    }

    /// Declares that no event will follow.
    pub fn finish(&mut self, program: &Program) {
        if !self.group.is_empty() {
            self.classify_group(program);
        }
        self.classify_start(program, true);
        if self.inside {
            self.inside = false;
            self.emit_span_end(HitKind::End, self.span.t_max());
        }
    }

    /// Returns the next boundary that is certain.
    pub fn pop(&mut self) -> Option<Boundary> {
        self.out.pop_front()
    }

    /// Evaluates the state before the first event. If the span begins inside, that is a boundary, unless the first
    /// event coincides with the start of the span (`alone` is `false`): then the state after the event decides, and
    /// this returns whether the span begins inside before it.
    fn classify_start(&mut self, program: &Program, alone: bool) -> bool {
        if self.begun {
            return false;
        }
        self.begun = true;
        let t_min = self.span.t_min();
        let inside = self.value(program, |group| {
            let first = || group.iter().map(|e| e.crossing.t).fold(t_min, f64::min);
            if alone { OneSided::After(t_min) } else { OneSided::Before(first()) }
        });
        if inside && alone {
            self.inside = true;
            self.emit_span_end(HitKind::Start, self.span.t_min());
        }
        inside && !alone
    }

    fn classify_group(&mut self, program: &Program) {
        // Events are in the order of their lower ends: in a chain the last event begins after the end of another.
        if self.group.last().is_some_and(|last| last.low > self.first_high) {
            self.classify_chain(program);
        } else {
            self.classify_event(program);
        }
        self.group.clear();
    }

    /// Evaluates a group that is one event.
    fn classify_event(&mut self, program: &Program) {
        let t_min = self.span.t_min();
        let at_start = self.group.iter().any(|e| e.low <= t_min);
        let began_inside = self.classify_start(program, !at_start);
        for i in 0..self.group.len() {
            let Event { leaf, kind, .. } = self.group[i];
            self.apply(program, leaf, kind);
        }
        let inside = self.value(program, |group| {
            OneSided::After(group.iter().map(|e| e.crossing.t).fold(f64::NEG_INFINITY, f64::max))
        });
        if inside != self.inside {
            let representative = representative(&self.group, program, inside);
            let t = representative.crossing.t;
            if inside && (began_inside || t < t_min) {
                self.inside = true;
                self.emit_span_end(HitKind::Start, t_min);
            } else if is_within(&representative, self.span) {
                self.inside = inside;
                self.out.push_back(Boundary { kind: HitKind::Surface, entering: inside, ..representative });
            }
        }
    }

    /// Evaluates a chain: applies its events one by one in the order of their `t`, then keeps the boundaries of the
    /// extents and gaps that are resolved.
    fn classify_chain(&mut self, program: &Program) {
        let t_min = self.span.t_min();
        let at_start = !self.begun && self.group.iter().any(|e| e.low <= t_min);
        let began_inside = self.classify_start(program, !at_start);
        let mut inside = if at_start { began_inside } else { self.inside };
        let before = inside;
        let mut chain = std::mem::take(&mut self.chain);
        chain.clear();
        let mut group = std::mem::take(&mut self.group);
        group.sort_by(|a, b| a.crossing.t.total_cmp(&b.crossing.t));
        for same in group.chunk_by(|a, b| a.crossing.t == b.crossing.t) {
            same.iter().for_each(|e| self.apply(program, e.leaf, e.kind));
            let now = self.value(program, |_| OneSided::After(same[0].crossing.t));
            if now != inside {
                chain.push(representative(same, program, now));
                inside = now;
            }
        }
        self.group = group;
        chain::resolve(&mut chain);
        let first = if at_start { self.start_in_chain(&chain, before) } else { 0 };
        for boundary in chain[first..].iter().take_while(|b| is_within(b, self.span)) {
            self.inside = boundary.entering;
            self.out.push_back(*boundary);
        }
        self.chain = chain;
    }

    /// Begins the span within a chain, given the state before the chain. Returns the index of the first boundary that
    /// counts.
    fn start_in_chain(&mut self, chain: &[Boundary], before: bool) -> usize {
        let t_min = self.span.t_min();
        let first = chain.partition_point(|b| b.crossing.t < t_min);
        self.inside = before ^ (first % 2 == 1);
        if self.inside {
            // If the ray exits where the span begins, the interval before the exit has no length.
            if chain.get(first).is_some_and(|b| b.crossing.low() <= t_min) {
                self.inside = false;
                return first + 1;
            }
            self.emit_span_end(HitKind::Start, t_min);
        }
        first
    }

    /// Emits a boundary where the span begins or ends inside.
    fn emit_span_end(&mut self, kind: HitKind, t: f64) {
        self.out.push_back(Boundary::of_span_end(kind, t));
    }
}

/// The representative of coincident crossings: among those that change the result in the given direction, the one
/// with the smallest error bound. It does not depend on the order of the events.
fn representative(group: &[Event], program: &Program, entering: bool) -> Boundary {
    let goes_along = |e: &&Event| (e.crossing.entering != program.is_subtracted(e.leaf)) == entering;
    let order = |a: &&Event, b: &&Event| {
        let (x, y) = (&a.crossing, &b.crossing);
        x.t_err
            .total_cmp(&y.t_err)
            .then(a.leaf.cmp(&b.leaf))
            .then(x.t.total_cmp(&y.t))
            .then(x.primitive.cmp(&y.primitive))
    };
    let best = group.iter().filter(goes_along).min_by(order).unwrap_or(&group[0]);
    Boundary { kind: HitKind::Surface, entering, leaf: best.leaf, crossing: best.crossing }
}

/// Whether a boundary lies before the end of a span. An entry at the end of the span bounds nothing in it.
pub(super) fn is_within(boundary: &Boundary, span: Span) -> bool {
    let t = boundary.crossing.t;
    t < span.t_max() || (t == span.t_max() && !boundary.entering)
}

#[cfg(test)]
mod tests {
    use super::super::{Op, Tree, TreeNode};
    use super::*;
    use crate::crossing::Crossing;
    use crate::lecture::roth::combine;
    use crate::testkit::random::Random;

    fn sweep(program: &Program, lists: &[Vec<f64>], span: Span) -> Vec<(f64, bool, HitKind)> {
        let mut sweep = Sweep::default();
        sweep.begin(program, span);
        let mut events = Vec::new();
        for (leaf, list) in (0..).zip(lists) {
            for (i, &t) in list.iter().enumerate() {
                let crossing = Crossing::new(t, t.abs() * 1e-16, i % 2 == 0, 0);
                match Event::new(leaf, EventKind::Membership, crossing, span.t_min()) {
                    Some(event) => events.push(event),
                    None => sweep.apply(program, leaf, EventKind::Membership),
                }
            }
        }
        events.sort_by(|a, b| a.low.total_cmp(&b.low));
        for event in events {
            sweep.push(program, event);
        }
        sweep.finish(program);
        let out = std::iter::from_fn(|| sweep.pop()).map(|b| (b.crossing.t, b.entering, b.kind)).collect();
        sweep.end(program);
        out
    }

    fn binary(op: Op) -> Program {
        let nodes = vec![TreeNode::Leaf(0), TreeNode::Leaf(1), TreeNode::Op(op, vec![0, 1])];
        Program::new(&Tree { nodes }, 2, 2)
    }

    const SURFACE: HitKind = HitKind::Surface;

    #[test]
    fn shared_faces_leave_no_film() {
        let whole = vec![vec![1.0, 4.0], vec![1.0, 2.0]];
        let out = sweep(&binary(Op::Difference), &whole, Span::FORWARD);
        assert_eq!(out, [(2.0, true, SURFACE), (4.0, false, SURFACE)]);
        let same = vec![vec![1.0, 4.0], vec![1.0, 4.0]];
        assert!(sweep(&binary(Op::Difference), &same, Span::FORWARD).is_empty());
        let abutting = vec![vec![1.0, 2.0], vec![2.0 + 4e-16, 3.0]];
        let out = sweep(&binary(Op::Union), &abutting, Span::FORWARD);
        assert_eq!(out, [(1.0, true, SURFACE), (3.0, false, SURFACE)]);
        assert!(sweep(&binary(Op::Intersection), &abutting, Span::FORWARD).is_empty());
    }

    #[test]
    fn spans_begin_and_end_inside() {
        let span = Span::new(0.0, 10.0).unwrap();
        let program = binary(Op::Union);
        let out = sweep(&program, &[vec![-1.0, 2.0], vec![5.0, 20.0]], span);
        let expected = [
            (0.0, true, HitKind::Start),
            (2.0, false, SURFACE),
            (5.0, true, SURFACE),
            (10.0, false, HitKind::End),
        ];
        assert_eq!(out, expected);
        // A span that begins on an exit face has nothing there; on an entry face the first boundary is a surface;
        // where two leaves abut, the span begins inside.
        assert!(sweep(&program, &[vec![-1.0, 0.0], vec![]], span).is_empty());
        assert_eq!(
            sweep(&program, &[vec![0.0, 1.0], vec![]], span),
            [(0.0, true, SURFACE), (1.0, false, SURFACE)]
        );
        assert_eq!(
            sweep(&program, &[vec![-1.0, 0.0], vec![0.0, 1.0]], span),
            [(0.0, true, HitKind::Start), (1.0, false, SURFACE)]
        );
    }

    /// Random trees over random lists: the flat program, pairwise merging by Roth's table and membership of
    /// midpoints agree.
    #[test]
    fn programs_agree_with_roth_and_with_membership() {
        let mut random = Random::new(11);
        for case in 0..4000 {
            let leaf_count = 1 + random.below(9);
            // Few distinct positions, so that many crossings coincide.
            let lists: Vec<Vec<f64>> = (0..leaf_count)
                .map(|_| {
                    let mut ts: Vec<f64> =
                        (0..2 * random.below(3)).map(|_| (1 + random.below(12)) as f64).collect();
                    ts.sort_by(f64::total_cmp);
                    ts
                })
                .collect();
            let (tree, root) = random_tree(&mut random, leaf_count);
            let program = Program::new(&tree, root, leaf_count);
            let swept: Vec<f64> = sweep(&program, &lists, Span::FORWARD).iter().map(|b| b.0).collect();
            let merged: Vec<f64> = merge(&tree, root, &lists).iter().map(|c| c.t).collect();
            assert_eq!(swept, merged, "case {case}: {tree:?} {lists:?}");
            for k in 0..13 {
                let t = k as f64 + 0.5;
                let inside = swept.iter().filter(|&&s| s < t).count() % 2 == 1;
                assert_eq!(inside, member(&tree, root, &lists, t), "case {case} at {t}");
            }
        }
    }

    fn random_tree(random: &mut Random, leaf_count: usize) -> (Tree, u32) {
        let mut nodes: Vec<TreeNode> = (0..leaf_count as u32).map(TreeNode::Leaf).collect();
        let mut open: Vec<u32> = (0..leaf_count as u32).collect();
        while open.len() > 1 || random.below(4) == 0 {
            let take = (1 + random.below(3)).min(open.len());
            let args = (0..take).map(|_| open.swap_remove(random.below(open.len()))).collect();
            let op = [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
            nodes.push(TreeNode::Op(op, args));
            open.push((nodes.len() - 1) as u32);
        }
        (Tree { nodes }, open[0])
    }

    fn merge(tree: &Tree, node: u32, lists: &[Vec<f64>]) -> Vec<Crossing> {
        match &tree.nodes[node as usize] {
            TreeNode::Leaf(leaf) => {
                let own = lists[*leaf as usize].iter().enumerate();
                let list: Vec<Crossing> = own.map(|(i, &t)| Crossing::new(t, 1e-16, i % 2 == 0, 0)).collect();
                combine(Op::Union, &list, &[])
            }
            TreeNode::Op(op, args) => {
                let first = merge(tree, args[0], lists);
                args[1..].iter().fold(first, |a, &arg| combine(*op, &a, &merge(tree, arg, lists)))
            }
        }
    }

    fn member(tree: &Tree, node: u32, lists: &[Vec<f64>], t: f64) -> bool {
        match &tree.nodes[node as usize] {
            TreeNode::Leaf(leaf) => lists[*leaf as usize].iter().filter(|&&s| s < t).count() % 2 == 1,
            TreeNode::Op(op, args) => {
                let mut values = args.iter().map(|&arg| member(tree, arg, lists, t));
                match op {
                    Op::Union => values.any(|v| v),
                    Op::Intersection => values.all(|v| v),
                    Op::Difference => values.next() == Some(true) && !values.any(|v| v),
                }
            }
        }
    }
}
