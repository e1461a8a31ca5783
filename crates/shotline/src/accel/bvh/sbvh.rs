//! The high-quality builder: where the boxes of two children would overlap, a plane may cut the boxes of items
//! instead (Stich, Friedrich and Dietrich 2009, "Spatial splits in bounding volume hierarchies").

use super::binned_sah::{self, BINS, BOX_COST, MAX_HEURISTIC_DEPTH};
use super::{Bvh, MAX_LEAF, Node};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, bounding_box, cut, partition_by_plane, partition_unbounded};

/// Maximum mean number of references to an item. It bounds the memory.
const MAX_SPREAD: usize = 2;
/// Spatial splits are tried where the area of the children's overlap is more than this fraction of the root's.
const OVERLAP: f64 = 1e-5;

/// A node to split or to keep as a leaf. Splits in its subtree may add at most `spare` references.
struct Task {
    node: usize,
    items: Vec<PrimRef>,
    depth: usize,
    spare: usize,
}

pub(super) fn build(boxes: &[Aabb]) -> Bvh {
    let (items, unbounded) = partition_unbounded(boxes);
    let mut tree =
        Bvh { nodes: Vec::new(), items: Vec::new(), unbounded, has_duplicate_refs: false, refit_data: None };
    if items.is_empty() {
        return tree;
    }
    let count = items.len();
    let overlap = OVERLAP * bounding_box(&items).half_area();
    tree.nodes.push(unsplit_node(&items));
    let spare = items.len() * (MAX_SPREAD - 1);
    let mut tasks = vec![Task { node: 0, items, depth: 0, spare }];
    while let Some(Task { node, mut items, depth, spare }) = tasks.pop() {
        let Some([left, right]) = split(&mut items, &tree.nodes[node].bounds, depth, spare, overlap) else {
            tree.nodes[node].first = tree.items.len() as u32;
            tree.nodes[node].count = items.len() as u32;
            tree.items.extend(items.iter().map(|b| b.item));
            continue;
        };
        let first = tree.nodes.len();
        tree.nodes[node].first = first as u32;
        tree.nodes.extend([unsplit_node(&left), unsplit_node(&right)]);
        let listed = left.len() + right.len();
        let spare = spare - (listed - items.len());
        for (node, items) in [(first + 1, right), (first, left)] {
            let spare = spare * items.len() / listed;
            tasks.push(Task { node, items, depth: depth + 1, spare });
        }
    }
    tree.has_duplicate_refs = tree.items.len() > count;
    tree
}

fn unsplit_node(items: &[PrimRef]) -> Node<Aabb> {
    Node { bounds: bounding_box(items), first: 0, count: 0 }
}

/// The references of the two children; `None` to keep a leaf.
fn split(
    items: &mut [PrimRef],
    bounds: &Aabb,
    depth: usize,
    spare: usize,
    overlap: f64,
) -> Option<[Vec<PrimRef>; 2]> {
    if items.len() < 2 {
        return None;
    }
    let centres = binned_sah::centres(items);
    let object = binned_sah::best_split(items, &centres).filter(|_| depth < MAX_HEURISTIC_DEPTH);
    let object_cost = object.as_ref().map_or(f64::INFINITY, |split| split.cost);
    let left = match object {
        Some(split) => split.partition(items, &centres),
        None => binned_sah::split_at_median(items, &centres),
    };
    let (left, right) = items.split_at(left);
    let shared = bounding_box(left).intersection(&bounding_box(right)).half_area();
    let plane = (depth < MAX_HEURISTIC_DEPTH && shared > overlap)
        .then(|| best_plane(items, bounds, spare))
        .flatten()
        .filter(|plane| plane.cost < object_cost);
    let cost = plane.as_ref().map_or(object_cost, |plane| plane.cost);
    let leaf_cost = bounds.half_area() * items.len() as f64;
    if items.len() <= MAX_LEAF && cost + BOX_COST * bounds.half_area() >= leaf_cost {
        return None;
    }
    if let Some(Plane { axis, at, .. }) = plane {
        let (below, above) = partition_by_plane(items, axis, at);
        let fits = below.len() + above.len() <= items.len() + spare;
        if fits && !below.is_empty() && !above.is_empty() {
            return Some([below, above]);
        }
    }
    Some([left.to_vec(), right.to_vec()])
}

struct Plane {
    cost: f64,
    axis: usize,
    at: f64,
}

/// A bin: the box around the pieces of boxes in it, and the numbers of boxes that begin and that end in it.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    begun: usize,
    ended: usize,
}

/// The cheapest of evenly spaced planes on any axis that add at most `spare` references.
fn best_plane(items: &[PrimRef], bounds: &Aabb, spare: usize) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for axis in 0..3 {
        let (low, width) = (bounds.min[axis], bounds.size()[axis] / BINS as f64);
        let at = |bin: usize| low + width * bin as f64;
        let bin_of = |x: f64| (((x - low) / width) as usize).min(BINS - 1);
        let mut bins = [Bin { bounds: Aabb::EMPTY, begun: 0, ended: 0 }; BINS];
        for PrimRef { bounds, .. } in items {
            let (first, last) = (bin_of(bounds.min[axis]), bin_of(bounds.max[axis]));
            bins[first].begun += 1;
            bins[last].ended += 1;
            let mut rest = *bounds;
            for (bin, index) in bins[first..last].iter_mut().zip(first..) {
                let (piece, behind) = cut(&rest, axis, at(index + 1));
                bin.bounds = bin.bounds.union(&piece);
                rest = behind;
            }
            bins[last].bounds = bins[last].bounds.union(&rest);
        }
        let mut right = [(0.0, 0); BINS];
        let (mut behind, mut count) = (Aabb::EMPTY, 0);
        for bin in (1..BINS).rev() {
            behind = behind.union(&bins[bin].bounds);
            count += bins[bin].ended;
            right[bin] = (behind.half_area() * count as f64, count);
        }
        let (mut before, mut count) = (Aabb::EMPTY, 0);
        for bin in 1..BINS {
            before = before.union(&bins[bin - 1].bounds);
            count += bins[bin - 1].begun;
            let (right_cost, right_count) = right[bin];
            let cost = before.half_area() * count as f64 + right_cost;
            let fits = count > 0 && right_count > 0 && count + right_count <= items.len() + spare;
            if fits && best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Plane { cost, axis, at: at(bin) });
            }
        }
    }
    best
}
