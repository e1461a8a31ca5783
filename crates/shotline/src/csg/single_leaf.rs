//! The boundaries of a single leaf, computed directly from its crossings. They are those that the sweep would return.

use super::event::{Boundary, HitKind};
use super::sweep::is_within;
use crate::crossing::Crossing;
use crate::ray::Span;

/// The position of a ray in the crossings of the only leaf of a body. The caller keeps the list of crossings.
#[derive(Clone, Copy, Debug)]
pub struct SingleLeaf {
    span: Span,
    /// The index of the next crossing.
    next: usize,
    /// Whether the ray is inside the leaf before that crossing.
    leaf_in: bool,
    /// Whether the ray was inside the result after the last boundary.
    inside: bool,
    begun: bool,
}

impl SingleLeaf {
    /// Begins a ray. Returns `None` if crossings coincide within their bounds: then the sweep must resolve them.
    pub fn begin(list: &[Crossing], span: Span) -> Option<SingleLeaf> {
        let apart = list.windows(2).all(|pair| pair[1].low() > pair[0].high());
        let before = list.iter().take_while(|c| c.high() < span.t_min()).count();
        let single = SingleLeaf { span, next: before, leaf_in: before % 2 == 1, inside: false, begun: false };
        apart.then_some(single)
    }

    /// Returns the next boundary, given the same list again.
    pub fn next(&mut self, list: &[Crossing]) -> Option<Boundary> {
        let (t_min, t_max) = (self.span.t_min(), self.span.t_max());
        while let Some(crossing) = list.get(self.next).filter(|c| c.t < f64::INFINITY && c.low() <= t_max) {
            let first = !std::mem::replace(&mut self.begun, true);
            let at_start = crossing.low() <= t_min;
            if first && self.leaf_in && !at_start {
                return Some(self.emit_start());
            }
            let began_inside = first && self.leaf_in;
            self.next += 1;
            self.leaf_in = !self.leaf_in;
            if self.leaf_in == self.inside {
                continue;
            }
            let entering = self.leaf_in;
            let boundary = Boundary { kind: HitKind::Surface, entering, leaf: 0, crossing: *crossing };
            if entering && (began_inside || crossing.t < t_min) {
                return Some(self.emit_start());
            }
            if is_within(&boundary, self.span) {
                self.inside = entering;
                return Some(boundary);
            }
        }
        if !std::mem::replace(&mut self.begun, true) && self.leaf_in {
            return Some(self.emit_start());
        }
        std::mem::take(&mut self.inside).then(|| Boundary::of_span_end(HitKind::End, t_max))
    }

    /// The number of crossings before the position: the last of them made the last boundary, if that is a surface.
    pub fn passed(&self) -> usize {
        self.next
    }

    fn emit_start(&mut self) -> Boundary {
        self.inside = true;
        Boundary::of_span_end(HitKind::Start, self.span.t_min())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Event, EventKind, Program, Sweep, Tree, TreeNode};
    use super::*;
    use crate::testkit::random::Random;

    /// The boundaries that the sweep returns.
    fn plain(list: &[Crossing], span: Span) -> Vec<Boundary> {
        let program = Program::new(&Tree { nodes: vec![TreeNode::Leaf(0)] }, 0, 1);
        let mut sweep = Sweep::default();
        sweep.begin(&program, span);
        for &crossing in list {
            match Event::new(0, EventKind::Membership, crossing, span.t_min()) {
                Some(event) if event.low <= span.t_max() && crossing.t < f64::INFINITY => {
                    sweep.push(&program, event);
                }
                Some(_) => {}
                None => sweep.apply(&program, 0, EventKind::Membership),
            }
        }
        sweep.finish(&program);
        std::iter::from_fn(|| sweep.pop()).collect()
    }

    #[test]
    fn a_single_leaf_has_the_boundaries_of_the_sweep() {
        let mut random = Random::new(3);
        let (mut fast, mut slow) = (0, 0);
        for _ in 0..200_000 {
            // Few distinct `t`, so that crossings lie at the ends of the span, and bounds that reach from one
            // crossing to the next.
            let mut ts: Vec<f64> = (0..2 * random.below(4)).map(|_| random.below(9) as f64 / 2.0).collect();
            ts.sort_by(f64::total_cmp);
            if let [first, .., last] = &mut ts[..] {
                (*first, *last) = match random.below(6) {
                    0 => (f64::NEG_INFINITY, *last),
                    1 => (*first, f64::INFINITY),
                    2 => (f64::NEG_INFINITY, f64::INFINITY),
                    _ => (*first, *last),
                };
            }
            let bound = |t: f64| if t.is_finite() { [0.0, 1e-17, 0.01, 0.04][random.below(4)] } else { 0.0 };
            let errors: Vec<f64> = ts.iter().copied().map(bound).collect();
            let list: Vec<Crossing> = (0..)
                .zip(ts.iter().zip(errors))
                .map(|(i, (&t, t_err))| Crossing::new(t, t_err, i % 2 == 0, i))
                .collect();
            let [a, b] = [0, 1].map(|_| random.below(9) as f64 / 2.0);
            let t_max = if random.below(4) == 0 { f64::INFINITY } else { a.max(b) };
            let span = Span::new(a.min(b), t_max).unwrap();
            let Some(mut single) = SingleLeaf::begin(&list, span) else {
                slow += 1;
                continue;
            };
            fast += 1;
            let boundaries: Vec<Boundary> = std::iter::from_fn(|| single.next(&list)).collect();
            assert_eq!(boundaries, plain(&list, span), "{list:?} {span:?}");
        }
        assert!(fast > 50_000 && slow > 20_000, "{fast} {slow}");
    }
}
