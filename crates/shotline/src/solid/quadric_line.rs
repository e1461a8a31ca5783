//! A quadric along a line: the polynomial about the closest approach to the centre, and the intervals inside.
//!
//! Expanded about a far origin, the polynomial loses all its digits. Expanded about the line's closest approach
//! to the centre, in coordinates of the solid's size, it does not (E. Haines et al., Ray Tracing Gems 7). The
//! point of closest approach is stored together with its rounding error, so it lies on the line far more
//! accurately than one f64 point can. Signs and roots that are in doubt in f64 are decided in double-double about
//! the same point.

use super::form::{Form, rounded};
use super::interval::{End, Interval};
use super::quadratic::{Quadratic, SignIntervals};
use crate::crossing::GROUPING;
use crate::math::{Dd, HALF_ULP, Vec3, power_of_two_below, two_prod, two_sum};
use crate::ray::Line;

/// The relative error of a term of a coefficient in f64. A term has a chain of up to seven roundings (the number,
/// two products, sums of three), whose error is far smaller on average, and the discriminant adds two.
pub(super) const TERM_ERROR: f64 = 5.0 * HALF_ULP;
/// The same in double-double, with a margin.
pub(super) const TERM_ERROR_WIDE: f64 = HALF_ULP * HALF_ULP * 64.0;
/// Roots are recomputed in double-double if rounding moved them by more than this multiple of what rounding of
/// the line itself could.
pub(super) const WELL_CONDITIONED: f64 = 8.0;
/// A line is scaled by its components on the axes that count for the form if they are below this fraction of the longest
/// one: scaled by that, they would underflow.
pub(super) const FEW: f64 = f64::from_bits((1023 - 600) << 52);
/// If the terms of the leading coefficient sum to less than this, some of them may have underflowed.
pub(super) const TINY: f64 = f64::from_bits((1023 - 900) << 52);
/// Stands for terms that have underflowed: even the error that is assumed of it in double-double exceeds theirs.
const UNDERFLOW: f64 = f64::from_bits((1023 - 960) << 52);
/// The end of a root's doubt is searched for if the doubt seems to cover more than this fraction of the way from
/// the root back to the closest approach.
pub(super) const FAR_REACHING: f64 = 0.5;

/// A line in the coordinates of a form: `p + (s - s0) d`, with `s` proportional to `t`.
pub(super) struct LocalLine {
    /// The line's origin and direction. The direction has a length of about 1.
    o: Vec3,
    pub d: Vec3,
    /// The parameter near the closest approach to the centre and the point there, as a rounded value and its
    /// remainder.
    pub s0: f64,
    pub p: Vec3,
    p_rest: Vec3,
    /// Two powers of two whose product is `t / s`. The product itself may not be representable.
    t_over_s: [f64; 2],
}

impl LocalLine {
    pub fn new(form: &Form, line: &Line) -> LocalLine {
        // Scales twice, so that no component underflows or overflows for an extreme length or an extreme size. What runs
        // along axes that the form ignores does not count.
        let counted = Vec3::select(form.shrink.cmpeq(Vec3::ZERO), Vec3::ZERO, line.d);
        let (mut length, counted_length) = (line.d.abs().max_element(), counted.abs().max_element());
        if 0.0 < counted_length && counted_length < FEW * length {
            length = counted_length;
        }
        let shorten = 1.0 / power_of_two_below(length);
        let d = counted * shorten * form.shrink;
        let lengthen = 1.0 / power_of_two_below(d.abs().max_element());
        let d = d * lengthen;
        let o = (line.o - form.centre) * form.shrink;
        let dd = d.length_squared();
        let s0 = if dd > 0.0 { -o.dot(d) / dd } else { 0.0 };
        // `math::two_sum`, the error-free sum, on all axes at once.
        let two_sum = |a: Vec3, b: Vec3| {
            let hi = a + b;
            let t = hi - a;
            (hi, (a - (hi - t)) + (b - t))
        };
        let (moved, moved_rest) = two_sum(line.o, -form.centre);
        let (step, step_rest) = exact_product(s0, d);
        let (sum, sum_rest) = two_sum(moved * form.shrink, step);
        let (p, p_rest) = two_sum(sum, sum_rest + (step_rest + moved_rest * form.shrink));
        LocalLine { o, d, s0, p, p_rest, t_over_s: [lengthen, shorten] }
    }

    /// Converts this line's parameter `s` to the ray's `t`.
    pub fn t(&self, s: f64) -> f64 {
        s * self.t_over_s[0] * self.t_over_s[1]
    }

    /// Converts the ray's parameter `t` to this line's `s`.
    pub fn s(&self, t: f64) -> f64 {
        t / self.t_over_s[0] / self.t_over_s[1]
    }

    /// The point `p` in double-double.
    fn point_wide(&self, form: &Form, line: &Line) -> [Dd; 3] {
        std::array::from_fn(|i| {
            two_sum(line.o[i], -form.centre[i]) * form.shrink[i] + two_prod(self.s0, self.d[i])
        })
    }
}

/// Returns the product of a number with each component of a vector, and its rounding error, which is accurate up
/// to 2^-78 of the product. Splitting off the upper 26 bits (Dekker 1971) is cheaper than a fused multiply-add
/// where the machine has none.
fn exact_product(a: f64, b: Vec3) -> (Vec3, Vec3) {
    let upper = |x: f64| f64::from_bits(x.to_bits() & !0x7ff_ffff);
    let (a_hi, b_hi) = (upper(a), b.map(upper));
    (a_hi * b_hi, a_hi * (b - b_hi) + (a - a_hi) * b)
}

/// The polynomial of a form along a line, and what is needed to judge its roots.
pub(super) struct Expansion {
    poly: Quadratic,
    /// Half the gradient at `p`, and half the gradient's change along `d`.
    pub slope: Vec3,
    pub turn: Vec3,
}

impl Expansion {
    /// Computes the expansion in f64.
    pub fn new(form: &Form, at: &LocalLine) -> Expansion {
        let (p, d, l) = (at.p, at.d, rounded(&form.linear));
        let turn = form.apply(d);
        let slope = form.apply(p) + l;
        let a = d.dot(turn);
        let b = d.dot(slope) + turn.dot(at.p_rest);
        let c = p.dot(slope + l) + form.constant.hi + 2.0 * slope.dot(at.p_rest);
        let slope_size = form.apply_abs(p) + l.abs();
        let turn_size = form.apply_abs(d);
        let mut a_size = d.abs().dot(turn_size);
        if a_size < TINY && turn_size.max_element() > 0.0 {
            a_size += UNDERFLOW;
        }
        let size =
            [a_size, d.abs().dot(slope_size), p.abs().dot(slope_size + l.abs()) + form.constant.hi.abs()];
        let poly = Quadratic { a, b, c, discriminant: b * b - a * c, size, noise: TERM_ERROR };
        Expansion { poly, slope, turn }
    }

    /// Computes the expansion in double-double and rounds it once.
    pub fn widened(&self, form: &Form, line: &Line, at: &LocalLine) -> Expansion {
        let p = at.point_wide(form, line);
        let d = [at.d.x, at.d.y, at.d.z].map(Dd::from);
        let l = form.linear;
        let add = |v: [Dd; 3], w: [Dd; 3]| -> [Dd; 3] { std::array::from_fn(|i| v[i] + w[i]) };
        let turn = form.apply_wide(d);
        let slope = add(form.apply_wide(p), l);
        let [sa, sb, sc] = self.poly.size;
        let a = flush_to_zero(dot_wide(d, turn), sa);
        let b = flush_to_zero(dot_wide(d, slope), sb);
        let c = flush_to_zero(dot_wide(p, add(slope, l)) + form.constant, sc);
        let doubt = 2.0 * b.hi.abs() * sb + a.hi.abs() * sc + c.hi.abs() * sa;
        let discriminant = flush_to_zero(b * b - a * c, doubt).hi;
        let poly = Quadratic { a: a.hi, b: b.hi, c: c.hi, discriminant, noise: TERM_ERROR_WIDE, ..self.poly };
        Expansion { poly, slope: rounded(&slope), turn: rounded(&turn) }
    }

    /// The magnitudes of the gradient's components at a root.
    fn gradient(&self, root: f64) -> Vec3 {
        2.0 * (self.slope + self.turn * root).abs()
    }
}

/// Returns zero if a double-double number is below the rounding error of terms of a given size, else the number.
fn flush_to_zero(x: Dd, size: f64) -> Dd {
    if x.hi.abs() <= TERM_ERROR_WIDE * size { Dd::ZERO } else { x }
}

fn dot_wide(v: [Dd; 3], w: [Dd; 3]) -> Dd {
    v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
}

/// A root as the end of an interval, and whether it is as accurate as the line allows.
struct Root {
    end: End,
    well_conditioned: bool,
}

/// Where the sign of an expansion is in doubt.
pub(super) struct SignDoubt<'a> {
    expansion: &'a Expansion,
    pub at: &'a LocalLine,
    /// Bounds on the effect of the frame's errors on the line, in the form's coordinates: on `o`, on one step of
    /// `t`, and on one step of `s`.
    pub o: Vec3,
    per_t: Vec3,
    pub per_s: Vec3,
}

impl SignDoubt<'_> {
    pub fn new<'a>(form: &Form, expansion: &'a Expansion, at: &'a LocalLine, line: &Line) -> SignDoubt<'a> {
        let (o, per_t) = (line.o_err * form.shrink, line.d_err * form.shrink);
        let per_s = line.d_err * at.t_over_s[1] * form.shrink * at.t_over_s[0];
        SignDoubt { expansion, at, o, per_t, per_s }
    }

    /// Whether the sign is certain at `s = s0 + x`, with a margin of the range in which crossings are coincident.
    fn certain(&self, x: f64) -> bool {
        let Quadratic { a, b, c, .. } = self.expansion.poly;
        let t = self.at.t(self.at.s0 + x);
        let frame = self.expansion.gradient(x).dot(self.o + self.per_t * t.abs());
        let value = x * (a * x + 2.0 * b) + c;
        value.abs() > GROUPING * (self.expansion.poly.residual(x) + frame)
    }

    /// Whether the line cannot be distinguished from one that lies in the surface: the coefficients and the value
    /// at the ray's origin are within their errors. (For a line nearly parallel to an axis, the closest approach
    /// is so far away that everything is in doubt there.)
    pub fn vanishes(&self) -> bool {
        let Quadratic { a, b, c, size, noise, .. } = self.expansion.poly;
        let (slope, turn) = (self.expansion.slope.abs(), self.expansion.turn.abs());
        let p = self.o + self.per_s * self.at.s0.abs();
        let is_below_error = |value: f64, doubt: f64| value.abs() <= GROUPING * doubt;
        is_below_error(a, noise * size[0] + 2.0 * turn.dot(self.per_s))
            && is_below_error(b, noise * size[1] + slope.dot(self.per_s) + turn.dot(p))
            && is_below_error(c, noise * size[2] + 2.0 * slope.dot(p))
            && !self.certain(-self.at.s0)
    }

    /// The distance from a root over which the sign is in doubt, towards the closest approach to the centre or
    /// towards the ray's origin, whichever is less. The search tests halves, quarters and so on of the way.
    /// `None` if the sign is in doubt all the way, as near a tangent.
    fn reach_back(&self, root: f64) -> Option<f64> {
        let (s0, b) = (self.at.s0, self.expansion.poly.b);
        let p = self.o + self.per_s * s0.abs();
        let poly = &self.expansion.poly;
        let slope_doubt = poly.noise * poly.size[1]
            + self.expansion.slope.abs().dot(self.per_s)
            + self.expansion.turn.abs().dot(p);
        if b.abs() <= GROUPING * slope_doubt && !self.certain(0.0) && !self.certain(-s0) {
            return None;
        }
        let first = |at_fraction: &dyn Fn(f64) -> f64| {
            let mut share = 0.5;
            while share > 0.0 && !self.certain(at_fraction(share)) {
                share *= 0.5;
            }
            (share > 0.0).then(|| (root - at_fraction(share)).abs())
        };
        let towards = [first(&|share| root * share), first(&|share| (s0 + root) * share - s0)];
        towards.into_iter().flatten().min_by(f64::total_cmp)
    }
}

impl Form {
    /// Returns the intervals of a line, ascending, on which the form is negative. Their ends lie on surface 0.
    pub fn inside(&self, line: &Line) -> [Option<Interval>; 2] {
        let at = LocalLine::new(self, line);
        let quick = Expansion::new(self, &at);
        // A line parallel to a plane has a sign but no root that would show how far to trust it.
        let is_parallel = quick.poly.a == 0.0 && quick.poly.b == 0.0;
        let doubt = || SignDoubt::new(self, &quick, &at, line);
        // A result that is certain for the rounded line may not be certain for the exact line, even if its roots
        // are: beside an apex.
        let is_certain = quick.poly.is_certain()
            && (!is_parallel || doubt().certain(0.0))
            && (line.o_err == Vec3::ZERO && line.d_err == Vec3::ZERO || !doubt().vanishes());
        if is_certain {
            let (intervals, well_conditioned) = self.intervals(&quick, &at, line);
            if well_conditioned {
                return intervals;
            }
        }
        let wide = quick.widened(self, line, &at);
        let doubt = SignDoubt::new(self, &wide, &at, line);
        if doubt.vanishes() {
            return [self.surrounds(&wide, &doubt, line).then_some(Interval::ALL), None];
        }
        self.intervals(&wide, &at, line).0
    }

    /// Returns `false` if the form is certainly of second degree along the line. This cheap test rejects nearly
    /// all lines.
    pub(super) fn may_lie_in_surface(&self, line: &Line) -> bool {
        let d = line.d * self.shrink;
        let turn = self.apply(d);
        let doubt =
            TERM_ERROR * d.abs().dot(self.apply_abs(d)) + 2.0 * turn.abs().dot(line.d_err * self.shrink);
        let curved = d.dot(turn).abs() > GROUPING * doubt;
        // Numbers out of range compare as not greater (NaN, or infinity with infinity): undecided.
        !curved
    }

    /// Returns the intervals according to one expansion, and whether all their ends are well conditioned.
    fn intervals(&self, expansion: &Expansion, at: &LocalLine, line: &Line) -> ([Option<Interval>; 2], bool) {
        let mut well_conditioned = true;
        let mut end = |x: f64| {
            let root = self.root(x, expansion, at, line);
            well_conditioned &= root.well_conditioned;
            root.end
        };
        let intervals = match expansion.poly.negative() {
            SignIntervals::Nowhere => [None, None],
            SignIntervals::Everywhere => [Some(Interval::ALL), None],
            SignIntervals::Between(x, y) => [Interval::after(end(x)).clip(Interval::before(end(y))), None],
            SignIntervals::Outside(x, y) => [Some(Interval::before(end(x))), Some(Interval::after(end(y)))],
            SignIntervals::Before(x) => [Some(Interval::before(end(x))), None],
            SignIntervals::After(x) => [Some(Interval::after(end(x))), None],
        };
        (intervals, well_conditioned)
    }

    fn root(&self, x: f64, expansion: &Expansion, at: &LocalLine, line: &Line) -> Root {
        let s = at.s0 + x;
        let t = at.t(s);
        if !t.is_finite() {
            return Root { end: End::new(t, 0.0, 0), well_conditioned: true };
        }
        let gradient = expansion.gradient(x);
        let rounded = expansion.poly.residual(x);
        // The effect on the value of the errors of the line's frame, and of the line's own last bits.
        let moved = gradient.dot((line.o_err + line.d_err * t.abs()) * self.shrink);
        let attainable = gradient.dot(at.o.abs() + at.d.abs() * s.abs());
        let s_err = expansion.poly.root_err(x, rounded + moved) + HALF_ULP * s.abs();
        let mut end = End::new(t, at.t(s_err).min(f64::MAX), 0);
        let reaches_back = GROUPING * s_err > FAR_REACHING * x.abs();
        if reaches_back && let Some(way) = SignDoubt::new(self, expansion, at, line).reach_back(x) {
            end.reach = (way / s_err * (1.0 - f64::from(f32::EPSILON))).min(GROUPING) as f32;
        }
        let well_conditioned = rounded <= WELL_CONDITIONED * (HALF_ULP * attainable + moved) && !reaches_back;
        Root { end, well_conditioned }
    }
}
