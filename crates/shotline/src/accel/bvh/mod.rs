//! A bounding volume hierarchy: a binary tree of boxes or other volumes, with two walks.
//!
//! Best first: the caller's heap holds pending boxes, the nearest is opened next (Goldsmith and Salmon 1987).
//! Depth first: the nearer child at once, the farther one on a small stack.

mod balanced;
mod best;
mod fast;
mod refit;
mod sphere;

use std::fmt::Debug;

use refit::Links;
use sphere::Sphere;

use super::{Accelerator, Offer, Pending, Visit, Work, words};
use crate::aabb::{Aabb, BoxRay};

/// Deeper trees are not built; so a walk's stack is an array.
const MAX_DEPTH: usize = 96;
/// Leaves of at most so many items are not split further unless the heuristic gains by it.
const MAX_LEAF: usize = 4;

/// What a node is bounded by.
pub(super) trait Volume: Copy + PartialEq + Debug + Send + Sync + 'static {
    /// A volume around boxes.
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self;

    /// A volume around both.
    fn union(&self, other: &Self) -> Self;

    /// A ray prepared for tests against many of these.
    type Ray<'r>;

    /// Prepares a ray.
    fn prepare(ray: &BoxRay) -> Self::Ray<'_>;

    /// Where a ray enters it; `None` if it passes by.
    fn enter(&self, ray: &Self::Ray<'_>) -> Option<f64>;

    /// Whether a volume around one box is that box.
    const IS_BOX: bool;

    /// In proportion to the chance of a line to meet it.
    fn area(&self) -> f64;

    /// What it is, for people.
    fn words(&self) -> String;
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

    fn words(&self) -> String {
        format!("box {}", words::box_of(self))
    }
}

/// A volume with what is in it.
#[derive(Clone, Copy, Debug)]
struct Node<V> {
    bounds: V,
    /// First of two adjacent children, or first item in `items`.
    first: u32,
    /// Number of items; 0 for an inner node.
    count: u32,
}

/// The hierarchy. Children are found behind their parents.
#[derive(Clone, Debug)]
pub(super) struct Bvh<V = Aabb> {
    /// Children are adjacent; the root is node 0. Empty without items.
    nodes: Vec<Node<V>>,
    /// Item numbers in the order of the leaves.
    items: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
    /// Whether items may be in several leaves, each with a part of its box.
    repeats: bool,
    /// What refitting needs; a tree that was never refitted has none.
    links: Option<Box<Links>>,
}

impl Bvh {
    /// Built with care for the time that rays take: by the surface area heuristic.
    pub(super) fn balanced(boxes: &[Aabb]) -> Bvh {
        balanced::build(boxes)
    }

    /// Built in the shortest time.
    pub(super) fn fast(boxes: &[Aabb]) -> Bvh {
        fast::build(boxes)
    }

    /// Built by the surface area heuristic, which may cut boxes in two.
    pub(super) fn best(boxes: &[Aabb]) -> Bvh {
        best::build(boxes)
    }

    /// The balanced tree, with spheres.
    pub(super) fn spheres(boxes: &[Aabb]) -> Bvh<Sphere> {
        sphere::build(boxes)
    }
}

impl<V: Volume> Bvh<V> {
    fn leaf_items(&self, node: &Node<V>) -> &[u32] {
        &self.items[node.first as usize..(node.first + node.count) as usize]
    }

    /// Offers what a node whose box is entered at `t` holds.
    fn offer(&self, index: u32, t: f64, out: &mut Vec<Pending>) {
        let node = &self.nodes[index as usize];
        if node.count == 0 {
            out.push(Pending { t, what: Offer::Part(u64::from(node.first)) });
        } else if V::IS_BOX && node.count == 1 && !self.repeats {
            out.push(Pending { t, what: Offer::Entered(self.items[node.first as usize]) });
        } else {
            out.extend(self.leaf_items(node).iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        }
    }

    #[inline]
    fn enter(&self, index: u32, ray: &V::Ray<'_>) -> Option<f64> {
        self.nodes[index as usize].bounds.enter(ray)
    }
}

impl<V: Volume> Accelerator for Bvh<V> {
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        if !self.nodes.is_empty() {
            work.boxes += 1;
            if let Some(t) = self.enter(0, &V::prepare(ray)) {
                self.offer(0, t, out);
            }
        }
    }

    /// A part is the first of two children.
    fn open(&self, part: u64, t: f64, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let (first, ray) = (part as u32, V::prepare(ray));
        work.boxes += 2;
        for child in [first, first + 1] {
            if let Some(enter) = self.enter(child, &ray) {
                self.offer(child, enter.max(t), out);
            }
        }
    }

    fn walk(&self, ray: &BoxRay, work: &mut Work, visit: &mut Visit) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, work);
        }
        if self.nodes.is_empty() {
            return;
        }
        work.boxes += 1;
        let ray = V::prepare(ray);
        let Some(t) = self.enter(0, &ray) else { return };
        let mut stack = [(0.0, 0); MAX_DEPTH];
        let mut height = 0;
        let mut next = (t, 0);
        loop {
            let node = &self.nodes[next.1 as usize];
            if next.0 <= limit {
                if node.count > 0 {
                    limit = visit(self.leaf_items(node), work);
                } else {
                    work.boxes += 2;
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
        !self.repeats && self.follow(items, boxes)
    }

    fn describe(&self, part: u64, _ray: &BoxRay) -> String {
        let [a, b] = [part, part + 1].map(|child| &self.nodes[child as usize].bounds);
        a.union(b).words()
    }

    fn repeats(&self) -> bool {
        self.repeats
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
            + self.links.as_ref().map_or(0, |links| links.memory())
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

    /// Boxes whose sizes grow by powers of two draw heuristics into a chain; the stack must hold it.
    #[test]
    fn depth_is_bounded() {
        let boxes: Vec<Aabb> =
            (0..900).map(|i| Aabb::new(Vec3::ZERO, Vec3::splat(2f64.powi(i - 450)))).collect();
        let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 5000];
        for build in [Bvh::fast, Bvh::balanced, Bvh::best] {
            assert!(depth(&build(&boxes)) < MAX_DEPTH);
            assert!(depth(&build(&same)) < 16);
        }
    }
}
