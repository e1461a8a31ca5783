//! A binary space partition: planes cut space in two recursively (Kaplan 1985). They are perpendicular to the axes
//! only, which makes a kd-tree (Havran 2000), or also to directions halfway between two axes.
//!
//! A ray enters a node with an interval of `t`, which the node's plane divides. The near side is traversed first. The
//! `t` of a plane has an error: the interval of the near side ends at the last `t` at which the ray may be before the
//! plane, and that of the far side begins at the first `t` at which it may be behind. So the two intervals overlap,
//! and no item is lost between them (see [`Slope::earliest`](crate::aabb::Slope::earliest)).

mod build;
mod direction;
mod oblique;

pub(super) use direction::Axis;
use direction::Direction;
pub(super) use oblique::Oblique;

use super::{Accelerator, Child, QueueEntry, Visitor, display};
use crate::aabb::{Aabb, BoxRay, Slope};
use crate::counters::Counters;
use crate::outline::Outline;

/// Maximum depth of a tree, see `build`. It lets the stack of a traversal be an array.
const MAX_DEPTH: usize = 64;

/// A node: a cell of space.
#[derive(Clone, Copy, Debug)]
enum Node<D> {
    /// Cut by the plane at the height `at` along a direction. The two children are adjacent, the lower one first.
    Plane {
        direction: D,
        first: u32,
        at: f64,
    },
    Leaf {
        first: u32,
        count: u32,
    },
}

/// A node, and the interval of `t` in which the ray is in it.
#[derive(Clone, Copy, Default)]
struct NodeInterval {
    node: u32,
    enter: f64,
    exit: f64,
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Bsp<D> {
    bounds: Aabb,
    /// The root is the first. Empty if there are no bounded items.
    nodes: Vec<Node<D>>,
    items: Vec<u32>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
}

impl<D: Direction> Bsp<D> {
    pub(super) fn build(boxes: &[Aabb]) -> Bsp<D> {
        build::build(boxes)
    }

    fn items(&self, first: u32, count: u32) -> &[u32] {
        &self.items[first as usize..][..count as usize]
    }

    /// The root and the ray's interval in it; `None` if the ray misses it.
    fn root(&self, ray: &BoxRay) -> Option<NodeInterval> {
        let (enter, exit) = ray.enter_exit(&self.bounds)?;
        (!self.nodes.is_empty()).then_some(NodeInterval { node: 0, enter, exit })
    }

    /// Queues a node with a plane, or the items of a leaf.
    fn push_children(&self, interval: NodeInterval, out: &mut Vec<QueueEntry>) {
        let t = interval.enter;
        match self.nodes[interval.node as usize] {
            Node::Plane { .. } => out.push(QueueEntry { t, child: Child::Node(pack(interval)) }),
            Node::Leaf { first, count } => {
                out.extend(self.items(first, count).iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
            }
        }
    }
}

/// The near and the far side of a plane; `None` for a side that the ray does not reach.
#[inline]
fn sides(
    NodeInterval { enter, exit, .. }: NodeInterval,
    first: u32,
    at: f64,
    slope: &Slope,
) -> [Option<NodeInterval>; 2] {
    let (behind, before) = (slope.earliest(at), slope.latest(at));
    let [near, far] = if slope.ascends() { [first, first + 1] } else { [first + 1, first] };
    [
        (enter <= before).then_some(NodeInterval {
            node: near,
            enter,
            exit: if before < exit { before } else { exit },
        }),
        (behind <= exit).then_some(NodeInterval {
            node: far,
            enter: if behind > enter { behind } else { enter },
            exit,
        }),
    ]
}

impl<D: Direction> Accelerator for Bsp<D> {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        counters.boxes += 1;
        if let Some(interval) = self.root(ray) {
            self.push_children(interval, out);
        }
    }

    /// A node number stands for a node with a plane and the `t` at which the ray leaves the node.
    fn expand(&self, node: u64, t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let (node, exit) = unpack(node);
        if let Node::Plane { direction, first, at } = self.nodes[node as usize] {
            counters.planes += 1;
            let sides = sides(NodeInterval { node, enter: t, exit }, first, at, &direction.slope(ray));
            for side in sides.into_iter().flatten() {
                self.push_children(side, out);
            }
        }
    }

    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, counters);
        }
        counters.boxes += 1;
        let Some(root) = self.root(ray) else { return };
        // Computed once: a ray crosses many planes, but they have few directions.
        let slopes = D::slopes(ray);
        let mut next = Some(root);
        let mut stack = [NodeInterval::default(); MAX_DEPTH];
        let mut height = 0;
        loop {
            if let Some(interval) = next.filter(|s| s.enter <= limit) {
                match self.nodes[interval.node as usize] {
                    Node::Plane { direction, first, at } => {
                        counters.planes += 1;
                        match sides(interval, first, at, &slopes[direction.index()]) {
                            [Some(near), Some(far)] => {
                                stack[height] = far;
                                height += 1;
                                next = Some(near);
                            }
                            [near, far] => next = near.or(far),
                        }
                        continue;
                    }
                    Node::Leaf { count: 0, .. } => {}
                    Node::Leaf { first, count } => limit = visit(self.items(first, count), counters),
                }
            }
            if height == 0 {
                return;
            }
            height -= 1;
            next = Some(stack[height]);
        }
    }

    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        match self.nodes[unpack(node).0 as usize] {
            Node::Plane { direction, at, .. } => {
                format!("plane {} = {}", direction.display(), display::number(at))
            }
            Node::Leaf { count, .. } => format!("leaf of {count}"),
        }
    }

    fn outline(&self, node: u64, _ray: &BoxRay) -> Option<Outline> {
        match self.nodes[unpack(node).0 as usize] {
            Node::Plane { direction, at, .. } => {
                Some(Outline::Plane { normal: direction.normal(), height: at })
            }
            Node::Leaf { .. } => None,
        }
    }

    fn has_duplicate_refs(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
    }
}

/// Packs a node number: the index of the node, and the exit rounded up to an f32.
fn pack(interval: NodeInterval) -> u64 {
    let mut exit = interval.exit as f32;
    if f64::from(exit) < interval.exit {
        exit = exit.next_up();
    }
    u64::from(interval.node) << 32 | u64::from(exit.to_bits())
}

fn unpack(node: u64) -> (u32, f64) {
    ((node >> 32) as u32, f64::from(f32::from_bits(node as u32)))
}
