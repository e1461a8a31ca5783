//! Refitting to items that move: boxes are computed again from the leaves up, and the tree stays as it is.

use std::collections::BinaryHeap;

use super::{Bvh, Volume};
use crate::aabb::Aabb;
use crate::accel::prim_ref::BoundsClass;

/// A refit fails where the sum of the inner volumes' areas exceeds this multiple of the sum of the tree as built. The
/// number of volumes that a line meets is proportional to the sum, so at twice the sum a ray costs twice as much.
const MAX_AREA_GROWTH: f64 = 2.0;

/// Where an item is in the tree.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stored<P> {
    /// It is not in the tree: its box is empty.
    Not,
    At(P),
    Unbounded,
}

/// The links from items and nodes towards the root. The first refit computes them.
#[derive(Clone, Debug)]
pub(super) struct RefitData<P> {
    /// The parent of each node; unused for the root.
    pub(super) parents: Vec<P>,
    pub(super) items: Vec<Stored<P>>,
    /// The sum of the areas of all inner volumes: as built, and now.
    built: f64,
    pub(super) now: f64,
}

impl<P: Copy> RefitData<P> {
    /// The links of a tree in which nothing but the unbounded items has been entered; `bounded` are its other items, and
    /// `root` stands for all parents.
    pub(super) fn new<'a>(
        nodes: usize,
        root: P,
        bounded: impl Iterator<Item = &'a u32>,
        unbounded: &'a [u32],
    ) -> RefitData<P> {
        let count = bounded.chain(unbounded).max().map_or(0, |&last| last as usize + 1);
        let mut items = vec![Stored::Not; count];
        unbounded.iter().for_each(|&item| items[item as usize] = Stored::Unbounded);
        RefitData { parents: vec![root; nodes], items, built: 0.0, now: 0.0 }
    }

    /// Adds the area of a volume of the tree as built.
    pub(super) fn add_area(&mut self, area: f64) {
        self.built += area;
        self.now = self.built;
    }

    /// Where an item is, if it is in the tree and bounded.
    pub(super) fn place(&self, item: u32) -> Option<P> {
        match self.items.get(item as usize) {
            Some(Stored::At(place)) => Some(*place),
            _ => None,
        }
    }

    /// Whether the box of an item is of another [`BoundsClass`] than the one that it was built with.
    pub(super) fn is_misplaced(&self, item: u32, bounds: &Aabb) -> bool {
        let class = match self.items.get(item as usize) {
            None | Some(Stored::Not) => BoundsClass::Empty,
            Some(Stored::At(_)) => BoundsClass::Bounded,
            Some(Stored::Unbounded) => BoundsClass::Unbounded,
        };
        class != BoundsClass::of(bounds)
    }

    /// Whether the tree has not become too slow.
    pub(super) fn is_fast_enough(&self) -> bool {
        self.now <= MAX_AREA_GROWTH * self.built
    }

    pub(super) fn memory(&self) -> usize {
        size_of::<RefitData<P>>() + size_of_val(self.parents.as_slice()) + size_of_val(self.items.as_slice())
    }
}

/// The nodes whose volumes are to be computed again. Children have larger indices than their parents: taking the largest
/// index first computes each volume once.
#[derive(Debug, Default)]
pub(super) struct ChangedNodes(BinaryHeap<u32>);

impl ChangedNodes {
    pub(super) fn add(&mut self, node: u32) {
        self.0.push(node);
    }

    /// Takes the node with the largest index.
    pub(super) fn take_last(&mut self) -> Option<u32> {
        let last = self.0.pop()?;
        while self.0.peek() == Some(&last) {
            self.0.pop();
        }
        Some(last)
    }
}

impl RefitData<u32> {
    fn of<V: Volume>(bvh: &Bvh<V>) -> RefitData<u32> {
        let mut data = RefitData::new(bvh.nodes.len(), 0, bvh.items.iter(), &bvh.unbounded);
        for (index, node) in (0..).zip(&bvh.nodes) {
            if node.count == 0 {
                data.parents[node.first as usize..][..2].fill(index);
                data.add_area(node.bounds.area());
            } else {
                let items = bvh.leaf_items(node);
                items.iter().for_each(|&item| data.items[item as usize] = Stored::At(index));
            }
        }
        data
    }
}

impl<V: Volume> Bvh<V> {
    /// Computes the volumes above some items again. Returns `false` if the [`BoundsClass`] of an item has changed, or
    /// if the tree has become too slow.
    pub(super) fn refit_bounds(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut refit_data = self.refit_data.take().unwrap_or_else(|| Box::new(RefitData::of(self)));
        if items.iter().any(|&item| refit_data.is_misplaced(item, &boxes(item))) {
            return false;
        }
        let mut changed = ChangedNodes::default();
        items.iter().filter_map(|&item| refit_data.place(item)).for_each(|leaf| changed.add(leaf));
        while let Some(index) = changed.take_last() {
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
                changed.add(refit_data.parents[index as usize]);
            }
        }
        let is_fast_enough = refit_data.is_fast_enough();
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
