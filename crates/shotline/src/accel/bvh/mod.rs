//! A bounding volume hierarchy: a binary tree of boxes or other volumes, with two traversals.
//!
//! Best first: the caller's heap holds the queued nodes, and the nearest is expanded next (Goldsmith and Salmon
//! 1987). Depth first: the nearer child is visited at once, and the farther one is pushed on a small stack.

mod binned_sah;
mod bvh8;
mod lbvh;
mod refit;
mod sbvh;
mod sphere;

use std::fmt::Debug;

pub(super) use bvh8::Bvh8;
use refit::RefitData;
use sphere::Sphere;

use super::{Accelerator, Child, QueueEntry, Visitor, display};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::outline::Outline;

/// Maximum depth of a tree. It lets the stack of a traversal be an array.
const MAX_DEPTH: usize = 96;
/// A leaf of at most this many items is split only if the heuristic gains by it.
const MAX_LEAF: usize = 4;

/// A bounding volume.
pub(super) trait Volume: Copy + PartialEq + Debug + Send + Sync + 'static {
    /// A volume around boxes.
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self;

    /// A volume around both.
    fn union(&self, other: &Self) -> Self;

    /// A ray prepared for tests against many volumes.
    type Ray<'r>;

    /// Prepares a ray.
    fn prepare(ray: &BoxRay) -> Self::Ray<'_>;

    /// The `t` at which a ray enters the volume; `None` if the ray misses it.
    fn enter(&self, ray: &Self::Ray<'_>) -> Option<f64>;

    /// Whether the volume around one box is that box itself.
    const IS_BOX: bool;

    /// A number proportional to the probability that a line meets the volume.
    fn area(&self) -> f64;

    /// A description for people.
    fn display(&self) -> String;

    /// Its shape, for pictures.
    fn outline(&self) -> Outline;
}

impl Volume for Aabb {
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Aabb {
        boxes.fold(Aabb::EMPTY, |all, b| all.union(&b))
    }

    fn union(&self, other: &Aabb) -> Aabb {
        self.union(other)
    }

    type Ray<'r> = &'r BoxRay;

    fn prepare(ray: &BoxRay) -> &BoxRay {
        ray
    }

    #[inline]
    fn enter(&self, ray: &&BoxRay) -> Option<f64> {
        ray.enter_exit(self).map(|(enter, _)| enter)
    }

    const IS_BOX: bool = true;

    fn area(&self) -> f64 {
        self.half_area()
    }

    fn display(&self) -> String {
        format!("box {}", display::box_of(self))
    }

    fn outline(&self) -> Outline {
        Outline::Box(*self)
    }
}

/// A volume, with its children or items.
#[derive(Clone, Copy, Debug)]
struct Node<V> {
    bounds: V,
    /// Index of the first of two adjacent children, or of the first item in `items`.
    first: u32,
    /// Number of items; 0 for an inner node.
    count: u32,
}

/// The hierarchy. Children have larger indices than their parents.
#[derive(Clone, Debug)]
pub(super) struct Bvh<V = Aabb> {
    /// Siblings are adjacent; the root is node 0. Empty if there are no bounded items.
    nodes: Vec<Node<V>>,
    /// Item numbers in the order of the leaves.
    items: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
    /// Whether an item may be in several leaves, each with a piece of its box.
    has_duplicate_refs: bool,
    /// Data for refitting; `None` until the first refit.
    refit_data: Option<Box<RefitData<u32>>>,
}

impl Bvh {
    /// Builds a tree for fast traversal, by the surface area heuristic.
    pub(super) fn binned_sah(boxes: &[Aabb]) -> Bvh {
        binned_sah::build(boxes, MAX_LEAF)
    }

    /// Builds a tree in the shortest time.
    pub(super) fn lbvh(boxes: &[Aabb]) -> Bvh {
        lbvh::build(boxes)
    }

    /// Builds a tree by the surface area heuristic with spatial splits, which may cut the boxes of items.
    pub(super) fn sbvh(boxes: &[Aabb]) -> Bvh {
        sbvh::build(boxes)
    }

    /// Builds the tree of `binned_sah`, with spheres.
    pub(super) fn spheres(boxes: &[Aabb]) -> Bvh<Sphere> {
        sphere::build(boxes)
    }
}

impl<V: Volume> Bvh<V> {
    fn leaf_items(&self, node: &Node<V>) -> &[u32] {
        &self.items[node.first as usize..(node.first + node.count) as usize]
    }

    /// Queues the children or the items of a node whose volume is entered at `t`.
    fn push_children(&self, index: u32, t: f64, out: &mut Vec<QueueEntry>) {
        let node = &self.nodes[index as usize];
        if node.count == 0 {
            out.push(QueueEntry { t, child: Child::Node(u64::from(node.first)) });
        } else if V::IS_BOX && node.count == 1 && !self.has_duplicate_refs {
            out.push(QueueEntry { t, child: Child::Entered(self.items[node.first as usize]) });
        } else {
            out.extend(self.leaf_items(node).iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        }
    }

    #[inline]
    fn enter(&self, index: u32, ray: &V::Ray<'_>) -> Option<f64> {
        self.nodes[index as usize].bounds.enter(ray)
    }
}

impl<V: Volume> Bvh<V> {
    /// The volume around two siblings, of which the number of the first is given: what a pending node stands for.
    fn around_siblings(&self, first: u64) -> V {
        let [a, b] = [first, first + 1].map(|child| &self.nodes[child as usize].bounds);
        a.union(b)
    }
}

impl<V: Volume> Accelerator for Bvh<V> {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        if !self.nodes.is_empty() {
            counters.boxes += 1;
            if let Some(t) = self.enter(0, &V::prepare(ray)) {
                self.push_children(0, t, out);
            }
        }
    }

    /// A node number is the index of the first of two siblings; both are tested.
    fn expand(&self, node: u64, t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let (first, ray) = (node as u32, V::prepare(ray));
        counters.boxes += 2;
        for child in [first, first + 1] {
            if let Some(enter) = self.enter(child, &ray) {
                self.push_children(child, enter.max(t), out);
            }
        }
    }

    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, counters);
        }
        if self.nodes.is_empty() {
            return;
        }
        counters.boxes += 1;
        let ray = V::prepare(ray);
        let Some(t) = self.enter(0, &ray) else { return };
        let mut stack = [(0.0, 0); MAX_DEPTH];
        let mut height = 0;
        let mut next = (t, 0);
        loop {
            let node = &self.nodes[next.1 as usize];
            if next.0 <= limit {
                if node.count > 0 {
                    limit = visit(self.leaf_items(node), counters);
                } else {
                    counters.boxes += 2;
                    let (a, b) = (node.first, node.first + 1);
                    match (self.enter(a, &ray), self.enter(b, &ray)) {
                        (Some(ta), Some(tb)) => {
                            let (near, far) = if ta <= tb { ((ta, a), (tb, b)) } else { ((tb, b), (ta, a)) };
                            stack[height] = far;
                            height += 1;
                            next = near;
                            continue;
                        }
                        (Some(ta), None) => {
                            next = (ta, a);
                            continue;
                        }
                        (None, Some(tb)) => {
                            next = (tb, b);
                            continue;
                        }
                        (None, None) => {}
                    }
                }
            }
            if height == 0 {
                return;
            }
            height -= 1;
            next = stack[height];
        }
    }

    fn refit(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        !self.has_duplicate_refs && self.refit_bounds(items, boxes)
    }

    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        self.around_siblings(node).display()
    }

    fn outline(&self, node: u64, _ray: &BoxRay) -> Option<Outline> {
        Some(self.around_siblings(node).outline())
    }

    fn has_duplicate_refs(&self) -> bool {
        self.has_duplicate_refs
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
            + self.refit_data.as_ref().map_or(0, |refit_data| refit_data.memory())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn depth(bvh: &Bvh) -> usize {
        let mut deepest = 0;
        let mut stack = vec![(0u32, 1)];
        while let Some((node, d)) = stack.pop() {
            let n = &bvh.nodes[node as usize];
            deepest = deepest.max(d);
            if n.count == 0 {
                stack.extend([(n.first, d + 1), (n.first + 1, d + 1)]);
            }
        }
        deepest
    }

    /// For boxes whose sizes grow by powers of two, heuristics build a chain of nodes; the stack must have room for
    /// it.
    #[test]
    fn depth_is_bounded() {
        let boxes: Vec<Aabb> =
            (0..900).map(|i| Aabb::new(Vec3::ZERO, Vec3::splat(2f64.powi(i - 450)))).collect();
        let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 5000];
        for build in [Bvh::lbvh, Bvh::binned_sah, Bvh::sbvh] {
            assert!(depth(&build(&boxes)) < MAX_DEPTH);
            assert!(depth(&build(&same)) < 16);
        }
    }
}
