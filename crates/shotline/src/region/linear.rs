//! The box of a polytope by linear programming. The farthest corner in a direction is found by cutting. Multipliers
//! of the planes that meet there then prove a bound that is valid whatever the rounding error of the corner (A.
//! Neumaier and O. Shcherbina, "Safe bounds in linear and mixed-integer linear programming", 2004).

use super::Quadratic;
use super::polytope::{Polytope, side};
use crate::aabb::Aabb;
use crate::math::{HALF_ULP, Plane, Vec3};

/// Maximum number of planes; further ones are ignored.
const MAX_PLANES: usize = 512;

/// Maximum number of planes that are combined in a corner.
const MAX_PLANES_PER_CORNER: usize = 9;

/// Planes meet in a corner if their distance from it is at most this fraction of the size of the box.
const CORNER_TOLERANCE: f64 = 1e-9;

/// A constraint `normal . p + offset <= error`, where `error` is a bound for all points of the box.
struct Bound {
    plane: Plane,
    error: f64,
}

/// Maximum number of rounds. A proof is less precise the farther out the sides are, so a round follows if a side has
/// moved far.
const ROUNDS: usize = 4;

/// The box with its sides moved inward to the bounds that the planes prove. Axes on which it is unbounded do not
/// change, and planes that involve them are ignored.
pub(super) fn tightened(b: Aabb, planes: &[Quadratic]) -> Aabb {
    let is_open = |axis: usize| !(b.min[axis].is_finite() && b.max[axis].is_finite());
    let open = || (0..3).filter(|&axis| is_open(axis));
    let planes: Vec<Quadratic> =
        planes.iter().filter(|form| !open().any(|axis| form.involves(axis))).copied().collect();
    if planes.is_empty() {
        return b;
    }
    let mut inner = b;
    open().for_each(|axis| (inner.min[axis], inner.max[axis]) = (-1.0, 1.0));
    for _ in 0..ROUNDS {
        let size = inner.size();
        inner = tighten_once(inner, &planes);
        if inner.is_empty() {
            return Aabb::EMPTY;
        }
        if !inner.size().cmplt(size * 0.5).any() {
            break;
        }
    }
    for axis in open() {
        (inner.min[axis], inner.max[axis]) = (b.min[axis], b.max[axis]);
    }
    inner
}

fn tighten_once(b: Aabb, planes: &[Quadratic]) -> Aabb {
    let reach = b.min.abs().max(b.max.abs());
    let mut bounds: Vec<Bound> = planes.iter().take(MAX_PLANES).map(|form| bound(form, reach)).collect();
    let room = b.size() * 0.25;
    let mut polytope = Polytope::of_box(&Aabb::new(b.min - room, b.max + room));
    for axis in 0..3 {
        let normal = Vec3::AXES[axis];
        bounds.push(Bound { plane: Plane::new(normal, -b.max[axis]), error: 0.0 });
        bounds.push(Bound { plane: Plane::new(-normal, b.min[axis]), error: 0.0 });
    }
    bounds.iter().for_each(|bound| polytope.cut(&bound.plane));
    let near = CORNER_TOLERANCE * b.size().max_element();
    let mut out = b;
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let ahead = |p: &Vec3| sign * p[axis];
            let Some(corner) = polytope.corners.iter().max_by(|p, q| ahead(p).total_cmp(&ahead(q))).copied()
            else {
                return b;
            };
            let meets = |bound: &&Bound| {
                let length = bound.plane.normal.abs().max_element();
                side(&bound.plane, corner).abs() <= near * length
            };
            let here: Vec<&Bound> = bounds.iter().filter(meets).take(MAX_PLANES_PER_CORNER).collect();
            let most = proven(&here, Vec3::AXES[axis] * sign, reach);
            if sign > 0.0 {
                out.max[axis] = out.max[axis].min(most);
            } else {
                out.min[axis] = out.min[axis].max(-most);
            }
        }
    }
    if out.is_empty() { Aabb::EMPTY } else { out }
}

fn bound(form: &Quadratic, reach: Vec3) -> Bound {
    let (q, e) = (&form.q, &form.e);
    let error = (0..3).fold(e[3][3], |sum, i| sum + 2.0 * e[i][3] * reach[i]) * (1.0 + 8.0 * HALF_ULP);
    Bound { plane: Plane::new(2.0 * Vec3::new(q[0][3], q[1][3], q[2][3]), q[3][3]), error }
}

/// The least upper bound on `direction . p` that any three of the planes prove for points with `|p| <= reach` on each
/// axis.
fn proven(planes: &[&Bound], direction: Vec3, reach: Vec3) -> f64 {
    let mut best = f64::INFINITY;
    for (i, a) in planes.iter().enumerate() {
        for (j, b) in planes.iter().enumerate().skip(i + 1) {
            for c in &planes[j + 1..] {
                best = best.min(by_three([a, b, c], direction, reach));
            }
        }
    }
    best
}

/// The bound that three planes prove. With `direction = sum m n + rest` and `m >= 0` it is:
/// `direction . p <= sum m (error - offset) + |rest| . reach`.
fn by_three(planes: [&Bound; 3], direction: Vec3, reach: Vec3) -> f64 {
    let [a, b, c] = planes.map(|bound| bound.plane.normal);
    let volume = a.dot(b.cross(c));
    let parts = [direction.dot(b.cross(c)), a.dot(direction.cross(c)), a.dot(b.cross(direction))];
    let multipliers = parts.map(|part| (part / volume).max(0.0));
    if !multipliers.iter().all(|m| m.is_finite()) {
        return f64::INFINITY;
    }
    let (mut rest, mut size, mut most, mut terms) = (direction, direction.abs(), 0.0, 0.0);
    for (m, bound) in multipliers.into_iter().zip(planes) {
        rest -= bound.plane.normal * m;
        size += bound.plane.normal.abs() * m;
        most += m * (bound.error - bound.plane.offset);
        terms += m * (bound.error + bound.plane.offset.abs());
    }
    let rest = rest.abs() + size * (8.0 * HALF_ULP);
    let bound = most + rest.dot(reach) + 16.0 * HALF_ULP * (terms + rest.dot(reach)) + f64::MIN_POSITIVE;
    if bound.is_nan() { f64::INFINITY } else { bound }
}
