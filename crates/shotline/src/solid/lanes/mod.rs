//! Lines in lanes: solids that intersect several lines at once.
//!
//! Each lane has the bits that [`Solid::crossings`](super::Solid::crossings) has for its line alone: the same operations in
//! the same order, without fused ones but in the torus, where both are one function. Where that method would go on in
//! double-double or to a search, or where a face or a generator might contain the line, the lane is left open, and the
//! caller casts its line alone.

mod quadric;
mod slab;
#[cfg(test)]
mod tests;

use quadric::FormLanes;
use slab::SlabLanes;

use super::form::Form;
use super::interval::Slab;
use super::ring::{self, Rings};
use crate::lanes::vector::gather;
use crate::lanes::{InsideLanes, IntervalLanes, LineLanes};
use crate::math::Vec3;
use crate::simd::Doubles;

/// How a solid intersects several lines at once.
#[derive(Clone, Copy, Debug)]
pub struct InLanes<'a>(Kernel<'a>);

#[derive(Clone, Copy, Debug)]
enum Kernel<'a> {
    Box(&'a Vec3, &'a Vec3),
    Quadric(&'a Form, Option<&'a Slab>),
    /// A torus, by its two radii.
    Ring(f64, f64),
}

/// The numbers of [`InLanes::group`] are below this.
pub(crate) const GROUPS: u32 = 2 + (1 << 6);

impl<'a> InLanes<'a> {
    /// The box between two corners.
    pub(super) fn cuboid(min: &'a Vec3, max: &'a Vec3) -> InLanes<'a> {
        InLanes(Kernel::Box(min, max))
    }

    /// Where a form is negative, within a slab if there is one.
    pub(super) fn quadric(form: &'a Form, caps: Option<&'a Slab>) -> InLanes<'a> {
        InLanes(Kernel::Quadric(form, caps))
    }

    /// A torus that the quick path takes, by its two radii.
    pub(super) fn ring(major: f64, minor: f64) -> InLanes<'a> {
        InLanes(Kernel::Ring(major, minor))
    }

    /// Where the lines of some lanes are inside.
    #[inline(always)]
    pub(crate) fn inside<F: Doubles>(&self, line: &LineLanes<F>, lanes: u8) -> InsideLanes<F> {
        match &self.0 {
            Kernel::Box(..) => {
                let [x, y, z] = [self.slab(0), self.slab(1), self.slab(2)];
                within_slabs(&[SlabLanes::of(&x), SlabLanes::of(&y), SlabLanes::of(&z)], line, lanes)
            }
            Kernel::Quadric(form, None) => quadric::inside(&FormLanes::of(form), line, lanes),
            Kernel::Quadric(form, Some(caps)) => {
                within_caps(&FormLanes::of(form), &SlabLanes::of(caps), line, lanes)
            }
            Kernel::Ring(major, minor) => ring::inside(&Rings::of(*major, *minor), line, lanes),
        }
    }

    /// A number for the solids that can be intersected together, each by a line of its own.
    pub(crate) fn group(&self) -> u32 {
        match &self.0 {
            Kernel::Box(..) => 0,
            Kernel::Ring(..) => 1,
            Kernel::Quadric(form, caps) => {
                let [x, y, z] = form.counts();
                let kind = [form.cross.is_some(), form.is_curved(), caps.is_some(), x, y, z];
                2 + kind.iter().rev().fold(0, |number, is| 2 * number + u32::from(*is))
            }
        }
    }

    /// Where the line of each lane is inside its own solid. All solids are of one [`InLanes::group`].
    #[inline(always)]
    pub(crate) fn inside_each<F: Doubles>(
        solids: &[InLanes<'_>; 8],
        line: &LineLanes<F>,
        lanes: u8,
    ) -> InsideLanes<F> {
        match &solids[0].0 {
            Kernel::Box(..) => within_slabs(
                &[slab_of_each(solids, 0), slab_of_each(solids, 1), slab_of_each(solids, 2)],
                line,
                lanes,
            ),
            Kernel::Quadric(first, caps) => {
                let forms = FormLanes::each(|lane| solids[lane].form().unwrap_or(first));
                match caps {
                    None => quadric::inside(&forms, line, lanes),
                    Some(_) => within_caps(&forms, &slab_of_each(solids, 0), line, lanes),
                }
            }
            Kernel::Ring(..) => ring::inside(&Rings::each(|lane| solids[lane].radii()), line, lanes),
        }
    }

    /// The slab across an axis, or the caps.
    #[inline(always)]
    fn slab(&self, number: usize) -> Slab {
        match &self.0 {
            Kernel::Box(min, max) => Slab::of_box(min, max, number),
            Kernel::Quadric(_, Some(caps)) => **caps,
            Kernel::Quadric(_, None) | Kernel::Ring(..) => unreachable!("solids of one group are alike"),
        }
    }

    #[inline(always)]
    fn form(&self) -> Option<&'a Form> {
        match &self.0 {
            Kernel::Quadric(form, _) => Some(form),
            Kernel::Box(..) | Kernel::Ring(..) => None,
        }
    }

    /// The two radii of a torus.
    #[inline(always)]
    fn radii(&self) -> [f64; 2] {
        match &self.0 {
            Kernel::Ring(major, minor) => [*major, *minor],
            Kernel::Box(..) | Kernel::Quadric(..) => unreachable!("solids of one group are alike"),
        }
    }
}

#[inline(always)]
fn slab_of_each<F: Doubles>(solids: &[InLanes<'_>; 8], number: usize) -> SlabLanes<F> {
    SlabLanes::each(|lane| solids[lane].slab(number))
}

/// Where lines are in all of some slabs.
#[inline(always)]
fn within_slabs<F: Doubles>(slabs: &[SlabLanes<F>; 3], line: &LineLanes<F>, lanes: u8) -> InsideLanes<F> {
    let (mut inside, mut open) = slabs[0].between(line, lanes);
    for slab in &slabs[1..] {
        let (between, undecided) = slab.between(line, lanes);
        (inside, open) = (inside.clip(&between), open | undecided);
    }
    InsideLanes { intervals: [inside, IntervalLanes::none()], open }
}

/// Where forms are negative between caps.
#[inline(always)]
fn within_caps<F: Doubles>(
    form: &FormLanes<F>,
    caps: &SlabLanes<F>,
    line: &LineLanes<F>,
    lanes: u8,
) -> InsideLanes<F> {
    let (between, open) = caps.between(line, lanes);
    let mut inside = quadric::inside(form, line, between.lanes);
    for interval in &mut inside.intervals {
        *interval = interval.clip(&between);
    }
    InsideLanes { open: inside.open | open, ..inside }
}

impl InLanes<'_> {
    /// The normals at points of surfaces, as [`Solid::normal`](super::Solid::normal).
    #[inline(always)]
    pub(crate) fn normal<F: Doubles>(&self, p: [F; 3], surface: F) -> [F; 3] {
        let (one, zero) = (F::splat(1.0), F::splat(0.0));
        match &self.0 {
            Kernel::Box(..) => {
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
                normals_of_quadrics(&FormLanes::of(form), caps.is_some(), p, surface)
            }
            Kernel::Ring(major, _) => ring::normals(F::splat(*major), p),
        }
    }

    /// As [`InLanes::normal`], at a point of the solid of each lane. All solids are of one [`InLanes::group`].
    #[inline(always)]
    pub(crate) fn normal_each<F: Doubles>(solids: &[InLanes<'_>; 8], p: [F; 3], surface: F) -> [F; 3] {
        match &solids[0].0 {
            Kernel::Box(..) => solids[0].normal(p, surface),
            Kernel::Quadric(first, caps) => {
                let forms = FormLanes::each(|lane| solids[lane].form().unwrap_or(first));
                normals_of_quadrics(&forms, caps.is_some(), p, surface)
            }
            Kernel::Ring(..) => ring::normals(gather(|lane| solids[lane].radii()[0]), p),
        }
    }
}

#[inline(always)]
fn normals_of_quadrics<F: Doubles>(form: &FormLanes<F>, has_caps: bool, p: [F; 3], surface: F) -> [F; 3] {
    let (one, zero) = (F::splat(1.0), F::splat(0.0));
    let side = form.gradient(p);
    if !has_caps {
        return side;
    }
    let cap = F::splat(0.5).is_less(surface);
    let up = one.where_set(F::splat(1.5).is_less(surface), -one);
    [zero.where_set(cap, side[0]), zero.where_set(cap, side[1]), up.where_set(cap, side[2])]
}
