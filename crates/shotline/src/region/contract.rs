//! Interval contraction (F. Benhamou et al., "Revising hull and box consistency", 1999): each constraint is solved
//! for one coordinate after the other, while the other coordinates range over the box. Works on unbounded boxes.

use super::Quadratic;
use crate::aabb::Aabb;
use crate::math::HALF_ULP;

/// Maximum number of rounds over all constraints.
const MAX_ROUNDS: usize = 30;

/// Rounds continue while an end becomes finite or a side shrinks by more than this fraction of its length.
const MIN_SHRINK: f64 = 1.0 / 64.0;

/// An interval of numbers.
type Range = (f64, f64);

/// A box around the points of a box that meet all constraints; empty if there are none.
pub fn contract(start: Aabb, forms: &[Quadratic]) -> Aabb {
    if start.is_empty() {
        return Aabb::EMPTY;
    }
    let mut b = start;
    for _ in 0..MAX_ROUNDS {
        let before = b;
        for form in forms {
            for axis in 0..3 {
                let Some((low, high)) = form.solved(&b, axis) else { return Aabb::EMPTY };
                b.min[axis] = b.min[axis].max(low);
                b.max[axis] = b.max[axis].min(high);
                // Not `!(min <= max)`: a NaN must not make the box empty.
                if b.min[axis] > b.max[axis] {
                    return Aabb::EMPTY;
                }
            }
        }
        let shrank = |i: usize| {
            let (old, new) = (before.max[i] - before.min[i], b.max[i] - b.min[i]);
            let ended = |old: f64, new: f64| old.is_infinite() && new.is_finite();
            ended(before.min[i], b.min[i]) || ended(before.max[i], b.max[i]) || old - new > MIN_SHRINK * old
        };
        if !(0..3).any(shrank) {
            break;
        }
    }
    b
}

impl Quadratic {
    /// A range around the values of a coordinate at which the constraint can be met in a box; `None` if there are
    /// none.
    fn solved(&self, b: &Aabb, axis: usize) -> Option<Range> {
        let all = (b.min[axis], b.max[axis]);
        if !self.involves(axis) {
            return Some(all);
        }
        let rest = self.least_without(b, axis);
        if !rest.is_finite() {
            return Some(all);
        }
        solve(self.entry(axis, axis), self.entry(axis, 3), -rest, all)
    }

    fn entry(&self, i: usize, j: usize) -> Range {
        let (q, e) = (self.q[i][j], self.e[i][j]);
        (q - e, q + e)
    }

    /// A lower bound on the sum of all terms except the square and the linear term of a coordinate.
    fn least_without(&self, b: &Aabb, axis: usize) -> f64 {
        let (constant, _) = self.entry(3, 3);
        let (mut sum, mut size) = (constant, constant.abs());
        let mut add = |(low, magnitude): Range| {
            sum += low;
            size += magnitude;
        };
        let side = |i: usize| (b.min[i], b.max[i]);
        for i in (0..3).filter(|&i| i != axis) {
            add(least_square(self.entry(i, i), self.entry(i, 3), side(i)));
        }
        for i in 0..3 {
            for j in 0..i {
                let cross = self.entry(i, j);
                if cross != (0.0, 0.0) {
                    add(least_product(cross, side(i), side(j)));
                }
            }
        }
        sum - 8.0 * HALF_ULP * size - f64::MIN_POSITIVE
    }
}

/// A product in which 0 times infinity is 0: an infinite factor stands for a coordinate that is arbitrarily large,
/// but finite.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// The least value of `a x^2 + 2 l x`, and the largest magnitude of its terms at the points compared.
fn least_square(a: Range, l: Range, x: Range) -> Range {
    let at = |x: f64| {
        if x.is_infinite() {
            let linear = if x > 0.0 { l.0 } else { -l.1 };
            let leading = if a.0 == 0.0 { linear } else { a.0 };
            return (times(leading, f64::INFINITY), 0.0);
        }
        let (square, linear) = (a.0 * x * x, 2.0 * times(l.0, x).min(times(l.1, x)));
        (square + linear, square.abs() + linear.abs())
    };
    let mut best = at(x.0);
    let mut consider = |candidate: Range| {
        best = (best.0.min(candidate.0), best.1.max(candidate.1));
    };
    consider(at(x.1));
    if x.0 <= 0.0 && 0.0 <= x.1 {
        consider((0.0, 0.0));
    }
    if a.0 > 0.0 {
        // The vertex of the parabola with the lower linear term, for either sign of x.
        consider(at((-l.0 / a.0).clamp(x.0, x.1)));
        consider(at((-l.1 / a.0).clamp(x.0, x.1)));
    }
    best
}

/// The least value of `2 c x y`, and its largest finite magnitude.
fn least_product(c: Range, x: Range, y: Range) -> Range {
    let mut best = (f64::INFINITY, 0.0);
    for c in [c.0, c.1] {
        for x in [x.0, x.1] {
            for y in [y.0, y.1] {
                let value = times(2.0 * c, times(x, y));
                best = (best.0.min(value), if value.is_finite() { value.abs().max(best.1) } else { best.1 });
            }
        }
    }
    best
}

/// A range around the `x` of a range with `a x^2 + 2 l x <= most`; `None` if there are none.
fn solve(a: Range, l: Range, most: f64, x: Range) -> Option<Range> {
    let largest = l.0.abs().max(l.1.abs());
    if a.0 > 0.0 {
        let (square, product) = (largest * largest, times(if most > 0.0 { a.1 } else { a.0 }, most));
        let inside = square + product + 8.0 * HALF_ULP * (square + product.abs()) + f64::MIN_POSITIVE;
        if inside < 0.0 {
            return None;
        }
        let root = inside.sqrt() * (1.0 + 4.0 * HALF_ULP);
        let over = |n: f64| {
            let end = if n > 0.0 { n / a.0 } else { n / a.1 };
            end + 8.0 * HALF_ULP * ((root + largest) / a.0) + f64::MIN_POSITIVE
        };
        return Some((-over(l.1 + root), over(root - l.0)));
    }
    if a == (0.0, 0.0) {
        let over = |l: f64| {
            let end = 0.5 * most / l;
            (end, 4.0 * HALF_ULP * end.abs() + f64::MIN_POSITIVE)
        };
        if l.0 > 0.0 {
            let (end, pad) = over(if most > 0.0 { l.0 } else { l.1 });
            return Some((x.0, x.1.min(end + pad)));
        }
        if l.1 < 0.0 {
            let (end, pad) = over(if most > 0.0 { l.1 } else { l.0 });
            return Some((x.0.max(end - pad), x.1));
        }
        return Some(x);
    }
    Some(if a.1 < 0.0 && most < 0.0 { outside((-a.1, -a.0), l, -most, x) } else { x })
}

/// A range around the `x` of a range with `p x^2 - 2 l x >= least`, for positive `p` and `least`. Such `x` are not
/// between the roots.
fn outside(p: Range, l: Range, least: f64, x: Range) -> Range {
    let smallest = if l.0 <= 0.0 && 0.0 <= l.1 { 0.0 } else { l.0.abs().min(l.1.abs()) };
    let root = (smallest * smallest + p.0 * least).sqrt() * (1.0 - 16.0 * HALF_ULP);
    let root = (root - f64::MIN_POSITIVE).max(0.0);
    let pad = 8.0 * HALF_ULP * ((root + l.0.abs().max(l.1.abs())) / p.0) + f64::MIN_POSITIVE;
    // A lower bound on the higher root, and an upper bound on the lower root.
    let over = |n: f64| if n > 0.0 { n / p.1 } else { n / p.0 };
    let (high, low) = (over(l.0 + root) - pad, -over(root - l.1) + pad);
    match x {
        (from, to) if from > low && to < high => (from.max(high), to.min(low)),
        (from, to) if from > low => (from.max(high), to),
        (from, to) if to < high => (from, to.min(low)),
        _ => x,
    }
}
