//! Helicoids: lines across an axis that turn about it in proportion to their height. Where another line crosses one is a root
//! of a trigonometric function, found by subdivision with bounds on derivatives.

use crate::math::{HALF_ULP, PowerOfTwo, Vec3};
use crate::ray::Line;

/// A side of a twisted solid. At the height z, with `s = z / (2 h)` for the half height `h`, it is the line
/// `n(s) . (p - s shift) = offset + s change`, whose normal `n` is turned by `s turn`. Inside is where the left is less.
#[derive(Clone, Debug)]
pub(super) struct Side {
    normal: [f64; 2],
    offset: f64,
    change: f64,
    turn: f64,
    shift: [f64; 2],
    /// `1 / (2 h)`.
    per_height: f64,
}

impl Side {
    /// The side with the given corner at its lower and at its upper end before they are turned, with the direction of the
    /// edge, to the left of which is the inside. The twist is in degrees.
    pub fn new(corner: [[f64; 2]; 2], edge: [f64; 2], h: f64, twist: f64, shift: [f64; 2]) -> Side {
        let length = libm::hypot(edge[0], edge[1]);
        let normal = [edge[1] / length, -edge[0] / length];
        let [lower, upper] = corner.map(|[x, y]| normal[0] * x + normal[1] * y);
        Side {
            normal,
            offset: 0.5 * (lower + upper),
            change: upper - lower,
            turn: twist.to_radians(),
            shift,
            per_height: 0.5 / h,
        }
    }

    /// The normal turned by an angle, and its derivative by the angle.
    fn normals(&self, angle: f64) -> [[f64; 2]; 2] {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let [x, y] = self.normal;
        let n = [x * cos - y * sin, x * sin + y * cos];
        [n, [-n[1], n[0]]]
    }

    /// The implicit function: the signed distance from the line at the height of the point.
    pub fn value(&self, p: Vec3) -> f64 {
        let s = p.z * self.per_height;
        let [n, _] = self.normals(s * self.turn);
        dot(n, [p.x - s * self.shift[0], p.y - s * self.shift[1]]) - (self.offset + s * self.change)
    }

    pub fn gradient(&self, p: Vec3) -> Vec3 {
        let s = p.z * self.per_height;
        let [n, turned] = self.normals(s * self.turn);
        let u = [p.x - s * self.shift[0], p.y - s * self.shift[1]];
        let by_s = self.turn * dot(turned, u) - dot(n, self.shift) - self.change;
        Vec3::new(n[0], n[1], by_s * self.per_height)
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// A line in units of length and of the parameter that are powers of two.
pub(super) struct Along {
    o: Vec3,
    d: Vec3,
    o_err: Vec3,
    d_err: Vec3,
}

impl Along {
    /// The line with lengths and directions multiplied by powers of two.
    pub fn new(line: &Line, lengths: PowerOfTwo, directions: PowerOfTwo) -> Along {
        Along {
            o: lengths.of(line.o),
            d: directions.of(line.d),
            o_err: lengths.of(line.o_err),
            d_err: directions.of(line.d_err),
        }
    }

    /// The value of a side along the line.
    pub fn course<'a>(&'a self, side: &'a Side) -> Course<'a> {
        let s = [self.o.z * side.per_height, self.d.z * side.per_height];
        let across = |p: Vec3, s: f64| [p.x - s * side.shift[0], p.y - s * side.shift[1]];
        Course { line: self, side, s, u: [across(self.o, s[0]), across(self.d, s[1])] }
    }
}

/// The value of a side along a line, as a function of its parameter: `n(a) . u - c` with the angle `a`, the point `u` across
/// the axis, and `c` linear in the parameter.
pub(super) struct Course<'a> {
    line: &'a Along,
    side: &'a Side,
    /// `s`, and the points relative to the axis: at the origin of the line, and their changes.
    s: [f64; 2],
    u: [[f64; 2]; 2],
}

impl Course<'_> {
    fn point(&self, t: f64) -> [f64; 2] {
        let [o, d] = self.u;
        [o[0] + t * d[0], o[1] + t * d[1]]
    }

    /// The value and its derivative.
    pub fn at(&self, t: f64) -> [f64; 2] {
        let Side { turn, offset, change, .. } = *self.side;
        let (s, u) = (self.s[0] + t * self.s[1], self.point(t));
        let [n, turned] = self.side.normals(s * turn);
        let slope = dot(n, self.u[1]) + turn * self.s[1] * dot(turned, u) - change * self.s[1];
        [dot(n, u) - (offset + s * change), slope]
    }

    /// A bound on the second derivative between two parameters. The normal has length 1, and the distance from the axis is
    /// greatest at an end.
    fn curvature(&self, a: f64, b: f64) -> f64 {
        let turn = (self.side.turn * self.s[1]).abs();
        let length = |v: [f64; 2]| libm::hypot(v[0], v[1]);
        let furthest = length(self.point(a)).max(length(self.point(b)));
        turn * (2.0 * length(self.u[1]) + turn * furthest)
    }

    /// A bound on the error of the value at a parameter: of the line itself, and of computing it.
    fn value_err(&self, t: f64) -> f64 {
        let (Side { turn, offset, change, shift, per_height, .. }, Along { o, d, o_err, d_err }) =
            (self.side, self.line);
        let reach = o.abs() + d.abs() * t.abs();
        let s = reach.z * per_height;
        let [x, y] = self.point(t).map(f64::abs);
        let by_s = (x + y) * turn.abs() + shift[0].abs() + shift[1].abs() + change.abs();
        let computed = reach.x + reach.y + s * by_s + x + y + offset.abs();
        let moved = *o_err + *d_err * t.abs();
        16.0 * HALF_ULP * computed + moved.x + moved.y + moved.z * per_height * by_s
    }

    /// Whether the line runs within the side, up to its errors.
    pub fn runs_within(&self, from: f64, to: f64) -> bool {
        [from, 0.5 * (from + to), to].iter().all(|t| self.at(*t)[0].abs() <= self.value_err(*t))
    }

    /// Calls `found` with every root between two parameters, in order, and a bound on its error. Their number is even if the
    /// sign is the same at both, and odd if not. An interval has no root if its value in the middle is greater than it can
    /// change, and one if its derivative has one sign; otherwise it is divided, until the value is smaller than its error.
    pub fn roots(&self, from: f64, to: f64, mut found: impl FnMut(f64, f64)) {
        let is_negative = |t: f64| self.at(t)[0] < 0.0;
        let mut todo = vec![[from, to]];
        while let Some([a, b]) = todo.pop() {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let [value, slope] = self.at(middle);
            let bend = self.curvature(a, b) * half;
            let is_monotone = slope.abs() > bend;
            let changes = (slope.abs() + 0.5 * bend) * half;
            let is_settled = is_monotone || value.abs() > changes || changes <= self.value_err(middle);
            if !is_settled && a < middle && middle < b {
                todo.extend([[middle, b], [a, middle]]);
            } else if is_negative(a) != is_negative(b) {
                let t = self.refined(a, b);
                found(t, self.parameter_err(t, from, to));
            }
        }
    }

    /// The root between two parameters at which the signs differ: by Newton's method, or by halves where that leaves them.
    fn refined(&self, mut a: f64, mut b: f64) -> f64 {
        let begins_negative = self.at(a)[0] < 0.0;
        let mut t = 0.5 * (a + b);
        for _ in 0..200 {
            let [value, slope] = self.at(t);
            if (value < 0.0) == begins_negative {
                a = t
            } else {
                b = t
            }
            let newton = t - value / slope;
            let next = if a < newton && newton < b { newton } else { 0.5 * (a + b) };
            if value == 0.0 || (next - t).abs() <= HALF_ULP * t.abs() || next <= a || next >= b {
                break;
            }
            t = next;
        }
        t
    }

    /// How far from a root the value may still be zero: until it is greater than its error on both sides.
    fn parameter_err(&self, t: f64, from: f64, to: f64) -> f64 {
        let rounding = 2.0 * HALF_ULP * t.abs();
        let [value, slope] = self.at(t);
        let most = (to - from).max(rounding);
        let linear = (value.abs() + self.value_err(t)) / slope.abs();
        let mut reach = if linear < most { linear } else { rounding.max(HALF_ULP * most) };
        let clears = |t: f64| (t < from || to < t) || self.at(t)[0].abs() > self.value_err(t);
        while reach < most && !(clears(t - reach) && clears(t + reach)) {
            reach *= 2.0;
        }
        reach.min(most) + rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    /// The sign at any point of a line is that at its beginning, changed by each root before it.
    #[test]
    fn signs_change_at_the_roots_and_nowhere_else() {
        let mut random = Random::new(19);
        let (mut total, mut most) = (0, 0);
        for _ in 0..600 {
            let mut pair = || [random.number(-1.0, 1.0), random.number(-1.0, 1.0)];
            let (corner, edge, shift) = ([pair(), pair()], pair(), pair());
            let h = random.number(0.1, 1.0);
            let side = Side::new(corner, edge, h, random.number(-360.0, 360.0), shift);
            let mut at = |z: f64| Vec3::new(random.number(-1.5, 1.5), random.number(-1.5, 1.5), z);
            let (from, to) = (at(-h), at(h));
            let line = Line::exact(from, to - from);
            let along = Along::new(&line, PowerOfTwo::new(0), PowerOfTwo::new(0));
            let (course, mut roots) = (along.course(&side), Vec::new());
            course.roots(0.0, 1.0, |t, t_err| roots.push((t, t_err)));
            let begins = course.at(0.0)[0] < 0.0;
            for i in 0..=2000 {
                let t = f64::from(i) / 2000.0;
                let before = roots.iter().filter(|(root, _)| *root < t).count();
                let is_near = roots.iter().any(|(root, t_err)| (root - t).abs() <= *t_err);
                let is_negative = side.value(line.at(t)) < 0.0;
                assert!(
                    is_near || is_negative == (begins == (before % 2 == 0)),
                    "{side:?} {line:?} {t} {roots:?}"
                );
            }
            assert!(
                roots.is_sorted_by(|a, b| a.0 <= b.0) && roots.iter().all(|root| root.1 < 1e-9),
                "{roots:?}"
            );
            total += roots.len();
            most = most.max(roots.len());
        }
        assert!(total > 500 && most >= 3, "{total}, at most {most}");
    }

    /// A line that touches the helicoid has no root or two that are close, as its distance from it decides.
    #[test]
    fn tangents_have_two_roots_or_none() {
        let side = Side::new([[0.0, 0.0]; 2], [1.0, 0.0], 1.0, 90.0, [0.0, 0.0]);
        // Along the axis at a distance, the value is that distance times the sine of an angle.
        for (offset, expected) in [(0.5 - 1e-12, 2), (0.5 + 1e-12, 0), (0.0, 1)] {
            let side = Side { offset, ..side.clone() };
            let line = Line::exact(Vec3::new(-0.5, 0.0, -1.0), Vec3::new(0.0, 0.0, 2.0));
            let along = Along::new(&line, PowerOfTwo::new(0), PowerOfTwo::new(0));
            let mut roots = Vec::new();
            // The height from -3 to 3, a turn of 270 degrees.
            along.course(&side).roots(-1.0, 2.0, |t, t_err| roots.push((t, t_err)));
            assert_eq!(roots.len(), expected, "{offset}: {roots:?}");
            if let [(a, a_err), (b, b_err)] = roots[..] {
                assert!(b - a < 1e-5 && a_err < 1e-7 && b_err < 1e-7, "{roots:?}");
            }
        }
    }
}
