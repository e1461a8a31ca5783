//! A bounding volume hierarchy: a binary tree of boxes, with two walks.
//!
//! Best first: the caller's heap holds pending boxes, the nearest is opened next (Goldsmith and Salmon 1987).
//! Depth first: the nearer child at once, the farther one on a small stack.

mod build;
mod refit;

use super::{Accelerator, Offer, Pending, Visit, Work};
use crate::aabb::{Aabb, BoxRay};

/// Deeper trees are not built, see `build`; so a walk's stack is an array.
const MAX_DEPTH: usize = 96;

/// A box with what is in it.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// First of two adjacent children, or first item in `items`.
    first: u32,
    /// Number of items; 0 for an inner node.
    count: u32,
}

/// The hierarchy.
#[derive(Debug)]
pub(super) struct Bvh {
    /// Children are adjacent; the root is node 0. Empty without items.
    nodes: Vec<Node>,
    /// Item numbers in the order of the leaves.
    items: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
    /// What refitting needs; a tree that was never refitted has none.
    links: Option<Box<refit::Links>>,
}

impl Bvh {
    pub(super) fn build(boxes: &[Aabb]) -> Bvh {
        build::build(boxes)
    }

    fn leaf_items(&self, node: &Node) -> &[u32] {
        &self.items[node.first as usize..(node.first + node.count) as usize]
    }

    /// Offers what a node whose box is entered at `t` holds.
    fn offer(&self, index: u32, t: f64, out: &mut Vec<Pending>) {
        let node = &self.nodes[index as usize];
        if node.count == 0 {
            out.push(Pending { t, what: Offer::Part(u64::from(node.first)) });
        } else {
            out.extend(self.leaf_items(node).iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        }
    }

    fn enter(&self, index: u32, ray: &BoxRay) -> Option<f64> {
        ray.enter_exit(&self.nodes[index as usize].bounds).map(|(enter, _)| enter)
    }
}

impl Accelerator for Bvh {
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        if !self.nodes.is_empty() {
            work.boxes += 1;
            if let Some(t) = self.enter(0, ray) {
                self.offer(0, t, out);
            }
        }
    }

    /// A part is the first of two children.
    fn open(&self, part: u64, _t: f64, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let first = part as u32;
        work.boxes += 2;
        for child in [first, first + 1] {
            if let Some(t) = self.enter(child, ray) {
                self.offer(child, t, out);
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
        let Some(t) = self.enter(0, ray) else { return };
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
                    match (self.enter(a, ray), self.enter(b, ray)) {
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
        self.follow(items, boxes)
    }

    fn repeats(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
            + self.links.as_ref().map_or(0, |links| links.memory())
    }
}
