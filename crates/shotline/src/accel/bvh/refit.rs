//! Refitting to items that move: boxes are computed again from the leaves up, and the tree stays as it is.

use std::collections::BinaryHeap;

use super::{Bvh, Volume};
use crate::aabb::Aabb;
use crate::accel::prim_ref::BoundsClass;

/// A refit fails where the sum of the inner volumes' areas exceeds this multiple of the sum of the tree as built. The
/// number of volumes that a line meets is proportional to the sum, so at twice the sum a ray costs twice as much.
pub(super) const MAX_AREA_GROWTH: f64 = 2.0;

/// Used in place of a leaf's index, for unbounded items and for items with an empty box.
const UNBOUNDED: u32 = u32::MAX;
const EMPTY: u32 = u32::MAX - 1;

/// The links from items and nodes towards the root. The first refit computes them.
#[derive(Clone, Debug)]
pub(super) struct RefitData {
    /// The parent of each node; unused for the root.
    parents: Vec<u32>,
    /// The leaf of each item.
    leaves: Vec<u32>,
    /// The sum of the areas of all inner volumes: as built, and now.
    built: f64,
    now: f64,
}

impl RefitData {
    fn of<V: Volume>(bvh: &Bvh<V>) -> RefitData {
        let count = bvh.items.iter().chain(&bvh.unbounded).max().map_or(0, |&last| last as usize + 1);
        let (mut parents, mut leaves) = (vec![0; bvh.nodes.len()], vec![EMPTY; count]);
        let mut built = 0.0;
        for (index, node) in (0..).zip(&bvh.nodes) {
            if node.count == 0 {
                parents[node.first as usize..][..2].fill(index);
                built += node.bounds.area();
            } else {
                bvh.leaf_items(node).iter().for_each(|&item| leaves[item as usize] = index);
            }
        }
        bvh.unbounded.iter().for_each(|&item| leaves[item as usize] = UNBOUNDED);
        RefitData { parents, leaves, built, now: built }
    }

    /// The leaf of an item; `None` if it is in no leaf.
    fn leaf(&self, item: u32) -> Option<u32> {
        self.leaves.get(item as usize).copied().filter(|&leaf| leaf < EMPTY)
    }

    fn kind(&self, item: u32) -> BoundsClass {
        match self.leaves.get(item as usize) {
            None | Some(&EMPTY) => BoundsClass::Empty,
            Some(&UNBOUNDED) => BoundsClass::Unbounded,
            Some(_) => BoundsClass::Bounded,
        }
    }

    pub(super) fn memory(&self) -> usize {
        size_of::<RefitData>() + size_of_val(self.parents.as_slice()) + size_of_val(self.leaves.as_slice())
    }
}

impl<V: Volume> Bvh<V> {
    /// Computes the volumes above some items again. Returns `false` if the [`BoundsClass`] of an item has changed, or
    /// if the tree has become too slow.
    pub(super) fn refit_bounds(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut refit_data = self.refit_data.take().unwrap_or_else(|| Box::new(RefitData::of(self)));
        if items.iter().any(|&item| refit_data.kind(item) != BoundsClass::of(&boxes(item))) {
            return false;
        }
        let mut changed: BinaryHeap<u32> = items.iter().filter_map(|&item| refit_data.leaf(item)).collect();
        // Children have larger indices than their parents. Taking the largest index first computes each volume once.
        while let Some(index) = changed.pop() {
            while changed.peek() == Some(&index) {
                changed.pop();
            }
            let bounds = self.node_bounds(index, boxes);
            let node = &mut self.nodes[index as usize];
            let old = std::mem::replace(&mut node.bounds, bounds);
            if bounds == old {
                continue;
            }
            if node.count == 0 {
                refit_data.now += bounds.area() - old.area();
            }
            if index > 0 {
                changed.push(refit_data.parents[index as usize]);
            }
        }
        let is_fast_enough = refit_data.now <= MAX_AREA_GROWTH * refit_data.built;
        self.refit_data = Some(refit_data);
        is_fast_enough
    }

    /// The volume around the children or the items of a node.
    pub(super) fn node_bounds(&self, index: u32, boxes: &dyn Fn(u32) -> Aabb) -> V {
        let node = &self.nodes[index as usize];
        if node.count > 0 {
            V::around(self.leaf_items(node).iter().map(|&item| boxes(item)))
        } else {
            let child = |i: u32| &self.nodes[i as usize].bounds;
            child(node.first).union(child(node.first + 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Accelerator;
    use crate::math::Vec3;
    use crate::testkit::random::Random;

    fn cloud(random: &mut Random) -> Vec<Aabb> {
        let mut one = || random.point(-1.0, 1.0);
        (0..500).map(|_| one()).map(|p| Aabb::new(p, p + Vec3::splat(0.05))).collect()
    }

    fn shift(b: &mut Aabb, by: Vec3) {
        *b = Aabb::new(b.min + by, b.max + by);
    }

    #[test]
    fn small_motions_are_followed_exactly() {
        let mut random = Random::new(3);
        let mut boxes = cloud(&mut random);
        let mut bvh = Bvh::binned_sah(&boxes);
        let built = bvh.memory();
        for round in 0..20 {
            let moved: Vec<u32> = (0..=round * round).map(|_| random.below(boxes.len()) as u32).collect();
            for &item in &moved {
                shift(&mut boxes[item as usize], random.point(-0.01, 0.01));
            }
            let boxes = |item: u32| boxes[item as usize];
            assert!(bvh.refit(&moved, &boxes));
            let bottom_up = |index| bvh.node_bounds(index, &boxes);
            assert!((0..).zip(&bvh.nodes).all(|(index, node)| node.bounds == bottom_up(index)));
            let refit_data = bvh.refit_data.as_ref().expect("a tree that was refitted");
            let sum = RefitData::of(&bvh).now;
            assert!((refit_data.now - sum).abs() <= 1e-12 * sum, "{} {sum}", refit_data.now);
        }
        assert!(bvh.memory() > built);
    }

    #[test]
    fn a_tree_that_has_become_bad_is_given_up() {
        let mut random = Random::new(4);
        let mut boxes = cloud(&mut random);
        let mut bvh = Bvh::binned_sah(&boxes);
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        boxes.iter_mut().for_each(|b| shift(b, random.point(-1.0, 1.0)));
        assert!(!bvh.refit(&all, &|item| boxes[item as usize]));
    }

    #[test]
    fn items_do_not_change_their_kind() {
        for (from, to) in [
            (Aabb::EVERYTHING, Aabb::EMPTY),
            (Aabb::EMPTY, Aabb::EVERYTHING),
            (Aabb::new(Vec3::ZERO, Vec3::ONE), Aabb::EVERYTHING),
            (Aabb::EMPTY, Aabb::new(Vec3::ZERO, Vec3::ONE)),
        ] {
            let mut boxes = vec![Aabb::new(Vec3::ZERO, Vec3::ONE), from];
            let mut bvh = Bvh::binned_sah(&boxes);
            assert!(bvh.refit(&[0, 1], &|item| boxes[item as usize]));
            boxes[1] = to;
            assert!(!bvh.refit(&[1], &|item| boxes[item as usize]));
        }
    }
}
