//! Refitting to items that move, as for the binary tree: boxes are computed again from the leaves up, and the tree stays
//! as it is.

use std::collections::BinaryHeap;

use super::super::refit::MAX_AREA_GROWTH;
use super::Bvh8;
use super::node::Node;
use crate::aabb::Aabb;
use crate::accel::prim_ref::BoundsClass;

/// A child, by its node and its slot there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    node: u32,
    slot: u32,
}

/// How an item is stored.
#[derive(Clone, Copy, Debug)]
enum Stored {
    Not,
    At(Place),
    Unbounded,
}

impl Stored {
    fn class(self) -> BoundsClass {
        match self {
            Stored::Not => BoundsClass::Empty,
            Stored::At(_) => BoundsClass::Bounded,
            Stored::Unbounded => BoundsClass::Unbounded,
        }
    }
}

/// The links from items and nodes towards the root. The first refit computes them.
#[derive(Clone, Debug)]
pub(super) struct RefitData {
    /// The place of each node; unused for the root.
    nodes: Vec<Place>,
    items: Vec<Stored>,
    /// The sum of the areas of all nodes but the root: as built, and now.
    built: f64,
    now: f64,
}

impl RefitData {
    fn of(bvh: &Bvh8) -> RefitData {
        let items = bvh.nodes.iter().flat_map(Node::items).chain(&bvh.unbounded);
        let count = items.max().map_or(0, |&last| last as usize + 1);
        let mut data = RefitData {
            nodes: vec![Place { node: 0, slot: 0 }; bvh.nodes.len()],
            items: vec![Stored::Not; count],
            built: 0.0,
            now: 0.0,
        };
        for (index, node) in (0..).zip(&bvh.nodes) {
            for (slot, &child) in (0..).zip(&node.children[..usize::from(node.count)]) {
                let place = Place { node: index, slot };
                if slot < u32::from(node.nodes) {
                    data.nodes[child as usize] = place;
                    data.built += node.child_box(slot as usize).half_area();
                } else {
                    data.items[child as usize] = Stored::At(place);
                }
            }
        }
        bvh.unbounded.iter().for_each(|&item| data.items[item as usize] = Stored::Unbounded);
        RefitData { now: data.built, ..data }
    }

    fn stored(&self, item: u32) -> Stored {
        self.items.get(item as usize).copied().unwrap_or(Stored::Not)
    }

    pub(super) fn memory(&self) -> usize {
        size_of::<RefitData>() + size_of_val(self.nodes.as_slice()) + size_of_val(self.items.as_slice())
    }
}

impl Bvh8 {
    /// Computes the boxes above some items again. Returns `false` if the [`BoundsClass`] of an item has changed, or if
    /// the tree has become too slow.
    pub(super) fn refit_boxes(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut data = self.refit_data.take().unwrap_or_else(|| Box::new(RefitData::of(self)));
        if items.iter().any(|&item| data.stored(item).class() != BoundsClass::of(&boxes(item))) {
            return false;
        }
        // The nodes that hold a box that has changed.
        let mut changed = BinaryHeap::new();
        for &item in items {
            if let Stored::At(Place { node, slot }) = data.stored(item) {
                self.nodes[node as usize].set_box(slot as usize, &boxes(item));
                changed.push(node);
            }
        }
        // Children have larger indices than their parents. Taking the largest index first computes each box once.
        while let Some(index) = changed.pop() {
            while changed.peek() == Some(&index) {
                changed.pop();
            }
            if index == 0 {
                break;
            }
            let bounds = self.nodes[index as usize].bounds();
            let Place { node, slot } = data.nodes[index as usize];
            let parent = &mut self.nodes[node as usize];
            let old = parent.child_box(slot as usize);
            if bounds != old {
                parent.set_box(slot as usize, &bounds);
                data.now += bounds.half_area() - old.half_area();
                changed.push(node);
            }
        }
        let is_fast_enough = data.now <= MAX_AREA_GROWTH * data.built;
        self.refit_data = Some(data);
        is_fast_enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn small_motions_are_followed_exactly() {
        let mut random = Random::new(3);
        let mut boxes: Vec<Aabb> =
            (0..500).map(|_| random.point(-1.0, 1.0)).map(|p| Aabb::new(p, p + 0.05)).collect();
        let mut bvh = Bvh8::binned_sah(&boxes);
        for round in 0..20 {
            let moved: Vec<u32> = (0..=round * round).map(|_| random.below(boxes.len()) as u32).collect();
            for &item in &moved {
                let (b, step) = (boxes[item as usize], random.point(-0.01, 0.01));
                boxes[item as usize] = Aabb::new(b.min + step, b.max + step);
            }
            assert!(bvh.refit_boxes(&moved, &|item| boxes[item as usize]));
            for node in &bvh.nodes {
                for slot in 0..usize::from(node.count) {
                    let child = node.children[slot] as usize;
                    let is_node = slot < usize::from(node.nodes);
                    let expected = if is_node { bvh.nodes[child].bounds() } else { boxes[child] };
                    assert_eq!(node.child_box(slot), expected);
                }
            }
            let data = bvh.refit_data.as_ref().expect("a tree that was refitted");
            let sum = RefitData::of(&bvh).now;
            assert!((data.now - sum).abs() <= 1e-12 * sum, "{} {sum}", data.now);
        }
        // Items that fly apart.
        boxes.iter_mut().for_each(|b| *b = Aabb::new(b.min * 9.0, b.min * 9.0 + random.point(0.0, 9.0)));
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        assert!(!bvh.refit_boxes(&all, &|item| boxes[item as usize]));
    }
}
