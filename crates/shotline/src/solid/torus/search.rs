//! The crossings of a line with a torus: certain in number, rounded once.
//!
//! 1. The line is moved near its closest approach (`approach`), and cut down to where it can meet the torus.
//! 2. Between two critical points of the quartic there is at most one crossing. They come from its plain
//!    coefficients: an error there enters the distance from the surface only squared.
//! 3. The sign of the torus function at the critical points decides (`distance`), in double-double where
//!    double is not sure. So the list alternates and is even whatever rounding does.
//! 4. Bracketed Newton finds each crossing, and a residual in double-double corrects it.

use super::approach::{Approach, PowerOfTwo, exponent, rounded};
use super::distance::Distance;
use crate::crossing::Crossing;
use crate::math::{Dd, HALF_ULP, Vec3};
use crate::ray::Line;
use crate::roots::{Piece, Roots, bracketed_newton, cubic_between};

/// Appends the crossings of a whole line with the torus of radii `major` and `minor`.
pub(super) fn crossings(major: f64, minor: f64, line: &Line, out: &mut Vec<Crossing>) {
    let size_exponent = exponent(major + minor);
    let unit = PowerOfTwo::new(-size_exponent);
    let (major, minor) = (unit.times(major), unit.times(minor));
    let approach = Approach::new(line, size_exponent);
    let Some((lo, hi)) = chord(&approach, major, minor) else {
        return;
    };
    let knots = critical_points(&approach, major, minor, lo, hi);
    let search = Search { line, approach: &approach, distance: Distance::new(&approach, major, minor), unit };
    search.run(lo, hi, &knots, out);
}

/// The part of the line within the sphere and the slab around the torus, both slightly enlarged, so that its
/// ends are outside of the torus.
fn chord(line: &Approach, major: f64, minor: f64) -> Option<(f64, f64)> {
    const MARGIN: f64 = 1e-9;
    let p = rounded(&line.p);
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
    // A line that misses the sphere has NaN for ends, and one from beyond the range of numbers as well.
    (half.is_finite() && lo < hi).then_some((lo, hi))
}

/// The zeros of the derivative of the quartic `(|q|^2 + R^2 - r^2)^2 - 4 R^2 rho^2` at `q = p + tau u`.
fn critical_points(line: &Approach, major: f64, minor: f64, lo: f64, hi: f64) -> Roots {
    let (p, u, uu) = (rounded(&line.p), line.u, line.uu);
    let pu = p.dot(u);
    let k = p.length_squared() + (major - minor) * (major + minor);
    let twice_major2 = 2.0 * major * major;
    let quarter_derivative = [
        pu * k - twice_major2 * (p.x * u.x + p.y * u.y),
        uu * k + 2.0 * pu * pu - twice_major2 * (u.x * u.x + u.y * u.y),
        3.0 * uu * pu,
        uu * uu,
    ];
    cubic_between(quarter_derivative, lo, hi, 1e-6 * (hi - lo))
}

struct Search<'a> {
    line: &'a Line,
    approach: &'a Approach,
    distance: Distance<'a>,
    /// Takes lengths of the solid's frame to units of its size.
    unit: PowerOfTwo,
}

impl Search<'_> {
    fn run(&self, lo: f64, hi: f64, knots: &[f64], out: &mut Vec<Crossing>) {
        let height = |tau: f64| self.distance.signed_value(tau);
        let (mut from, mut inside) = ((lo, height(lo)), false);
        for &to in knots {
            let to = (to, height(to));
            // A knot on the surface touches it, from whichever side: nothing changes.
            if to.1 != 0.0 && (to.1 < 0.0) != inside {
                out.push(if inside { self.crossing(from, to, true) } else { self.crossing(to, from, false) });
                inside = !inside;
            }
            from = to;
        }
        if inside {
            out.push(self.crossing(from, (hi, height(hi)), true));
        }
    }

    /// The one crossing between two knots, given with the values of `f`: the inner is in the tube.
    fn crossing(&self, inner: (f64, f64), outer: (f64, f64), leaving: bool) -> Crossing {
        let piece = Piece { lo: inner.0.min(outer.0), hi: inner.0.max(outer.0), rising: leaving };
        // From its low point in the tube f rises much like a parabola.
        let share = (inner.1 / (inner.1 - outer.1)).sqrt();
        let way = (outer.0 - inner.0) * if share < 1.0 { share } else { 0.5 };
        // Next to a touching f is but noise in double, and only the correction can see the crossing.
        let tolerance = f64::max(1e-5 * way.abs(), 1e-15 / way.abs());
        let f = &self.distance;
        let tau =
            bracketed_newton(piece, inner.0 + way, tolerance, |tau| f.value_and_slope_times_rho(&f.at(tau)));
        self.corrected(piece, tau)
    }

    /// The crossing of a piece, from a first approximation, by Newton's steps with the residual in
    /// double-double, until what is left cannot be seen in `t`.
    fn corrected(&self, piece: Piece, approximation: f64) -> Crossing {
        let f = &self.distance;
        let mut tau = Dd::from(approximation);
        let mut root = Root::unknown(approximation);
        // Mostly one step; next to a touching there may be many, of which the first only halve the way.
        for _ in 0..60 {
            let at = f.at(tau.hi);
            let value = f.wide_value(tau);
            let slope = f.slope(&at);
            let step = -value / slope;
            let next = tau + Dd::from(step);
            if !(piece.lo <= next.hi && next.hi <= piece.hi) {
                let end = if (value < 0.0) == piece.rising { piece.hi } else { piece.lo };
                tau = Dd::from(0.5 * tau.hi + 0.5 * end);
                root = Root::unknown(tau.hi);
                continue;
            }
            tau = next;
            let bend = f.bend(&at) * self.approach.uu;
            let slope_error = f.slope_error(&at) + bend * step.abs();
            let residual = slope_error * step.abs() + f.wide_error(&at);
            root = Root { tau: tau.hi, slope: slope.abs() - slope_error, residual, bend };
            let visible = 1e-3 * HALF_ULP * self.approach.reach(tau.hi);
            if residual <= visible * slope.abs() || step.abs() <= HALF_ULP * visible {
                break;
            }
        }
        let t = self.approach.t(tau);
        let spread = self.approach.t_length(self.spread(&root, t, piece));
        Crossing::new(t, spread + HALF_ULP * t.abs() + f64::MIN_POSITIVE, !piece.rising, 0)
    }

    /// How far the exact crossing of the exact line can be from the root, if it crosses here at all: where `f`
    /// can be off by the residual and by the line's own bounds.
    fn spread(&self, root: &Root, t: f64, piece: Piece) -> f64 {
        let doubt = root.residual + self.shaken(root.tau, t);
        let linear = doubt / root.slope;
        // How much the slope can change over that way, relatively.
        let turn = root.bend * linear / root.slope;
        if root.slope > 0.0 && turn <= 0.125 {
            return linear * (1.0 + 2.0 * turn);
        }
        // Next to a touching: as far as it takes until f is sure of its sign on both sides.
        let decided = |tau: f64| {
            let sure = f64::abs(self.distance.wide_value(Dd::from(tau)));
            sure > self.distance.wide_error(&self.distance.at(tau)) + self.shaken(tau, t)
        };
        let mut way = f64::EPSILON * (piece.hi - piece.lo);
        for _ in 0..60 {
            if decided(root.tau - way) && decided(root.tau + way) {
                break;
            }
            way *= 2.0;
        }
        way
    }

    /// What the line's own bounds can do to `f`.
    fn shaken(&self, tau: f64, t: f64) -> f64 {
        let by = self.line.point_err(t);
        if by == Vec3::ZERO {
            return 0.0;
        }
        self.distance.shaken(&self.distance.at(tau), self.unit.of(by))
    }
}

/// What is known of the torus function at a computed crossing.
struct Root {
    tau: f64,
    /// A lower bound of `|f'|`.
    slope: f64,
    /// A bound on `|f|`.
    residual: f64,
    /// A bound on `|f''|` nearby.
    bend: f64,
}

impl Root {
    /// A place of which nothing is known yet.
    fn unknown(tau: f64) -> Root {
        Root { tau, slope: 0.0, residual: f64::INFINITY, bend: 0.0 }
    }
}
