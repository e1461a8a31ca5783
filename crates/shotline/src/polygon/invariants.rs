//! Properties of every triangulation, checked in integers by code that shares nothing with ear clipping.

use std::collections::HashMap;

use crate::math::Vec3;

use super::{Triangulation, triangulate};

type Corner = [i64; 2];

/// Triangulates a polygon of small integers in a slanted plane and checks the result.
///
/// # Panics
/// If a property does not hold.
pub fn check(corners: &[Corner], axis: usize, slopes: [i64; 2]) {
    if corners.len() < 3 {
        return;
    }
    let point = |[x, y]: &Corner| {
        let mut point = [0; 3];
        (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (*x, *y);
        point[axis] = slopes[0] * x + slopes[1] * y;
        Vec3::from(point.map(|x| x as f64))
    };
    let points: Vec<Vec3> = corners.iter().map(point).collect();
    let cut = triangulate(&points);
    let n = corners.len() as u32;
    assert_eq!(cut.triangles.len(), corners.len() - 2);
    assert_eq!(outline(&cut), (0..n).map(|i| ((i, (i + 1) % n), 1)).collect(), "{corners:?}");
    let whole = (1..corners.len() - 1).map(|i| area(corners[0], corners[i], corners[i + 1])).sum::<i64>();
    let areas: Vec<i64> = cut.triangles.iter().map(|t| area_of(corners, t)).collect();
    assert_eq!(areas.iter().sum::<i64>(), whole, "{corners:?}");
    let same = areas.iter().all(|a| a * whole.signum() >= 0);
    assert!(!cut.is_proper || same, "{corners:?}: {cut:?}");
    if is_simple(corners) {
        assert!(cut.is_proper && areas.iter().all(|a| a * whole.signum() > 0), "{corners:?}: {cut:?}");
    }
}

/// Twice the signed area of a triangle.
fn area(a: Corner, b: Corner, c: Corner) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn area_of(corners: &[Corner], triangle: &[u32; 3]) -> i64 {
    let [a, b, c] = triangle.map(|i| corners[i as usize]);
    area(a, b, c)
}

/// The directed edges of the triangles, each with how many times more it occurs than its reverse.
fn outline(cut: &Triangulation) -> HashMap<(u32, u32), i64> {
    let mut edges = HashMap::new();
    for [a, b, c] in &cut.triangles {
        for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
            *edges.entry((to, from)).or_insert(0) -= 1;
        }
    }
    edges.retain(|_, times| *times > 0);
    edges
}

/// Whether no two edges have a point in common, except the corner between neighbours.
pub(super) fn is_simple(corners: &[Corner]) -> bool {
    let n = corners.len();
    let edge = |i: usize| (corners[i], corners[(i + 1) % n]);
    let apart = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (edge(i), edge(j));
        if (i + 1) % n == j || (j + 1) % n == i {
            // The other ends of neighbours must not lie on each other; for three corners both are shared.
            return if (i + 1) % n == j {
                !is_on(a, c, d) && !is_on(d, a, b)
            } else {
                !is_on(b, c, d) && !is_on(c, a, b)
            };
        }
        let crosses = area(a, b, c).signum() * area(a, b, d).signum() < 0
            && area(c, d, a).signum() * area(c, d, b).signum() < 0;
        !crosses && !is_on(a, c, d) && !is_on(b, c, d) && !is_on(c, a, b) && !is_on(d, a, b)
    };
    n > 3 && (0..n).all(|i| (0..i).all(|j| apart(i, j)))
}

/// Whether a point lies on an edge, its ends included.
fn is_on(p: Corner, a: Corner, b: Corner) -> bool {
    let between = |k: usize| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]);
    area(a, b, p) == 0 && between(0) && between(1)
}
