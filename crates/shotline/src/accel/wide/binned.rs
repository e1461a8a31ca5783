//! Builds a binary tree by the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies"), to be collapsed into a wide one.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::ParallelSlice;

use super::binary::{BinaryNode, Content, Part};
use super::bins::{Binning, Bins, Split};
use super::bounds::{Bounds, Extent, ItemBox};
use super::emit::emit;
use super::{Frame, LEAF_COST, LEAF_SIZE, MAX_HEURISTIC_DEPTH, NONE, PARALLEL, WideBvh};
use crate::aabb::Aabb;
use crate::accel::collapse::{self, Costs};

/// Nodes of at least this many items are examined by several threads, this many at a time.
const CHUNK: usize = 1 << 15;

/// Builds a tree over items that have finite boxes, none of them empty, within given bounds. Returns it with the items
/// of each leaf.
pub(crate) fn build(
    bounds: &Aabb,
    count: usize,
    box_of: impl Fn(u32) -> Aabb + Sync,
) -> (WideBvh, Vec<[u32; LEAF_SIZE]>) {
    if count == 0 {
        return (WideBvh::default(), Vec::new());
    }
    let frame = Frame::of(bounds);
    let item_box = |item: u32| ItemBox::new(item, frame.outward(&box_of(item)));
    let mut items: Vec<ItemBox> =
        (0..count as u32).into_par_iter().with_min_len(PARALLEL).map(item_box).collect();
    let extent = extent_of(&items);
    let (tree, _) = build_part(&mut items, &extent, 0);
    drop(items);
    emit(frame, &tree)
}

fn build_part(items: &mut [ItemBox], extent: &Extent, depth: usize) -> (Part, Costs) {
    let count = items.len();
    if count < PARALLEL {
        let mut nodes = Vec::with_capacity(count);
        let costs = build_nodes(&mut nodes, items, extent, depth, &mut Bins::default());
        return (Part::Whole(nodes), costs);
    }
    let split = if depth < MAX_HEURISTIC_DEPTH { best_split(items, &extent.centres) } else { None };
    let (left_items, right_items) = divide(items, split);
    let build_side = |items: &mut [ItemBox]| {
        let extent = extent_of(items);
        build_part(items, &extent, depth + 1)
    };
    let ((left, left_costs), (right, right_costs)) =
        rayon::join(|| build_side(left_items), || build_side(right_items));
    let (forests, costs) = collapse::of_split(extent.bounds.half_area(), &left_costs, &right_costs);
    let node = BinaryNode::new(&extent.bounds, count, Content::Split { right: 0, forests });
    (Part::Split(node, Box::new([left, right])), costs)
}

/// Appends the nodes of a subtree.
fn build_nodes(
    nodes: &mut Vec<BinaryNode>,
    items: &mut [ItemBox],
    extent: &Extent,
    depth: usize,
    bins: &mut Bins,
) -> Costs {
    let count = items.len();
    if count <= LEAF_SIZE {
        let leaf = std::array::from_fn(|i| items.get(i).map_or(NONE, ItemBox::item));
        nodes.push(BinaryNode::new(&extent.bounds, count, Content::Leaf(leaf)));
        return collapse::of_leaf(extent.bounds.half_area() * LEAF_COST);
    }
    let split = if depth < MAX_HEURISTIC_DEPTH {
        bins.fill(items, Binning::of(count, &extent.centres));
        bins.best_split()
    } else {
        None
    };
    let (left_items, right_items) = divide(items, split);
    let index = nodes.len();
    nodes.push(BinaryNode::new(&extent.bounds, count, Content::Leaf([NONE; LEAF_SIZE])));
    let left_costs = build_nodes(nodes, left_items, &Extent::of(left_items), depth + 1, bins);
    let right = nodes.len() as u32;
    let right_costs = build_nodes(nodes, right_items, &Extent::of(right_items), depth + 1, bins);
    let (forests, costs) = collapse::of_split(extent.bounds.half_area(), &left_costs, &right_costs);
    nodes[index].content = Content::Split { right, forests };
    costs
}

/// Sorts items to both sides of a split, or halves them without one. No side is empty.
fn divide(items: &mut [ItemBox], split: Option<Split>) -> (&mut [ItemBox], &mut [ItemBox]) {
    let half = items.len() / 2;
    let left = split.map_or(half, |split| split.partition(items));
    items.split_at_mut(if left > 0 && left < items.len() { left } else { half })
}

fn extent_of(items: &[ItemBox]) -> Extent {
    items.par_chunks(CHUNK).map(Extent::of).reduce(|| Extent::EMPTY, Extent::union)
}

/// The best split of many items.
fn best_split(items: &[ItemBox], centres: &Bounds) -> Option<Split> {
    let binning = Binning::of(items.len(), centres);
    let bins_of = |items: &[ItemBox]| {
        let mut bins = Bins::default();
        bins.fill(items, binning);
        bins
    };
    items.par_chunks(CHUNK).map(bins_of).reduce_with(|a, b| a.merged(&b))?.best_split()
}
