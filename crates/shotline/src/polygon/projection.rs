//! A polygon projected along a coordinate axis. The projection keeps two of the three coordinates as they are, so signs
//! are exact for the given numbers.

use std::cmp::Ordering;

use crate::math::Vec3;
use robust::{Coord, orient2d};

/// A point of the plane.
pub(super) type Point = [f64; 2];

/// The orientation of three points: positive if a, b, c turns left, negative if it turns right, zero if they are
/// collinear. The sign is exact (J. R. Shewchuk 1997) unless products of coordinates overflow or underflow; see
/// [`scaled`].
pub(super) fn orientation(a: Point, b: Point, c: Point) -> f64 {
    let coord = |[x, y]: Point| Coord { x, y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Whether b, collinear with a and c, is not strictly between them, so that the corner is a spike.
pub(super) fn is_spike(a: Point, b: Point, c: Point) -> bool {
    let strictly = |k: usize| (a[k] < b[k] && b[k] < c[k]) || (c[k] < b[k] && b[k] < a[k]);
    !(strictly(0) || strictly(1))
}

/// The corners, scaled by a power of two so that products of three differences neither overflow nor underflow.
pub(super) fn scaled(corners: &[Vec3]) -> Vec<Vec3> {
    let largest = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
    // Only very small and very large polygons are scaled.
    let scale = match largest {
        x if x >= 1e100 => 2f64.powi(-700),
        x if x <= 1e-100 => 2f64.powi(700),
        _ => 1.0,
    };
    corners.iter().map(|c| *c * scale).collect()
}

/// The axes along which a polygon can be projected, the one with the largest area first (M. Newell's normal). Axes in the
/// plane of the polygon, along which its area is only rounding error, are left out.
pub(super) fn projection_axes(corners: &[Vec3]) -> Vec<usize> {
    let from = corners.first().copied().unwrap_or_default();
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let areas = pairs.map(|(a, b)| (*a - from).cross(*b - from));
    let (signed, unsigned) = areas.fold((Vec3::ZERO, Vec3::ZERO), |(s, u), area| (s + area, u + area.abs()));
    let mut axes: Vec<usize> =
        (0..3).rev().filter(|k| unsigned[*k] * 64.0 >= unsigned.max_element()).collect();
    axes.sort_by(|i, j| signed[*j].abs().partial_cmp(&signed[*i].abs()).unwrap_or(Ordering::Equal));
    axes
}

/// Projects the corners along an axis, as seen from its positive end.
pub(super) fn project(corners: &[Vec3], axis: usize) -> Vec<Point> {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    corners.iter().map(|c| [c[i], c[j]]).collect()
}

/// Twice the signed area of a ring of corners, and a bound on its rounding error.
fn area(points: &[Point], ring: &[u32]) -> (f64, f64) {
    let Some(from) = ring.first().map(|i| points[*i as usize]) else { return (0.0, 0.0) };
    let mut sum = (0.0, 0.0);
    for pair in ring.windows(2) {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]].map(|i| points[i as usize]);
        let (one, other) = ((ax - from[0]) * (by - from[1]), (ay - from[1]) * (bx - from[0]));
        sum.0 += one - other;
        sum.1 += one.abs() + other.abs();
    }
    (sum.0, sum.1 * 2.0 * f64::EPSILON * (ring.len() as f64 + 4.0))
}

/// Whether a ring is clockwise. Decided by the sign of its area, or, if that may be rounding error, by the orientation
/// of its corner with the least coordinates, which is exact for a polygon that does not cross itself.
pub(super) fn is_clockwise(points: &[Point], ring: &[u32]) -> bool {
    let (area, err) = area(points, ring);
    if area.abs() > err {
        return area < 0.0;
    }
    let n = ring.len();
    let at = |i: usize| points[ring[i % n] as usize];
    let order = |a: &Point, b: &Point| a.partial_cmp(b).unwrap_or(Ordering::Equal);
    let Some(lowest) = (0..n).map(at).min_by(order) else { return false };
    let turns = (0..n).filter(|i| at(*i) == lowest).map(|i| orientation(at(i + n - 1), at(i), at(i + 1)));
    turns.into_iter().find(|turn| *turn != 0.0).is_some_and(|turn| turn < 0.0)
}

/// The turning number of a ring: how many full turns to the left its direction makes. It is 1 for a counter-clockwise
/// polygon that does not cross itself. The ring must have no spikes.
pub(super) fn turning_number(points: &[Point], ring: &[u32]) -> i64 {
    let n = ring.len();
    let at = |i: usize| points[ring[i % n] as usize];
    let is_up = |a: Point, b: Point| b[1] > a[1] || (b[1] == a[1] && b[0] > a[0]);
    // Each full turn to the left passes the direction of x once, from below it upwards.
    let step = |i: usize| {
        let (a, b, c) = (at(i), at(i + 1), at(i + 2));
        match (is_up(a, b), is_up(b, c)) {
            (false, true) => i64::from(orientation(a, b, c) > 0.0),
            (true, false) => -i64::from(orientation(a, b, c) < 0.0),
            _ => 0,
        }
    };
    (0..n).map(step).sum()
}
