//! Refitting to items that move, as for the binary tree: boxes are computed again from the leaves up, and the tree stays
//! as it is.

use super::super::refit::{ChangedNodes, RefitData, Stored};
use super::Bvh8;
use super::node::Node;
use crate::aabb::Aabb;

/// A child, by its node and its slot there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    node: u32,
    slot: u32,
}

impl RefitData<Slot> {
    fn of(bvh: &Bvh8) -> RefitData<Slot> {
        let items = bvh.nodes.iter().flat_map(Node::items);
        let mut data = RefitData::new(bvh.nodes.len(), Slot { node: 0, slot: 0 }, items, &bvh.unbounded);
        for (index, node) in (0..).zip(&bvh.nodes) {
            for (slot, &child) in (0..).zip(&node.children[..usize::from(node.count)]) {
                let place = Slot { node: index, slot };
                if slot < u32::from(node.nodes) {
                    data.parents[child as usize] = place;
                    data.add_area(node.child_box(slot as usize).half_area());
                } else {
                    data.items[child as usize] = Stored::At(place);
                }
            }
        }
        data
    }
}

impl Bvh8 {
    /// Computes the boxes above some items again. Returns `false` if the class of the bounds of an item has changed, or if
    /// the tree has become too slow.
    pub(super) fn refit_boxes(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut data = self.refit_data.take().unwrap_or_else(|| Box::new(RefitData::of(self)));
        if items.iter().any(|&item| data.is_misplaced(item, &boxes(item))) {
            return false;
        }
        // The nodes that hold a box that has changed.
        let mut changed = ChangedNodes::default();
        for &item in items {
            if let Some(Slot { node, slot }) = data.place(item) {
                self.nodes[node as usize].set_box(slot as usize, &boxes(item));
                changed.add(node);
            }
        }
        while let Some(index) = changed.take_last() {
            if index == 0 {
                break;
            }
            let bounds = self.nodes[index as usize].bounds();
            let Slot { node, slot } = data.parents[index as usize];
            let parent = &mut self.nodes[node as usize];
            let old = parent.child_box(slot as usize);
            if bounds != old {
                parent.set_box(slot as usize, &bounds);
                data.now += bounds.half_area() - old.half_area();
                changed.add(node);
            }
        }
        let is_fast_enough = data.is_fast_enough();
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
