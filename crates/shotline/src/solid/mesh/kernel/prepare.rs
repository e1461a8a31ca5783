//! Prepares rays, four at a time.

use super::frame::MeshFrame;
use super::lines::{BlockQuery, RayBlock};
use super::ray::{CLEARANCE, KernelRay, MISS, Prepared, SMALLEST, beyond};
use super::widths::{Errors, Vectors, Widths, width};
use crate::accel::wide::{Frame, PAD};
use crate::math::{HALF_ULP, Real, Vec3, power_of_two};
use crate::simd::{F64x4, Simd};
use crate::solid::mesh::mesh_line::exponent_within_range;

/// Rays whose origin is farther from the centre of the mesh than this many sizes take the plain path: the error of the
/// entry into the mesh's box would exceed the padding of the boxes.
const FARTHEST: f64 = (1 << 23) as f64;

/// Components of a direction below this fraction of the longest count as this fraction for boxes: the ray then moves
/// by less than the padding within the mesh.
const STEEPEST: f64 = 1e-18;

/// Rays whose `t` is scaled by more than two to this power take the plain path: it may overflow or underflow.
const MAX_EXPONENT: i32 = 900;

/// Lines that may run in planes farther away than this many sizes take the plain path. Less than the padding of the
/// boxes leaves, so that the triangles in these planes are visited.
const NEAREST: f64 = 1.0 / (1 << 30) as f64;

/// The number of rays that are prepared at a time.
pub(super) const AT_A_TIME: usize = 4;

/// What rays are prepared for: the numbers of a mesh that all of them need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Preparation {
    frame: Frame,
    /// The corners of the padded box of the mesh, relative to its centre.
    low: Vec3,
    high: Vec3,
    /// A bound on a sheared coordinate of any vertex of a leaf that the ray meets, without the part that depends on the
    /// ray.
    width: f64,
    query: BlockQuery,
}

/// Four lines after scaling.
struct Scaled<S: Simd> {
    o: Vectors<S>,
    d: Vectors<S>,
    /// `t_min` and `t_max`.
    from: S::F64,
    to: S::F64,
    /// The factors of origins and of directions.
    of_o: S::F64,
    of_d: S::F64,
    /// The lines whose `t` has an extreme scale, whose span does not scale without rounding, or that have components
    /// that may vanish.
    is_extreme: u8,
}

/// The axes of four lines: where `z_is_shorter` is negative the direction is not largest along z, and where
/// `y_is_shorter` is too, it is largest along x.
#[derive(Clone, Copy)]
struct Roles<S: Simd> {
    z_is_shorter: S::F64,
    y_is_shorter: S::F64,
}

impl<S: Simd> Roles<S> {
    #[inline(always)]
    fn of(size: &Vectors<S>) -> Roles<S> {
        Roles { z_is_shorter: size[2] - size[0].greater(size[1]), y_is_shorter: size[1] - size[0] }
    }

    /// One of three values for lines along x, y and z.
    #[inline(always)]
    fn pick(&self, x: S::F64, y: S::F64, z: S::F64) -> S::F64 {
        x.where_negative(self.y_is_shorter, y).where_negative(self.z_is_shorter, z)
    }

    /// The components across, in cyclic order, and along.
    #[inline(always)]
    fn sorted(&self, v: &Vectors<S>) -> Vectors<S> {
        [self.pick(v[1], v[2], v[0]), self.pick(v[2], v[0], v[1]), self.pick(v[0], v[1], v[2])]
    }
}

/// Four lines in the box of the mesh.
struct InBox<S: Simd> {
    roles: Roles<S>,
    /// The largest component of each direction.
    longest: S::F64,
    /// The origins, relative to the centre of the mesh.
    from_centre: Vectors<S>,
    /// The reciprocals of the directions.
    inverse: Vectors<S>,
    enter: S::F64,
    exit: S::F64,
    is_extreme: u8,
}

/// The intervals of `t` in which hits of four lines count.
struct Window<S: Simd> {
    from: S::F64,
    to: S::F64,
    /// Hits whose `t` differ by more are separate events.
    margin: S::F64,
    /// How near the planes of triangles are in which a line may run.
    near: S::F64,
    may_be_inside: u8,
    /// The lines on which an event may have any width.
    is_unbounded: u8,
}

impl Preparation {
    pub fn of(mesh: &MeshFrame, frame: Frame, query: BlockQuery) -> Preparation {
        let (bounds, pad) = (mesh.scaled_bounds, Vec3::splat(2.0 * PAD * frame.size));
        Preparation {
            frame,
            low: bounds.min - frame.centre - pad,
            high: bounds.max - frame.centre + pad,
            // Rays meet boxes that are padded and tested in float32: that adds far less than a hundredth.
            width: 2.02 * bounds.size().max_element(),
            query,
        }
    }

    /// Whether the rays are cast at an operand of a combination.
    pub fn is_for_operands(&self) -> bool {
        self.query == BlockQuery::Operand
    }

    /// Prepares the rays of four rows in four slots.
    #[inline(always)]
    pub fn prepare<S: Simd>(
        &self,
        mesh: &MeshFrame,
        block: &RayBlock,
        rows: [usize; AT_A_TIME],
        rays: &mut [KernelRay],
        slots: [usize; AT_A_TIME],
    ) -> [Prepared; AT_A_TIME] {
        let lines = scaled::<S>(mesh, block, rows);
        let in_box = self.in_box(&lines);
        let reach = self.reach::<S>(mesh, &lines.o);
        let window = self.window(mesh, block, rows, &lines, &in_box, reach);
        let is_plain = lines.is_extreme | in_box.is_extreme | window.is_unbounded;
        let (entry, exit) = (in_box.enter.greater(window.from), in_box.exit.lesser(window.to));
        let is_met = entry.is_at_most(exit);
        if (is_met | is_plain) & 0xf == 0 {
            return [Prepared::Misses; AT_A_TIME];
        }
        self.write_boxes(&lines, &in_box, [entry, exit], rays, slots);
        self.write_triangles(&lines, &in_box, &window, reach, rays, slots);
        let prepared = |lane: usize| {
            rays[slots[lane]].row = rows[lane] as u32;
            if is_plain >> lane & 1 == 1 {
                Prepared::Plain
            } else if is_met >> lane & 1 == 0 {
                Prepared::Misses
            } else if window.may_be_inside >> lane & 1 == 1 {
                Prepared::ReadyInside
            } else {
                Prepared::Ready
            }
        };
        [0, 1, 2, 3].map(prepared)
    }

    /// Where lines are within the mesh's box.
    #[inline(always)]
    fn in_box<S: Simd>(&self, lines: &Scaled<S>) -> InBox<S> {
        let splat = <S::F64 as Real>::splat;
        let Scaled { o, d, .. } = lines;
        let size = [d[0].abs(), d[1].abs(), d[2].abs()];
        let roles = Roles::<S>::of(&size);
        let longest = roles.pick(size[0], size[1], size[2]);
        let centre = self.frame.centre;
        let from_centre = [o[0] - splat(centre.x), o[1] - splat(centre.y), o[2] - splat(centre.z)];
        let far = from_centre[0].abs().greater(from_centre[1].abs()).greater(from_centre[2].abs());
        // Components that are almost zero count as small ones: then no product is NaN.
        let least = longest * splat(STEEPEST);
        let inverse = |i: usize| {
            let inverse = splat(1.0) / size[i].greater(least);
            (-inverse).where_negative(d[i], inverse)
        };
        let inverse = [inverse(0), inverse(1), inverse(2)];
        let plane = |at: f64, i: usize| (splat(at) - from_centre[i]) * inverse[i];
        let (low, high) = (self.low, self.high);
        let a = [plane(low.x, 0), plane(low.y, 1), plane(low.z, 2)];
        let b = [plane(high.x, 0), plane(high.y, 1), plane(high.z, 2)];
        InBox {
            roles,
            longest,
            from_centre,
            inverse,
            enter: a[0].lesser(b[0]).greater(a[1].lesser(b[1])).greater(a[2].lesser(b[2])),
            exit: a[0].greater(b[0]).lesser(a[1].greater(b[1])).lesser(a[2].greater(b[2])),
            is_extreme: !far.is_at_most(splat(FARTHEST * self.frame.size)) | !splat(0.25).is_at_most(longest),
        }
    }

    /// The interval of `t` in which hits count: the span and, for a solid, the hits beyond its ends that may belong to
    /// events in it.
    #[inline(always)]
    fn window<S: Simd>(
        &self,
        mesh: &MeshFrame,
        block: &RayBlock,
        rows: [usize; AT_A_TIME],
        lines: &Scaled<S>,
        in_box: &InBox<S>,
        reach: S::F64,
    ) -> Window<S> {
        let splat = <S::F64 as Real>::splat;
        let &Scaled { from, to, .. } = lines;
        let is_any = self.query == BlockQuery::AnyOffEdges;
        let is_first = self.query == BlockQuery::First || is_any;
        if !is_first && !matches!(self.query, BlockQuery::Within | BlockQuery::Operand) {
            let (margin, near) = (splat(SMALLEST), splat(0.0));
            return Window { from, to, margin, near, may_be_inside: 0, is_unbounded: 0 };
        }
        let exit = in_box.exit;
        let latest = exit.greater(from.abs());
        let (of_from, of_to, of_latest, near, grows_slowly) = match block.lines.errors {
            Some(errors) => {
                let size = mesh.scaled_bounds.size();
                let size = in_box.roles.pick(splat(size.x), splat(size.y), splat(size.z));
                let errors = Errors::<S>::load(errors, rows, [lines.of_o, lines.of_d]);
                let widths = Widths::of([&lines.o, &lines.d], errors, [in_box.longest, size], reach);
                let (of_from, of_to, of_latest) = (widths.at(from), widths.at(to), widths.at(latest));
                (of_from, of_to, of_latest, widths.near(), widths.grow_slowly)
            }
            None => {
                let (from, to) = (width::<S>(from, reach), width::<S>(to, reach));
                (from, to, width::<S>(latest, reach), splat(0.0), !0)
            }
        };
        // The width grows with `t`, and no hit is beyond the box. The ends of the intervals that are compared are
        // rounded too, by half an ulp each.
        let rounding = splat(4.0 * HALF_ULP) * latest;
        let is_limited = is_first && (block.ends.is_some() || block.span.t_max() < f64::INFINITY);
        let margin = splat(SMALLEST) + of_latest + rounding;
        // No event with a hit of the mesh is wider than the margin.
        let [of_from, of_to] = if is_any { [margin; 2] } else { [of_from, of_to] };
        let widest = if is_any { CLEARANCE / 2.0 } else { f64::INFINITY };
        let from = from - of_from;
        Window {
            from,
            // For `Within` all hits ahead: their sum is the winding number at the start.
            to: if is_limited { to + of_to } else { splat(f64::INFINITY) },
            margin,
            near,
            may_be_inside: if is_first { in_box.enter.is_at_most(from) } else { 0 },
            is_unbounded: !grows_slowly
                | !margin.is_less(splat(widest))
                | !near.is_less(splat(NEAREST * self.frame.size)),
        }
    }

    /// Writes what the tests of boxes need, and the interval of `t` within the mesh's box.
    #[inline(always)]
    fn write_boxes<S: Simd>(
        &self,
        lines: &Scaled<S>,
        in_box: &InBox<S>,
        [entry, exit]: [S::F64; 2],
        rays: &mut [KernelRay],
        slots: [usize; AT_A_TIME],
    ) {
        let (d, InBox { from_centre, inverse, longest, .. }) = (&lines.d, in_box);
        let per_size = <S::F64 as Real>::splat(1.0 / self.frame.size);
        let start = |i: usize| ((from_centre[i] + d[i] * entry) * per_size).store();
        let start = [start(0), start(1), start(2)];
        let reciprocal = |i: usize| (inverse[i] * *longest).store();
        let reciprocal = [reciprocal(0), reciprocal(1), reciprocal(2)];
        let per_t = *longest * per_size;
        let depth = ((exit - entry) * per_t).store();
        let (entry, per_t) = (entry.store(), per_t.store());
        for lane in 0..AT_A_TIME {
            let ray = &mut rays[slots[lane]];
            for axis in 0..3 {
                let r = reciprocal[axis][lane] as f32;
                ray.reciprocal[axis] = r;
                ray.offset[axis] = start[axis][lane] as f32 * r;
                ray.near[axis] = u32::from(r < 0.0);
            }
            ray.limit = beyond(depth[lane]);
            (ray.entry, ray.per_t) = (entry[lane], per_t[lane]);
        }
    }

    /// Writes what the tests of triangles need. There is no hit yet.
    #[inline(always)]
    fn write_triangles<S: Simd>(
        &self,
        lines: &Scaled<S>,
        in_box: &InBox<S>,
        window: &Window<S>,
        reach: S::F64,
        rays: &mut [KernelRay],
        slots: [usize; AT_A_TIME],
    ) {
        let roles = &in_box.roles;
        let (o, d) = (roles.sorted(&lines.o), roles.sorted(&lines.d));
        let origin = [o[0].store(), o[1].store(), o[2].store()];
        let slope = [(d[0] / d[2]).store(), (d[1] / d[2]).store()];
        let inverse = (<S::F64 as Real>::splat(1.0) / d[2]).store();
        let (z_is_shorter, y_is_shorter) = (roles.z_is_shorter.store(), roles.y_is_shorter.store());
        let [doubt, depth_doubt] = self.doubts::<S>(reach, window.near);
        let (doubt, depth_doubt) = (doubt.store(), depth_doubt.store());
        let (from, to, margin) = (window.from.store(), window.to.store(), window.margin.store());
        for lane in 0..AT_A_TIME {
            let ray = &mut rays[slots[lane]];
            let is_z = z_is_shorter[lane] >= 0.0;
            let along = if is_z { 2 } else { u32::from(y_is_shorter[lane] >= 0.0) };
            ray.axes = [(along + 1) % 3, (along + 2) % 3, along];
            ray.origin = [origin[0][lane], origin[1][lane], origin[2][lane]];
            ray.slope = [slope[0][lane], slope[1][lane]];
            ray.inverse = inverse[lane];
            (ray.doubt, ray.depth_doubt) = (doubt[lane], depth_doubt[lane]);
            (ray.from, ray.to, ray.margin) = (from[lane], to[lane], margin[lane]);
            (ray.leaf, ray.lane, ray.may_coincide) = (MISS, 0, false);
            ray.best = [f64::INFINITY; 2];
        }
    }

    /// As `sheared_ray::reach`.
    #[inline(always)]
    fn reach<S: Simd>(&self, mesh: &MeshFrame, o: &Vectors<S>) -> S::F64 {
        let splat = <S::F64 as Real>::splat;
        let (min, max) = (mesh.scaled_bounds.min, mesh.scaled_bounds.max);
        let along = |i: usize| (splat(min[i]) - o[i]).abs().greater((splat(max[i]) - o[i]).abs());
        along(0).greater(along(1)).greater(along(2)) * splat(1.0 + 4.0 * HALF_ULP)
    }

    /// Bounds on the rounding of edge functions, and of depths.
    #[inline(always)]
    fn doubts<S: Simd>(&self, reach: S::F64, near: S::F64) -> [S::F64; 2] {
        let splat = <S::F64 as Real>::splat;
        // As in `ShearedRay::new`. Only operands need the triangles whose planes are near.
        let e = splat(6.5 * HALF_ULP) * reach;
        let width = splat(self.width) + splat(64.0 * HALF_ULP) * reach + splat(2.0) * near;
        let square = (width + e) * (width + e);
        let rounding = splat(4.0) * width * e + splat(2.0) * e * e + splat(8.0 * HALF_ULP) * square;
        let doubt = splat(1.01) * (rounding + splat(2.0) * width * near) + splat(f64::MIN_POSITIVE);
        // The sums have three terms. Each edge function is off by `doubt` and at most `2 (width + e)^2`, each depth is
        // off by half an ulp and at most `reach`; products and sums round by another nine half-ulps.
        let sums = splat(3.0) * doubt + splat(40.0 * HALF_ULP) * square;
        [doubt, splat(2.02) * reach * sums + splat(f64::MIN_POSITIVE)]
    }
}

/// The lanes with a component other than zero that is so small after scaling that it, its products or its reciprocal may
/// underflow or overflow. Box tests before scaling still see such a component.
#[inline(always)]
fn may_vanish<S: Simd>(scaled: &Vectors<S>, unscaled: &Vectors<S>) -> u8 {
    let splat = <S::F64 as Real>::splat;
    let is_small =
        |axis: usize| scaled[axis].abs().is_less(splat(1e-100)) & splat(0.0).is_less(unscaled[axis].abs());
    is_small(0) | is_small(1) | is_small(2)
}

#[inline(always)]
fn scaled<S: Simd>(mesh: &MeshFrame, block: &RayBlock, rows: [usize; AT_A_TIME]) -> Scaled<S> {
    let lines = &block.lines.rows;
    let four = [&lines[rows[0]], &lines[rows[1]], &lines[rows[2]], &lines[rows[3]]];
    let load = |k: usize| S::F64::load(&[four[0][k], four[1][k], four[2][k], four[3][k]]);
    let (o, d) = ([load(0), load(1), load(2)], [load(3), load(4), load(5)]);
    let longest = d[0].abs().greater(d[1].abs()).greater(d[2].abs()).store();
    let of_size = mesh.size.exponent();
    let (mut scales, mut of_t, mut is_far) = ([0.0; AT_A_TIME], [0.0; AT_A_TIME], 0);
    for lane in 0..AT_A_TIME {
        let exponent = exponent_within_range(longest[lane]);
        scales[lane] = power_of_two(-exponent);
        // The original `t` is that after scaling times two to this power.
        let exponent_of_t = of_size - exponent;
        of_t[lane] = power_of_two((-exponent_of_t).clamp(-1000, 1000));
        is_far |= u8::from(exponent_of_t.abs() > MAX_EXPONENT) << lane;
    }
    let (of_o, of_d) = (<S::F64 as Real>::splat(power_of_two(-of_size)), S::F64::load(&scales));
    let of_t = S::F64::load(&of_t);
    let t_min = <S::F64 as Real>::splat(block.span.t_min());
    let ends = [block.end(rows[0]), block.end(rows[1]), block.end(rows[2]), block.end(rows[3])];
    let t_max = S::F64::load(&ends);
    let (from, to) = (t_min * of_t, t_max * of_t);
    let (unscaled_from, unscaled_to) = (from / of_t, to / of_t);
    let is_exact = unscaled_from.is_at_most(t_min)
        & t_min.is_at_most(unscaled_from)
        & unscaled_to.is_at_most(t_max)
        & t_max.is_at_most(unscaled_to);
    let (unscaled_o, unscaled_d) = (o, d);
    let o = [o[0] * of_o, o[1] * of_o, o[2] * of_o];
    let d = [d[0] * of_d, d[1] * of_d, d[2] * of_d];
    let vanishes = may_vanish::<S>(&o, &unscaled_o) | may_vanish::<S>(&d, &unscaled_d);
    Scaled { o, d, from, to, of_o, of_d, is_extreme: is_far | !is_exact | vanishes }
}
