//! A torus along lines, in float64: the quick path to its crossings, where they are certain.
//!
//! It is written once, for one line or for one in each lane, so all of them have the same bits.
//!
//! 1. The line gets an origin near its closest approach, without rounding error. Lines that miss the sphere or the slab
//!    around the torus are done.
//! 2. On the line the torus is a quartic without a cubic term. Ferrari's method (in Cardano, Ars magna, 1545) splits it
//!    into two quadratics: the resolvent cubic gives the sum of the two lowest roots. So each quadratic holds the ends of
//!    one interval (`ferrari`).
//! 3. A Newton step on the torus function, in double-double where that can be seen, corrects each root and bounds its error.
//! 4. The number of roots is certain: a quartic has four at most, and where fewer are found, what the product of the
//!    quadratics differs from the quartic cannot make up for the minimum of the quadratic that has no root.
//!
//! A line for which any bound fails is left open: the certified search takes it.

mod ferrari;
pub(super) mod implicit;

use crate::crossing::{Crossing, GROUPING};
use crate::lanes::vector::{Vectors, abs, dot, largest, scale};
use crate::lanes::{EndLanes, InsideLanes, IntervalLanes, LineLanes};
use crate::math::{
    Dd, HALF_ULP, UNIT_RANGE, binary_exponent, power_of_two, quick_two_sum, two_prod, two_sum,
};
use crate::ray::Line;
use crate::simd::Doubles;
use ferrari::{Chords, Factors, Half, Rivals};
use implicit::{LinePoint, TorusFunction};

/// The least `r / R`. The quartic of a thinner ring is only noise.
const THINNEST: f64 = 1e-5;

/// The most `r / R`. Inside a tighter hole the curvature has no useful bound.
const FATTEST: f64 = 1.0 - 1e-6;

/// The binary exponents of sizes and of directions for which nothing overflows or underflows.
const SIZES: i32 = 320;
const DIRECTIONS: i32 = 640;

/// The most `|tau|` of an origin at which the new one is accurate.
const FARTHEST: f64 = (1_u64 << 30) as f64;

/// A bound on the error of the torus function in f64 at the surface, in units of `r`. A point of the line is off by an ulp
/// in each component, so the distance from the axis is off by five half ulps, and three roundings follow.
const VALUE_ERROR: f64 = 32.0 * HALF_ULP;

/// A bound on the error of the slope at the surface, in units of the bound on the curvature.
const SLOPE_ERROR: f64 = 64.0 * HALF_ULP;

/// The error of two roundings of a subnormal number. Subnormal numbers are 2^-1074 apart.
pub(super) const UNDERFLOW: f64 = f64::from_bits(4);

/// Whether the quick path takes a torus: a ring of an ordinary size, neither too thin nor touching itself.
pub(super) fn takes(major: f64, minor: f64) -> bool {
    minor <= FATTEST * major && minor >= THINNEST * major && binary_exponent(major + minor).abs() <= SIZES
}

/// Appends the crossings of a line with a torus that [`takes`] allows. Returns whether they are certain; if not, appends
/// nothing.
#[multiversion::multiversion(targets("x86_64+avx+fma"))]
pub(super) fn crossings(major: f64, minor: f64, line: &Line, out: &mut Vec<Crossing>) -> bool {
    let inside = inside::<f64>(&Rings::of(major, minor), &LineLanes::splat(line), 1);
    for interval in &inside.intervals {
        if interval.lanes != 0 {
            let (enter, exit) = (&interval.enter, &interval.exit);
            out.push(Crossing::new(enter.t, enter.t_err, true, 0));
            out.push(Crossing::new(exit.t, exit.t_err, false, 0));
        }
    }
    inside.open == 0
}

/// The tori of lanes, in units of about their sizes.
pub(super) struct Rings<F> {
    major: F,
    minor: F,
    /// The units: powers of two.
    size: F,
}

impl<F: Doubles> Rings<F> {
    /// The same torus in every lane.
    #[inline(always)]
    pub fn of(major: f64, minor: f64) -> Rings<F> {
        let size = size(major, minor);
        Rings { major: F::splat(major / size), minor: F::splat(minor / size), size: F::splat(size) }
    }

    /// The torus of each lane, by its two radii.
    #[inline(always)]
    pub fn each(radii: impl Fn(usize) -> [f64; 2]) -> Rings<F> {
        let [mut majors, mut minors, mut sizes] = [[0.0; 8]; 3];
        let numbers = majors.iter_mut().zip(&mut minors).zip(&mut sizes);
        for (lane, ((to_major, to_minor), to_size)) in numbers.take(F::LANES).enumerate() {
            let [major, minor] = radii(lane);
            let size = size(major, minor);
            (*to_major, *to_minor, *to_size) = (major / size, minor / size, size);
        }
        Rings {
            major: F::load_some(&majors, 0),
            minor: F::load_some(&minors, 0),
            size: F::load_some(&sizes, 0),
        }
    }
}

fn size(major: f64, minor: f64) -> f64 {
    power_of_two(binary_exponent(major + minor))
}

/// Where the lines of some lanes are inside tori that [`takes`] allows.
#[inline(always)]
pub(super) fn inside<F: Doubles>(rings: &Rings<F>, line: &LineLanes<F>, lanes: u8) -> InsideLanes<F> {
    let Rings { major, minor, size } = *rings;
    let at = Approaches::new(line, size);
    let met = lanes & !at.certain_misses(major, minor);
    let none = IntervalLanes::none();
    if met == 0 {
        return InsideLanes { intervals: [none; 2], open: 0 };
    }
    let factors = Factors::new(&at.chords, major, minor, met & at.ordinary);
    let function = TorusFunction::new(at.p, at.u, major, minor);
    let (has_first, has_second) = (met & factors.halves[0].has_roots(), met & factors.halves[1].has_roots());
    let is_missed = met & at.ordinary & factors.certain_misses();
    let crossed = met & at.ordinary & !is_missed & (has_first | has_second);
    let mut open = met & !is_missed & !crossed;
    if crossed == 0 {
        return InsideLanes { intervals: [none; 2], open };
    }
    let both = crossed & has_first & has_second;
    let rivals = factors.rivals(has_first, both);
    let first = factors.halves[0].where_set(has_first, &factors.halves[1]);
    let (first, first_is_good) = interval(&at, &function, &first, &rivals, crossed);
    open |= crossed & !first_is_good;
    if both & !open == 0 {
        return InsideLanes { intervals: [IntervalLanes { lanes: crossed & !open, ..first }, none], open };
    }
    let (second, second_is_good) = interval(&at, &function, &factors.halves[1], &rivals, both);
    open |= both & !(second_is_good & are_apart(&first.exit, &second.enter));
    let [first, second] =
        [IntervalLanes { lanes: crossed & !open, ..first }, IntervalLanes { lanes: both & !open, ..second }];
    InsideLanes { intervals: [first, second], open }
}

/// The vectors from the nearest points of the circle inside the tube, scaled. On the axis they are along it.
#[inline(always)]
pub(super) fn normals<F: Doubles>(major: F, p: Vectors<F>) -> Vectors<F> {
    let (zero, one) = (F::splat(0.0), F::splat(1.0));
    let [x, y, z] = p;
    let rho = distance_from_axis(p);
    let stretch = (rho - major) / rho;
    let off_axis = zero.is_less(rho);
    [
        (x * stretch).where_set(off_axis, zero),
        (y * stretch).where_set(off_axis, zero),
        z.where_set(off_axis, (-one).where_negative(z, one)),
    ]
}

/// The distances of points from the z axis.
#[inline(always)]
fn distance_from_axis<F: Doubles>([x, y, _]: Vectors<F>) -> F {
    let size = x.abs().greater(y.abs());
    let ordinary = F::splat(UNIT_RANGE[0]).is_at_most(size) & size.is_less(F::splat(UNIT_RANGE[1]));
    let rho = (x * x + y * y).sqrt();
    if ordinary == F::ALL {
        return rho;
    }
    let (x, y) = (x.store(), y.store());
    rho.where_set(ordinary, F::from_fn(|lane| libm::hypot(x[lane], y[lane])))
}

/// The lanes in which two ends are certainly two events: twice as far apart as the bounds reach.
#[inline(always)]
fn are_apart<F: Doubles>(a: &EndLanes<F>, b: &EndLanes<F>) -> u8 {
    (F::splat(2.0 * GROUPING) * (a.t_err + b.t_err)).is_less(b.t - a.t)
}

/// The interval between the roots of a quadratic, and the lanes of which it is certain.
#[inline(always)]
fn interval<F: Doubles>(
    at: &Approaches<F>,
    function: &TorusFunction<F>,
    half: &Half<F>,
    rivals: &Rivals<F>,
    lanes: u8,
) -> (IntervalLanes<F>, u8) {
    let way = half.rest.sqrt();
    let rivals = Rivals { error: rivals.error, least: rivals.least * way };
    let (enter, enter_is_good) = at.root(function, half.middle - way, &rivals, lanes, true);
    let (exit, exit_is_good) = at.root(function, half.middle + way, &rivals, lanes, false);
    let good = enter_is_good & exit_is_good & are_apart(&enter, &exit);
    (IntervalLanes { enter, exit, lanes }, good)
}

/// The lines `p + tau u` in units of the torus, with `p` near the point closest to the centre.
struct Approaches<F> {
    p: [Dd<F>; 3],
    u: Vectors<F>,
    uu: F,
    /// `1 / |u|`.
    per_length: F,
    /// Minus the `tau` of the line's own origin.
    shift: F,
    /// The `tau` of the closest approach.
    closest: F,
    chords: Chords<F>,
    /// The factors from `tau` to `t`.
    t_unit: [F; 2],
    /// Bounds on the errors of the origin, and of a step of 1 in `tau`.
    o_err: Vectors<F>,
    per_tau: Vectors<F>,
    /// The lanes whose numbers are of an ordinary size.
    ordinary: u8,
}

impl<F: Doubles> Approaches<F> {
    #[inline(always)]
    fn new(line: &LineLanes<F>, size: F) -> Approaches<F> {
        let length = largest(abs(line.d));
        let shorten = length.power_below_one();
        let u = scale(line.d, shorten);
        let uu = dot(u, u);
        let unit = F::splat(1.0) / size;
        let o = scale(line.o, unit);
        let shift = -dot(o, u) / uu;
        let p = [moved(o[0], shift, u[0]), moved(o[1], shift, u[1]), moved(o[2], shift, u[2])];
        let near = [p[0].hi, p[1].hi, p[2].hi];
        let closest = -dot(near, u) / uu;
        let c =
            [u[0].mul_add(closest, near[0]), u[1].mul_add(closest, near[1]), u[2].mul_add(closest, near[2])];
        let per_length = F::splat(1.0) / uu.sqrt();
        let ordinary = F::splat(power_of_two(-DIRECTIONS)).is_at_most(length)
            & length.is_at_most(F::splat(power_of_two(DIRECTIONS)))
            & shift.abs().is_at_most(F::splat(FARTHEST));
        Approaches {
            p,
            u,
            uu,
            per_length,
            shift,
            closest,
            chords: Chords { distance2: dot(c, c), height: c[2], rise: u[2] * per_length },
            t_unit: [shorten, size],
            o_err: scale(line.o_err, unit),
            per_tau: scale(line.d_err, shorten),
            ordinary,
        }
    }

    /// The lanes whose lines miss the sphere or the slab around the torus.
    #[inline(always)]
    fn certain_misses(&self, major: F, minor: F) -> u8 {
        const MARGIN: f64 = 1e-9;
        let reach = (major + minor) * F::splat(1.0 + MARGIN);
        let chord2 = reach * reach - self.chords.distance2;
        let zero = F::splat(0.0);
        let height = minor * F::splat(1.0 + MARGIN) + F::splat(1e-12);
        let way = self.chords.rise.abs() * chord2.greater(zero).sqrt();
        self.ordinary & (chord2.is_less(zero) | (height + way).is_less(self.chords.height.abs()))
    }

    /// Converts a length in `tau` to one in `t`.
    #[inline(always)]
    fn t(&self, tau: F) -> F {
        tau * self.t_unit[0] * self.t_unit[1]
    }

    /// The crossing near a point at a distance from the closest approach, and the lanes in which it is certain: the only
    /// one as near as any rival.
    #[inline(always)]
    fn root(
        &self,
        function: &TorusFunction<F>,
        way: F,
        rivals: &Rivals<F>,
        lanes: u8,
        entering: bool,
    ) -> (EndLanes<F>, u8) {
        let (zero, two) = (F::splat(0.0), F::splat(2.0));
        let tau = way.mul_add(self.per_length, self.closest);
        let at = function.at(tau);
        let slope = function.slope(&at);
        let per_slope = F::splat(1.0) / slope;
        let by = self.point_error(self.shift + tau);
        let perturbation = function.perturbation_bound_off_axis(&at, by);
        let (value, error) = self.value(function, &at, perturbation, lanes);
        let step = -(value * per_slope);
        let moved = step.abs();
        let curvature_bound = function.curvature_bound(&at) * self.uu;
        let slope_error = curvature_bound * (moved + F::splat(SLOPE_ERROR));
        let least_slope = slope.abs() - slope_error;
        let next = two_sum(tau, step);
        let from_origin = two_sum(self.shift, next.hi);
        let from_origin = from_origin.hi + (from_origin.lo + next.lo);
        let t = self.t(from_origin);
        let of_step = slope_error * moved;
        let visible = F::splat(1e-3 * HALF_ULP) * from_origin.abs();
        let converged = of_step.is_at_most((visible * least_slope).greater(error));
        // The bounds at the point before the step, and what the step changes.
        let doubt = of_step + error + perturbation + curvature_bound * moved * (by[0] + by[1] + by[2]);
        let linear = doubt * per_slope.abs() * (F::splat(1.0) + two * (slope_error * per_slope.abs()));
        // The relative change of the slope over that distance.
        let turn = curvature_bound * linear * per_slope.abs() * F::splat(1.0 + 1.0 / 8.0);
        let root_error = self.t(linear * (F::splat(1.0) + two * turn));
        let t_err = (root_error + F::splat(HALF_ULP) * t.abs()).greater(F::splat(UNDERFLOW));
        let is_alone = (two * curvature_bound * (rivals.error + moved * rivals.least))
            .is_at_most(least_slope * rivals.least);
        let is_right_way = if entering { slope.is_less(zero) } else { zero.is_less(slope) };
        let is_steep = (F::splat(16.0) * slope_error).is_less(slope.abs());
        let good = converged & is_alone & is_right_way & is_steep & turn.is_at_most(F::splat(0.125));
        (EndLanes { t, t_err, surface: zero }, good)
    }

    /// The torus function, and a bound on its error. In double-double, except in lanes in which the line's own errors hide
    /// those of f64.
    #[inline(always)]
    fn value(&self, function: &TorusFunction<F>, at: &LinePoint<F>, perturbation: F, lanes: u8) -> (F, F) {
        let (value, error) = (function.value(at), F::splat(VALUE_ERROR) * function.minor());
        let narrow = (F::splat(8.0) * error).is_less(perturbation);
        if lanes & !narrow == 0 {
            return (value, error);
        }
        // The second term is that of the new origin, which is far from the old one.
        let wide_error =
            F::splat(power_of_two(-100)).mul_add(self.shift.abs(), error * F::splat(16.0 * HALF_ULP));
        (value.where_set(narrow, function.wide_value_at(at)), error.where_set(narrow, wide_error))
    }

    /// Bounds on the errors of the points at a distance of the line's own origin that are due to its own errors.
    #[inline(always)]
    fn point_error(&self, from_origin: F) -> Vectors<F> {
        let (o, d, far) = (self.o_err, self.per_tau, from_origin.abs());
        [d[0].mul_add(far, o[0]), d[1].mul_add(far, o[1]), d[2].mul_add(far, o[2])]
    }
}

/// `o + shift u`.
#[inline(always)]
fn moved<F: Doubles>(o: F, shift: F, u: F) -> Dd<F> {
    let way = two_prod(shift, u);
    let sum = two_sum(o, way.hi);
    quick_two_sum(sum.hi, sum.lo + way.lo)
}
