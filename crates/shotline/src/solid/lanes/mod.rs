//! Lines in lanes: solids that intersect several lines at once.
//!
//! Each lane has the bits that [`Solid::crossings`](super::Solid::crossings) has for its line alone: the same operations in
//! the same order, without fused ones. Where that method would go on in double-double, or where a face or a generator
//! might contain the line, the lane is left open, and the caller casts its line alone.

mod quadric;
mod slab;
#[cfg(test)]
mod tests;

use super::form::Form;
use super::interval::Slab;
use crate::lanes::{IntervalLanes, LineLanes};
use crate::simd::Doubles;

/// How a solid intersects several lines at once.
#[derive(Clone, Copy, Debug)]
pub struct InLanes<'a>(Kernel<'a>);

#[derive(Clone, Copy, Debug)]
enum Kernel<'a> {
    Slabs([Slab; 3]),
    Quadric(&'a Form, Option<&'a Slab>),
}

/// Where lines are inside a solid: in up to two intervals, ascending.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InsideLanes<F> {
    pub intervals: [IntervalLanes<F>; 2],
    /// The lanes that are not decided.
    pub open: u8,
}

impl<'a> InLanes<'a> {
    /// What three slabs have in common.
    pub(super) fn slabs(slabs: [Slab; 3]) -> InLanes<'a> {
        InLanes(Kernel::Slabs(slabs))
    }

    /// Where a form is negative, within a slab if there is one.
    pub(super) fn quadric(form: &'a Form, caps: Option<&'a Slab>) -> InLanes<'a> {
        InLanes(Kernel::Quadric(form, caps))
    }

    /// Where the lines of some lanes are inside.
    #[inline(always)]
    pub(crate) fn inside<F: Doubles>(&self, line: &LineLanes<F>, lanes: u8) -> InsideLanes<F> {
        match &self.0 {
            Kernel::Slabs([x, y, z]) => {
                let (mut inside, mut open) = slab::between(x, line, lanes);
                for slab in [y, z] {
                    let (between, undecided) = slab::between(slab, line, lanes);
                    (inside, open) = (inside.clip(&between), open | undecided);
                }
                InsideLanes { intervals: [inside, IntervalLanes::none()], open }
            }
            Kernel::Quadric(form, None) => quadric::inside(form, line, lanes),
            Kernel::Quadric(form, Some(caps)) => {
                let (between, open) = slab::between(caps, line, lanes);
                let mut inside = quadric::inside(form, line, between.lanes);
                for interval in &mut inside.intervals {
                    *interval = interval.clip(&between);
                }
                InsideLanes { open: inside.open | open, ..inside }
            }
        }
    }
}

impl InLanes<'_> {
    /// The normals at points of surfaces, as [`Solid::normal`](super::Solid::normal).
    #[inline(always)]
    pub(crate) fn normal<F: Doubles>(&self, p: [F; 3], surface: F) -> [F; 3] {
        let (one, zero) = (F::splat(1.0), F::splat(0.0));
        match &self.0 {
            Kernel::Slabs(_) => {
                let is =
                    |number: f64| surface.is_at_most(F::splat(number)) & F::splat(number).is_at_most(surface);
                let side = one.where_set(is(1.0) | is(3.0) | is(5.0), -one);
                [
                    one.where_set(is(0.0) | is(1.0), zero) * side,
                    one.where_set(is(2.0) | is(3.0), zero) * side,
                    one.where_set(is(4.0) | is(5.0), zero) * side,
                ]
            }
            Kernel::Quadric(form, caps) => {
                let side = quadric::gradient(form, p);
                if caps.is_none() {
                    return side;
                }
                let cap = F::splat(0.5).is_less(surface);
                let up = one.where_set(F::splat(1.5).is_less(surface), -one);
                [zero.where_set(cap, side[0]), zero.where_set(cap, side[1]), up.where_set(cap, side[2])]
            }
        }
    }
}
