//! References to items during a build. Every builder first separates the items with finite bounds from those without.

use crate::aabb::Aabb;

/// Boxes that extend farther count as unbounded, so that no size and no area overflows.
const FARTHEST: f64 = 1e150;

/// A reference to an item, with its box or a piece of its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimRef {
    pub bounds: Aabb,
    pub item: u32,
}

/// How a structure stores an item, by its box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundsClass {
    /// Never proposed.
    Empty,
    /// Stored in the tree or the cells.
    Bounded,
    /// Stored in a separate list, and proposed first.
    Unbounded,
}

impl BoundsClass {
    pub(super) fn of(bounds: &Aabb) -> BoundsClass {
        if bounds.is_empty() {
            BoundsClass::Empty
        } else if bounds.min.abs().max(bounds.max.abs()).max_element() <= FARTHEST {
            BoundsClass::Bounded
        } else {
            BoundsClass::Unbounded
        }
    }
}

/// References to the bounded items, and the unbounded items. Items with an empty box are in neither.
pub(super) fn partition_unbounded(boxes: &[Aabb]) -> (Vec<PrimRef>, Vec<u32>) {
    let (mut bounded, mut unbounded) = (Vec::with_capacity(boxes.len()), Vec::new());
    for (item, &bounds) in (0..).zip(boxes) {
        match BoundsClass::of(&bounds) {
            BoundsClass::Empty => {}
            BoundsClass::Bounded => bounded.push(PrimRef { bounds, item }),
            BoundsClass::Unbounded => unbounded.push(item),
        }
    }
    (bounded, unbounded)
}

/// The box around all items.
pub(super) fn bounding_box(items: &[PrimRef]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, item| all.union(&item.bounds))
}

/// The pieces of a box below and above a plane.
pub(super) fn cut(bounds: &Aabb, axis: usize, at: f64) -> (Aabb, Aabb) {
    let (mut low, mut high) = (*bounds, *bounds);
    low.max[axis] = low.max[axis].min(at);
    high.min[axis] = high.min[axis].max(at);
    (low, high)
}

/// The items below and above a plane, with their boxes clipped to it. A box that ends at the plane is not above it.
pub(super) fn partition_by_plane(items: &[PrimRef], axis: usize, at: f64) -> (Vec<PrimRef>, Vec<PrimRef>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for &PrimRef { bounds, item } in items {
        let (low, high) = cut(&bounds, axis, at);
        let is_above = bounds.max[axis] > at;
        if is_above {
            above.push(PrimRef { bounds: high, item });
        }
        if bounds.min[axis] < at || !is_above {
            below.push(PrimRef { bounds: low, item });
        }
    }
    (below, above)
}

/// A measure proportional to the probability that a line meets a box within `whole`: the surface area, or the sum of
/// the edge lengths where `whole` has no area.
pub(super) fn measure(whole: &Aabb) -> fn(&Aabb) -> f64 {
    if whole.half_area() > 0.0 { Aabb::half_area } else { |b| b.size().element_sum() }
}
