//! The default builder: the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies").

use super::{Bvh, MAX_DEPTH, Node};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, bounding_box, partition_unbounded};
use crate::math::Vec3;

pub(super) const BINS: usize = 16;
/// The cost of a box test, in units of an item test.
pub(super) const BOX_COST: f64 = 1.0;
/// Deeper nodes are halved by count, which adds at most 32 levels.
pub(super) const MAX_HEURISTIC_DEPTH: usize = MAX_DEPTH - 34;

/// A node to split, with its range of entries.
struct Task {
    node: usize,
    start: usize,
    end: usize,
    depth: usize,
}

/// Builds a tree. A leaf of at most `max_leaf` items is split only if the heuristic gains by it.
pub(super) fn build(boxes: &[Aabb], max_leaf: usize) -> Bvh {
    let (mut entries, unbounded) = partition_unbounded(boxes);
    let mut nodes = Vec::new();
    if !entries.is_empty() {
        nodes.push(leaf(&entries, 0));
        split_all(&mut nodes, &mut entries, max_leaf);
    }
    Bvh {
        nodes,
        items: entries.iter().map(|e| e.item).collect(),
        unbounded,
        has_duplicate_refs: false,
        refit_data: None,
    }
}

fn leaf(entries: &[PrimRef], start: usize) -> Node<Aabb> {
    Node { bounds: bounding_box(entries), first: start as u32, count: entries.len() as u32 }
}

/// Splits leaves while that lowers the cost. Works depth first, so that nodes close in the tree are close in memory.
fn split_all(nodes: &mut Vec<Node<Aabb>>, entries: &mut [PrimRef], max_leaf: usize) {
    let mut tasks = vec![Task { node: 0, start: 0, end: entries.len(), depth: 0 }];
    while let Some(Task { node, start, end, depth }) = tasks.pop() {
        let range = &mut entries[start..end];
        let Some(left) = split(range, &nodes[node].bounds, depth, max_leaf) else { continue };
        let middle = start + left;
        let first = nodes.len();
        nodes[node].first = first as u32;
        nodes[node].count = 0;
        nodes.push(leaf(&range[..left], start));
        nodes.push(leaf(&range[left..], middle));
        tasks.push(Task { node: first + 1, start: middle, end, depth: depth + 1 });
        tasks.push(Task { node: first, start, end: middle, depth: depth + 1 });
    }
}

/// Partitions the entries of a node. Returns how many go left, or `None` to keep a leaf.
fn split(entries: &mut [PrimRef], bounds: &Aabb, depth: usize, max_leaf: usize) -> Option<usize> {
    if entries.len() < 2 {
        return None;
    }
    let centres = centres(entries);
    if depth < MAX_HEURISTIC_DEPTH
        && let Some(best) = best_split(entries, &centres)
    {
        let leaf_cost = bounds.half_area() * entries.len() as f64;
        if entries.len() <= max_leaf && best.cost + BOX_COST * bounds.half_area() >= leaf_cost {
            return None;
        }
        return Some(best.partition(entries, &centres));
    }
    // All centres are in one bin, or the node is too deep for the heuristic: halve by count.
    if entries.len() <= max_leaf {
        return None;
    }
    Some(split_at_median(entries, &centres))
}

/// The box around the centres of the entries.
pub(super) fn centres(entries: &[PrimRef]) -> Aabb {
    Aabb::around(entries.iter().map(|e| e.bounds.centre()))
}

/// Moves the lower half of the entries, by count along the longest axis, to the front. Returns its length.
pub(super) fn split_at_median(entries: &mut [PrimRef], centres: &Aabb) -> usize {
    let axis = largest_axis(centres.size());
    let middle = entries.len() / 2;
    let along = |e: &PrimRef| e.bounds.centre()[axis];
    entries.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)).then(a.item.cmp(&b.item)));
    middle
}

/// Bins along one axis of the box of the centres.
struct Binning {
    axis: usize,
    low: f64,
    scale: f64,
}

impl Binning {
    fn new(centres: &Aabb, axis: usize) -> Binning {
        Binning { axis, low: centres.min[axis], scale: BINS as f64 / centres.size()[axis] }
    }

    fn of(&self, entry: &PrimRef) -> usize {
        (((entry.bounds.centre()[self.axis] - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

/// A split at the border between two bins.
pub(super) struct Split {
    pub cost: f64,
    axis: usize,
    /// Entries in lower bins go left.
    bin: usize,
}

impl Split {
    /// Moves the entries that go left to the front. Returns their number.
    pub(super) fn partition(&self, entries: &mut [PrimRef], centres: &Aabb) -> usize {
        let bins = Binning::new(centres, self.axis);
        let mut left = 0;
        for i in 0..entries.len() {
            if bins.of(&entries[i]) < self.bin {
                entries.swap(i, left);
                left += 1;
            }
        }
        left
    }
}

/// The cheapest split on any axis; `None` if on every axis all centres are in one bin.
pub(super) fn best_split(entries: &[PrimRef], centres: &Aabb) -> Option<Split> {
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        let bins = Binning::new(centres, axis);
        if !bins.scale.is_finite() {
            continue;
        }
        let mut boxes = [Aabb::EMPTY; BINS];
        let mut counts = [0usize; BINS];
        for e in entries {
            let bin = bins.of(e);
            boxes[bin] = boxes[bin].union(&e.bounds);
            counts[bin] += 1;
        }
        // A sweep from the right computes the cost right of each border. A sweep from the left adds the rest.
        let mut right_cost = [0.0; BINS];
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(&boxes[bin]);
            count += counts[bin];
            right_cost[bin] = bounds.half_area() * count as f64;
        }
        let (mut bounds, mut left) = (Aabb::EMPTY, 0);
        for bin in 1..BINS {
            bounds = bounds.union(&boxes[bin - 1]);
            left += counts[bin - 1];
            if left == 0 || left == entries.len() {
                continue;
            }
            let cost = bounds.half_area() * left as f64 + right_cost[bin];
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Split { cost, axis, bin });
            }
        }
    }
    best
}

fn largest_axis(v: Vec3) -> usize {
    (0..3).max_by(|&a, &b| v[a].total_cmp(&v[b])).unwrap_or(0)
}
