//! Branch and prune: a cell is halved repeatedly until each piece is outside of some constraint, or a piece at the
//! finest size is not.

use super::Quadratic;
use super::contract::contract;
use crate::aabb::Aabb;
use crate::math::{HALF_ULP, Vec3};

/// A cell of homogeneous coordinates: the centre, and half of the size along each coordinate.
type Cell = ([f64; 4], [f64; 4]);

/// How far a region may extend, in sizes of the constraints, and still be found to be bounded.
const REACH: f64 = (1 << 20) as f64;

/// Pieces of at most this fraction of the size of the cell are not halved again.
const MIN_FRACTION: f64 = 1.0 / (1 << 16) as f64;

/// Maximum number of pieces examined to prove that a region is bounded.
const MAX_PIECES: usize = 4096;

/// Maximum number of pieces examined to prove that a slab may be cut off.
const MAX_PIECES_PER_SLAB: usize = 256;

/// The thicknesses of slabs that are tried, as fractions of the box.
const SLABS: [f64; 4] = [0.5, 0.25, 0.125, 0.0625];

/// The box, made finite on the axes on which the region is proved to be bounded.
///
/// Distant points are `[v w]` with `v` on the surface of the cube from -1 to 1 and `0 <= w <= 1 / REACH`. If none of
/// them meets all constraints, the region lies within `REACH`. Where it is unbounded along an axis, the constraints
/// that do not involve that axis may still bound the two others.
pub(super) fn bounded(b: Aabb, forms: &[Quadratic]) -> Aabb {
    for axes in [&[0, 1, 2][..], &[0, 1], &[0, 2], &[1, 2]] {
        let others = || (0..3).filter(|axis| !axes.contains(axis));
        let within: Vec<Quadratic> =
            forms.iter().filter(|form| !others().any(|axis| form.involves(axis))).copied().collect();
        if within.is_empty() || !is_bounded(&within, axes) {
            continue;
        }
        let mut bounded = b;
        for &axis in axes {
            bounded.min[axis] = bounded.min[axis].max(-REACH);
            bounded.max[axis] = bounded.max[axis].min(REACH);
        }
        return bounded;
    }
    b
}

fn is_bounded(forms: &[Quadratic], axes: &[usize]) -> bool {
    let half = 0.5 / REACH;
    let mut search = Search::new(forms);
    axes.iter().all(|&axis| {
        [-1.0, 1.0].into_iter().all(|sign| {
            let (mut middle, mut size) = ([0.0; 4], [0.0; 4]);
            axes.iter().for_each(|&axis| size[axis] = 1.0);
            (middle[axis], size[axis]) = (sign, 0.0);
            (middle[3], size[3]) = (half, half);
            search.excludes((middle, size), MAX_PIECES)
        })
    })
}

/// Cuts slabs off a finite box where no point of the slab meets all constraints.
pub(super) fn without_empty_slabs(b: Aabb, forms: &[Quadratic]) -> Aabb {
    let (mut b, mut search) = (b, Search::new(forms));
    for part in SLABS {
        let mut goes_on = true;
        // Twenty halvings of each side lead from `REACH` to the size of the constraints.
        for _ in 0..64 {
            if !std::mem::take(&mut goes_on) {
                break;
            }
            for axis in 0..3 {
                for upper in [false, true] {
                    let cut = if upper {
                        b.max[axis] - part * (b.max[axis] - b.min[axis])
                    } else {
                        b.min[axis] + part * (b.max[axis] - b.min[axis])
                    };
                    let mut slab = b;
                    let end = if upper { &mut slab.min } else { &mut slab.max };
                    end[axis] = cut;
                    if search.excludes(cell(&slab), MAX_PIECES_PER_SLAB) {
                        let end = if upper { &mut b.max } else { &mut b.min };
                        end[axis] = cut;
                        goes_on = true;
                    }
                }
            }
            if goes_on && part == SLABS[0] {
                b = contract(b, forms);
            }
            if b.is_empty() {
                return Aabb::EMPTY;
            }
        }
    }
    b
}

/// A cell that contains a box.
fn cell(b: &Aabb) -> Cell {
    let middle = b.centre();
    let half = (b.max - middle).max(middle - b.min);
    let half = half + (half + middle.abs()) * (4.0 * HALF_ULP) + Vec3::splat(f64::MIN_POSITIVE);
    ([middle.x, middle.y, middle.z, 1.0], [half.x, half.y, half.z, 0.0])
}

struct Search {
    forms: Vec<Homogeneous>,
    /// The constraint that excluded the last piece. It is likely to exclude the next.
    last: usize,
}

impl Search {
    fn new(forms: &[Quadratic]) -> Search {
        Search { forms: forms.iter().map(Homogeneous::new).collect(), last: 0 }
    }

    /// Whether it is certain that no point of a cell meets all constraints.
    fn excludes(&mut self, whole: Cell, patience: usize) -> bool {
        let largest = |half: &[f64; 4]| half.iter().fold(0.0, |m: f64, x| m.max(*x));
        let finest = MIN_FRACTION * largest(&whole.1);
        let mut stack = vec![whole];
        for _ in 0..patience {
            let Some((middle, half)) = stack.pop() else { return true };
            if self.is_outside(&middle, &half) {
                continue;
            }
            let widest = (1..4).fold(0, |best, i| if half[i] > half[best] { i } else { best });
            if half[widest] <= finest {
                return false;
            }
            // Halves are rounded outward, so that together they cover the whole.
            let mut less = half;
            less[widest] *= 0.5;
            for sign in [-1.0, 1.0] {
                let mut part = middle;
                part[widest] += sign * less[widest];
                let mut half = less;
                half[widest] += (part[widest].abs() + less[widest]) * (4.0 * HALF_ULP);
                stack.push((part, half));
            }
        }
        stack.is_empty()
    }

    fn is_outside(&mut self, middle: &[f64; 4], half: &[f64; 4]) -> bool {
        if self.forms[self.last].lower_bound(middle, half) > 0.0 {
            return true;
        }
        let found = self.forms.iter().position(|form| form.lower_bound(middle, half) > 0.0);
        self.last = found.unwrap_or(self.last);
        found.is_some()
    }
}

/// A constraint over homogeneous coordinates. That of a plane is kept linear. As a quadratic it would be 0 at `w =
/// 0`, where the linear one excludes most.
enum Homogeneous {
    Linear { coefficients: [f64; 4], errors: [f64; 4] },
    Quadratic(Quadratic),
}

impl Homogeneous {
    fn new(form: &Quadratic) -> Homogeneous {
        if !form.is_plane() {
            return Homogeneous::Quadratic(*form);
        }
        let row = |m: &[[f64; 4]; 4]| [2.0 * m[0][3], 2.0 * m[1][3], 2.0 * m[2][3], m[3][3]];
        Homogeneous::Linear { coefficients: row(&form.q), errors: row(&form.e) }
    }

    /// A lower bound on the values in a cell.
    fn lower_bound(&self, middle: &[f64; 4], half: &[f64; 4]) -> f64 {
        match self {
            Homogeneous::Linear { coefficients, errors } => {
                let (mut value, mut spread) = (0.0, 0.0);
                for i in 0..4 {
                    let (c, reach) = (coefficients[i], middle[i].abs() + half[i]);
                    value += c * middle[i];
                    spread += c.abs() * half[i] + (errors[i] + 16.0 * HALF_ULP * c.abs()) * reach;
                }
                value - spread - f64::MIN_POSITIVE
            }
            Homogeneous::Quadratic(form) => form.lower_bound(middle, half),
        }
    }
}

impl Quadratic {
    /// A lower bound on the values in a cell, from the value and the slope at its centre.
    fn lower_bound(&self, middle: &[f64; 4], half: &[f64; 4]) -> f64 {
        let (mut value, mut spread, mut error) = (0.0, 0.0, 0.0);
        for i in 0..4 {
            let (mut slope, mut size, mut doubt, mut across) = (0.0, 0.0, 0.0, 0.0);
            for j in 0..4 {
                let reach = middle[j].abs() + half[j];
                slope += self.q[i][j] * middle[j];
                size += self.q[i][j].abs() * reach;
                doubt += self.e[i][j] * reach;
                if i != j {
                    across += self.q[i][j].abs() * half[j];
                }
            }
            value += slope * middle[i];
            spread += half[i] * (2.0 * slope.abs() + across - (self.q[i][i] * half[i]).min(0.0));
            error += (middle[i].abs() + half[i]) * (doubt + 64.0 * HALF_ULP * size);
        }
        value - spread - error - f64::MIN_POSITIVE
    }
}
