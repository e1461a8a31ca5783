//! Where lines in lanes are inside a leaf.

use super::level_visit::ones;
use crate::compile::Leaf;
use crate::contact::Contact;
use crate::crossing::{Crossing, GROUPING, is_alternating};
use crate::lanes::{EndLanes, InsideLanes, IntervalLanes, LineLanes};
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::simd::Doubles;
use crate::solid::Wanted;

/// Memory for leaves whose solids take one line at a time.
#[derive(Debug, Default)]
pub(super) struct LeafMemory {
    crossings: Vec<Crossing>,
    contacts: Vec<Contact>,
}

impl LeafMemory {
    /// Where the lines of some lanes, in the frame of a leaf, are inside it. Leaves lanes open whose lines may run within
    /// its surface, unless it is the only leaf of its body.
    #[inline(always)]
    pub fn inside<F: Doubles>(
        &mut self,
        leaf: &Leaf,
        is_lone: bool,
        (lines, lanes): (&LineLanes<F>, u8),
        span: Span,
        scratch: &mut Scratch,
    ) -> InsideLanes<F> {
        match leaf.solid.in_lanes() {
            Some(solid) => solid.inside(lines, lanes),
            None => self.one_by_one(leaf, is_lone, (lines, lanes), span, scratch),
        }
    }

    #[inline(always)]
    fn one_by_one<F: Doubles>(
        &mut self,
        leaf: &Leaf,
        is_lone: bool,
        (lines, lanes): (&LineLanes<F>, u8),
        span: Span,
        scratch: &mut Scratch,
    ) -> InsideLanes<F> {
        let mut numbers = [[[0.0; 8]; 3]; 4];
        let LineLanes { o, d, o_err, d_err } = lines;
        for (to, vector) in numbers.iter_mut().zip([o, d, o_err, d_err]) {
            for axis in 0..3 {
                vector[axis].store_some(&mut to[axis], 0);
            }
        }
        let mut ends = [[[0.0; 8]; 3]; 4];
        let (mut sets, mut open) = ([0_u8; 2], 0);
        for lane in ones(u32::from(lanes)) {
            let number = |of: usize, axis: usize| numbers[of][axis][lane];
            let vector = |of: usize| Vec3::new(number(of, 0), number(of, 1), number(of, 2));
            let line = Line { o: vector(0), d: vector(1), o_err: vector(2), d_err: vector(3) };
            if !self.is_usual(leaf, is_lone, &line, span, scratch) {
                open |= 1 << lane;
                continue;
            }
            for (i, crossing) in self.crossings.iter().enumerate() {
                sets[i / 2] |= 1 << lane;
                let numbers = [crossing.t, crossing.t_err, f64::from(crossing.surface)];
                numbers.iter().zip(&mut ends[i]).for_each(|(number, lanes)| lanes[lane] = *number);
            }
        }
        InsideLanes { intervals: [interval(&ends[..2], sets[0]), interval(&ends[2..], sets[1])], open }
    }

    /// Finds the crossings of one line. Returns whether they are two intervals at most, as the sweep in lanes takes them.
    fn is_usual(
        &mut self,
        leaf: &Leaf,
        is_lone: bool,
        line: &Line,
        span: Span,
        scratch: &mut Scratch,
    ) -> bool {
        let LeafMemory { crossings, contacts } = self;
        crossings.clear();
        contacts.clear();
        scratch.in_plane.clear();
        leaf.solid.crossings_within(line, span, Wanted::All, crossings, scratch);
        if (crossings.is_empty() || !scratch.in_plane.is_empty()) && !is_lone {
            leaf.solid.contacts(line, contacts, scratch);
        }
        crossings.len() <= 4
            && contacts.is_empty()
            && is_alternating(crossings)
            && crossings.iter().all(|crossing| crossing.reach == GROUPING as f32)
    }
}

#[inline(always)]
fn interval<F: Doubles>(ends: &[[[f64; 8]; 3]], lanes: u8) -> IntervalLanes<F> {
    let end = |[t, t_err, surface]: &[[f64; 8]; 3]| EndLanes {
        t: F::load_some(t, 0),
        t_err: F::load_some(t_err, 0),
        surface: F::load_some(surface, 0),
    };
    IntervalLanes { enter: end(&ends[0]), exit: end(&ends[1]), lanes }
}
