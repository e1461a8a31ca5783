//! A binary space partition: planes cut space in two, and again (Kaplan 1985; across the axes, as a kd-tree,
//! Havran 2000), across the axes only or also halfway between two.
//!
//! A ray comes to a node with an interval of `t`, and a plane divides the interval; the near side is walked
//! first. The `t` of a plane has a doubt: the near side keeps all up to the last `t` at which the ray may be
//! before the plane, the far side begins with the first at which it may be behind. So the two intervals overlap,
//! and no item is lost between them (see [`Slope::earliest`](crate::aabb::Slope::earliest)).

mod build;
mod direction;
mod oblique;

pub(super) use direction::Axis;
use direction::Direction;
pub(super) use oblique::Oblique;

use super::{Accelerator, Offer, Pending, Visit, Work, words};
use crate::aabb::{Aabb, BoxRay, Slope};

/// Deeper trees are not built, see `build`; so a walk's stack is an array.
const MAX_DEPTH: usize = 64;

/// Space on one side of all planes above it.
#[derive(Clone, Copy, Debug)]
enum Node<D> {
    /// Cut by the plane at a height along a direction; the two sides are adjacent, the lower first.
    Plane {
        across: D,
        first: u32,
        at: f64,
    },
    Leaf {
        first: u32,
        count: u32,
    },
}

/// A node and where the ray is in it.
#[derive(Clone, Copy, Default)]
struct Stretch {
    node: u32,
    enter: f64,
    exit: f64,
}

/// The tree.
#[derive(Clone, Debug)]
pub(super) struct Bsp<D> {
    bounds: Aabb,
    /// The root is the first. None without items.
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

    /// Where the ray is in the root.
    fn root(&self, ray: &BoxRay) -> Option<Stretch> {
        let (enter, exit) = ray.enter_exit(&self.bounds)?;
        (!self.nodes.is_empty()).then_some(Stretch { node: 0, enter, exit })
    }

    /// Offers what a node holds.
    fn offer(&self, stretch: Stretch, out: &mut Vec<Pending>) {
        let t = stretch.enter;
        match self.nodes[stretch.node as usize] {
            Node::Plane { .. } => out.push(Pending { t, what: Offer::Part(pack(stretch)) }),
            Node::Leaf { first, count } => {
                out.extend(self.items(first, count).iter().map(|&i| Pending { t, what: Offer::Item(i) }));
            }
        }
    }
}

/// The near and the far side of a plane, as far as the ray comes to them.
#[inline]
fn sides(Stretch { enter, exit, .. }: Stretch, first: u32, at: f64, slope: &Slope) -> [Option<Stretch>; 2] {
    let (behind, before) = (slope.earliest(at), slope.latest(at));
    let [near, far] = if slope.ascends() { [first, first + 1] } else { [first + 1, first] };
    [
        (enter <= before).then_some(Stretch {
            node: near,
            enter,
            exit: if before < exit { before } else { exit },
        }),
        (behind <= exit).then_some(Stretch {
            node: far,
            enter: if behind > enter { behind } else { enter },
            exit,
        }),
    ]
}

impl<D: Direction> Accelerator for Bsp<D> {
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| Pending { t, what: Offer::Item(i) }));
        work.boxes += 1;
        if let Some(stretch) = self.root(ray) {
            self.offer(stretch, out);
        }
    }

    /// A part is a node with a plane, and where the ray leaves it.
    fn open(&self, part: u64, t: f64, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work) {
        let (node, exit) = unpack(part);
        if let Node::Plane { across, first, at } = self.nodes[node as usize] {
            work.planes += 1;
            let sides = sides(Stretch { node, enter: t, exit }, first, at, &across.slope(ray));
            for side in sides.into_iter().flatten() {
                self.offer(side, out);
            }
        }
    }

    fn walk(&self, ray: &BoxRay, work: &mut Work, visit: &mut Visit) {
        let mut limit = ray.span().t_max();
        if !self.unbounded.is_empty() {
            limit = visit(&self.unbounded, work);
        }
        work.boxes += 1;
        let Some(root) = self.root(ray) else { return };
        // Worked out once: planes across few directions are passed by the dozen.
        let slopes = D::slopes(ray);
        let mut next = Some(root);
        let mut stack = [Stretch::default(); MAX_DEPTH];
        let mut height = 0;
        loop {
            if let Some(stretch) = next.filter(|s| s.enter <= limit) {
                match self.nodes[stretch.node as usize] {
                    Node::Plane { across, first, at } => {
                        work.planes += 1;
                        match sides(stretch, first, at, &slopes[across.place()]) {
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
                    Node::Leaf { first, count } => limit = visit(self.items(first, count), work),
                }
            }
            if height == 0 {
                return;
            }
            height -= 1;
            next = Some(stack[height]);
        }
    }

    fn describe(&self, part: u64, _ray: &BoxRay) -> String {
        match self.nodes[unpack(part).0 as usize] {
            Node::Plane { across, at, .. } => format!("plane {} = {}", across.words(), words::number(at)),
            Node::Leaf { count, .. } => format!("leaf of {count}"),
        }
    }

    fn repeats(&self) -> bool {
        true
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.items.as_slice())
            + size_of_val(self.unbounded.as_slice())
    }
}

/// The number of a part: the node, and the exit rounded up to an f32.
fn pack(stretch: Stretch) -> u64 {
    let mut exit = stretch.exit as f32;
    if f64::from(exit) < stretch.exit {
        exit = exit.next_up();
    }
    u64::from(stretch.node) << 32 | u64::from(exit.to_bits())
}

fn unpack(part: u64) -> (u32, f64) {
    ((part >> 32) as u32, f64::from(f32::from_bits(part as u32)))
}
