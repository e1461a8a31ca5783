//! Tests whether boxes are disjoint.

use std::ops::Range;

use crate::aabb::Aabb;

/// Up to this many boxes are compared pairwise where no axis-aligned plane separates them.
const FEW: usize = 32;

/// Half-ulps of its coordinates by which rounding may enlarge a box, so that boxes of solids that touch overlap.
const PADDING: f64 = 32.0;

/// Whether no two boxes overlap by more than rounding; boxes that touch are disjoint.
///
/// Groups are cut by axis-aligned planes until each holds one box or few. The result is conservative: it is `false` for
/// larger groups that no plane cuts, even if their boxes are disjoint.
pub(super) fn are_disjoint(mut boxes: Vec<Aabb>) -> bool {
    boxes.iter_mut().for_each(|b| *b = b.widened(-PADDING));
    // Each cut sorts a group. This budget is enough for grids and rows, and ends what would take too long.
    let mut budget = 64 * boxes.len();
    let mut groups: Vec<Range<usize>> = std::iter::once(0..boxes.len()).collect();
    while let Some(group) = groups.pop() {
        let cut = (0..3).any(|axis| {
            budget = budget.saturating_sub(group.len());
            let pieces = pieces(&mut boxes[group.clone()], axis);
            let is_cut = pieces.len() > 1;
            if is_cut {
                groups.extend(pieces.iter().map(|piece| group.start + piece.start..group.start + piece.end));
            }
            is_cut
        });
        if budget == 0 && !group.is_empty() || !cut && !each_disjoint(&boxes[group]) {
            return false;
        }
    }
    true
}

/// Sorts boxes along an axis, and cuts them at each perpendicular plane that meets none of them.
fn pieces(boxes: &mut [Aabb], axis: usize) -> Vec<Range<usize>> {
    boxes.sort_by(|a, b| a.min[axis].total_cmp(&b.min[axis]));
    let (mut pieces, mut start, mut reach) = (Vec::new(), 0, f64::NEG_INFINITY);
    for (i, b) in boxes.iter().enumerate() {
        if b.min[axis] >= reach && i > start {
            pieces.push(start..i);
            start = i;
        }
        reach = reach.max(b.max[axis]);
    }
    pieces.push(start..boxes.len());
    pieces
}

/// Whether there are at most [`FEW`] boxes and they are pairwise disjoint.
fn each_disjoint(boxes: &[Aabb]) -> bool {
    let overlap = |a: &Aabb, b: &Aabb| a.min.cmplt(b.max).all() && b.min.cmplt(a.max).all();
    boxes.len() <= FEW && (0..boxes.len()).all(|i| boxes[..i].iter().all(|b| !overlap(b, &boxes[i])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::testkit::random::Random;

    fn cube(at: Vec3, size: f64) -> Aabb {
        Aabb::new(at, at + Vec3::splat(size))
    }

    #[test]
    fn grids_that_touch_are_apart_wherever_they_are() {
        for away in [0.0, 1e6 + 0.1] {
            let at = |i: usize| Vec3::new((i % 20) as f64, (i / 20 % 20) as f64, (i / 400) as f64) * 0.1;
            let grid = |size: f64| (0..8000).map(|i| cube(at(i) + Vec3::splat(away), size)).collect();
            assert!(are_disjoint(grid(0.1)), "{away}");
            assert!(!are_disjoint(grid(0.100001)), "{away}");
        }
    }

    #[test]
    fn a_pinwheel_is_apart_though_no_plane_cuts_it() {
        let wall =
            |x0: f64, y0: f64, x1: f64, y1: f64| Aabb::new(Vec3::new(x0, y0, 0.0), Vec3::new(x1, y1, 1.0));
        let wheel = [wall(0., 0., 2., 1.), wall(2., 0., 3., 2.), wall(1., 2., 3., 3.), wall(0., 1., 1., 3.)];
        assert!(are_disjoint(wheel.to_vec()));
        assert!(!are_disjoint([&wheel[..], &[wall(0.5, 0.5, 1.5, 1.5)]].concat()));
        assert!(are_disjoint(vec![]) && are_disjoint(vec![wheel[0]]));
    }

    #[test]
    fn random_boxes_agree_with_all_pairs() {
        let mut random = Random::new(3);
        for size in [0.02, 0.1, 0.3] {
            for _ in 0..50 {
                let boxes: Vec<Aabb> = (0..12).map(|_| cube(random.point(0.0, 1.0), size)).collect();
                assert_eq!(are_disjoint(boxes.clone()), each_disjoint(&boxes));
            }
        }
    }

    #[test]
    fn stairs_end_soon() {
        // Each overlaps only the next, so no plane separates any.
        let stairs = (0..20_000).map(|i| cube(Vec3::splat(f64::from(i)), 1.5)).collect();
        assert!(!are_disjoint(stairs));
    }
}
