//! What every structure sorts out first: items it can hold in cells, and items without finite bounds.

use crate::aabb::Aabb;

/// Boxes that reach farther count as infinite, so that no size and no area overflows.
const FARTHEST: f64 = 1e150;

/// An item with the box, or the part of it, that is to be held.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrimRef {
    pub bounds: Aabb,
    pub item: u32,
}

/// What a structure does with an item, by its box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoundsClass {
    /// Never proposed.
    Empty,
    /// Held.
    Bounded,
    /// Kept aside.
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

/// Items to be held by a structure, and those that are kept aside and proposed first. Items with an empty box
/// are in neither.
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

/// The box around all.
pub(super) fn bounding_box(items: &[PrimRef]) -> Aabb {
    items.iter().fold(Aabb::EMPTY, |all, item| all.union(&item.bounds))
}

/// The parts of a box below and above a plane.
pub(super) fn cut(bounds: &Aabb, axis: usize, at: f64) -> (Aabb, Aabb) {
    let (mut low, mut high) = (*bounds, *bounds);
    low.max[axis] = low.max[axis].min(at);
    high.min[axis] = high.min[axis].max(at);
    (low, high)
}

/// Items below and above a plane, or what of them is. A box that ends at the plane does not reach behind it.
pub(super) fn divide(items: &[PrimRef], axis: usize, at: f64) -> (Vec<PrimRef>, Vec<PrimRef>) {
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

/// What the chance of a line to meet a box within `whole` is proportional to: the surface, or where `whole` has
/// none the edges.
pub(super) fn measure(whole: &Aabb) -> fn(&Aabb) -> f64 {
    if whole.half_area() > 0.0 { Aabb::half_area } else { |b| b.size().element_sum() }
}
