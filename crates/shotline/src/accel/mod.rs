//! Accelerators: structures over the boxes of numbered items, which propose items to a ray in ascending `t`.
//!
//! An accelerator sees only boxes and item numbers, never solids. The caller of a traversal knows what an item is,
//! and tags the items that it has tested.

mod beam;
mod brute;
mod bsp;
mod bvh;
mod collapse;
mod display;
mod grid;
mod hierarchy;
mod lattice;
mod octree;
mod prim_ref;
mod walk;
pub(crate) mod wide;

use std::fmt::Debug;
use std::ops::Range;

pub use beam::{BEAM_RAYS, Beam, BeamEntry, BeamRays, BeamSome, ByRay, MetRays};
pub use lattice::LatticeIndex;
pub use walk::{Walk, WalkEntry, WalkKind};

use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::outline::Outline;

/// An entry in the queue of a best-first traversal: a node or an item that the ray may meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueueEntry {
    /// A lower bound on every `t` at which the ray meets the child.
    pub t: f64,
    /// The node or item.
    pub child: Child,
}

/// What a [`QueueEntry`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// A node, to be expanded by [`Accelerator::expand`]. Only the structure can interpret the number.
    Node(u64),
    /// An item.
    Item(u32),
    /// An item whose own box the ray enters exactly at the bound, and which is proposed only once. Callers need not
    /// test its box again.
    Entered(u32),
}

/// Called with a run of items. Returns the `t` beyond which the caller needs no more items.
pub type Visitor<'a> = dyn FnMut(&[u32], &mut Counters) -> f64 + 'a;

/// A structure over the boxes of numbered items.
///
/// Every item whose box the ray meets within its span is proposed, with a bound of at most the first such `t`. An
/// item may be proposed more than once, see [`Tags`](crate::tags::Tags).
pub trait Accelerator: CloneBoxed + Send + Sync + Debug {
    /// Appends the entries with which a traversal starts.
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters);

    /// Expands a node that was queued with the bound `t`: appends its children.
    fn expand(&self, node: u64, t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters);

    /// Whether the structure can be traversed by a beam. It then proposes no item more than once.
    fn takes_beams(&self) -> bool {
        false
    }

    /// As [`Accelerator::roots`], for a beam: appends what any of its rays may meet. The bounds hold for all rays. Callers
    /// test the boxes of items ray by ray.
    fn beam_roots(&self, _some: &BeamSome, _out: &mut Vec<BeamEntry>) {}

    /// As [`Accelerator::expand`], for a beam.
    fn expand_beam(&self, _node: u64, _some: &BeamSome, _out: &mut Vec<BeamEntry>) {}

    /// Begins a walk of a ray: makes the first entries pending. Structures that take beams can be walked.
    fn begin_walk(&self, _ray: &BoxRay, _walk: &mut Walk) {}

    /// Walks on to the next item that begins at or before `limit`. What lies below `base` belongs to other structures.
    fn walk(&self, _ray: &BoxRay, _limit: f64, _base: usize, _walk: &mut Walk) -> Option<WalkEntry> {
        None
    }

    /// Traverses the structure depth first, nearer children first. Calls `visit` with runs of items. Skips everything
    /// that begins after the `t` that `visit` returned last (initially the span's `t_max`).
    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        let (mut stack, mut found) = (Vec::new(), Vec::new());
        self.roots(ray, &mut found, counters);
        loop {
            // The nearest entry comes on top. Entries with equal `t` keep the order in which they were proposed.
            found.reverse();
            found.sort_by(|a: &QueueEntry, b: &QueueEntry| b.t.total_cmp(&a.t));
            stack.append(&mut found);
            let Some(next) = stack.pop() else { return };
            if next.t > limit {
                continue;
            }
            match next.child {
                Child::Node(node) => self.expand(node, next.t, ray, &mut found, counters),
                Child::Item(item) | Child::Entered(item) => limit = visit(&[item], counters),
            }
        }
    }

    /// Describes a node in the structure's own terms, for a reader who follows a ray step by step.
    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        format!("node {node}")
    }

    /// The shape of a node, for a picture of the ray's way. `None` where a node has none.
    fn outline(&self, _node: u64, _ray: &BoxRay) -> Option<Outline> {
        None
    }

    /// Refits the structure to items whose boxes have changed; `boxes` returns the new box of any item. Returns
    /// `false` if the structure cannot be refitted or would become too slow. The structure is then invalid, and the
    /// caller must rebuild it.
    fn refit(&mut self, _items: &[u32], _boxes: &dyn Fn(u32) -> Aabb) -> bool {
        false
    }

    /// Whether the structure may propose an item more than once to one ray.
    fn has_duplicate_refs(&self) -> bool;

    /// Bytes used.
    fn memory(&self) -> usize;
}

/// Cloning of a boxed accelerator of unknown type. Every accelerator that is [`Clone`] implements this.
pub trait CloneBoxed {
    /// Returns a boxed copy.
    fn clone_boxed(&self) -> Box<dyn Accelerator>;
}

impl<A: Accelerator + Clone + 'static> CloneBoxed for A {
    fn clone_boxed(&self) -> Box<dyn Accelerator> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Accelerator> {
    fn clone(&self) -> Box<dyn Accelerator> {
        (**self).clone_boxed()
    }
}

/// The input of a builder.
#[derive(Clone, Copy, Debug)]
pub struct Items<'a> {
    /// The boxes of items `0..boxes.len()`. Items with an empty box are never proposed.
    pub boxes: &'a [Aabb],
    /// The groups that the user made: ranges of items. Any two are nested or disjoint. Outer ranges come before inner
    /// ones, disjoint ranges in ascending order. `None` where there are no groups, as in a mesh.
    pub groups: Option<&'a [Range<u32>]>,
}

impl<'a> From<&'a [Aabb]> for Items<'a> {
    fn from(boxes: &'a [Aabb]) -> Items<'a> {
        Items { boxes, groups: None }
    }
}

impl<'a> From<&'a Vec<Aabb>> for Items<'a> {
    fn from(boxes: &'a Vec<Aabb>) -> Items<'a> {
        Items::from(boxes.as_slice())
    }
}

/// The name of the accelerator that suits most scenes.
pub const DEFAULT: &str = "bvh";

/// Declares the registry, with a conformance test for each entry.
macro_rules! registry {
    ($($name:ident => $build:expr),* $(,)?) => {
        /// The names of all accelerators.
        pub static NAMES: &[&str] = &[$(stringify!($name)),*];

        /// Builds the accelerator with a name. Returns `None` if there is no such name.
        pub fn build<'a>(name: &str, items: impl Into<Items<'a>>) -> Option<Box<dyn Accelerator>> {
            let build: fn(Items) -> Box<dyn Accelerator> = match name {
                $(stringify!($name) => $build,)*
                _ => return None,
            };
            Some(build(items.into()))
        }

        #[cfg(test)]
        mod conformance {
            $(
                #[test]
                fn $name() {
                    crate::testkit::accel::conformance(stringify!($name));
                }
            )*
        }
    };
}

registry! {
    brute => |items| Box::new(brute::Brute::build(items.boxes)),
    hierarchy => hierarchy::build,
    bvh_fast => |items| Box::new(bvh::Bvh::lbvh(items.boxes)),
    bvh => |items| Box::new(bvh::Bvh8::binned_sah(items.boxes)),
    bvh_best => |items| Box::new(bvh::Bvh::sbvh(items.boxes)),
    bvh_spheres => |items| Box::new(bvh::Bvh::spheres(items.boxes)),
    grid => |items| Box::new(grid::Grid::build(items.boxes)),
    octree => |items| Box::new(octree::Octree::build(items.boxes)),
    bsp => |items| Box::new(bsp::Bsp::<bsp::Axis>::build(items.boxes)),
    bsp_oblique => |items| Box::new(bsp::Bsp::<bsp::Oblique>::build(items.boxes)),
}
