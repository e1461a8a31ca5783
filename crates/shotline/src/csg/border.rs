//! The border of a sector as a curve in the plane perpendicular to a ray. Along the ray, the curve may rotate and its
//! curvature may change.

use std::f64::consts::TAU;

use crate::contact::Border;
use crate::crossing::Crossing;
use crate::math::{HALF_ULP, Vec3};

/// Borders that differ by less than this angle, in radians, have the same direction.
pub(super) const SAME_DIRECTION: f64 = 1e-6;

/// Curvatures that differ by less than this fraction of them are equal.
const SAME_CURVATURE: f64 = 1e-6;

/// A curvature below this fraction of the largest that the form of a surface has in any direction counts as zero.
const NO_CURVATURE: f64 = 1e-10;

/// A curve that starts at the ray in the direction of an angle. The curvature is positive if it bends
/// counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    pub angle: f64,
    pub curvature: f64,
    /// Curvatures that differ by less than this are equal.
    pub doubt: f64,
}

impl Curve {
    /// Whether it starts in the same direction as another curve.
    pub fn is_along(&self, other: &Curve) -> bool {
        libm::remainder(self.angle - other.angle, TAU).abs() < SAME_DIRECTION
    }

    /// Whether it differs from another curve by rounding only.
    pub fn coincides_with(&self, other: &Curve) -> bool {
        self.is_along(other) && !self.is_behind(other) && !other.is_behind(self)
    }

    /// Whether it bends further counter-clockwise than another curve of the same direction.
    pub fn is_behind(&self, other: &Curve) -> bool {
        self.curvature == f64::INFINITY || self.curvature - other.curvature > self.doubt.max(other.doubt)
    }
}

/// A vector in the plane perpendicular to the ray.
type Flat = [f64; 2];

/// A [`Border`] in coordinates of the plane perpendicular to the ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatBorder {
    normal: Flat,
    turn: Flat,
    at: f64,
    /// The coefficients of the form: of `x^2`, half of that of `x y`, and of `y^2`.
    form: [f64; 3],
    /// The largest absolute value in the whole form.
    form_size: f64,
    doubt: f64,
    side: f64,
}

impl FlatBorder {
    /// Projects the border into the plane that two directions span.
    pub fn new(border: &Border, (x, y): (Vec3, Vec3)) -> FlatBorder {
        let sheet = &border.sheet;
        let flat = |v: Vec3| [v.dot(x), v.dot(y)];
        let times = |v: Vec3| Vec3::from(sheet.form.map(|row| row.dot(v)));
        FlatBorder {
            normal: flat(sheet.normal),
            turn: flat(sheet.turn),
            at: sheet.at,
            form: [x.dot(times(x)), x.dot(times(y)), y.dot(times(y))],
            form_size: sheet.form.iter().map(|row| row.abs().max_element()).fold(0.0, f64::max),
            doubt: sheet.doubt,
            side: border.side,
        }
    }

    /// Whether this is the other half of the sheet of another border.
    pub fn is_opposite(&self, other: &FlatBorder) -> bool {
        self.side == -other.side && (self.normal, self.turn, self.at) == (other.normal, other.turn, other.at)
    }

    /// Whether its direction or its curvature changes along the ray.
    pub fn turns(&self) -> bool {
        self.turn != [0.0; 2]
    }

    fn normal_at(&self, t: f64) -> Flat {
        if self.turns() { add(self.normal, self.turn, t - self.at) } else { self.normal }
    }

    /// The curve at a `t`: to first order perpendicular to the normal `n`, and to second order such that
    /// `2 n v + v form v` is 0.
    pub fn curve(&self, t: f64) -> Curve {
        let normal = self.normal_at(t);
        let length = libm::hypot(normal[0], normal[1]);
        let [x, y] = quarter_turn(normal).map(|x| x / length * self.side);
        let curvature = 0.5 * self.side * polar(self.form, [x, y], [x, y]) / length;
        let doubt = (SAME_CURVATURE * curvature.abs()).max(NO_CURVATURE * self.form_size / length);
        Curve { angle: libm::atan2(y, x), curvature, doubt }
    }

    /// A step of `t` over which the border rotates by an angle that is not small; infinite if it does not rotate.
    pub fn step(&self, t: f64) -> f64 {
        size(self.normal_at(t)).max(size(self.normal)) / size(self.turn)
    }

    /// Appends where the borders of two sheets may exchange their order: where the sheets become parallel, or, if
    /// they are parallel everywhere, where their curvatures become equal.
    pub fn exchanges(&self, other: &FlatBorder, out: &mut Vec<Crossing>) {
        if !self.turns() && !other.turns() {
            return;
        }
        // `u` is `t` relative to the position of the first border.
        let (n, dn) = (self.normal, self.turn);
        let shift = self.at - other.at;
        let (m, dm) = (add(other.normal, other.turn, shift), other.turn);
        let m_size = size(other.normal) + size(dm) * shift.abs();
        let parallel = Polynomial {
            terms: [cross(n, m), cross(n, dm) + cross(dn, m), cross(dn, dm)],
            sizes: [size(n) * m_size, size(n) * size(dm) + size(dn) * m_size, size(dn) * size(dm)],
        };
        let doubt = self.doubt + other.doubt;
        let polynomial = if !parallel.is_zero(SAME_DIRECTION) {
            parallel
        } else if cross(n, dn).abs() > SAME_DIRECTION * size(n) * size(dn) {
            // Both rotate alike: one normal is a constant multiple of the other.
            let ratio = dot(n, m) / dot(n, n);
            let form: [f64; 3] = std::array::from_fn(|i| ratio * self.form[i] - other.form[i]);
            let large: f64 = (0..3).map(|i| (ratio * self.form[i]).abs() + other.form[i].abs()).sum();
            let (w, dw) = (quarter_turn(n), quarter_turn(dn));
            Polynomial {
                terms: [polar(form, w, w), 2.0 * polar(form, w, dw), polar(form, dw, dw)],
                sizes: [size(w) * size(w), 2.0 * size(w) * size(dw), size(dw) * size(dw)].map(|x| x * large),
            }
        } else {
            // Neither rotates: the curvatures are inversely proportional to the lengths of the normals.
            let w = quarter_turn(n);
            let (a, b) = (polar(self.form, w, w), polar(other.form, w, w));
            Polynomial {
                terms: [a * dot(m, n) - b * dot(n, n), a * dot(dm, n) - b * dot(dn, n), 0.0],
                sizes: [
                    a.abs() * m_size * size(n) + b.abs() * dot(n, n),
                    (a.abs() * size(dm) + b.abs() * size(dn)) * size(n),
                    0.0,
                ],
            }
        };
        for [u, err] in polynomial.roots(doubt).into_iter().flatten() {
            let t = self.at + u;
            out.push(Crossing::new(t, err + HALF_ULP * (t.abs() + self.at.abs()), true, 0));
        }
    }
}

/// A polynomial of the second degree, with the sizes of the summands of its coefficients.
struct Polynomial {
    terms: [f64; 3],
    sizes: [f64; 3],
}

impl Polynomial {
    /// Whether all coefficients are zero within a relative error of their sizes.
    fn is_zero(&self, doubt: f64) -> bool {
        self.terms.iter().zip(self.sizes).all(|(term, size)| term.abs() <= doubt * size)
    }

    /// The real roots with bounds on their errors, given the relative error of the sizes.
    fn roots(&self, doubt: f64) -> [Option<[f64; 2]>; 2] {
        let doubt = doubt + 8.0 * HALF_ULP;
        let [c, b, a] = std::array::from_fn(|i| {
            if self.terms[i].abs() <= doubt * self.sizes[i] { 0.0 } else { self.terms[i] }
        });
        let discriminant = b * b - 4.0 * a * c;
        if discriminant < 0.0 || (a, b) == (0.0, 0.0) {
            return [None; 2];
        }
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        let root = |x: f64| {
            let value = doubt * (self.sizes[0] + x.abs() * (self.sizes[1] + x.abs() * self.sizes[2]));
            let err = (value / (2.0 * a * x + b).abs()).min((value / a.abs()).sqrt());
            (x.is_finite() && err.is_finite()).then_some([x, err])
        };
        match (a == 0.0, q == 0.0) {
            (true, _) => [root(-c / b), None],
            (_, true) => [root(0.0), None],
            _ => [root(q / a), root(c / q)],
        }
    }
}

fn add(a: Flat, b: Flat, times: f64) -> Flat {
    [a[0] + b[0] * times, a[1] + b[1] * times]
}

fn dot(a: Flat, b: Flat) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Flat, b: Flat) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn size(a: Flat) -> f64 {
    libm::hypot(a[0], a[1])
}

/// Rotates by 90 degrees counter-clockwise.
fn quarter_turn([x, y]: Flat) -> Flat {
    [-y, x]
}

/// The symmetric bilinear form of a quadratic form.
fn polar([xx, xy, yy]: [f64; 3], a: Flat, b: Flat) -> f64 {
    xx * a[0] * b[0] + xy * (a[0] * b[1] + a[1] * b[0]) + yy * a[1] * b[1]
}
