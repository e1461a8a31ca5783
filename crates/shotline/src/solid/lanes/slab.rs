//! Lines in lanes between two parallel planes.

use crate::crossing::GROUPING;
use crate::lanes::vector::gather;
use crate::lanes::{EndLanes, IntervalLanes, LineLanes};
use crate::math::HALF_ULP;
use crate::simd::Doubles;
use crate::solid::interval::Slab;

/// The component of lines across the planes.
struct Across<F> {
    o: F,
    d: F,
    o_err: F,
    d_err: F,
}

impl<F: Doubles> Across<F> {
    /// Where the lines cross the plane at `z`.
    #[inline(always)]
    fn end(&self, z: F, surface: u32) -> EndLanes<F> {
        let t = (z - self.o) / self.d;
        let moved = self.o_err + self.d_err * t.abs();
        let of_frame = (moved / self.d.abs()).where_set(F::splat(0.0).is_less(moved), F::splat(0.0));
        let t_err = F::splat(2.0 * HALF_ULP) * t.abs() + of_frame;
        EndLanes { t, t_err, surface: F::splat(f64::from(surface)) }
    }
}

/// A slab of each lane, all across the same axis.
pub(super) struct SlabLanes<F> {
    axis: usize,
    low: F,
    high: F,
    surface: u32,
}

impl<F: Doubles> SlabLanes<F> {
    /// The same slab in every lane.
    #[inline(always)]
    pub fn of(slab: &Slab) -> SlabLanes<F> {
        let (low, high) = (F::splat(slab.low), F::splat(slab.high));
        SlabLanes { axis: slab.axis, low, high, surface: slab.surface }
    }

    /// The slab of each lane.
    #[inline(always)]
    pub fn each(slab: impl Fn(usize) -> Slab) -> SlabLanes<F> {
        let Slab { axis, surface, .. } = slab(0);
        SlabLanes { axis, low: gather(|lane| slab(lane).low), high: gather(|lane| slab(lane).high), surface }
    }

    /// Where lines are between the planes, as [`Slab::interval`]. Leaves lanes open whose lines might lie in a plane.
    #[inline(always)]
    pub fn between(&self, line: &LineLanes<F>, lanes: u8) -> (IntervalLanes<F>, u8) {
        let SlabLanes { axis, low, high, surface } = *self;
        let across =
            Across { o: line.o[axis], d: line.d[axis], o_err: line.o_err[axis], d_err: line.d_err[axis] };
        let (low_end, high_end) = (across.end(low, surface), across.end(high, surface + 1));
        let is_forward = F::splat(0.0).is_less(across.d);
        let enter = low_end.where_set(is_forward, &high_end);
        let exit = high_end.where_set(is_forward, &low_end);
        let mut interval = IntervalLanes { enter, exit, lanes: lanes & enter.t.is_less(exit.t) };
        let most = F::splat(f64::MAX);
        let is_far = !(low_end.t.abs().is_at_most(most) & high_end.t.abs().is_at_most(most));
        let is_parallel = across.d.abs().is_at_most(F::splat(GROUPING) * across.d_err);
        if (is_far | is_parallel) & lanes == 0 {
            return (interval, 0);
        }
        let doubt = F::splat(GROUPING) * across.o_err;
        let is_near = |z: F| (across.o - z).abs().is_at_most(doubt);
        let is_still = across.d.abs().is_at_most(F::splat(0.0));
        let open = is_parallel & (is_near(low) | is_near(high)) | is_far & !is_still;
        let is_inside = low.is_less(across.o) & across.o.is_less(high);
        let all = IntervalLanes::all(lanes);
        interval.enter = all.enter.where_set(is_still, &interval.enter);
        interval.exit = all.exit.where_set(is_still, &interval.exit);
        interval.lanes = (interval.lanes & !is_still) | (is_still & is_inside & lanes);
        (interval, open & lanes)
    }
}
