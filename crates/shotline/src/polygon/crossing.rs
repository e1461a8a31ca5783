//! Where a polygon crosses itself.

use super::projection::{Point, orientation};

/// Two edges, by the corners at which they begin, that cross each other in the interior of both, or of which one passes
/// through the other at one of its corners. Edges that only touch do not cross.
pub(super) fn find(points: &[Point]) -> Option<[usize; 2]> {
    let n = points.len();
    let edge = |i: usize| [points[i], points[(i + 1) % n]];
    let range = |i: usize| {
        let [a, b] = edge(i);
        [a[1].min(b[1]), a[1].max(b[1])]
    };
    // A sweep in the direction of y, so that only edges whose heights overlap are compared.
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|i, j| range(*i)[0].total_cmp(&range(*j)[0]));
    let mut active: Vec<usize> = Vec::new();
    for i in order {
        active.retain(|j| range(*j)[1] >= range(i)[0]);
        let crosses =
            |j: &&usize| is_proper(edge(i), edge(**j)) || passes(points, i, **j) || passes(points, **j, i);
        if let Some(j) = active.iter().find(crosses) {
            return Some([i.min(*j), i.max(*j)]);
        }
        active.push(i);
    }
    None
}

/// Whether two edges cross in the interior of both.
fn is_proper([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let opposite = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    opposite(orientation(a, b, c), orientation(a, b, d))
        && opposite(orientation(c, d, a), orientation(c, d, b))
}

/// Whether the polygon passes through the interior of an edge at the corner at which another begins.
fn passes(points: &[Point], edge: usize, corner: usize) -> bool {
    let n = points.len();
    let [a, b] = [points[edge], points[(edge + 1) % n]];
    let [before, at, after] = [corner + n - 1, corner, corner + 1].map(|i| points[i % n]);
    let between = |k: usize| (a[k] < at[k] && at[k] < b[k]) || (b[k] < at[k] && at[k] < a[k]);
    (between(0) || between(1))
        && orientation(a, b, at) == 0.0
        && orientation(a, b, before) * orientation(a, b, after) < 0.0
}
