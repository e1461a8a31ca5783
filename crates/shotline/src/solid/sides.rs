//! Finds the side of the interior for a line that lies in a quadric.
//!
//! To first order the interior lies behind the tangent plane. Along the line the gradient changes linearly in
//! `t`. On a cylinder or a plane it is constant. On a cone it vanishes at the apex, where the interior changes to
//! the other side of the line. On other ruled surfaces it rotates around the line. Where it vanishes along the
//! whole line, as where two planes meet, the form restricted to the plane across the line decides.

use super::form::{Form, rounded};
use super::interval::{End, Interval};
use super::quadric_line::{Expansion, LocalLine, SignDoubt, TERM_ERROR_WIDE};
use crate::contact::{Border, Sector, Sheet};
use crate::crossing::GROUPING;
use crate::math::{HALF_ULP, Vec3, unit};
use crate::ray::Line;

/// Two planes count as one if the cosine of their angle is within this distance of 1.
const ONE_PLANE: f64 = 1e-12;

/// An interval on which a line lies in the surface, and the location of the interior beside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub interval: Interval,
    inward: Inward,
}

#[derive(Clone, Copy, Debug)]
enum Inward {
    Behind(Sheet),
    Between(Sector),
}

impl Side {
    /// The sector of the interior around a line, cut by the plane of a cap if the line lies in one. (A quadric
    /// with caps contains no line on which its gradient vanishes.)
    pub fn sector(&self, cap: Option<Vec3>, line: Vec3) -> Option<Sector> {
        match (self.inward, cap) {
            (Inward::Behind(sheet), None) => Sector::behind(&[sheet], line),
            (Inward::Behind(sheet), Some(cap)) => Sector::behind(&[sheet, Sheet::plane(cap)], line),
            (Inward::Between(sector), None) => Some(sector),
            (Inward::Between(_), Some(_)) => None,
        }
    }
}

/// Where the form is negative around a line on which it and its gradient vanish.
#[derive(Clone, Copy, Debug)]
enum Across {
    Nowhere,
    /// In two opposite sectors, given by the directions of their borders.
    Between([[Vec3; 2]; 2]),
    /// On both sides of a plane with this normal.
    Everywhere(Vec3),
}

impl Form {
    /// Whether a line in the surface has the interior on all sides, as a line in the plane of `-x^2 < 0` does.
    pub(super) fn surrounds(&self, expansion: &Expansion, doubt: &SignDoubt, line: &Line) -> bool {
        doubt.has_no_gradient(self, expansion) && matches!(self.across(line.d), Across::Everywhere(_))
    }

    /// Returns the intervals on which a line lies in the surface, with the side of the interior. `None` if the
    /// line does not lie in the surface.
    pub(super) fn sides(&self, line: &Line) -> Option<Vec<Side>> {
        if !self.may_lie_in_surface(line) {
            return None;
        }
        let at = LocalLine::new(self, line);
        let expansion = Expansion::new(self, &at).widened(self, line, &at);
        let doubt = SignDoubt::new(self, &expansion, &at, line);
        if !doubt.vanishes() {
            return None;
        }
        let side = |inward| Side { interval: Interval::ALL, inward };
        if doubt.has_no_gradient(self, &expansion) {
            return Some(match self.across(line.d) {
                Across::Nowhere => Vec::new(),
                Across::Between(sectors) => {
                    let border = |direction: Vec3| Border::straight(direction, line.d);
                    let sector = |[from, to]: [Vec3; 2]| Sector { from: border(from), to: border(to) };
                    sectors.map(|directions| side(Inward::Between(sector(directions)))).to_vec()
                }
                Across::Everywhere(normal) => {
                    [normal, -normal].map(|normal| side(Inward::Behind(Sheet::plane(normal)))).to_vec()
                }
            });
        }
        let sheet = |x: f64| Inward::Behind(doubt.sheet(self, &expansion, x));
        Some(match doubt.apex(self, &expansion) {
            Some(apex) => {
                let end = End::new(at.t(at.s0 + apex.step), at.t(apex.err), 0);
                let behind = |x: f64, interval: Interval| Side { interval, inward: sheet(x) };
                let far = 1.0 + apex.step.abs() + 2.0 * apex.err;
                vec![
                    behind(apex.step - far, Interval::before(end)),
                    behind(apex.step + far, Interval::after(end)),
                ]
            }
            None => vec![side(sheet(0.0))],
        })
    }

    /// Returns the surface along a line in it, if the interior is on one side. `None` if the line does not lie in
    /// it.
    pub(super) fn sheet_along(&self, line: &Line) -> Option<Sheet> {
        match self.sides(line)?[..] {
            [Side { inward: Inward::Behind(sheet), .. }] => Some(sheet),
            _ => None,
        }
    }

    /// Where the form is negative around a line on which it and its gradient vanish. At an angle `a` from a
    /// principal axis of the form across the line, its value is `mean + swing cos 2 a`.
    fn across(&self, d: Vec3) -> Across {
        let (x, y) = unit(d).any_orthonormal_pair();
        let unit_size = 1.0 / self.shrink.max_element();
        let [u, v] = [x, y].map(|w| w * self.shrink * unit_size);
        let (xx, xy, yy) = (u.dot(self.apply(u)), u.dot(self.apply(v)), v.dot(self.apply(v)));
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let swing = libm::hypot(half, xy);
        let axis = 0.5 * libm::atan2(xy, half);
        let towards = |angle: f64| x * libm::cos(angle) + y * libm::sin(angle);
        if mean >= swing * (1.0 - ONE_PLANE) {
            Across::Nowhere
        } else if mean <= -swing * (1.0 - ONE_PLANE) {
            Across::Everywhere(towards(axis + std::f64::consts::FRAC_PI_2))
        } else {
            let begin = 0.5 * libm::acos(-mean / swing);
            let (from, to) = (towards(axis + begin), towards(axis - begin));
            // The first sector runs from `begin` to half a turn minus `begin`. The other is opposite to it.
            Across::Between([[from, -to], [-from, to]])
        }
    }
}

/// The point of a line at which the gradient vanishes, in steps of `s` from the closest approach, and a bound on
/// its error.
struct Apex {
    step: f64,
    err: f64,
}

impl SignDoubt<'_> {
    /// Bounds on the errors of half the gradient at the closest approach, and of its change for a step of `s`.
    fn gradient_doubt(&self, form: &Form, expansion: &Expansion) -> [Vec3; 2] {
        let (p, d) = (self.at.p, self.at.d);
        let rounding = |terms: Vec3, value: Vec3| TERM_ERROR_WIDE * terms + HALF_ULP * value.abs();
        let slope = rounding(form.apply_abs(p) + rounded(&form.linear).abs(), expansion.slope)
            + form.apply_abs(self.o + self.per_s * self.at.s0.abs());
        [slope, rounding(form.apply_abs(d), expansion.turn) + form.apply_abs(self.per_s)]
    }

    /// Whether the gradient vanishes along the whole line.
    fn has_no_gradient(&self, form: &Form, expansion: &Expansion) -> bool {
        let [slope, turn] = self.gradient_doubt(form, expansion);
        is_below_error(expansion.slope, slope) && is_below_error(expansion.turn, turn)
    }

    /// The surface around a line in it, from the gradient at `s = s0 + x`.
    fn sheet(&self, form: &Form, expansion: &Expansion, x: f64) -> Sheet {
        let [slope_doubt, turn_doubt] = self.gradient_doubt(form, expansion);
        let turn = if is_below_error(expansion.turn, turn_doubt) { Vec3::ZERO } else { expansion.turn };
        // Scaled by the largest component, so that products are in range.
        let size = form.shrink.max_element();
        let shrink = form.shrink / size;
        let gradient = (expansion.slope + turn * x) * shrink;
        let length = gradient.length();
        let relative = |doubt: Vec3, value: Vec3| {
            if value == Vec3::ZERO { 0.0 } else { doubt.length() / value.length() }
        };
        let doubt = relative((slope_doubt + turn_doubt * x.abs()) * shrink, gradient)
            .max(relative(turn_doubt * shrink, turn * shrink));
        let per_t = self.at.s(1.0);
        let row = |axis: Vec3| form.apply(axis * shrink) * shrink * (size / length);
        Sheet {
            normal: gradient / length,
            turn: turn * shrink / length * if per_t.is_finite() { per_t } else { 0.0 },
            at: self.at.t(self.at.s0 + x),
            form: Vec3::AXES.map(row),
            doubt: (doubt + 8.0 * HALF_ULP).min(1.0),
        }
    }

    /// Returns the point where the gradient vanishes, if there is one.
    fn apex(&self, form: &Form, expansion: &Expansion) -> Option<Apex> {
        let [slope_doubt, turn_doubt] = self.gradient_doubt(form, expansion);
        let Expansion { slope, turn, .. } = *expansion;
        if is_below_error(turn, turn_doubt) {
            return None;
        }
        let step = -slope.dot(turn) / turn.length_squared();
        let doubt = slope_doubt + turn_doubt * step.abs();
        let rest = slope + turn * step;
        let rounding = 4.0 * HALF_ULP * (slope.abs() + turn.abs() * step.abs());
        is_below_error(rest, doubt + rounding)
            .then(|| Apex { step, err: (doubt + rounding).length() / turn.length() })
    }
}

fn is_below_error(value: Vec3, doubt: Vec3) -> bool {
    value.abs().cmple(GROUPING * doubt).all()
}
