//! A bounding volume hierarchy of up to eight children a node, whose boxes are tested together (Wald, Benthin and Boulos
//! 2008, "Getting rid of packets").
//!
//! It is collapsed from a binary tree. An item is a child of its own, with its own box, so a ray that meets it needs no
//! further test.

mod collapse;
mod node;
mod refit;

use collapse::collapse;
use node::{Met, Node};
use refit::Slot;

use super::binned_sah;
use super::refit::RefitData;
use crate::aabb::{Aabb, BoxRay};
use crate::accel::collapse::WIDTH;
use crate::accel::{Accelerator, BeamEntry, BeamSome, Child, QueueEntry, Walk, WalkEntry, WalkKind, display};
use crate::counters::Counters;
use crate::outline::Outline;
use crate::simd::{Simd, Task, dispatch};

/// The hierarchy.
#[derive(Clone, Debug)]
pub(in crate::accel) struct Bvh8 {
    /// The root comes first, and every node before its children. Empty if there are no bounded items.
    nodes: Vec<Node>,
    /// Items without finite bounds, proposed first.
    unbounded: Vec<u32>,
    /// Data for refitting; `None` until the first refit.
    refit_data: Option<Box<RefitData<Slot>>>,
}

impl Bvh8 {
    /// Builds a tree for fast traversal, by the surface area heuristic.
    pub(in crate::accel) fn binned_sah(boxes: &[Aabb]) -> Bvh8 {
        let bvh = binned_sah::build(boxes, 1);
        Bvh8 { nodes: collapse(&bvh), unbounded: bvh.unbounded, refit_data: None }
    }
}

/// Appends the children of a node that a ray meets.
struct Expand<'a> {
    node: &'a Node,
    ray: &'a BoxRay,
    out: &'a mut Vec<QueueEntry>,
}

impl Task for Expand<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Expand { node, ray, out } = self;
        let met = node.test::<S::Wide>(ray);
        each_child(node, &met, |_, t, child| out.push(QueueEntry { t, child }));
    }
}

/// Appends the children of a node that rays of a beam may meet.
struct ExpandBeam<'a> {
    node: &'a Node,
    some: &'a BeamSome<'a>,
    out: &'a mut Vec<BeamEntry>,
}

impl Task for ExpandBeam<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let ExpandBeam { node, some, out } = self;
        if some.beam.is_loose {
            let met = node.test_each::<S::Wide>(some);
            each_child(node, &met.any, |slot, t, child| {
                out.push(BeamEntry { t, child, places: met.places[slot] });
            });
        } else {
            let places = some.places;
            each_child(node, &node.test_beam::<S::Wide>(some.beam), |_, t, child| {
                out.push(BeamEntry { t, child, places });
            });
        }
    }
}

/// Walks on to the next item.
struct WalkOn<'a> {
    nodes: &'a [Node],
    ray: &'a BoxRay,
    limit: f64,
    base: usize,
    walk: &'a mut Walk,
}

impl Task for WalkOn<'_> {
    type Output = Option<WalkEntry>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<WalkEntry> {
        let WalkOn { nodes, ray, limit, base, walk } = self;
        let mut entry = walk.take(base, limit)?;
        while entry.kind == WalkKind::Node {
            let node = &nodes[entry.number as usize];
            let met = node.test::<S::Wide>(ray);
            let child = |slot: usize| {
                let kind = if slot < usize::from(node.nodes) { WalkKind::Node } else { WalkKind::Entered };
                WalkEntry { t: met.enter[slot], number: node.children[slot], kind }
            };
            if met.children == 0 {
                entry = walk.take(base, limit)?;
                continue;
            }
            let (first, last) = (lowest(met.children), highest(met.children));
            let mut rest = met.children & !(1 << first | 1 << last);
            let start = walk.pending.len();
            // Most nodes have one or two children that are met. Which of two is nearer is not a branch, as no CPU can predict
            // it. The nearest goes on without a detour over memory.
            let is_swapped = met.enter[last] < met.enter[first];
            let [near, far] = if is_swapped { [last, first] } else { [first, last] };
            walk.pending.push(child(far));
            walk.pending.truncate(start + usize::from(first != last));
            entry = child(near);
            while rest != 0 {
                let other = child(lowest(rest));
                rest &= rest - 1;
                let is_nearer = other.t < entry.t;
                let (nearest, farther) = if is_nearer { (other, entry) } else { (entry, other) };
                entry = nearest;
                walk.add(start, farther);
            }
            walk.steps += 1;
            if entry.t > limit {
                entry = walk.take(base, limit)?;
            }
        }
        Some(entry)
    }
}

/// The lowest slot of a mask that is not zero.
#[inline(always)]
fn lowest(slots: u8) -> usize {
    slots.trailing_zeros() as usize % WIDTH
}

/// The highest slot of a mask that is not zero.
#[inline(always)]
fn highest(slots: u8) -> usize {
    WIDTH - 1 - slots.leading_zeros() as usize % WIDTH
}

/// Passes the children that are met, each with its slot and the `t` at which it is entered.
#[inline(always)]
fn each_child(node: &Node, met: &Met, mut take: impl FnMut(usize, f64, Child)) {
    let mut rest = met.children;
    while rest != 0 {
        let slot = rest.trailing_zeros() as usize % WIDTH;
        rest &= rest - 1;
        let number = node.children[slot];
        let is_node = slot < usize::from(node.nodes);
        let child = if is_node { Child::Node(u64::from(number)) } else { Child::Entered(number) };
        take(slot, met.enter[slot], child);
    }
}

impl Accelerator for Bvh8 {
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let t = ray.span().t_min();
        out.extend(self.unbounded.iter().map(|&i| QueueEntry { t, child: Child::Item(i) }));
        if !self.nodes.is_empty() {
            self.expand(0, t, ray, out, counters);
        }
    }

    fn expand(&self, node: u64, _t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters) {
        let node = &self.nodes[node as usize];
        counters.boxes += u64::from(node.count);
        dispatch(Expand { node, ray, out });
    }

    fn takes_beams(&self) -> bool {
        true
    }

    fn beam_roots(&self, some: &BeamSome, out: &mut Vec<BeamEntry>) {
        let (t, places) = (some.beam.t_min, some.places);
        out.extend(self.unbounded.iter().map(|&i| BeamEntry { t, child: Child::Item(i), places }));
        if !self.nodes.is_empty() {
            self.expand_beam(0, some, out);
        }
    }

    fn expand_beam(&self, node: u64, some: &BeamSome, out: &mut Vec<BeamEntry>) {
        dispatch(ExpandBeam { node: &self.nodes[node as usize], some, out });
    }

    fn begin_walk(&self, ray: &BoxRay, walk: &mut Walk) {
        let t = ray.span().t_min();
        if !self.nodes.is_empty() {
            walk.pending.push(WalkEntry { t, number: 0, kind: WalkKind::Node });
        }
        let unbounded = self.unbounded.iter();
        walk.pending.extend(unbounded.map(|&number| WalkEntry { t, number, kind: WalkKind::Item }));
    }

    fn walk(&self, ray: &BoxRay, limit: f64, base: usize, walk: &mut Walk) -> Option<WalkEntry> {
        dispatch(WalkOn { nodes: &self.nodes, ray, limit, base, walk })
    }

    fn refit(&mut self, items: &[u32], boxes: &dyn Fn(u32) -> Aabb) -> bool {
        self.refit_boxes(items, boxes)
    }

    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        format!("box {}", display::box_of(&self.nodes[node as usize].bounds()))
    }

    fn outline(&self, node: u64, _ray: &BoxRay) -> Option<Outline> {
        Some(Outline::Box(self.nodes[node as usize].bounds()))
    }

    fn has_duplicate_refs(&self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.unbounded.as_slice())
            + self.refit_data.as_ref().map_or(0, |refit_data| refit_data.memory())
    }
}
