//! The sweep: crossings of leaves in ascending order go in, boundaries of the combination come out.
//!
//! Crossings that agree within their bounds are one event: all of them are toggled, then the expression is
//! judged once. So tangents, shared faces and flush holes leave nothing, at any scale.

use std::collections::VecDeque;

use super::{Program, ProgramState};
use crate::crossing::{Crossing, GROUPING};
use crate::ray::Span;

/// What a boundary is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum HitKind {
    /// The ray passes a surface.
    Surface = 0,
    /// The span begins inside: there is no surface.
    Start = 1,
    /// The span ends inside: there is no surface.
    End = 2,
}

/// A crossing of a leaf on its way into the sweep.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// The lower end of the interval in which this crossing is one with others.
    pub low: f64,
    /// The leaf.
    pub leaf: u32,
    /// What the leaf's solid answered.
    pub crossing: Crossing,
}

impl Event {
    /// The event of a leaf's crossing, given where the ray enters the leaf's effective bounds. Before those
    /// the leaf cannot matter; `None` says that it happened before and only changes the state.
    pub fn new(leaf: u32, crossing: Crossing, enter: f64) -> Option<Event> {
        let reach = GROUPING * crossing.t_err;
        if crossing.t + reach < enter {
            return None;
        }
        // Never before the box: so the order of events does not depend on when the box was opened.
        Some(Event { low: (crossing.t - reach).max(enter), leaf, crossing })
    }

    fn high(&self) -> f64 {
        self.low.max(self.crossing.t + GROUPING * self.crossing.t_err)
    }
}

/// Where the membership in the result changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// What it is.
    pub kind: HitKind,
    /// Whether the ray passes into the result.
    pub entering: bool,
    /// The leaf whose surface it is; meaningless without a surface.
    pub leaf: u32,
    /// The leaf's crossing, with `t` and its bound.
    pub crossing: Crossing,
}

/// The state of one sweep; reused from ray to ray.
#[derive(Debug)]
pub struct Sweep {
    span: Span,
    state: ProgramState,
    group: Vec<Event>,
    group_high: f64,
    /// Whether the result was in after the last event.
    inside: bool,
    begun: bool,
    out: VecDeque<Boundary>,
}

impl Default for Sweep {
    fn default() -> Sweep {
        Sweep {
            span: Span::FORWARD,
            state: ProgramState::default(),
            group: Vec::new(),
            group_high: f64::NEG_INFINITY,
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

    /// Ends a ray; must be called before the next begins.
    pub fn end(&mut self, program: &Program) {
        self.state.clear(program);
    }

    /// A crossing that happened before anything that matters.
    pub fn preset(&mut self, program: &Program, leaf: u32) {
        self.state.toggle(program, leaf);
    }

    /// The next event; `low` must not be below that of earlier ones.
    pub fn offer(&mut self, program: &Program, event: Event) {
        self.advance(program, event.low);
        self.group_high =
            if self.group.is_empty() { event.high() } else { self.group_high.max(event.high()) };
        self.group.push(event);
    }

    /// Promises that no event below `low` will come.
    pub fn advance(&mut self, program: &Program, low: f64) {
        if !self.group.is_empty() && low > self.group_high {
            self.judge(program);
        }
    }

    /// Promises that no event will come.
    pub fn finish(&mut self, program: &Program) {
        if !self.group.is_empty() {
            self.judge(program);
        }
        self.settle_start(program, true);
        if self.inside {
            self.inside = false;
            self.emit_span_end(HitKind::End, self.span.t_max());
        }
    }

    /// The next boundary that is certain.
    pub fn pop(&mut self) -> Option<Boundary> {
        self.out.pop_front()
    }

    /// Judges the state before the first event. If the span begins inside, that is a boundary, unless the
    /// first event lies where the span begins: then what comes after it decides.
    fn settle_start(&mut self, program: &Program, alone: bool) -> bool {
        if self.begun {
            return false;
        }
        self.begun = true;
        let inside = self.state.value(program);
        if inside && alone {
            self.inside = true;
            self.emit_span_end(HitKind::Start, self.span.t_min());
        }
        inside && !alone
    }

    fn judge(&mut self, program: &Program) {
        let (t_min, t_max) = (self.span.t_min(), self.span.t_max());
        let at_start = self.group.iter().any(|e| e.low <= t_min);
        let began_inside = self.settle_start(program, !at_start);
        for event in &self.group {
            self.state.toggle(program, event.leaf);
        }
        let inside = self.state.value(program);
        if inside != self.inside {
            let witness = self.witness(program, inside);
            let t = witness.crossing.t;
            if inside && (began_inside || t < t_min) {
                self.inside = true;
                self.emit_span_end(HitKind::Start, t_min);
            } else if t < t_max || (t == t_max && !inside) {
                // What begins where the span ends has no length in it.
                self.inside = inside;
                self.out.push_back(Boundary { kind: HitKind::Surface, entering: inside, ..witness });
            }
        }
        self.group.clear();
    }

    /// The crossing of the group that stands for it: one that goes the way the result goes, the surest,
    /// whatever order they came in.
    fn witness(&self, program: &Program, entering: bool) -> Boundary {
        let goes_along = |e: &&Event| (e.crossing.entering != program.is_subtracted(e.leaf)) == entering;
        let order = |a: &&Event, b: &&Event| {
            let (x, y) = (&a.crossing, &b.crossing);
            x.t_err
                .total_cmp(&y.t_err)
                .then(a.leaf.cmp(&b.leaf))
                .then(x.t.total_cmp(&y.t))
                .then(x.primitive.cmp(&y.primitive))
        };
        let best = self.group.iter().filter(goes_along).min_by(order).unwrap_or(&self.group[0]);
        Boundary { kind: HitKind::Surface, entering, leaf: best.leaf, crossing: best.crossing }
    }

    /// A boundary where the span begins or ends inside.
    fn emit_span_end(&mut self, kind: HitKind, t: f64) {
        let entering = kind == HitKind::Start;
        self.out.push_back(Boundary {
            kind,
            entering,
            leaf: 0,
            crossing: Crossing::new(t, 0.0, entering, 0),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::op::combine;
    use super::super::{Op, Tree, TreeNode};
    use super::*;
    use crate::testkit::random::Random;

    fn sweep(program: &Program, lists: &[Vec<f64>], span: Span) -> Vec<(f64, bool, HitKind)> {
        let mut sweep = Sweep::default();
        sweep.begin(program, span);
        let mut events = Vec::new();
        for (leaf, list) in (0..).zip(lists) {
            for (i, &t) in list.iter().enumerate() {
                match Event::new(leaf, Crossing::new(t, t.abs() * 1e-16, i % 2 == 0, 0), span.t_min()) {
                    Some(event) => events.push(event),
                    None => sweep.preset(program, leaf),
                }
            }
        }
        events.sort_by(|a, b| a.low.total_cmp(&b.low));
        for event in events {
            sweep.offer(program, event);
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
        // On a face that is left nothing follows; on one that is entered it is a surface; on a seam the
        // span begins inside.
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
