//! The crossings of a line with a torus: certain in number, rounded once.
//!
//! 1. The line gets an origin near its closest approach (`approach`) and is cut to the interval where it can meet
//!    the torus.
//! 2. Between two critical points of the quartic there is at most one crossing. The critical points come from the
//!    f64 coefficients. Their error affects the distance from the surface only to second order.
//! 3. The sign of the torus function at the critical points decides (`implicit`), in double-double where f64 is
//!    not certain. So the list alternates and is even despite rounding.
//! 4. Newton steps on the quartic approach each crossing, and a residual in double-double corrects it.

use super::approach::Approach;
use crate::crossing::Crossing;
use crate::math::{Dd, HALF_ULP, PowerOfTwo, Vec3, binary_exponent};
use crate::ray::Line;
use crate::roots::{Piece, Roots, bracketed_newton, cubic_between, horner};
use crate::solid::ring::UNDERFLOW;
use crate::solid::ring::implicit::{TorusFunction, rounded};

/// Appends the crossings of a whole line with the torus of radii `major` and `minor`.
#[multiversion::multiversion(targets("x86_64+avx+fma"))]
pub(super) fn crossings(major: f64, minor: f64, line: &Line, out: &mut Vec<Crossing>) {
    let size_exponent = binary_exponent(major + minor);
    let unit = PowerOfTwo::new(-size_exponent);
    let (major, minor) = (unit.times(major), unit.times(minor));
    let approach = Approach::new(line, size_exponent);
    let Some((lo, hi)) = chord(&approach, major, minor) else {
        return;
    };
    let quartic = quartic(&approach, major, minor);
    let knots = critical_points(quartic, lo, hi);
    let search = Search {
        line,
        approach: &approach,
        function: TorusFunction::new(approach.p, approach.u.to_array(), major, minor),
        unit,
        quartic,
    };
    search.run(lo, hi, &knots, out);
}

/// Returns the interval of the line within the sphere and the slab around the torus. Both are slightly enlarged,
/// so that its ends are outside the torus.
#[inline(always)]
fn chord(line: &Approach, major: f64, minor: f64) -> Option<(f64, f64)> {
    const MARGIN: f64 = 1e-9;
    let p = Vec3::from(rounded(&line.p));
    let reach = (major + minor) * (1.0 + MARGIN);
    let middle = -p.dot(line.u) / line.uu;
    let off = p + line.u * middle;
    let half = ((reach * reach - off.length_squared()) / line.uu).sqrt();
    let (mut lo, mut hi) = (middle - half, middle + half);
    let height = minor * (1.0 + MARGIN) + 1e-14;
    if line.u.z != 0.0 {
        let (a, b) = ((-height - p.z) / line.u.z, (height - p.z) / line.u.z);
        lo = lo.max(a.min(b));
        hi = hi.min(a.max(b));
    } else if p.z.abs() > height {
        return None;
    }
    // If the line misses the sphere the ends are NaN, as they are if it starts beyond the range of numbers.
    (half.is_finite() && lo < hi).then_some((lo, hi))
}

/// A quarter of the quartic `(|q|^2 + R^2 - r^2)^2 - 4 R^2 rho^2` at `q = p + tau u`, from the constant term
/// upwards.
#[inline(always)]
fn quartic(line: &Approach, major: f64, minor: f64) -> [f64; 5] {
    let (p, u, uu) = (Vec3::from(rounded(&line.p)), line.u, line.uu);
    let pu = p.dot(u);
    let k = p.length_squared() + (major - minor) * (major + minor);
    let major2 = major * major;
    [
        0.25 * k * k - major2 * (p.x * p.x + p.y * p.y),
        pu * k - 2.0 * major2 * (p.x * u.x + p.y * u.y),
        0.5 * uu * k + pu * pu - major2 * (u.x * u.x + u.y * u.y),
        uu * pu,
        0.25 * uu * uu,
    ]
}

/// Returns the zeros of the derivative of a quartic.
#[inline(always)]
fn critical_points([_, a, b, c, d]: [f64; 5], lo: f64, hi: f64) -> Roots {
    cubic_between([a, 2.0 * b, 3.0 * c, 4.0 * d], lo, hi, 1e-6 * (hi - lo))
}

struct Search<'a> {
    line: &'a Line,
    approach: &'a Approach,
    function: TorusFunction<f64>,
    quartic: [f64; 5],
    /// Converts lengths of the solid's frame to units of its size.
    unit: PowerOfTwo,
}

impl Search<'_> {
    /// Appends the crossings between two points outside the torus. A Newton step is a long chain of dependent
    /// operations. The chains overlap because the steps of all crossings are interleaved.
    #[inline(always)]
    fn run(&self, lo: f64, hi: f64, knots: &[f64], out: &mut Vec<Crossing>) {
        let (mut brackets, count) = self.brackets(lo, hi, knots);
        let brackets = &mut brackets[..count];
        self.approximate(brackets);
        let mut roots = [Root::default(); 4];
        for (root, bracket) in roots.iter_mut().zip(&*brackets) {
            *root = self.corrected(Dd::from(bracket.tau), bracket.piece);
        }
        for (root, bracket) in roots.iter_mut().zip(&*brackets) {
            if !root.converged {
                self.refine(root, bracket.piece);
            }
            out.push(self.crossing(root, bracket.piece));
        }
    }

    /// Brackets the crossings: the intervals between successive knots on different sides of the surface.
    #[inline(always)]
    fn brackets(&self, lo: f64, hi: f64, knots: &[f64]) -> ([Bracket; 4], usize) {
        let height = |tau: f64| (tau, self.function.signed_value(tau));
        let (mut brackets, mut count) = ([Bracket::default(); 4], 0);
        let (mut from, mut inside) = (height(lo), false);
        for &knot in knots {
            let to = height(knot);
            // A knot on the surface is a tangent point, from either side: membership does not change.
            if to.1 != 0.0 && (to.1 < 0.0) != inside {
                brackets[count] = if inside { Bracket::out(from, to) } else { Bracket::into(from, to) };
                count += 1;
                inside = !inside;
            }
            from = to;
        }
        if inside {
            brackets[count] = Bracket::out(from, height(hi));
            count += 1;
        }
        (brackets, count)
    }

    /// Moves each bracket's `tau` near its crossing by Newton steps on the quartic. Three steps without
    /// safeguards nearly always suffice.
    #[inline(always)]
    fn approximate(&self, brackets: &mut [Bracket]) {
        for _ in 0..3 {
            for Bracket { piece, tau, step, .. } in &mut *brackets {
                let (value, slope) = horner(&self.quartic, *tau);
                *step = value / slope;
                *tau = (*tau - *step).max(piece.lo).min(piece.hi);
            }
        }
        for bracket in brackets {
            if bracket.step.is_nan() || bracket.step.abs() > bracket.tolerance {
                bracket.tau = self.bracketed(bracket);
            }
        }
    }

    #[cold]
    fn bracketed(&self, bracket: &Bracket) -> f64 {
        bracketed_newton(bracket.piece, bracket.start, bracket.tolerance, |tau| horner(&self.quartic, tau))
    }

    /// Returns the result of one Newton step towards the crossing of a piece, with the residual in double-double.
    #[inline(always)]
    fn corrected(&self, tau: Dd, piece: Piece) -> Root {
        let f = &self.function;
        let at = f.at(tau.hi);
        let value = f.wide_value(tau);
        let slope = f.slope(&at);
        let step = -value / slope;
        let next = tau + Dd::from(step);
        if !(piece.lo <= next.hi && next.hi <= piece.hi) {
            let end = if (value < 0.0) == piece.rising { piece.hi } else { piece.lo };
            return Root::unknown(0.5 * tau.hi + 0.5 * end);
        }
        let curvature_bound = f.curvature_bound(&at) * self.approach.uu;
        let slope_error = f.slope_error(&at) + curvature_bound * step.abs();
        let residual = slope_error * step.abs() + f.wide_error(&at);
        let visible = 1e-3 * HALF_ULP * self.approach.reach(next.hi);
        let converged = residual <= visible * slope.abs() || step.abs() <= HALF_ULP * visible;
        Root { tau: next, slope: slope.abs() - slope_error, residual, curvature_bound, converged }
    }

    /// Takes further steps until the remaining error cannot be seen in `t`. Near a tangent there may be many, the
    /// first of which only halve the interval.
    #[cold]
    fn refine(&self, root: &mut Root, piece: Piece) {
        for _ in 0..60 {
            *root = self.corrected(root.tau, piece);
            if root.converged {
                break;
            }
        }
    }

    #[inline(always)]
    fn crossing(&self, root: &Root, piece: Piece) -> Crossing {
        let t = self.approach.t(root.tau);
        let root_error = self.approach.t_length(self.root_error(root, t, piece));
        Crossing::new(t, (root_error + HALF_ULP * t.abs()).max(UNDERFLOW), !piece.rising, 0)
    }

    /// A bound on the distance from the root to the exact crossing of the exact line, if it crosses here at all:
    /// the range in which `f` may be zero given the residual and the line's own bounds.
    #[inline(always)]
    fn root_error(&self, root: &Root, t: f64, piece: Piece) -> f64 {
        let doubt = root.residual + self.perturbation_bound(root.tau.hi, t);
        let linear = doubt / root.slope;
        // The relative change of the slope over that distance.
        let turn = root.curvature_bound * linear / root.slope;
        if root.slope > 0.0 && turn <= 0.125 {
            return linear * (1.0 + 2.0 * turn);
        }
        self.root_error_at_tangent(root.tau.hi, t, piece)
    }

    /// The distance at which the sign of `f` is certain on both sides, found by doubling.
    #[cold]
    fn root_error_at_tangent(&self, tau: f64, t: f64, piece: Piece) -> f64 {
        let decided = |tau: f64| {
            let sure = f64::abs(self.function.wide_value(Dd::from(tau)));
            sure > self.function.wide_error(&self.function.at(tau)) + self.perturbation_bound(tau, t)
        };
        let mut way = f64::EPSILON * (piece.hi - piece.lo);
        for _ in 0..60 {
            if decided(tau - way) && decided(tau + way) {
                break;
            }
            way *= 2.0;
        }
        way
    }

    /// A bound on the change of `f` due to the line's own errors.
    #[inline(always)]
    fn perturbation_bound(&self, tau: f64, t: f64) -> f64 {
        let by = self.line.point_err(t);
        if by == Vec3::ZERO {
            return 0.0;
        }
        self.function.perturbation_bound(&self.function.at(tau), self.unit.of(by).to_array())
    }
}

/// A piece of the line with one crossing, and the current approximation of that crossing.
#[derive(Clone, Copy, Default)]
struct Bracket {
    piece: Piece,
    start: f64,
    /// Close to the crossing once the last `step` is at most `tolerance`.
    tau: f64,
    step: f64,
    tolerance: f64,
}

impl Bracket {
    /// Between a knot outside the tube and one inside, each given with its value of `f`.
    #[inline(always)]
    fn into(outer: (f64, f64), inner: (f64, f64)) -> Bracket {
        Bracket::between(inner, outer, false)
    }

    /// Between a knot inside the tube and one outside.
    #[inline(always)]
    fn out(inner: (f64, f64), outer: (f64, f64)) -> Bracket {
        Bracket::between(inner, outer, true)
    }

    #[inline(always)]
    fn between(inner: (f64, f64), outer: (f64, f64), rising: bool) -> Bracket {
        // From its minimum in the tube, f rises much like a parabola.
        let share = (inner.1 / (inner.1 - outer.1)).sqrt();
        let way = (outer.0 - inner.0) * if share < 1.0 { share } else { 0.5 };
        let start = inner.0 + way;
        // Near a tangent the quartic is only noise, and only the double-double correction can locate the
        // crossing.
        let tolerance = f64::max(1e-5 * way.abs(), 1e-15 / way.abs());
        let piece = Piece { lo: inner.0.min(outer.0), hi: inner.0.max(outer.0), rising };
        Bracket { piece, start, tau: start, step: f64::NAN, tolerance }
    }
}

/// The data on the torus function at a computed crossing.
#[derive(Clone, Copy, Default)]
struct Root {
    tau: Dd,
    /// A lower bound of `|f'|`.
    slope: f64,
    /// A bound on `|f|`.
    residual: f64,
    /// A bound on `|f''|` nearby.
    curvature_bound: f64,
    /// Whether the remaining error cannot be seen in `t`.
    converged: bool,
}

impl Root {
    /// A point for which nothing is known yet.
    #[inline(always)]
    fn unknown(tau: f64) -> Root {
        Root {
            tau: Dd::from(tau),
            slope: 0.0,
            residual: f64::INFINITY,
            curvature_bound: 0.0,
            converged: false,
        }
    }
}
