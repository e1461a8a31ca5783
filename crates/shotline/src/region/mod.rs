//! Boxes around the region that planes and quadrics enclose together.
//!
//! A half-space or a cylinder given as a quadric is unbounded, but an intersection of them may be bounded. The box of
//! such an intersection is found in steps, from cheap to expensive, each of which is valid by itself:
//!
//! 1. interval contraction (`contract`): exact where everything is aligned with the axes;
//! 2. a proof that the region is bounded (`prune`): the distant points, in homogeneous coordinates, are cut into
//!    cells until each cell is outside of some constraint;
//! 3. the box of the polytope of the planes (`linear`), by multipliers of linear programming;
//! 4. cutting slabs off the box where quadrics are slanted (`prune` again).
//!
//! Every box contains the region for all values of the coefficients within their error bounds, rounding included. A
//! step that does not succeed leaves a larger box.

mod contract;
mod linear;
mod polytope;
mod prune;

use crate::aabb::Aabb;
use crate::math::{Affine, HALF_ULP, Vec3, power_of_two_below};

pub use contract::contract;
pub use polytope::Polytope;

/// The function `x^T Q x` of homogeneous points `x = [x y z 1]`, with a bound on the error of each coefficient. The
/// region is where it is at most 0 for some coefficients within these bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadratic {
    /// `Q`, symmetric.
    q: [[f64; 4]; 4],
    /// A bound on the error of each entry; 0 for entries that are exactly 0.
    e: [[f64; 4]; 4],
}

/// A constraint on the points of a body, in two frames.
#[derive(Clone, Copy, Debug)]
pub struct Constraint {
    /// In the frame of the leaf it comes from.
    local: Quadratic,
    /// That frame.
    body_from_local: Affine,
    /// In the frame of the body.
    body: Quadratic,
}

impl Quadratic {
    /// From a symmetric matrix, row by row, each entry of which is accurate to two ulps.
    pub fn new(q: [[f64; 4]; 4]) -> Quadratic {
        let doubt = |x: f64| if x == 0.0 { 0.0 } else { 4.0 * HALF_ULP * x.abs() + f64::MIN_POSITIVE };
        Quadratic { q, e: q.map(|row| row.map(doubt)) }
    }

    /// The same region in the coordinates of another frame, given the map from that frame.
    fn moved(&self, local_from_body: &Affine) -> Quadratic {
        if local_from_body.is_identity() {
            return *self;
        }
        let m = &local_from_body.rows;
        let t = [m[0], m[1], m[2], [0.0, 0.0, 0.0, 1.0]];
        let size = t.map(|row| row.map(f64::abs));
        let q = congruence(&self.q, &t);
        let (error, all) =
            (congruence(&self.e, &size), congruence(&self.q.map(|row| row.map(f64::abs)), &size));
        // A product that underflows is not exactly 0: only entries without any nonzero product are exact.
        let is_there = |x: f64| f64::from(u8::from(x != 0.0));
        let products = congruence(
            &each(|i, j| is_there(self.q[i][j]).max(is_there(self.e[i][j]))),
            &t.map(|row| row.map(is_there)),
        );
        let vanished = f64::MIN_POSITIVE * (1.0 + size.iter().flatten().fold(0.0, |m: f64, x| m.max(*x)));
        // Two roundings for each entry of the map, the products and the sums of four, twice.
        let e = each(|i, j| {
            let e = error[i][j] * (1.0 + 32.0 * HALF_ULP) + 32.0 * HALF_ULP * all[i][j];
            if products[i][j] == 0.0 { 0.0 } else { e + vanished }
        });
        Quadratic { q, e }
    }

    /// The closure of the complement.
    fn negated(&self) -> Quadratic {
        Quadratic { q: self.q.map(|row| row.map(|x| -x)), ..*self }
    }

    /// The same region in units of `length`, a power of two. The coefficients are divided by a power of two that
    /// makes the largest about 1.
    fn scaled(&self, length: f64) -> Quadratic {
        let s = [length, length, length, 1.0];
        let by = |m: &[[f64; 4]; 4], factor: f64| each(|i, j| m[i][j] * s[i] * s[j] * factor);
        let largest = by(&self.q, 1.0).iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let factor =
            if largest > 0.0 && largest.is_finite() { 1.0 / power_of_two_below(largest) } else { 1.0 };
        let e = by(&self.e, factor);
        // A coefficient or error bound that underflowed was at most the smallest normal number before the factor.
        let vanished = f64::MIN_POSITIVE * factor.max(1.0);
        let e = each(|i, j| if self.e[i][j] == 0.0 { 0.0 } else { e[i][j] + vanished });
        Quadratic { q: by(&self.q, factor), e }
    }

    fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.e).flatten().all(|x| x.is_finite())
    }

    /// Whether the function depends on a coordinate.
    fn involves(&self, axis: usize) -> bool {
        (0..4).any(|j| self.q[axis][j] != 0.0 || self.e[axis][j] != 0.0)
    }

    fn is_plane(&self) -> bool {
        (0..3).all(|i| (0..3).all(|j| self.q[i][j] == 0.0 && self.e[i][j] == 0.0))
    }

    /// Whether contraction alone does not find the exact extent of the region.
    fn is_slanted(&self) -> bool {
        if self.is_plane() {
            (0..3).filter(|&i| self.involves(i)).count() > 1
        } else {
            (0..3).any(|i| (0..i).any(|j| self.q[i][j] != 0.0 || self.e[i][j] != 0.0))
        }
    }

    /// A length of about the size of the region: the distance of a plane from the origin, or the extent of a quadric
    /// around its centre. 0 if the coefficients determine none.
    fn length(&self) -> f64 {
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, x| m.max(x.abs()));
        let square = most(&mut (0..9).map(|k| self.q[k / 3][k % 3]));
        let linear = most(&mut (0..3).map(|i| self.q[i][3]));
        let constant = self.q[3][3].abs();
        let length = if square > 0.0 {
            (linear / square).max((constant / square).sqrt())
        } else {
            0.5 * constant / linear
        };
        if length.is_finite() { length } else { 0.0 }
    }
}

impl Constraint {
    /// The constraint on the points of a leaf, which is where `x^T Q x < 0` in its own frame, or of its complement.
    /// `None` if the numbers are too large to compute with.
    pub fn new(
        q: [[f64; 4]; 4],
        body_from_local: &Affine,
        local_from_body: &Affine,
        is_complement: bool,
    ) -> Option<Constraint> {
        let local = Quadratic::new(q);
        let local = if is_complement { local.negated() } else { local };
        let body = local.moved(local_from_body);
        let constraint = Constraint { local, body_from_local: *body_from_local, body };
        (local.is_finite() && body.is_finite()).then_some(constraint)
    }
}

/// A box around the points of a box that meet all constraints; the empty box if there are none.
pub fn enclose(start: Aabb, constraints: &[&Constraint]) -> Aabb {
    let Some(first) = constraints.first() else { return start };
    let mut start = start;
    let frame = first.body_from_local;
    if !frame.is_identity() && constraints.iter().all(|c| c.body_from_local == frame) {
        // All constraints share a frame, in which they may be aligned with the axes.
        let locals: Vec<Quadratic> = constraints.iter().map(|c| c.local).collect();
        start = start.intersection(&contract(Aabb::EVERYTHING, &locals).transformed(&frame));
    }
    let size =
        |v: Vec3| v.to_array().into_iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
    let lengths = constraints.iter().map(|c| c.body.length());
    let length = lengths.fold(size(start.min).max(size(start.max)), f64::max);
    let unit = if length > 0.0 { power_of_two_below(length) } else { 1.0 };
    let forms: Vec<Quadratic> =
        constraints.iter().map(|c| c.body.scaled(unit)).filter(Quadratic::is_finite).collect();
    let inner = unit_box(Aabb::new(start.min / unit, start.max / unit), &forms);
    if inner.is_empty() {
        return Aabb::EMPTY;
    }
    // Scaling by a power of two is exact except for underflow.
    let grown = Aabb::new(inner.min * unit - tiny(unit), inner.max * unit + tiny(unit));
    start.intersection(&grown)
}

/// A bound on the underflow of a coordinate that is multiplied by `unit`.
fn tiny(unit: f64) -> f64 {
    if unit < 1e-280 { f64::MIN_POSITIVE } else { 0.0 }
}

/// Does the same as [`enclose`], in coordinates in which all sizes are about 1.
fn unit_box(start: Aabb, forms: &[Quadratic]) -> Aabb {
    let mut b = contract(start, forms);
    let slanted = forms.iter().filter(|form| form.is_slanted()).count();
    if b.is_empty() || slanted == 0 {
        return b;
    }
    let was_finite = b.is_finite();
    if !was_finite {
        b = contract(prune::bounded(b, forms), forms);
    }
    if b.is_empty() {
        return b;
    }
    let planes: Vec<Quadratic> = forms.iter().filter(|form| form.is_plane()).copied().collect();
    if slanted > 1 && planes.iter().any(Quadratic::is_slanted) {
        b = linear::tightened(b, &planes);
    }
    if b.is_empty() || !b.is_finite() {
        return b;
    }
    if !was_finite && planes.len() < forms.len() {
        b = contract(prune::without_empty_slabs(contract(b, forms), forms), forms);
    }
    b
}

/// `T^T Q T`, symmetric in every bit.
fn congruence(q: &[[f64; 4]; 4], t: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let right: [[f64; 4]; 4] = each(|k, j| (0..4).map(|l| q[k][l] * t[l][j]).sum());
    each(|i, j| {
        let (i, j) = (i.min(j), i.max(j));
        (0..4).map(|k| t[k][i] * right[k][j]).sum()
    })
}

fn each(entry: impl Fn(usize, usize) -> f64) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}
