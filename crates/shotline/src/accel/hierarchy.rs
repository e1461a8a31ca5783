//! The user's own hierarchy: there is a box around each group of the scene graph and each operation of a combination
//! (Clark 1976, "Hierarchical geometric models for visible surface algorithms"; Rubin and Whitted 1980).

use std::collections::BinaryHeap;
use std::ops::Range;

use super::bvh::Bvh;
use super::{Accelerator, Child, Items, QueueEntry, display};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::outline::Outline;

/// A group that the user made, with the box around it.
#[derive(Clone, Debug)]
struct Group {
    bounds: Aabb,
    /// Index of its first member. Its members are adjacent.
    first: u32,
    count: u32,
    /// Index of the enclosing group; unused for the first group.
    parent: u32,
}

#[derive(Clone, Copy, Debug)]
enum Member {
    Item(u32),
    Group(u32),
}

/// The innermost group of an item, and whether the item's box is empty.
#[derive(Clone, Copy, Debug, Default)]
struct ItemGroup {
    group: u32,
    is_empty: bool,
}

/// The tree of groups.
#[derive(Clone, Debug)]
struct Hierarchy {
    /// Outer groups come before inner ones; the first contains all items.
    groups: Vec<Group>,
    members: Vec<Member>,
    item_groups: Vec<ItemGroup>,
}

/// Builds the hierarchy, or a BVH where there are no groups, as in a mesh.
pub(super) fn build(items: Items) -> Box<dyn Accelerator> {
    match items.groups {
        Some(groups) => Box::new(Hierarchy::build(items.boxes, groups)),
        None => Box::new(Bvh::binned_sah(items.boxes)),
    }
}

impl Hierarchy {
    fn build(boxes: &[Aabb], groups: &[Range<u32>]) -> Hierarchy {
        let everything = 0..boxes.len() as u32;
        // A group of one item, or with the same items as the enclosing group, adds nothing.
        let inner = groups.iter().filter(|r| r.len() > 1 && **r != everything);
        let mut ranges: Vec<Range<u32>> = std::iter::once(&everything).chain(inner).cloned().collect();
        ranges.dedup();
        let next_siblings = next_siblings(&ranges);
        let mut tree = Hierarchy {
            groups: Vec::new(),
            members: Vec::new(),
            item_groups: vec![ItemGroup::default(); boxes.len()],
        };
        let mut parents = vec![0; ranges.len()];
        for (index, range) in ranges.iter().enumerate() {
            let first = tree.members.len() as u32;
            let (mut item, mut child) = (range.start, index + 1);
            while item < range.end {
                if ranges.get(child).is_some_and(|r| r.start == item) {
                    parents[child] = index as u32;
                    tree.members.push(Member::Group(child as u32));
                    (item, child) = (ranges[child].end, next_siblings[child]);
                } else {
                    tree.members.push(Member::Item(item));
                    tree.item_groups[item as usize].group = index as u32;
                    item += 1;
                }
            }
            let count = tree.members.len() as u32 - first;
            tree.groups.push(Group { bounds: Aabb::EMPTY, first, count, parent: parents[index] });
        }
        for (item_group, b) in tree.item_groups.iter_mut().zip(boxes) {
            item_group.is_empty = b.is_empty();
        }
        for index in (0..tree.groups.len()).rev() {
            tree.groups[index].bounds = tree.group_bounds(index, &|item| boxes[item as usize]);
        }
        tree
    }

    fn members(&self, group: usize) -> &[Member] {
        let Group { first, count, .. } = self.groups[group];
        &self.members[first as usize..][..count as usize]
    }

    /// The box around the members of a group.
    fn group_bounds(&self, group: usize, boxes: &dyn Fn(u32) -> Aabb) -> Aabb {
        let bounds = |member: &Member| match *member {
            Member::Item(item) => Some(boxes(item)).filter(|b| !b.is_empty()),
            Member::Group(group) => Some(self.groups[group as usize].bounds),
        };
        self.members(group).iter().filter_map(bounds).fold(Aabb::EMPTY, |all, b| all.union(&b))
    }

    /// Queues a group if the ray meets its box.
    fn push_group(&self, group: u32, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        counters.boxes += 1;
        if let Some((t, _)) = ray.enter_exit(&self.groups[group as usize].bounds) {
            out.push(QueueEntry { t, child: Child::Node(u64::from(group)) });
        }
    }
}

/// For each range, the index of the next range that does not lie in it.
fn next_siblings(ranges: &[Range<u32>]) -> Vec<usize> {
    let mut next_siblings = vec![ranges.len(); ranges.len()];
    for index in (0..ranges.len()).rev() {
        let mut next = index + 1;
        while ranges.get(next).is_some_and(|r| r.start < ranges[index].end) {
            next = next_siblings[next];
        }
        next_siblings[index] = next;
    }
    next_siblings
}

impl Accelerator for Hierarchy {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        self.push_group(0, ray, out, counters);
    }

    /// A node is a group. Its items get the bound of the group; the caller tests their own boxes.
    fn expand(&self, node: u64, t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        for &member in self.members(node as usize) {
            match member {
                Member::Group(group) => self.push_group(group, ray, out, counters),
                Member::Item(item) if self.item_groups[item as usize].is_empty => {}
                Member::Item(item) => out.push(QueueEntry { t, child: Child::Item(item) }),
            }
        }
    }

    /// Always succeeds: the groups do not depend on where their members are.
    fn refit(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        let mut changed = BinaryHeap::new();
        for &item in items {
            let item_group = &mut self.item_groups[item as usize];
            item_group.is_empty = boxes(item).is_empty();
            changed.push(item_group.group);
        }
        // Inner groups have larger indices than outer ones. Taking the largest index first computes each box once.
        while let Some(index) = changed.pop() {
            while changed.peek() == Some(&index) {
                changed.pop();
            }
            let bounds = self.group_bounds(index as usize, boxes);
            let group = &mut self.groups[index as usize];
            if std::mem::replace(&mut group.bounds, bounds) != bounds && index > 0 {
                changed.push(group.parent);
            }
        }
        true
    }

    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        let group = &self.groups[node as usize];
        format!("group of {}, box {}", group.count, display::box_of(&group.bounds))
    }

    fn outline(&self, node: u64, _ray: &BoxRay) -> Option<Outline> {
        Some(Outline::Box(self.groups[node as usize].bounds))
    }

    fn has_duplicate_refs(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of_val(self.groups.as_slice())
            + size_of_val(self.members.as_slice())
            + size_of_val(self.item_groups.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::ray::{Line, Span};

    /// The items proposed to a ray along x at a height, among boxes at heights 0, 1, 2..., and the number of boxes
    /// tested.
    fn offered(groups: &[Range<u32>], height: f64) -> (Vec<u32>, u64) {
        let at = |i: u32| Vec3::new(0.0, 0.0, f64::from(i));
        let boxes: Vec<Aabb> = (0..8).map(|i| Aabb::new(at(i), at(i) + Vec3::new(1.0, 1.0, 0.5))).collect();
        let tree = Hierarchy::build(&boxes, groups);
        let line = Line::exact(Vec3::new(-1.0, 0.5, height), Vec3::X);
        let (mut items, mut counters) = (Vec::new(), Counters::default());
        tree.traverse(&BoxRay::new(&line, Span::FORWARD), &mut counters, &mut |found, _| {
            items.extend_from_slice(found);
            f64::INFINITY
        });
        (items, counters.boxes)
    }

    #[test]
    fn groups_are_boxes() {
        assert_eq!(offered(&[], 4.25), ((0..8).collect(), 1));
        let nested = [0..8, 1..1, 1..6, 1..6, 2..5, 2..3, 6..8];
        assert_eq!(offered(&nested, 4.25), ((0..6).collect(), 4));
        assert_eq!(offered(&nested, 7.25), (vec![0, 6, 7], 3));
    }
}
