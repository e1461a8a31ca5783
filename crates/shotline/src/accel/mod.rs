//! Accelerators: structures over boxes that propose items in ascending `t`. They see boxes and item numbers,
//! never solids; what an item is, and tagging, is the business of whoever walks them.

mod bounded;
mod brute;
mod bsp;
mod bvh;
mod grid;
mod hierarchy;
mod octree;
mod tags;
mod words;

use std::fmt::Debug;
use std::ops::Range;

use crate::aabb::{Aabb, BoxRay};
use crate::budget::Budget;
use crate::trace::Log;
pub use tags::{Tags, VisitTags};

/// Counts of work done, added up by a walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Boxes tested against a ray.
    pub boxes: u64,
    /// Cells visited by a grid or an octree.
    pub cells: u64,
    /// Splitting planes met.
    pub planes: u64,
    /// Solids and triangles intersected.
    pub solids: u64,
    /// Intersections that a tag saved.
    pub tags_saved: u64,
    /// Entries pushed on a heap.
    pub heap_pushes: u64,
    /// Lists that rounding had broken and that were repaired by membership. None should ever be.
    pub repaired: u64,
    /// Rays cast from a [`Seed`](crate::query::Seed) that met anything.
    pub seeded: u64,
    /// Those among them that met the body of their seed.
    pub seeded_right: u64,
}

/// One of the counts of [`Work`].
#[derive(Clone, Copy, Debug)]
pub struct Counter {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it counts, in a few words.
    pub summary: &'static str,
    /// Reads it.
    pub of: fn(&Work) -> u64,
}

/// All counts.
pub static COUNTERS: &[Counter] = &[
    Counter { name: "boxes", summary: "boxes tested", of: |w| w.boxes },
    Counter { name: "cells", summary: "cells visited", of: |w| w.cells },
    Counter { name: "planes", summary: "splitting planes met", of: |w| w.planes },
    Counter { name: "solids", summary: "solids and triangles intersected", of: |w| w.solids },
    Counter { name: "tags", summary: "intersections saved by tags", of: |w| w.tags_saved },
    Counter { name: "heap", summary: "entries pushed on heaps", of: |w| w.heap_pushes },
    Counter {
        name: "all",
        summary: "boxes, cells, planes and solids",
        of: |w| w.boxes + w.cells + w.planes + w.solids,
    },
];

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Work) {
        self.boxes += other.boxes;
        self.cells += other.cells;
        self.planes += other.planes;
        self.solids += other.solids;
        self.tags_saved += other.tags_saved;
        self.heap_pushes += other.heap_pushes;
        self.repaired += other.repaired;
        self.seeded += other.seeded;
        self.seeded_right += other.seeded_right;
    }
}

/// The memory of whoever walks; reused from ray to ray.
#[derive(Clone, Debug, Default)]
pub struct Scratch<'c> {
    /// Work counted so far.
    pub work: Work,
    /// Tags of the items of one structure at a time.
    pub tags: Tags,
    /// Steps, while they are recorded.
    pub log: Log,
    /// The triangles of the mesh asked last in whose planes the line runs, up to rounding.
    pub in_plane: Vec<u32>,
    /// What the ray may still cost.
    pub budget: Budget<'c>,
}

/// What a structure has still to offer to one ray, beginning not before `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pending {
    /// A true lower bound of every `t` at which the ray meets what is behind this.
    pub t: f64,
    /// What is behind it.
    pub what: Offer,
}

/// What a pending entry stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offer {
    /// A part of the structure, to be opened by [`Accelerator::open`]. The number is the structure's own.
    Part(u64),
    /// An item.
    Item(u32),
    /// An item whose own box the ray enters exactly at the bound, and that is offered once only: callers need not test its
    /// box again.
    Entered(u32),
}

/// Called with a run of items; answers the `t` beyond which nothing is wanted any more.
pub type Visit<'a> = dyn FnMut(&[u32], &mut Work) -> f64 + 'a;

/// A structure over the boxes of numbered items.
///
/// The same item may be proposed more than once, see [`Tags`]. Every item whose box the ray meets within its span is
/// proposed, with a bound not above the first such `t`.
pub trait Accelerator: Duplicate + Send + Sync + Debug {
    /// Appends what a walk begins with.
    fn start(&self, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work);

    /// Opens a part that was offered at `t`: appends what it consists of.
    fn open(&self, part: u64, t: f64, ray: &BoxRay, out: &mut Vec<Pending>, work: &mut Work);

    /// Ordered depth-first walk: visits runs of items, nearest first as far as the structure can tell, and
    /// skips what begins after the `t` last answered by `visit` (at first `t_max` of the span).
    fn walk(&self, ray: &BoxRay, work: &mut Work, visit: &mut Visit) {
        let mut limit = ray.span().t_max();
        let (mut stack, mut found) = (Vec::new(), Vec::new());
        self.start(ray, &mut found, work);
        loop {
            // Nearest on top; ties in the order proposed.
            found.reverse();
            found.sort_by(|a: &Pending, b: &Pending| b.t.total_cmp(&a.t));
            stack.append(&mut found);
            let Some(next) = stack.pop() else { return };
            if next.t > limit {
                continue;
            }
            match next.what {
                Offer::Part(part) => self.open(part, next.t, ray, &mut found, work),
                Offer::Item(item) | Offer::Entered(item) => limit = visit(&[item], work),
            }
        }
    }

    /// What a part is, in the structure's own words: for people who follow a ray step by step.
    fn describe(&self, part: u64, _ray: &BoxRay) -> String {
        format!("part {part}")
    }

    /// Follows items whose boxes have changed, where `boxes` tells the box of any item. `false` if the structure
    /// cannot follow, or would be bad: then it has to be built anew, and means nothing any more.
    fn refit(&mut self, _items: &[u32], _boxes: &dyn Fn(u32) -> Aabb) -> bool {
        false
    }

    /// Whether an item may be proposed more than once to a ray.
    fn repeats(&self) -> bool;

    /// Bytes used.
    fn memory(&self) -> usize;
}

/// Copies of what is known only as some accelerator. Whatever is [`Clone`] has this.
pub trait Duplicate {
    /// A copy.
    fn duplicate(&self) -> Box<dyn Accelerator>;
}

impl<A: Accelerator + Clone + 'static> Duplicate for A {
    fn duplicate(&self) -> Box<dyn Accelerator> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Accelerator> {
    fn clone(&self) -> Box<dyn Accelerator> {
        (**self).duplicate()
    }
}

/// What a structure is built over.
#[derive(Clone, Copy, Debug)]
pub struct Items<'a> {
    /// The boxes of items `0..boxes.len()`. Items with an empty box are never proposed.
    pub boxes: &'a [Aabb],
    /// What the user has put together: ranges of items, each within or beside any other, outer before inner
    /// and otherwise in order. `None` where nobody has grouped anything, as in a mesh.
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

/// The name of the structure that suits most.
pub const DEFAULT: &str = "bvh";

/// Declares the registry and stamps the conformance suite onto each entry.
macro_rules! registry {
    ($($name:ident => $build:expr),* $(,)?) => {
        /// The names of all accelerators.
        pub static NAMES: &[&str] = &[$(stringify!($name)),*];

        /// Builds the structure of a name; `None` if there is no such name.
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
    bvh_fast => |items| Box::new(bvh::Bvh::fast(items.boxes)),
    bvh => |items| Box::new(bvh::Bvh::balanced(items.boxes)),
    bvh_best => |items| Box::new(bvh::Bvh::best(items.boxes)),
    bvh_spheres => |items| Box::new(bvh::Bvh::spheres(items.boxes)),
    grid => |items| Box::new(grid::Grid::build(items.boxes)),
    octree => |items| Box::new(octree::Octree::build(items.boxes)),
    bsp => |items| Box::new(bsp::Bsp::<bsp::Axis>::build(items.boxes)),
    bsp_oblique => |items| Box::new(bsp::Bsp::<bsp::Oblique>::build(items.boxes)),
}
