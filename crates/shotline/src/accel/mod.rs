//! Accelerators: structures over boxes that propose items in ascending `t`. They see boxes and item numbers,
//! never solids; what an item is, and tagging, is the business of whoever walks them.

mod brute;
mod bsp;
mod bvh;
mod display;
mod grid;
mod hierarchy;
mod octree;
mod prim_ref;

use std::fmt::Debug;
use std::ops::Range;

use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;

/// What a structure has still to offer to one ray, beginning not before `t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueueEntry {
    /// A true lower bound of every `t` at which the ray meets what is behind this.
    pub t: f64,
    /// What is behind it.
    pub child: Child,
}

/// What a pending entry stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// A part of the structure, to be opened by [`Accelerator::open`]. The number is the structure's own.
    Node(u64),
    /// An item.
    Item(u32),
    /// An item whose own box the ray enters exactly at the bound, and that is offered once only: callers need not test its
    /// box again.
    Entered(u32),
}

/// Called with a run of items; answers the `t` beyond which nothing is wanted any more.
pub type Visitor<'a> = dyn FnMut(&[u32], &mut Counters) -> f64 + 'a;

/// A structure over the boxes of numbered items.
///
/// The same item may be proposed more than once, see [`Tags`](crate::tags::Tags). Every item whose box the ray meets within its span is
/// proposed, with a bound not above the first such `t`.
pub trait Accelerator: CloneBoxed + Send + Sync + Debug {
    /// Appends what a walk begins with.
    fn roots(&self, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters);

    /// Opens a part that was offered at `t`: appends what it consists of.
    fn expand(&self, node: u64, t: f64, ray: &BoxRay, out: &mut Vec<QueueEntry>, counters: &mut Counters);

    /// Ordered depth-first walk: visits runs of items, nearest first as far as the structure can tell, and
    /// skips what begins after the `t` last answered by `visit` (at first `t_max` of the span).
    fn traverse(&self, ray: &BoxRay, counters: &mut Counters, visit: &mut Visitor) {
        let mut limit = ray.span().t_max();
        let (mut stack, mut found) = (Vec::new(), Vec::new());
        self.roots(ray, &mut found, counters);
        loop {
            // Nearest on top; ties in the order proposed.
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

    /// What a part is, in the structure's own words: for people who follow a ray step by step.
    fn describe(&self, node: u64, _ray: &BoxRay) -> String {
        format!("node {node}")
    }

    /// Follows items whose boxes have changed, where `boxes` tells the box of any item. `false` if the structure
    /// cannot follow, or would be bad: then it has to be built anew, and means nothing any more.
    fn refit(&mut self, _items: &[u32], _boxes: &dyn Fn(u32) -> Aabb) -> bool {
        false
    }

    /// Whether an item may be proposed more than once to a ray.
    fn has_duplicate_refs(&self) -> bool;

    /// Bytes used.
    fn memory(&self) -> usize;
}

/// Copies of what is known only as some accelerator. Whatever is [`Clone`] has this.
pub trait CloneBoxed {
    /// A copy.
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
    bvh_fast => |items| Box::new(bvh::Bvh::lbvh(items.boxes)),
    bvh => |items| Box::new(bvh::Bvh::binned_sah(items.boxes)),
    bvh_best => |items| Box::new(bvh::Bvh::sbvh(items.boxes)),
    bvh_spheres => |items| Box::new(bvh::Bvh::spheres(items.boxes)),
    grid => |items| Box::new(grid::Grid::build(items.boxes)),
    octree => |items| Box::new(octree::Octree::build(items.boxes)),
    bsp => |items| Box::new(bsp::Bsp::<bsp::Axis>::build(items.boxes)),
    bsp_oblique => |items| Box::new(bsp::Bsp::<bsp::Oblique>::build(items.boxes)),
}
