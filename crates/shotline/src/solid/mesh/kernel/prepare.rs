//! Prepares rays, as many at a time as a register has lanes.

use super::frame::MeshFrame;
use super::lines::{BlockQuery, RayBlock};
use super::ray::{CLEARANCE, KernelRay, MISS, Prepared, SMALLEST, beyond_all};
use super::widths::{Errors, Vectors, Widths, load_halves, width};
use crate::accel::wide::{Frame, PAD};
use crate::math::{HALF_ULP, Vec3, power_of_two};
use crate::simd::{Doubles, Simd, Task};

/// Rays whose origin is farther from the centre of the mesh than this many sizes take the plain path: the error of the
/// entry into the mesh's box would exceed the padding of the boxes.
const FARTHEST: f64 = (1 << 23) as f64;

/// Components of a direction below this fraction of the longest count as this fraction for boxes: the ray then moves
/// by less than the padding within the mesh.
const STEEPEST: f64 = 1e-18;

/// Rays whose `t` is scaled by more than this take the plain path: it may overflow or underflow.
const LARGEST_SCALE: f64 = f64::from_bits((1023 + 900) << 52);

/// Rays whose direction is longer than this, or shorter than its reciprocal, take the plain path, which scales them by
/// other powers.
const HUGE: f64 = f64::from_bits((1023 + 999) << 52);

/// Lines that may run in planes farther away than this many sizes take the plain path. Less than the padding of the
/// boxes leaves, so that the triangles in these planes are visited.
const NEAREST: f64 = 1.0 / (1 << 30) as f64;

/// The number of rays that are prepared by one call.
pub(super) const AT_A_TIME: usize = 8;

/// The axes for triangles, by the axis in which the direction is largest: x, y or z, which has two entries.
const AXES: [[u32; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

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

/// Rays that are prepared together, one for each lane.
struct LaneRays<'a> {
    rows: &'a [usize],
    slots: &'a [usize],
    rays: &'a mut [KernelRay],
}

/// Rays to be prepared: see [`Kernel::prepare`](super::context::Kernel::prepare).
pub(super) struct Prepare<'a> {
    pub preparation: &'a Preparation,
    pub mesh: &'a MeshFrame,
    pub block: &'a RayBlock<'a>,
    pub rows: [usize; AT_A_TIME],
    pub slots: [usize; AT_A_TIME],
    pub rays: &'a mut [KernelRay],
}

impl Task for Prepare<'_> {
    type Output = Prepared;

    #[inline(always)]
    fn run<S: Simd>(self) -> Prepared {
        let mut prepared = Prepared::default();
        for first in (0..AT_A_TIME).step_by(S::Wide::LANES) {
            let lanes = first..first + S::Wide::LANES;
            let (rows, slots) = (&self.rows[lanes.clone()], &self.slots[lanes.clone()]);
            let mut together = LaneRays { rows, slots, rays: self.rays };
            let some = self.preparation.prepare_lanes::<S::Wide>(self.mesh, self.block, &mut together);
            prepared = prepared.with(some, first);
        }
        prepared
    }
}

/// Lines after scaling.
struct Scaled<F: Doubles> {
    o: Vectors<F>,
    d: Vectors<F>,
    /// `t_min` and `t_max`.
    from: F,
    to: F,
    /// The factors of origins and of directions.
    of_o: F,
    of_d: F,
    /// The lines whose `t` has an extreme scale, whose span does not scale without rounding, or that have components
    /// that may vanish.
    is_extreme: u8,
}

/// The axes of lines: where `z_is_shorter` is negative the direction is not largest along z, and where
/// `y_is_shorter` is too, it is largest along x.
#[derive(Clone, Copy)]
struct Roles<F: Doubles> {
    z_is_shorter: F,
    y_is_shorter: F,
}

impl<F: Doubles> Roles<F> {
    #[inline(always)]
    fn of(size: &Vectors<F>) -> Roles<F> {
        Roles { z_is_shorter: size[2] - size[0].greater(size[1]), y_is_shorter: size[1] - size[0] }
    }

    /// One of three values for lines along x, y and z.
    #[inline(always)]
    fn pick(&self, x: F, y: F, z: F) -> F {
        x.where_negative(self.y_is_shorter, y).where_negative(self.z_is_shorter, z)
    }

    /// The components across, in cyclic order, and along.
    #[inline(always)]
    fn sorted(&self, v: &Vectors<F>) -> Vectors<F> {
        [self.pick(v[1], v[2], v[0]), self.pick(v[2], v[0], v[1]), self.pick(v[0], v[1], v[2])]
    }
}

/// Lines in the box of the mesh.
struct InBox<F: Doubles> {
    roles: Roles<F>,
    /// The largest component of each direction.
    longest: F,
    /// The origins, relative to the centre of the mesh.
    from_centre: Vectors<F>,
    /// The reciprocals of the directions.
    inverse: Vectors<F>,
    enter: F,
    exit: F,
    is_extreme: u8,
}

/// The intervals of `t` in which hits of some lines count.
struct Window<F: Doubles> {
    from: F,
    to: F,
    /// Hits whose `t` differ by more are separate events.
    margin: F,
    /// How near the planes of triangles are in which a line may run.
    near: F,
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

    /// Prepares the rays of some rows in some slots, one for each lane.
    #[inline(always)]
    fn prepare_lanes<F: Doubles>(
        &self,
        mesh: &MeshFrame,
        block: &RayBlock,
        together: &mut LaneRays,
    ) -> Prepared {
        let rows = together.rows;
        let lines = scaled::<F>(mesh, block, rows);
        let in_box = self.in_box(&lines);
        let reach = self.reach::<F>(mesh, &lines.o);
        let window = self.window(mesh, block, rows, &lines, &in_box, reach);
        let is_plain = lines.is_extreme | in_box.is_extreme | window.is_unbounded;
        let (entry, exit) = (in_box.enter.greater(window.from), in_box.exit.lesser(window.to));
        let is_met = entry.is_at_most(exit);
        let plain = is_plain & F::ALL;
        let ready = is_met & !plain & F::ALL;
        if ready == 0 {
            return Prepared { plain, ..Prepared::default() };
        }
        self.write_boxes(&lines, &in_box, [entry, exit], together);
        self.write_triangles(&lines, &in_box, &window, reach, entry, together);
        Prepared { ready, inside: ready & window.may_be_inside, plain }
    }

    /// Where lines are within the mesh's box.
    #[inline(always)]
    fn in_box<F: Doubles>(&self, lines: &Scaled<F>) -> InBox<F> {
        let splat = F::splat;
        let Scaled { o, d, .. } = lines;
        let size = [d[0].abs(), d[1].abs(), d[2].abs()];
        let roles = Roles::<F>::of(&size);
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
    fn window<F: Doubles>(
        &self,
        mesh: &MeshFrame,
        block: &RayBlock,
        rows: &[usize],
        lines: &Scaled<F>,
        in_box: &InBox<F>,
        reach: F,
    ) -> Window<F> {
        let splat = F::splat;
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
                let errors = Errors::<F>::load(errors, rows, [lines.of_o, lines.of_d]);
                let widths = Widths::of([&lines.o, &lines.d], errors, [in_box.longest, size], reach);
                let (of_from, of_to, of_latest) = (widths.at(from), widths.at(to), widths.at(latest));
                (of_from, of_to, of_latest, widths.near(), widths.grow_slowly)
            }
            None => {
                let (from, to) = (width::<F>(from, reach), width::<F>(to, reach));
                (from, to, width::<F>(latest, reach), splat(0.0), !0)
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

    /// Writes what the tests of boxes need, with the depth of the interval of `t` within the mesh's box as limit.
    #[inline(always)]
    fn write_boxes<F: Doubles>(
        &self,
        lines: &Scaled<F>,
        in_box: &InBox<F>,
        [entry, exit]: [F; 2],
        together: &mut LaneRays,
    ) {
        let (d, InBox { from_centre, inverse, longest, .. }) = (&lines.d, in_box);
        let per_size = F::splat(1.0 / self.frame.size);
        // The product of two float32 numbers is exact in float64, so it is rounded to float32 only once.
        let reciprocal = |i: usize| (inverse[i] * *longest).to_single();
        let reciprocal = [reciprocal(0), reciprocal(1), reciprocal(2)];
        let offset = |i: usize| ((from_centre[i] + d[i] * entry) * per_size).to_single() * reciprocal[i];
        let limit = beyond_all((exit - entry) * (*longest * per_size));
        let [x, y, z] = reciprocal;
        let columns = [x, y, z, offset(0), offset(1), offset(2), limit, F::splat(0.0)];
        F::store_singles(columns, |lane, row| together.rays[together.slots[lane]].boxes = row);
    }

    /// Writes what the tests of triangles need. There is no hit yet.
    #[inline(always)]
    fn write_triangles<F: Doubles>(
        &self,
        lines: &Scaled<F>,
        in_box: &InBox<F>,
        window: &Window<F>,
        reach: F,
        entry: F,
        together: &mut LaneRays,
    ) {
        let roles = &in_box.roles;
        let (o, d) = (roles.sorted(&lines.o), roles.sorted(&lines.d));
        let [x, y, z] = in_box.inverse;
        // No component is raised along the axis in which the direction is largest.
        let inverse = roles.pick(x, y, z);
        let [doubt, depth_doubt] = self.doubts(reach, window.near);
        // The slopes are off by two half-ulps instead of one, but their products with depths are not rounded: so the
        // bound of `ShearedRay::new` holds.
        let columns = [o[0], o[1], o[2], d[0] * inverse, d[1] * inverse, inverse, doubt, depth_doubt];
        F::store_rows(columns, |lane, row| together.rays[together.slots[lane]].triangles = row);
        let per_t = in_box.longest * F::splat(1.0 / self.frame.size);
        let best = F::splat(f64::INFINITY);
        let columns = [entry, per_t, window.from, window.to, window.margin, best, best, best];
        F::store_rows(columns, |lane, row| together.rays[together.slots[lane]].ts = row);
        let zero = F::splat(0.0);
        let (z_is_longest, y_is_longer) =
            (zero.is_at_most(roles.z_is_shorter), zero.is_at_most(roles.y_is_shorter));
        for (lane, (&slot, &row)) in together.slots.iter().zip(together.rows).enumerate() {
            let is_in = |mask: u8| usize::from(mask >> lane & 1);
            let ray = &mut together.rays[slot];
            ray.axes = AXES[2 * is_in(z_is_longest) + is_in(y_is_longer)];
            (ray.row, ray.leaf, ray.lane, ray.may_coincide) = (row as u32, MISS, 0, false);
        }
    }

    /// As `sheared_ray::reach`.
    #[inline(always)]
    fn reach<F: Doubles>(&self, mesh: &MeshFrame, o: &Vectors<F>) -> F {
        let splat = F::splat;
        let (min, max) = (mesh.scaled_bounds.min, mesh.scaled_bounds.max);
        let along = |i: usize| (splat(min[i]) - o[i]).abs().greater((splat(max[i]) - o[i]).abs());
        along(0).greater(along(1)).greater(along(2)) * splat(1.0 + 4.0 * HALF_ULP)
    }

    /// Bounds on the rounding of edge functions, and of depths.
    #[inline(always)]
    fn doubts<F: Doubles>(&self, reach: F, near: F) -> [F; 2] {
        let splat = F::splat;
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
fn may_vanish<F: Doubles>(scaled: &Vectors<F>, unscaled: &Vectors<F>) -> u8 {
    let splat = F::splat;
    let is_small =
        |axis: usize| scaled[axis].abs().is_less(splat(1e-100)) & splat(0.0).is_less(unscaled[axis].abs());
    is_small(0) | is_small(1) | is_small(2)
}

#[inline(always)]
fn scaled<F: Doubles>(mesh: &MeshFrame, block: &RayBlock, rows: &[usize]) -> Scaled<F> {
    let [o, d] = load_halves::<F>(block.lines.rows, rows);
    let longest = d[0].abs().greater(d[1].abs()).greater(d[2].abs());
    // The scale of `t` after scaling, and its reciprocal.
    let size = power_of_two(mesh.size.exponent());
    let (of_o, of_d) = (F::splat(1.0 / size), longest.power_below_one());
    // The factors are powers of two: so this is the reciprocal of `of_d`, without a division.
    let inverse_of_d = of_d.power_below_one() * F::splat(2.0);
    let (per_t, of_t) = (F::splat(size) * of_d, inverse_of_d * of_o);
    let is_usual = of_t.is_at_most(F::splat(LARGEST_SCALE))
        & per_t.is_at_most(F::splat(LARGEST_SCALE))
        & F::splat(1.0 / HUGE).is_at_most(longest)
        & longest.is_at_most(F::splat(HUGE));
    let t_min = F::splat(block.span.t_min());
    let t_max = match block.ends {
        Some(ends) => F::from_fn(|lane| ends[rows[lane]]),
        None => F::splat(block.span.t_max()),
    };
    let (from, to) = (t_min * of_t, t_max * of_t);
    let (unscaled_from, unscaled_to) = (from * per_t, to * per_t);
    let is_exact = unscaled_from.is_at_most(t_min)
        & t_min.is_at_most(unscaled_from)
        & unscaled_to.is_at_most(t_max)
        & t_max.is_at_most(unscaled_to);
    let (unscaled_o, unscaled_d) = (o, d);
    let o = [o[0] * of_o, o[1] * of_o, o[2] * of_o];
    let d = [d[0] * of_d, d[1] * of_d, d[2] * of_d];
    let vanishes = may_vanish::<F>(&o, &unscaled_o) | may_vanish::<F>(&d, &unscaled_d);
    Scaled { o, d, from, to, of_o, of_d, is_extreme: !is_usual | !is_exact | vanishes }
}
