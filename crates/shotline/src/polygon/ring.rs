//! The outline of a polygon of the plane, without corners that change nothing.

use std::collections::VecDeque;

use super::crossing;
use super::projection::{Point, is_clockwise, orientation, project, scaled};
use crate::math::Vec3;

/// The corners of a polygon that does not cross itself, counter-clockwise. No corner equals the next, none lies on a straight
/// edge, and no edge folds back on itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ring {
    pub corners: Vec<Point>,
}

/// Why points are not the corners of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RingError {
    /// They lie on a line.
    Flat,
    /// Two edges cross. Each is given by the indices of its ends.
    Crosses([[usize; 2]; 2]),
}

impl Ring {
    /// The polygon with the given corners, in either direction.
    pub fn of(corners: &[Point]) -> Result<Ring, RingError> {
        let wide: Vec<Vec3> = corners.iter().map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect();
        let points = project(&scaled(&wide), 2);
        let mut kept = without_straight_corners(&points);
        if kept.len() < 3 {
            return Err(RingError::Flat);
        }
        let outline: Vec<Point> = kept.iter().map(|i| points[*i]).collect();
        if let Some(edges) = crossing::find(&outline) {
            return Err(RingError::Crosses(edges.map(|i| [kept[i], kept[(i + 1) % kept.len()]])));
        }
        let order: Vec<u32> = (0..outline.len() as u32).collect();
        if is_clockwise(&outline, &order) {
            kept.reverse();
        }
        Ok(Ring { corners: kept.into_iter().map(|i| corners[i]).collect() })
    }

    /// The edges, in order.
    pub fn edges(&self) -> impl Iterator<Item = [Point; 2]> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(a, b)| [*a, *b])
    }
}

/// The indices of the corners at which a polygon turns.
fn without_straight_corners(points: &[Point]) -> Vec<usize> {
    let turns = |a: usize, b: usize, c: usize| orientation(points[a], points[b], points[c]) != 0.0;
    let mut kept: VecDeque<usize> = VecDeque::with_capacity(points.len());
    for i in 0..points.len() {
        loop {
            match kept.len() {
                n if n > 0 && points[kept[n - 1]] == points[i] => break,
                n if n > 1 && !turns(kept[n - 2], kept[n - 1], i) => drop(kept.pop_back()),
                _ => {
                    kept.push_back(i);
                    break;
                }
            }
        }
    }
    // The same where the end meets the beginning.
    while kept.len() > 2 {
        let n = kept.len();
        if points[kept[n - 1]] == points[kept[0]] || !turns(kept[n - 2], kept[n - 1], kept[0]) {
            kept.pop_back();
        } else if !turns(kept[n - 1], kept[0], kept[1]) {
            kept.pop_front();
        } else {
            break;
        }
    }
    kept.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_that_change_nothing_are_dropped() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let ring = Ring::of(&square).unwrap();
        assert_eq!(ring.corners, square);
        // Equal and straight corners, a spike, and corners to drop at both ends.
        let more = [
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 0.0],
            [2.0, 3.0],
            [2.0, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
            [0.0, 0.0],
            [1.0, 0.0],
        ];
        let mut found = Ring::of(&more).unwrap().corners;
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut expected = square.to_vec();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(found, expected);
        let backwards: Vec<Point> = square.iter().rev().copied().collect();
        assert_eq!(Ring::of(&backwards).unwrap().corners, square);
    }

    #[test]
    fn edges_that_cross_are_named_by_their_corners() {
        let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(Ring::of(&bow), Err(RingError::Crosses([[0, 1], [3, 4]])));
        // Through a corner: the edge from (0, 0) to (4, 0) has the corner (2, 0) in it.
        let through = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [2.0, 0.0], [1.0, -1.0], [0.0, -1.0]];
        assert!(matches!(Ring::of(&through), Err(RingError::Crosses(_))));
        // A corner that only touches an edge does not cross it.
        let touching = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
        assert_eq!(Ring::of(&touching).map(|ring| ring.corners.len()), Ok(5));
        for line in [&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]][..], &[[1.0, 1.0]; 4], &[]] {
            assert_eq!(Ring::of(line), Err(RingError::Flat));
        }
    }

    #[test]
    fn size_does_not_matter() {
        for scale in [1e-300, 1e-100, 1e100, 1e300] {
            let corners =
                [[0.0, 0.0], [3.0, 0.0], [1.0, 1.0], [0.0, 3.0]].map(|[x, y]| [x * scale, y * scale]);
            assert_eq!(Ring::of(&corners).map(|ring| ring.corners), Ok(corners.to_vec()));
        }
    }
}
