//! Combinations in lanes have the boundaries of the sweep.

use super::lanes::{Boundaries, LaneEvents};
use super::{Boundary, Event, EventKind, HitKind, Op, Program, Sweep, Tree, TreeNode};
use crate::crossing::Crossing;
use crate::lanes::{EndLanes, IntervalLanes};
use crate::math::Real;
use crate::ray::Span;
use crate::simd::{Doubles, Portable, Simd, Task, dispatch};
use crate::testkit::random::Random;

/// A line: the crossings of each leaf, and where it enters the box of each leaf.
struct Line {
    lists: Vec<Vec<Crossing>>,
    boxes: Vec<f64>,
}

fn random_program(random: &mut Random, leaf_count: usize) -> Program {
    let mut nodes: Vec<TreeNode> = (0..leaf_count as u32).map(TreeNode::Leaf).collect();
    let mut open: Vec<u32> = (0..leaf_count as u32).collect();
    while open.len() > 1 {
        let take = (1 + random.below(3)).min(open.len());
        let args = (0..take).map(|_| open.swap_remove(random.below(open.len()))).collect();
        nodes.push(TreeNode::Op([Op::Union, Op::Intersection, Op::Difference][random.below(3)], args));
        open.push((nodes.len() - 1) as u32);
    }
    Program::new(&Tree { nodes }, open[0], leaf_count)
}

/// A list of crossings at few distinct `t`, so that many coincide, also with the ends of the span.
fn random_list(random: &mut Random, infinite: bool) -> Vec<Crossing> {
    let mut ts: Vec<f64> = (0..2 * random.below(3))
        .map(|_| random.below(13) as f64 / 2.0 + 0.01 * random.below(4) as f64)
        .collect();
    ts.sort_by(f64::total_cmp);
    if let [first, .., last] = &mut ts[..]
        && infinite
    {
        match random.below(4) {
            0 => *first = f64::NEG_INFINITY,
            1 => *last = f64::INFINITY,
            2 => (*first, *last) = (f64::NEG_INFINITY, f64::INFINITY),
            _ => {}
        }
    }
    let bound = |t: f64| if t.is_finite() { [0.0, 1e-17, 1e-3, 2e-3, 0.04][random.below(5)] } else { 0.0 };
    let errors: Vec<f64> = ts.iter().copied().map(bound).collect();
    let crossing = |(i, (&t, t_err)): (u32, (&f64, f64))| Crossing::new(t, t_err, i.is_multiple_of(2), i);
    (0..).zip(ts.iter().zip(errors)).map(crossing).collect()
}

/// The boundaries that the sweep returns.
fn swept(program: &Program, line: &Line, span: Span) -> Vec<Boundary> {
    let mut sweep = Sweep::default();
    sweep.begin(program, span);
    // Boxes are opened in order, before the events that begin there.
    let mut actions: Vec<(f64, Option<Event>, u32)> = Vec::new();
    for (leaf, (list, &enter)) in (0..).zip(line.lists.iter().zip(&line.boxes)) {
        for &crossing in list {
            match Event::new(leaf, EventKind::Membership, crossing, enter) {
                Some(event) if crossing.t < f64::INFINITY => actions.push((event.low, Some(event), leaf)),
                Some(_) => {}
                None => actions.push((enter, None, leaf)),
            }
        }
    }
    actions.retain(|(t, ..)| *t <= span.t_max());
    actions
        .sort_by(|(a, event, _), (b, other, _)| a.total_cmp(b).then(event.is_some().cmp(&other.is_some())));
    for (t, event, leaf) in actions {
        sweep.advance(program, t);
        match event {
            Some(event) => sweep.push(program, event),
            None => sweep.apply(program, leaf, EventKind::Membership),
        }
    }
    sweep.finish(program);
    let out = std::iter::from_fn(|| sweep.pop()).collect();
    sweep.end(program);
    out
}

/// The boundaries of eight lines: all, or the first up to a limit. `None` for those that are left open.
#[derive(Clone, Copy)]
struct Judge<'a> {
    program: &'a Program,
    lines: &'a [Line],
    span: Span,
    first: Option<f64>,
    surfaces_only: bool,
}

impl Task for Judge<'_> {
    type Output = Vec<Option<Vec<Boundary>>>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let mut out = Vec::new();
        for start in (0..8).step_by(S::Wide::LANES) {
            let lines = &self.lines[start..start + S::Wide::LANES];
            let mut events = LaneEvents::<S::Wide>::new(self.span);
            for leaf in 0..self.program.leaf_count() {
                let enter = S::Wide::from_fn(|lane| lines[lane].boxes[leaf]);
                for interval in 0..2 {
                    events.add(leaf as u32, &interval_of(lines, leaf, interval), enter);
                }
            }
            let boundaries = match self.first {
                Some(limit) => {
                    events.first(self.program, S::Wide::ALL, S::Wide::splat(limit), self.surfaces_only)
                }
                None => events.all(self.program, S::Wide::ALL),
            };
            out.extend((0..S::Wide::LANES).map(|lane| self.of_lane(&events, &boundaries, lane)));
        }
        out
    }
}

impl Judge<'_> {
    fn of_lane<F: Doubles>(
        &self,
        events: &LaneEvents<F>,
        boundaries: &Boundaries,
        lane: usize,
    ) -> Option<Vec<Boundary>> {
        let is = |lanes: u8| lanes >> lane & 1 == 1;
        let mut list = Vec::new();
        for (i, event) in events.events().iter().enumerate().filter(|(i, _)| is(boundaries.events[*i])) {
            let number = |of: F| of.store()[lane];
            let surface = number(event.surface) as u32;
            let crossing = Crossing::new(number(event.t), number(event.t_err), event.entering, surface);
            let entering = is(boundaries.after(i));
            list.push(Boundary { kind: HitKind::Surface, entering, leaf: event.leaf, crossing });
        }
        list.sort_by(|a, b| a.crossing.t.total_cmp(&b.crossing.t));
        if is(boundaries.starts) {
            list.insert(0, Boundary::of_span_end(HitKind::Start, self.span.t_min()));
        }
        if is(boundaries.ends) {
            list.push(Boundary::of_span_end(HitKind::End, self.span.t_max()));
        }
        (!is(boundaries.open)).then_some(list)
    }
}

#[inline(always)]
fn interval_of<F: Doubles>(lines: &[Line], leaf: usize, interval: usize) -> IntervalLanes<F> {
    let crossing = |lane: usize, side: usize| lines[lane].lists[leaf].get(2 * interval + side);
    let end = |side: usize| EndLanes {
        t: F::from_fn(|lane| crossing(lane, side).map_or(0.0, |c| c.t)),
        t_err: F::from_fn(|lane| crossing(lane, side).map_or(0.0, |c| c.t_err)),
        surface: F::from_fn(|lane| crossing(lane, side).map_or(0.0, |c| f64::from(c.surface))),
    };
    let exists = |lane: usize| u8::from(crossing(lane, 0).is_some()) << lane;
    let lanes = (0..lines.len()).fold(0, |lanes, lane| lanes | exists(lane));
    IntervalLanes { enter: end(0), exit: end(1), lanes }
}

#[test]
fn combinations_in_lanes_have_the_boundaries_of_the_sweep() {
    let mut random = Random::new(23);
    let (mut decided, mut open, mut boundaries) = (0, 0, 0);
    for _ in 0..20_000 {
        let leaf_count = 1 + random.below(8);
        let program = random_program(&mut random, leaf_count);
        assert!(program.takes_lanes());
        let [a, b] = [0, 1].map(|_| random.below(13) as f64 / 2.0);
        let t_max = if random.below(2) == 0 { f64::INFINITY } else { a.max(b) };
        let span = Span::new(a.min(b) - 0.25 * random.below(2) as f64, t_max).expect("a span");
        let infinite = random.below(3) == 0;
        let lines: Vec<Line> = (0..8)
            .map(|_| {
                let mut lists: Vec<_> = (0..leaf_count).map(|_| random_list(&mut random, infinite)).collect();
                // Boxes begin at the first crossings or before.
                let enter = |list: &Vec<Crossing>| match list.first() {
                    Some(first) if first.t.is_finite() && random.below(2) == 0 => {
                        (first.t - [0.1, 1e-3, 0.0][random.below(3)]).max(span.t_min())
                    }
                    _ => span.t_min(),
                };
                let mut boxes: Vec<f64> = lists.iter().map(enter).collect();
                if program.needs(0) {
                    // Outside of the first leaf no other one matters, so their boxes are cut by its box.
                    let first = boxes[0];
                    boxes.iter_mut().for_each(|enter| *enter = enter.max(first));
                }
                // A box behind the span is missed.
                lists
                    .iter_mut()
                    .zip(&boxes)
                    .filter(|(_, enter)| **enter > t_max)
                    .for_each(|(list, _)| list.clear());
                Line { lists, boxes }
            })
            .collect();
        let limit = [f64::INFINITY, random.number(0.0, 7.0).max(span.t_min())][random.below(2)];
        let judge = |first: Option<f64>, surfaces_only: bool| {
            let judge = Judge { program: &program, lines: &lines, span, first, surfaces_only };
            let found = dispatch(judge);
            // Four lanes at a time.
            assert_eq!(found, judge.run::<Portable>());
            found
        };
        let (all, first, surface) = (judge(None, false), judge(Some(limit), false), judge(Some(limit), true));
        for (lane, line) in lines.iter().enumerate() {
            let expected = swept(&program, line, span);
            let nearest = |only: bool| {
                let counts = |b: &&Boundary| !only || b.kind == HitKind::Surface;
                let surfaces = expected.iter().filter(|b| b.kind != HitKind::End).find(counts);
                surfaces.copied().into_iter().filter(|b| b.crossing.t <= limit).collect::<Vec<_>>()
            };
            let cases = [(&all, expected.clone()), (&first, nearest(false)), (&surface, nearest(true))];
            for (found, expected) in cases {
                match &found[lane] {
                    Some(found) => {
                        assert_eq!(found, &expected, "{:?} {:?} {span:?} {limit}", line.lists, line.boxes);
                        (decided, boundaries) = (decided + 1, boundaries + found.len());
                    }
                    None => open += 1,
                }
            }
        }
    }
    assert!(decided > 2 * open && boundaries > decided / 2, "{decided} {open} {boundaries}");
}
