//! Following items that move: boxes are worked out anew from the leaf up, until one stays as it is.
//!
//! The tree keeps its shape, so answers stay exact, but boxes grow and overlap where items have moved apart. The
//! sum of their areas, which the expected cost of a ray grows with (Goldsmith and Salmon 1987), is watched; when
//! it has doubled the tree is to be built anew.

use super::{Bvh, Node};
use crate::aabb::Aabb;
use crate::accel::bounded::is_bounded;

/// How much the areas may grow.
const WORN: f64 = 2.0;

/// The way from items and nodes up. Worked out when something first moves.
#[derive(Debug)]
pub(super) struct Upward {
    /// By node.
    parents: Vec<u32>,
    /// By item.
    leaves: Vec<u32>,
    area: f64,
    built_area: f64,
}

/// The parent of the root, and the leaf of an item that is in none.
const NONE: u32 = u32::MAX;

impl Upward {
    fn of(bvh: &Bvh) -> Upward {
        let items = bvh.items.iter().max().map_or(0, |&i| i as usize + 1);
        let (mut parents, mut leaves) = (vec![NONE; bvh.nodes.len()], vec![NONE; items]);
        for (i, node) in (0..).zip(&bvh.nodes) {
            if node.count == 0 {
                parents[node.first as usize] = i;
                parents[node.first as usize + 1] = i;
            } else {
                bvh.leaf_items(node).iter().for_each(|&item| leaves[item as usize] = i);
            }
        }
        let area = bvh.nodes.iter().map(|node| node.bounds.half_area()).sum();
        Upward { parents, leaves, area, built_area: area }
    }
}

/// See [`Accelerator::refit`](crate::accel::Accelerator::refit).
pub(super) fn refit(bvh: &mut Bvh, moved: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
    let mut upward = bvh.upward.take().unwrap_or_else(|| Box::new(Upward::of(bvh)));
    for &item in moved {
        let leaf = upward.leaves.get(item as usize).copied().unwrap_or(NONE);
        if leaf == NONE || !is_bounded(&boxes(item)) {
            return false;
        }
        let mut node = leaf;
        while node != NONE {
            let old = bvh.nodes[node as usize];
            let bounds = contents(bvh, &old, boxes);
            if bounds == old.bounds {
                break;
            }
            upward.area += bounds.half_area() - old.bounds.half_area();
            bvh.nodes[node as usize].bounds = bounds;
            node = upward.parents[node as usize];
        }
    }
    let good = upward.area <= WORN * upward.built_area;
    bvh.upward = Some(upward);
    good
}

/// The box around what a node holds.
fn contents(bvh: &Bvh, node: &Node, boxes: &dyn Fn(u32) -> Aabb) -> Aabb {
    if node.count == 0 {
        let child = |i: u32| &bvh.nodes[(node.first + i) as usize].bounds;
        return child(0).union(child(1));
    }
    bvh.leaf_items(node).iter().fold(Aabb::EMPTY, |all, &item| all.union(&boxes(item)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Accelerator;
    use crate::math::Vec3;
    use crate::testkit::random::Random;

    #[test]
    fn boxes_are_those_worked_out_from_all_items() {
        let mut random = Random::new(4);
        let mut boxes: Vec<Aabb> =
            (0..500).map(|_| random.point(-1.0, 1.0)).map(|p| Aabb::new(p, p + Vec3::splat(0.02))).collect();
        let mut bvh = Bvh::build(&boxes);
        for _ in 0..50 {
            let moved: Vec<u32> = (0..1 + random.below(4)).map(|_| random.below(500) as u32).collect();
            for &item in &moved {
                let by = random.point(-0.05, 0.05);
                let old = boxes[item as usize];
                boxes[item as usize] = Aabb::new(old.min + by, old.max + by);
            }
            assert!(bvh.refit(&moved, &|i| boxes[i as usize]));
        }
        for node in (0..bvh.nodes.len()).rev() {
            let node = bvh.nodes[node];
            assert_eq!(node.bounds, contents(&bvh, &node, &|i| boxes[i as usize]));
        }
    }

    #[test]
    fn a_worn_tree_and_items_without_end_ask_to_be_built_anew() {
        let row: Vec<Aabb> =
            (0..50).map(|i| Vec3::X * f64::from(i)).map(|p| Aabb::new(p, p + Vec3::ONE)).collect();
        let far = Aabb::new(Vec3::splat(1e6), Vec3::splat(2e6));
        for (change, good) in [(row[3], true), (far, false), (Aabb::EVERYTHING, false), (Aabb::EMPTY, false)]
        {
            let boxes = |i: u32| if i == 3 { change } else { row[i as usize] };
            assert_eq!(Bvh::build(&row).refit(&[3], &boxes), good);
        }
    }
}
