//! Which crossings on the boundary of a face the surface joins within it.

use crate::samples::Crossing;

/// With more crossings than this, each is joined with its neighbour: the search would take long, and the face is divided anyway.
const MOST: usize = 16;

/// The crossing that is joined with one of those around a face. They are in order, entering and leaving in turn. The lines that join
/// them do not cross each other, and of all such ways it is the one whose points and normals fit best.
pub fn paired(crossings: &[Crossing], one: usize) -> usize {
    let count = crossings.len();
    if count == 2 || count > MOST || !count.is_multiple_of(2) {
        return if one.is_multiple_of(2) { (one + 1) % count } else { one - 1 };
    }
    // The least misfit of each run of crossings, by its first one and its length, and the partner of its first one.
    let mut best = vec![[(0.0, 0); MOST + 1]; count + 1];
    for length in (2..=count).step_by(2) {
        for first in 0..=count - length {
            let ways = (1..length).step_by(2).map(|step| {
                let inner = best[first + 1][step - 1].0;
                let after = best[first + step + 1][length - step - 1].0;
                (misfit(&crossings[first], &crossings[first + step]) + inner + after, first + step)
            });
            best[first][length] = ways.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        }
    }
    partner(&best, 0, count, one)
}

/// The partner of one crossing in the best way to join a run.
fn partner(best: &[[(f64, usize); MOST + 1]], mut first: usize, mut length: usize, one: usize) -> usize {
    loop {
        let second = best[first][length].1;
        if one == first {
            return second;
        } else if one == second {
            return first;
        } else if one < second {
            (first, length) = (first + 1, second - first - 1);
        } else {
            (first, length) = (second + 1, first + length - second - 1);
        }
    }
}

/// How little two crossings look like points of one smooth surface: by the angle between their normals, and by the angles of
/// the line between them to both planes.
fn misfit(a: &Crossing, b: &Crossing) -> f64 {
    let between = (b.position - a.position).normalize_or_zero();
    let misfit = 1.0 - a.normal.dot(b.normal) + a.normal.dot(between).abs() + b.normal.dot(between).abs();
    // Where a normal is not known, all others fit as well.
    if misfit.is_nan() { 2.0 } else { misfit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shotline::math::Vec3;

    fn crossing(x: f64, y: f64, normal: Vec3, entering: bool) -> Crossing {
        Crossing { entering, position: Vec3::new(x, y, 0.0), normal }
    }

    /// The sides of a thin wall are joined along the wall, not across it.
    #[test]
    fn sides_of_a_wall_stay_apart() {
        let wall = [
            crossing(0.4, 0.0, -Vec3::X, true),
            crossing(0.41, 0.0, Vec3::X, false),
            crossing(0.41, 1.0, Vec3::X, true),
            crossing(0.4, 1.0, -Vec3::X, false),
        ];
        assert_eq!([0, 1, 2, 3].map(|one| paired(&wall, one)), [3, 2, 1, 0]);
        let mut turned = wall;
        turned.rotate_left(1);
        assert_eq!([0, 1, 2, 3].map(|one| paired(&turned, one)), [1, 0, 3, 2]);
    }

    /// Whatever the normals are, pairs are mutual and do not cross.
    #[test]
    fn pairs_are_mutual_and_do_not_cross() {
        let mut random = shotline::testkit::random::Random::new(7);
        for count in [2, 4, 6, 8, 12, 16, 18] {
            for _ in 0..50 {
                let all: Vec<Crossing> = (0..count)
                    .map(|i| Crossing {
                        entering: i % 2 == 0,
                        position: random.point(0.0, 1.0),
                        normal: random.direction(),
                    })
                    .collect();
                let partners: Vec<usize> = (0..count).map(|one| paired(&all, one)).collect();
                for (one, other) in partners.iter().enumerate() {
                    assert_eq!(partners[*other], one);
                    let (low, high) = (one.min(*other), one.max(*other));
                    assert!(
                        (low..high).filter(|i| (low..=high).contains(&partners[*i])).count() == high - low
                    );
                    assert_eq!((high - low) % 2, 1);
                }
            }
        }
    }
}
