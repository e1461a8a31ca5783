//! Cuts triangles at planes, and finds the best plane to cut them at.

use super::bounds::{Bounds, ItemBox};
use super::frame;
use crate::math::Vec3;

/// A triangle in the coordinates of the tree's frame.
pub(super) type Triangle = [Vec3; 3];

/// The boxes around the parts of a triangle below and above a plane, each also within a box around the part that is
/// already known. They are padded as all boxes are.
pub(super) fn cut(corners: &Triangle, within: &Bounds, axis: usize, at: f32) -> [Bounds; 2] {
    let at = f64::from(at);
    let mut low = [Vec3::INFINITY; 2];
    let mut high = [Vec3::NEG_INFINITY; 2];
    let mut take = |side: usize, p: Vec3| {
        low[side] = low[side].min(p);
        high[side] = high[side].max(p);
    };
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if a[axis] <= at {
            take(0, a);
        }
        if a[axis] >= at {
            take(1, a);
        }
        if (a[axis] < at && at < b[axis]) || (b[axis] < at && at < a[axis]) {
            // Rounded by far less than the pad.
            let mut p = a + (b - a) * ((at - a[axis]) / (b[axis] - a[axis]));
            p[axis] = at;
            take(0, p);
            take(1, p);
        }
    }
    [0, 1].map(|side: usize| match low[side].cmple(high[side]).all() {
        true => Bounds::of(frame::padded(low[side], high[side])).intersection(*within),
        false => Bounds::EMPTY,
    })
}

/// A plane at which references are cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub axis: usize,
    pub at: f32,
    /// The sum over both sides of half the area times the number of references.
    pub cost: f32,
}

/// The number of bins along each axis.
const BINS: usize = 16;

/// A bin: the box around the parts of triangles in it, and the numbers of references that begin and that end in it.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    begun: usize,
    ended: usize,
}

/// The cheapest of evenly spaced planes on any axis that add at most `spare` references.
pub(super) fn best_plane(
    references: &[ItemBox],
    bounds: &Bounds,
    spare: usize,
    triangle: &(dyn Fn(u32) -> Triangle + Sync),
) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let (low, width) = (bounds.low(axis), bounds.size(axis) / BINS as f32);
        if width <= 0.0 {
            continue;
        }
        let at = |bin: usize| low + width * bin as f32;
        let bin_of = |x: f32| (((x - low) / width) as usize).min(BINS - 1);
        let mut bins = [Bin { bounds: Bounds::EMPTY, begun: 0, ended: 0 }; BINS];
        for reference in references {
            let mut rest = reference.bounds();
            let (first, last) = (bin_of(rest.low(axis)), bin_of(rest.high(axis)));
            bins[first].begun += 1;
            bins[last].ended += 1;
            if first < last {
                let corners = triangle(reference.item());
                for (bin, index) in bins[first..last].iter_mut().zip(first..) {
                    let [part, behind] = cut(&corners, &rest, axis, at(index + 1));
                    bin.bounds = bin.bounds.union(part.or_empty());
                    rest = behind;
                }
            }
            bins[last].bounds = bins[last].bounds.union(rest.or_empty());
        }
        let mut right = [(0.0, 0); BINS];
        let (mut behind, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            behind = behind.union(bins[bin].bounds);
            count += bins[bin].ended;
            right[bin] = (behind.half_area() * count as f32, count);
        }
        let (mut before, mut count) = (Bounds::EMPTY, 0);
        for bin in 1..BINS {
            before = before.union(bins[bin - 1].bounds);
            count += bins[bin - 1].begun;
            let (right_cost, right_count) = right[bin];
            let cost = before.half_area() * count as f32 + right_cost;
            let fits = count > 0 && right_count > 0 && count + right_count <= references.len() + spare;
            if fits && best.is_none_or(|best| cost < best.cost) {
                best = Some(Plane { axis, at: at(bin), cost });
            }
        }
    }
    best
}
