//! Repairs crossing lists that do not alternate.
//!
//! Solids return lists that ascend and alternate in spite of rounding, and their conformance suite tests this. If a
//! list did not, the parity of everything after the fault would be wrong. So each list is checked. A broken list is
//! rebuilt from the membership of points between its crossings, and the repair is counted.

use crate::crossing::{Crossing, is_alternating};
use crate::ray::Line;
use crate::solid::Solid;

/// Repairs the crossings of a solid if necessary; returns whether it was necessary.
pub(super) fn repair(solid: &dyn Solid, line: &Line, list: &mut Vec<Crossing>) -> bool {
    if is_alternating(list) {
        return false;
    }
    list.retain(|c| !c.t.is_nan());
    list.sort_by(|a, b| a.t.total_cmp(&b.t));
    let ends: Vec<f64> = list.iter().skip(1).map(|c| c.t).collect();
    let mut ends = ends.into_iter();
    let mut inside = false;
    list.retain_mut(|crossing| {
        // An infinite end means that the interior is unbounded. After the last crossing the line is outside.
        let after = ends.next().is_some_and(|end| {
            let middle = 0.5 * crossing.t + 0.5 * end;
            middle.is_infinite() || solid.contains(line.at(middle))
        });
        let changes = after != inside;
        crossing.entering = after;
        inside = after;
        changes
    });
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aabb::Aabb;
    use crate::math::Vec3;

    /// Two slabs perpendicular to the x axis.
    #[derive(Debug)]
    struct Slabs;

    impl Solid for Slabs {
        fn bounds(&self) -> Aabb {
            Aabb::EVERYTHING
        }
        fn crossings(&self, _line: &Line, _out: &mut Vec<Crossing>) {}
        fn implicit(&self, _p: Vec3, _surface: u32, _primitive: u32) -> f64 {
            0.0
        }
        fn normal(&self, _p: Vec3, _surface: u32, _primitive: u32) -> Vec3 {
            Vec3::X
        }
        fn contains(&self, p: Vec3) -> bool {
            (1.0..2.0).contains(&p.x) || (3.0..4.0).contains(&p.x)
        }
        fn surfaces(&self) -> &'static [&'static str] {
            &["plane"]
        }
    }

    fn repaired(list: &[(f64, bool)]) -> (bool, Vec<(f64, bool)>) {
        let mut list: Vec<Crossing> = list.iter().map(|&(t, way)| Crossing::new(t, 0.0, way, 0)).collect();
        let needed = repair(&Slabs, &Line::exact(Vec3::ZERO, Vec3::X), &mut list);
        assert!(is_alternating(&list));
        (needed, list.iter().map(|c| (c.t, c.entering)).collect())
    }

    #[test]
    fn sound_lists_are_left_alone() {
        let list = [(1.0, true), (2.5, false)];
        assert_eq!(repaired(&list), (false, list.to_vec()));
    }

    #[test]
    fn broken_lists_follow_membership() {
        let right = vec![(1.0, true), (2.0, false), (3.0, true), (4.0, false)];
        // Out of order, one with the wrong direction, one duplicate, one NaN.
        let swapped = [(2.0, false), (1.0, true), (3.0, true), (4.0, false)];
        assert_eq!(repaired(&swapped), (true, right.clone()));
        let turned = [(1.0, true), (2.0, true), (3.0, true), (4.0, false), (f64::NAN, true)];
        assert_eq!(repaired(&turned), (true, right.clone()));
        let double = [(1.0, true), (1.5, true), (2.0, false), (3.0, true), (4.0, false)];
        assert_eq!(repaired(&double), (true, right));
        // A missing crossing cannot be recovered, but the crossings that remain alternate.
        assert_eq!(repaired(&[(1.0, true), (2.0, false), (3.0, true)]).1, [(1.0, true), (2.0, false)]);
    }
}
