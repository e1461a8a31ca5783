//! The directions across which planes may lie: the three axes and the six diagonals between two of them.

use crate::aabb::{Aabb, BoxRay};
use crate::math::two_sum;

/// A direction, by its number: first the axes, then for each pair of axes their sum and their difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Normal(u8);

/// How many there are.
pub(super) const NORMALS: usize = 9;

/// When a ray passes a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Whether it comes from below.
    pub ascends: bool,
    /// The first `t` at which it may be behind the plane.
    pub behind: f64,
    /// The last `t` at which it may be before it.
    pub before: f64,
}

const NOT_ABOVE: Passage = Passage { ascends: true, behind: f64::INFINITY, before: f64::INFINITY };
const NOT_BELOW: Passage = Passage { ascends: true, behind: f64::NEG_INFINITY, before: f64::NEG_INFINITY };
const ON_BOTH_SIDES: Passage = Passage { ascends: true, behind: f64::NEG_INFINITY, before: f64::INFINITY };

impl Normal {
    pub fn across(axis: usize) -> Normal {
        Normal(axis as u8)
    }

    pub fn all() -> impl Iterator<Item = Normal> {
        (0..NORMALS as u8).map(Normal)
    }

    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// The axis it lies along; `None` for a diagonal.
    #[inline]
    pub fn axis(self) -> Option<usize> {
        (self.0 < 3).then_some(usize::from(self.0))
    }

    /// The two axes of a diagonal, and the sign of the second.
    pub fn pair(self) -> (usize, usize, f64) {
        let i = usize::from(self.0 - 3);
        (i / 2, (i / 2 + 1) % 3, if i % 2 == 0 { 1.0 } else { -1.0 })
    }

    /// The coordinate along it, for people.
    pub fn words(self) -> String {
        const AXES: [&str; 3] = ["x", "y", "z"];
        match self.axis() {
            Some(axis) => AXES[axis].to_owned(),
            None => {
                let (i, j, sign) = self.pair();
                format!("{} {} {}", AXES[i], if sign > 0.0 { "+" } else { "-" }, AXES[j])
            }
        }
    }

    /// The interval of a box along it, rounded outward.
    pub fn project(self, b: &Aabb) -> (f64, f64) {
        if let Some(axis) = self.axis() {
            return (b.min[axis], b.max[axis]);
        }
        let (i, j, sign) = self.pair();
        let (low, high) = if sign > 0.0 { (b.min[j], b.max[j]) } else { (-b.max[j], -b.min[j]) };
        (sum_below(b.min[i], low), sum_above(b.max[i], high))
    }

    /// When a ray passes a plane across a diagonal, on its stretch from `enter` to `exit`.
    ///
    /// Let `t` be in the interval of a box on one side of the plane. On both axes the point `t` steps from the
    /// origin is in the box, but for the doubt of the origin, which `bottom` and `top` take in, and twice the ray's
    /// doubt of the step. So along the normal it is on that side but for `2 doubt |t| (|d_i| + |d_j|)`: a doubt of
    /// `t` that is relative, and worse the less the ray goes along the normal. Doubled, it also covers the rounding
    /// done here; the least normal number covers that of numbers below it.
    pub fn passage(self, at: f64, ray: &BoxRay, (enter, exit): (f64, f64)) -> Passage {
        let (i, j, sign) = self.pair();
        let ((a, b, inverse_i), (c, d, inverse_j)) = (ray.along(i), ray.along(j));
        let (c, d) = (sign * c, sign * d);
        let (bottom, top) = (sum_below(a.min(b), c.min(d)), sum_above(a.max(b), c.max(d)));
        let (step_i, step_j) = (1.0 / inverse_i, sign / inverse_j);
        let (step, blur) = (step_i + step_j, 4.0 * ray.doubt() * (step_i.abs() + step_j.abs()));
        if blur < 0.25 * step.abs() {
            let doubt = blur / step.abs() + ray.doubt();
            let inverse = 1.0 / step;
            let (ahead, behind) = if step > 0.0 { (top, bottom) } else { (bottom, top) };
            let (first, last) = ((at - ahead) * inverse, (at - behind) * inverse);
            return Passage {
                ascends: step > 0.0,
                behind: number_or(first - first.abs() * doubt - f64::MIN_POSITIVE, f64::NEG_INFINITY),
                before: number_or(last + last.abs() * doubt + f64::MIN_POSITIVE, f64::INFINITY),
            };
        }
        // As good as parallel: perhaps all of the stretch is on one side. With NaN it is on both.
        let reach = (step.abs() + blur) * (enter.abs().max(exit.abs()) + f64::MIN_POSITIVE) * 1.001;
        if top + reach < at {
            NOT_ABOVE
        } else if bottom - reach > at {
            NOT_BELOW
        } else {
            ON_BOTH_SIDES
        }
    }
}

fn number_or(t: f64, else_: f64) -> f64 {
    if t.is_nan() { else_ } else { t }
}

/// The greatest number not above the exact sum.
fn sum_below(a: f64, b: f64) -> f64 {
    let sum = two_sum(a, b);
    match sum.lo {
        rest if rest < 0.0 => sum.hi.next_down(),
        rest if rest.is_nan() => f64::NEG_INFINITY,
        _ => sum.hi,
    }
}

/// The smallest number not below the exact sum.
fn sum_above(a: f64, b: f64) -> f64 {
    -sum_below(-a, -b)
}
