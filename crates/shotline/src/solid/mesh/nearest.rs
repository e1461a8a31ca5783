//! The distance from each point to the nearest other point, by a k-d tree (J. L. Bentley 1975).

use crate::math::{Vec3, length};

/// Points in the order of a k-d tree: the median of each range splits it, along cycling axes.
pub(super) struct Nearest<'a> {
    points: &'a [Vec3],
    order: Vec<u32>,
}

/// Ranges of at most this many points are searched linearly.
const FEW: usize = 8;

impl<'a> Nearest<'a> {
    pub(super) fn of(points: &'a [Vec3]) -> Nearest<'a> {
        let mut tree = Nearest { points, order: (0..).take(points.len()).collect() };
        let mut ranges = vec![(0..points.len(), 0)];
        while let Some((range, axis)) = ranges.pop() {
            if range.len() > FEW {
                let (start, half) = (range.start, range.len() / 2);
                let key = |i: &u32| points[*i as usize][axis];
                tree.order[range.clone()].select_nth_unstable_by(half, |i, j| key(i).total_cmp(&key(j)));
                ranges.extend([
                    (start..start + half, (axis + 1) % 3),
                    (start + half + 1..range.end, (axis + 1) % 3),
                ]);
            }
        }
        tree
    }

    /// Returns for each point the distance to the nearest other; infinite if there is only one point.
    pub(super) fn distances(&self) -> Vec<f64> {
        let of = |point: usize| {
            let mut best = f64::INFINITY;
            self.search(point, (0, self.order.len()), 0, &mut best);
            best
        };
        (0..self.points.len()).map(of).collect()
    }

    /// Searches a range for a nearer point. The recursion is as deep as a balanced tree.
    fn search(&self, point: usize, (start, end): (usize, usize), axis: usize, best: &mut f64) {
        let p = self.points[point];
        let mut meet = |i: u32| {
            if i as usize != point {
                *best = best.min(length(self.points[i as usize] - p));
            }
        };
        if end - start <= FEW {
            self.order[start..end].iter().for_each(|i| meet(*i));
            return;
        }
        let middle = start + (end - start) / 2;
        meet(self.order[middle]);
        let side = p[axis] - self.points[self.order[middle] as usize][axis];
        let (low, high) = ((start, middle), (middle + 1, end));
        let (near, far) = if side < 0.0 { (low, high) } else { (high, low) };
        let next = (axis + 1) % 3;
        self.search(point, near, next, best);
        if side.abs() <= *best {
            self.search(point, far, next, best);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn distances_are_those_of_all_pairs() {
        let mut random = Random::new(3);
        for n in [0, 1, 2, 9, 300] {
            for round in [false, true] {
                let point = |random: &mut Random| random.point(-4.0, 4.0);
                let points: Vec<Vec3> = (0..n)
                    .map(|_| if round { point(&mut random).round() } else { point(&mut random) })
                    .collect();
                let plainly = |i: usize| {
                    let others = (0..n).filter(|j| *j != i);
                    others.map(|j| length(points[j] - points[i])).fold(f64::INFINITY, f64::min)
                };
                let plain: Vec<f64> = (0..n).map(plainly).collect();
                assert_eq!(Nearest::of(&points).distances(), plain);
            }
        }
    }
}
