//! A quadric along lines in lanes: the intervals inside, where float64 decides them.

use crate::crossing::GROUPING;
use crate::lanes::vector::{Vectors, abs, add, dot, gather, gather_vectors, largest, mul, scale, splat, sub};
use crate::lanes::{EndLanes, InsideLanes, IntervalLanes, LineLanes};
use crate::math::{HALF_ULP, Vec3};
use crate::simd::Doubles;
use crate::solid::form::{Form, rounded};
use crate::solid::quadratic::SEPARATION;
use crate::solid::quadric_line::{FAR_REACHING, FEW, TERM_ERROR, TINY, WELL_CONDITIONED};

/// The rounded coefficients of a form.
pub(super) struct FormLanes<F> {
    centre: Vectors<F>,
    shrink: Vectors<F>,
    /// Whether each axis counts.
    counts: [bool; 3],
    square: Vectors<F>,
    cross: Option<Vectors<F>>,
    linear: Vectors<F>,
    constant: F,
    /// Whether they have squares.
    are_curved: bool,
}

#[expect(clippy::manual_map, reason = "a closure is not compiled for the instructions of its caller")]
impl<F: Doubles> FormLanes<F> {
    /// The same form in every lane.
    #[inline(always)]
    pub fn of(form: &Form) -> FormLanes<F> {
        FormLanes {
            centre: splat(form.centre),
            shrink: splat(form.shrink),
            counts: form.counts(),
            square: splat(rounded(&form.square)),
            cross: match &form.cross {
                Some(cross) => Some(splat(rounded(cross))),
                None => None,
            },
            linear: splat(rounded(&form.linear)),
            constant: F::splat(form.constant.hi),
            are_curved: form.is_curved(),
        }
    }

    /// The form of each lane. Either all of them are curved, or none; either all have cross terms, or none; and the same axes
    /// count for all.
    #[inline(always)]
    pub fn each<'f>(form: impl Fn(usize) -> &'f Form) -> FormLanes<F> {
        FormLanes {
            centre: gather_vectors(|lane| form(lane).centre),
            shrink: gather_vectors(|lane| form(lane).shrink),
            counts: form(0).counts(),
            square: gather_vectors(|lane| rounded(&form(lane).square)),
            cross: match &form(0).cross {
                Some(_) => Some(gather_vectors(|lane| form(lane).cross.as_ref().map_or(Vec3::ZERO, rounded))),
                None => None,
            },
            linear: gather_vectors(|lane| rounded(&form(lane).linear)),
            constant: gather(|lane| form(lane).constant.hi),
            are_curved: form(0).is_curved(),
        }
    }

    /// The gradients at points, as [`Form::gradient`].
    #[inline(always)]
    pub fn gradient(&self, p: Vectors<F>) -> Vectors<F> {
        let x = mul(sub(p, self.centre), self.shrink);
        mul(scale(add(self.apply(x), self.linear), F::splat(2.0)), self.shrink)
    }

    /// As [`Form::apply`].
    #[inline(always)]
    fn apply(&self, v: Vectors<F>) -> Vectors<F> {
        multiply(self.square, self.cross, v)
    }

    /// As [`Form::apply_abs`].
    #[inline(always)]
    fn apply_abs(&self, v: Vectors<F>) -> Vectors<F> {
        let cross = match self.cross {
            Some(cross) => Some(abs(cross)),
            None => None,
        };
        multiply(abs(self.square), cross, abs(v))
    }
}

#[inline(always)]
fn multiply<F: Doubles>(square: Vectors<F>, cross: Option<Vectors<F>>, v: Vectors<F>) -> Vectors<F> {
    let Some(cross) = cross else { return mul(square, v) };
    [
        square[0] * v[0] + cross[2] * v[1] + cross[1] * v[2],
        cross[2] * v[0] + square[1] * v[1] + cross[0] * v[2],
        cross[1] * v[0] + cross[0] * v[1] + square[2] * v[2],
    ]
}

/// Lines in the coordinates of a form, as `LocalLine`.
struct LocalLines<'l, F> {
    line: &'l LineLanes<F>,
    shrink: Vectors<F>,
    o: Vectors<F>,
    d: Vectors<F>,
    s0: F,
    p: Vectors<F>,
    p_rest: Vectors<F>,
    t_over_s: [F; 2],
    /// The effect of the frame's errors, in the form's coordinates: on `o`, on one step of `t`, and on one of `s`.
    o_err: Vectors<F>,
    per_t: Vectors<F>,
    per_s: Vectors<F>,
    /// The lanes whose lengths are of an ordinary size.
    ordinary: u8,
}

/// The sums of the components, and their rounding errors.
#[inline(always)]
fn two_sum<F: Doubles>(a: Vectors<F>, b: Vectors<F>) -> (Vectors<F>, Vectors<F>) {
    let hi = add(a, b);
    let t = sub(hi, a);
    (hi, add(sub(a, sub(hi, t)), sub(b, t)))
}

/// As `exact_product` of a single line.
#[inline(always)]
fn exact_product<F: Doubles>(a: F, b: Vectors<F>) -> (Vectors<F>, Vectors<F>) {
    let (a_hi, b_hi) = (a.upper_half(), [b[0].upper_half(), b[1].upper_half(), b[2].upper_half()]);
    (scale(b_hi, a_hi), add(scale(sub(b, b_hi), a_hi), scale(b, a - a_hi)))
}

/// `1 / power_of_two_below(x)`, for `x` below `2^1022`.
#[inline(always)]
fn reciprocal_of_power_below<F: Doubles>(x: F) -> F {
    let reciprocal = x.power_below_one() * F::splat(2.0);
    F::splat(1.0 / f64::MIN_POSITIVE).where_set(x.is_less(F::splat(f64::MIN_POSITIVE)), reciprocal)
}

impl<'l, F: Doubles> LocalLines<'l, F> {
    #[inline(always)]
    fn new(form: &FormLanes<F>, line: &'l LineLanes<F>) -> LocalLines<'l, F> {
        let length = largest(abs(line.d));
        let zero = F::splat(0.0);
        let mut counted = line.d;
        for (component, counts) in counted.iter_mut().zip(form.counts) {
            if !counts {
                *component = zero;
            }
        }
        let counted_length = largest(abs(counted));
        let is_scaled_alike =
            (F::splat(FEW) * length).is_at_most(counted_length) | counted_length.is_at_most(zero);
        let shorten = reciprocal_of_power_below(length);
        let d = mul(scale(counted, shorten), form.shrink);
        let short_length = largest(abs(d));
        let lengthen = reciprocal_of_power_below(short_length);
        let d = scale(d, lengthen);
        let most = F::splat(1e300);
        let ordinary = length.is_less(most) & short_length.is_less(most) & is_scaled_alike;
        let o = mul(sub(line.o, form.centre), form.shrink);
        let dd = dot(d, d);
        let s0 = (-dot(o, d) / dd).where_set(F::splat(0.0).is_less(dd), F::splat(0.0));
        let minus = [-form.centre[0], -form.centre[1], -form.centre[2]];
        let (moved, moved_rest) = two_sum(line.o, minus);
        let (step, step_rest) = exact_product(s0, d);
        let (sum, sum_rest) = two_sum(mul(moved, form.shrink), step);
        let (p, p_rest) = two_sum(sum, add(sum_rest, add(step_rest, mul(moved_rest, form.shrink))));
        let per_s = scale(mul(scale(line.d_err, shorten), form.shrink), lengthen);
        LocalLines {
            line,
            shrink: form.shrink,
            o,
            d,
            s0,
            p,
            p_rest,
            t_over_s: [lengthen, shorten],
            o_err: mul(line.o_err, form.shrink),
            per_t: mul(line.d_err, form.shrink),
            per_s,
            ordinary,
        }
    }

    #[inline(always)]
    fn t(&self, s: F) -> F {
        s * self.t_over_s[0] * self.t_over_s[1]
    }
}

/// The polynomial of a form along lines, as `Expansion`.
struct ExpansionLanes<F> {
    a: F,
    b: F,
    c: F,
    discriminant: F,
    size: [F; 3],
    slope: Vectors<F>,
    turn: Vectors<F>,
}

impl<F: Doubles> ExpansionLanes<F> {
    #[inline(always)]
    fn new(form: &FormLanes<F>, at: &LocalLines<'_, F>) -> ExpansionLanes<F> {
        let (p, d, l) = (at.p, at.d, form.linear);
        let turn = form.apply(d);
        let slope = add(form.apply(p), l);
        let a = dot(d, turn);
        let b = dot(d, slope) + dot(turn, at.p_rest);
        let c = dot(p, add(slope, l)) + form.constant + F::splat(2.0) * dot(slope, at.p_rest);
        let slope_size = add(form.apply_abs(p), abs(l));
        let size = [
            dot(abs(d), form.apply_abs(d)),
            dot(abs(d), slope_size),
            dot(abs(p), add(slope_size, abs(l))) + form.constant.abs(),
        ];
        ExpansionLanes { a, b, c, discriminant: b * b - a * c, size, slope, turn }
    }

    /// The lanes in which rounding cannot have changed the number of roots, as `Quadratic::is_certain`.
    #[inline(always)]
    fn certain(&self) -> u8 {
        let ExpansionLanes { a, b, c, size, .. } = self;
        let doubt = F::splat(2.0) * b.abs() * size[1] + a.abs() * size[2] + c.abs() * size[0];
        (F::splat(TERM_ERROR) * size[0]).greater(F::splat(TINY)).is_less(a.abs())
            & (F::splat(SEPARATION * TERM_ERROR) * doubt).is_less(self.discriminant.abs())
    }

    /// The lanes in which the line may lie in the surface: the coefficients are within their errors, or nearly.
    #[inline(always)]
    fn vanishing(&self, at: &LocalLines<'_, F>) -> u8 {
        let ExpansionLanes { a, b, c, size, .. } = self;
        let (slope, turn, two) = (abs(self.slope), abs(self.turn), F::splat(2.0));
        let noise = F::splat(TERM_ERROR);
        let below = |value: &F, doubt: F| value.abs().is_at_most(F::splat(2.0 * GROUPING) * doubt);
        let flat = below(a, noise * size[0] + two * dot(turn, at.per_s));
        if flat == 0 {
            return 0;
        }
        let p = add(at.o_err, scale(at.per_s, at.s0.abs()));
        flat & below(b, noise * size[1] + dot(slope, at.per_s) + dot(turn, p))
            & below(c, noise * size[2] + two * dot(slope, p))
    }

    /// The lanes in which the value at `s0` is certain, as `SignDoubt::certain`.
    #[inline(always)]
    fn certain_at_closest(&self, at: &LocalLines<'_, F>) -> u8 {
        let two = F::splat(2.0);
        let gradient = scale(abs(self.slope), two);
        let frame = dot(gradient, add(at.o_err, scale(at.per_t, at.t(at.s0).abs())));
        (F::splat(GROUPING) * (F::splat(TERM_ERROR) * self.size[2] + frame)).is_less(self.c.abs())
    }

    /// The root `s0 + x`, and the lanes in which it is as accurate as the line allows, as `Form::root`.
    #[inline(always)]
    fn root(&self, x: F, at: &LocalLines<'_, F>, is_curved: bool) -> (EndLanes<F>, u8) {
        let (half_ulp, two) = (F::splat(HALF_ULP), F::splat(2.0));
        let s = at.s0 + x;
        let t = at.t(s);
        let gradient = scale(abs(add(self.slope, scale(self.turn, x))), two);
        let far = x.abs();
        let [a, b, c] = self.size;
        let rounded = F::splat(TERM_ERROR) * (c + far * (two * b + far * a));
        let moved = dot(gradient, mul(add(at.line.o_err, scale(at.line.d_err, t.abs())), at.shrink));
        let attainable = dot(gradient, add(abs(at.o), scale(abs(at.d), s.abs())));
        let s_err = self.root_err(x, rounded + moved, is_curved) + half_ulp * s.abs();
        let t_err = at.t(s_err).lesser(F::splat(f64::MAX));
        let well_conditioned = rounded
            .is_at_most(F::splat(WELL_CONDITIONED) * (half_ulp * attainable + moved))
            & (F::splat(GROUPING) * s_err).is_at_most(F::splat(FAR_REACHING) * far)
            & t.abs().is_at_most(F::splat(f64::MAX));
        (EndLanes { t, t_err, surface: F::splat(0.0) }, well_conditioned)
    }

    /// As `Quadratic::root_err`.
    #[inline(always)]
    fn root_err(&self, x: F, residual: F, is_curved: bool) -> F {
        let arithmetic = F::splat(3.0 * HALF_ULP) * x.abs();
        if !is_curved {
            return residual / (F::splat(2.0) * self.b.abs()) + arithmetic;
        }
        let curvature = self.a.abs();
        let slope = F::splat(2.0) * self.discriminant.sqrt();
        let rest = slope * slope - F::splat(4.0) * curvature * residual;
        let near = F::splat(2.0) * residual / (slope + rest.sqrt());
        let merged = (residual / curvature).sqrt();
        near.where_set(F::splat(0.0).is_less(rest), merged) + arithmetic
    }
}

/// Where lines are inside, as `Form::inside`. Leaves lanes open that it decides in double-double.
#[inline(always)]
pub(super) fn inside<F: Doubles>(form: &FormLanes<F>, line: &LineLanes<F>, lanes: u8) -> InsideLanes<F> {
    let is_curved = form.are_curved;
    let at = LocalLines::new(form, line);
    let expansion = ExpansionLanes::new(form, &at);
    let zero = F::splat(0.0);
    let is_zero = |x: F| x.abs().is_at_most(zero);
    let ExpansionLanes { a, b, c, discriminant, size, .. } = expansion;
    // A line along the axis of a cylinder, or parallel to a plane.
    let parallel = is_zero(a) & is_zero(b) & is_zero(size[0]) & is_zero(size[1]);
    let mut certain =
        if is_curved { expansion.certain() } else { (F::splat(TERM_ERROR) * size[1]).is_less(b.abs()) };
    if parallel & lanes != 0 {
        certain = (certain & !parallel) | (parallel & expansion.certain_at_closest(&at));
    }
    let open = lanes & !(certain & at.ordinary & !expansion.vanishing(&at));
    let decided = lanes & !open;
    let is_negative = a.is_less(zero);
    if !is_curved {
        return behind(&expansion, &at, decided, parallel, open);
    }
    let crossed = decided & zero.is_less(discriminant) & !parallel;
    let everywhere = decided & !crossed & ((is_negative & !parallel) | (parallel & c.is_less(zero)));
    let all = IntervalLanes::all(everywhere);
    if crossed == 0 {
        return InsideLanes { intervals: [all, IntervalLanes::none()], open };
    }
    let root = discriminant.sqrt();
    let q = -(b + (-root).where_negative(b, root));
    let (x, y) = (q / a, c / q);
    let is_ordered = x.is_less(y);
    let (low, low_is_good) = expansion.root(x.where_set(is_ordered, y), &at, true);
    let (high, high_is_good) = expansion.root(y.where_set(is_ordered, x), &at, true);
    let good = crossed & low_is_good & high_is_good;
    let (between, outside) = (good & !is_negative, good & is_negative);
    let first = IntervalLanes {
        enter: low.where_set(between, &all.enter),
        exit: high.where_set(between, &low.where_set(outside, &all.exit)),
        lanes: (between & low.t.is_less(high.t)) | outside | everywhere,
    };
    let second = IntervalLanes { enter: high, exit: all.exit, lanes: outside };
    InsideLanes { intervals: [first, second], open: open | (crossed & !good) }
}

/// Where lines are behind a plane.
#[inline(always)]
fn behind<F: Doubles>(
    expansion: &ExpansionLanes<F>,
    at: &LocalLines<'_, F>,
    decided: u8,
    parallel: u8,
    open: u8,
) -> InsideLanes<F> {
    let zero = F::splat(0.0);
    let ExpansionLanes { b, c, .. } = expansion;
    let (end, is_good) = expansion.root(-*c / (F::splat(2.0) * *b), at, false);
    let good = decided & (is_good | parallel);
    let everywhere = good & parallel & c.is_less(zero);
    let crossed = good & !parallel;
    let all = IntervalLanes::all(crossed | everywhere);
    let (before, after) = (crossed & zero.is_less(*b), crossed & b.is_less(zero));
    let interval = IntervalLanes {
        enter: end.where_set(after, &all.enter),
        exit: end.where_set(before, &all.exit),
        lanes: all.lanes,
    };
    InsideLanes { intervals: [interval, IntervalLanes::none()], open: open | (decided & !good) }
}
