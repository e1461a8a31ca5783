//! Ends and intervals of lines in lanes.

use crate::simd::Doubles;

/// The end of an interval of each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EndLanes<F> {
    pub t: F,
    pub t_err: F,
    /// The number of the surface.
    pub surface: F,
}

/// An interval of each lane of a mask.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntervalLanes<F> {
    pub enter: EndLanes<F>,
    pub exit: EndLanes<F>,
    pub lanes: u8,
}

/// Where lines are inside a solid: in up to two intervals, ascending.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InsideLanes<F> {
    pub intervals: [IntervalLanes<F>; 2],
    /// The lanes that are not decided.
    pub open: u8,
}

impl<F: Doubles> EndLanes<F> {
    /// An end at infinity, where there is no surface.
    #[inline(always)]
    pub fn at_infinity(t: f64) -> EndLanes<F> {
        EndLanes { t: F::splat(t), t_err: F::splat(0.0), surface: F::splat(0.0) }
    }

    /// `self` in the lanes of a mask, else `other`.
    #[inline(always)]
    pub fn where_set(&self, lanes: u8, other: &EndLanes<F>) -> EndLanes<F> {
        EndLanes {
            t: self.t.where_set(lanes, other.t),
            t_err: self.t_err.where_set(lanes, other.t_err),
            surface: self.surface.where_set(lanes, other.surface),
        }
    }
}

impl<F: Doubles> IntervalLanes<F> {
    /// The whole line, in the lanes of a mask.
    #[inline(always)]
    pub fn all(lanes: u8) -> IntervalLanes<F> {
        let (enter, exit) = (EndLanes::at_infinity(f64::NEG_INFINITY), EndLanes::at_infinity(f64::INFINITY));
        IntervalLanes { enter, exit, lanes }
    }

    /// No interval.
    #[inline(always)]
    pub fn none() -> IntervalLanes<F> {
        IntervalLanes::all(0)
    }

    /// What both have in common, as `Interval::clip`.
    #[inline(always)]
    pub fn clip(&self, other: &IntervalLanes<F>) -> IntervalLanes<F> {
        let enter = other.enter.where_set(self.enter.t.is_less(other.enter.t), &self.enter);
        let exit = other.exit.where_set(other.exit.t.is_less(self.exit.t), &self.exit);
        let lanes = self.lanes & other.lanes & enter.t.is_less(exit.t);
        IntervalLanes { enter, exit, lanes }
    }
}
