//! Following items that move: boxes are worked out again from the leaf up, and the tree stays as it is.

use std::collections::BinaryHeap;

use super::{Bvh, Volume};
use crate::aabb::Aabb;
use crate::accel::bounded::Kind;

/// The sum of the inner volumes' areas, beside what it was when built, at which a tree is given up. The sum is
/// what lines through the scene meet boxes in proportion to, so at twice the sum a ray costs twice as much.
const WORST: f64 = 2.0;

/// In place of a leaf: for items kept aside, and for empty ones.
const ASIDE: u32 = u32::MAX;
const NOWHERE: u32 = u32::MAX - 1;

/// The way up, worked out when it is first needed.
#[derive(Clone, Debug)]
pub(super) struct Links {
    /// Of each node; the root has none.
    parents: Vec<u32>,
    /// The leaf of each item.
    leaves: Vec<u32>,
    /// Areas of all inner volumes, added up: as built, and now.
    built: f64,
    now: f64,
}

impl Links {
    fn of<V: Volume>(bvh: &Bvh<V>) -> Links {
        let count = bvh.items.iter().chain(&bvh.unbounded).max().map_or(0, |&last| last as usize + 1);
        let (mut parents, mut leaves) = (vec![0; bvh.nodes.len()], vec![NOWHERE; count]);
        let mut built = 0.0;
        for (index, node) in (0..).zip(&bvh.nodes) {
            if node.count == 0 {
                parents[node.first as usize..][..2].fill(index);
                built += node.bounds.area();
            } else {
                bvh.leaf_items(node).iter().for_each(|&item| leaves[item as usize] = index);
            }
        }
        bvh.unbounded.iter().for_each(|&item| leaves[item as usize] = ASIDE);
        Links { parents, leaves, built, now: built }
    }

    /// The leaf of an item; `None` where there is none.
    fn leaf(&self, item: u32) -> Option<u32> {
        self.leaves.get(item as usize).copied().filter(|&leaf| leaf < NOWHERE)
    }

    fn kind(&self, item: u32) -> Kind {
        match self.leaves.get(item as usize) {
            None | Some(&NOWHERE) => Kind::Empty,
            Some(&ASIDE) => Kind::Unbounded,
            Some(_) => Kind::Bounded,
        }
    }

    pub(super) fn memory(&self) -> usize {
        size_of::<Links>() + size_of_val(self.parents.as_slice()) + size_of_val(self.leaves.as_slice())
    }
}

impl<V: Volume> Bvh<V> {
    /// Works out the boxes above some items again. `false` if one of them belongs elsewhere now, or if the
    /// tree has become bad.
    pub(super) fn follow(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut links = self.links.take().unwrap_or_else(|| Box::new(Links::of(self)));
        if items.iter().any(|&item| links.kind(item) != Kind::of(&boxes(item))) {
            return false;
        }
        let mut changed: BinaryHeap<u32> = items.iter().filter_map(|&item| links.leaf(item)).collect();
        // Children come behind their parents: the last first, and each box is worked out once.
        while let Some(index) = changed.pop() {
            while changed.peek() == Some(&index) {
                changed.pop();
            }
            let bounds = self.around(index, boxes);
            let node = &mut self.nodes[index as usize];
            let old = std::mem::replace(&mut node.bounds, bounds);
            if bounds == old {
                continue;
            }
            if node.count == 0 {
                links.now += bounds.area() - old.area();
            }
            if index > 0 {
                changed.push(links.parents[index as usize]);
            }
        }
        let follows = links.now <= WORST * links.built;
        self.links = Some(links);
        follows
    }

    /// The volume around what a node holds.
    pub(super) fn around(&self, index: u32, boxes: &dyn Fn(u32) -> Aabb) -> V {
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
        let mut bvh = Bvh::balanced(&boxes);
        let built = bvh.memory();
        for round in 0..20 {
            let moved: Vec<u32> = (0..=round * round).map(|_| random.below(boxes.len()) as u32).collect();
            for &item in &moved {
                shift(&mut boxes[item as usize], random.point(-0.01, 0.01));
            }
            let boxes = |item: u32| boxes[item as usize];
            assert!(bvh.refit(&moved, &boxes));
            let bottom_up = |index| bvh.around(index, &boxes);
            assert!((0..).zip(&bvh.nodes).all(|(index, node)| node.bounds == bottom_up(index)));
            let links = bvh.links.as_ref().expect("a tree that was refitted");
            let sum = Links::of(&bvh).now;
            assert!((links.now - sum).abs() <= 1e-12 * sum, "{} {sum}", links.now);
        }
        assert!(bvh.memory() > built);
    }

    #[test]
    fn a_tree_that_has_become_bad_is_given_up() {
        let mut random = Random::new(4);
        let mut boxes = cloud(&mut random);
        let mut bvh = Bvh::balanced(&boxes);
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
            let mut bvh = Bvh::balanced(&boxes);
            assert!(bvh.refit(&[0, 1], &|item| boxes[item as usize]));
            boxes[1] = to;
            assert!(!bvh.refit(&[1], &|item| boxes[item as usize]));
        }
    }
}
