//! Builds a binary tree by the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies"), to be collapsed into a wide one.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::ParallelSlice;

use super::binary::{BinaryNode, Content, Part};
use super::bins::{Binning, Bins, Split};
use super::bounds::{Centres, Extent, ItemBox};
use super::emit::emit;
use super::{Frame, LEAF_COST, LEAF_SIZE, MAX_HEURISTIC_DEPTH, NONE, PARALLEL, WideBvh};
use crate::aabb::Aabb;
use crate::accel::collapse::{self, Costs};
use crate::simd::{Simd, Task, dispatch};

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
        let bins = &mut Bins::default();
        let costs = dispatch(Nodes { nodes: &mut nodes, items, extent, depth, bins });
        return (Part::Whole(nodes), costs);
    }
    let split = if depth < MAX_HEURISTIC_DEPTH { best_split(items, &extent.centres) } else { None };
    let [left, right] = dispatch(Divide { items, split });
    let build_side = |(items, extent): (&mut [ItemBox], Extent)| build_part(items, &extent, depth + 1);
    let ((left, left_costs), (right, right_costs)) = rayon::join(|| build_side(left), || build_side(right));
    let (forests, costs) = collapse::of_split(extent.bounds.half_area(), &left_costs, &right_costs);
    let node = BinaryNode::new(&extent.bounds, count, Content::Split { right: 0, forests });
    (Part::Split(node, Box::new([left, right])), costs)
}

/// Appends the nodes of a subtree.
struct Nodes<'a> {
    nodes: &'a mut Vec<BinaryNode>,
    items: &'a mut [ItemBox],
    extent: &'a Extent,
    depth: usize,
    bins: &'a mut Bins,
}

impl Task for Nodes<'_> {
    type Output = Costs;

    #[inline(always)]
    fn run<S: Simd>(self) -> Costs {
        let Nodes { nodes, items, extent, depth, bins } = self;
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
        let [left, right] = Divide { items, split }.run::<S>();
        let index = nodes.len();
        nodes.push(BinaryNode::new(&extent.bounds, count, Content::Leaf([NONE; LEAF_SIZE])));
        let mut build_side = |nodes: &mut Vec<BinaryNode>, (items, extent): (&mut [ItemBox], Extent)| {
            S::call(Nodes { nodes, items, extent: &extent, depth: depth + 1, bins })
        };
        let left_costs = build_side(nodes, left);
        let right_index = nodes.len() as u32;
        let right_costs = build_side(nodes, right);
        let (forests, costs) = collapse::of_split(extent.bounds.half_area(), &left_costs, &right_costs);
        nodes[index].content = Content::Split { right: right_index, forests };
        costs
    }
}

/// Sorts items to both sides of a split, or halves them without one. No side is empty.
struct Divide<'a> {
    items: &'a mut [ItemBox],
    split: Option<Split>,
}

impl<'a> Task for Divide<'a> {
    type Output = [(&'a mut [ItemBox], Extent); 2];

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Divide { items, split } = self;
        if let Some(split) = split {
            let (count, [left_extent, right_extent]) = split.partition(items);
            if count > 0 && count < items.len() {
                let (left, right) = items.split_at_mut(count);
                return [(left, left_extent), (right, right_extent)];
            }
        }
        let (left, right) = items.split_at_mut(items.len() / 2);
        let extents = [Extent::of(left), Extent::of(right)];
        [(left, extents[0]), (right, extents[1])]
    }
}

fn extent_of(items: &[ItemBox]) -> Extent {
    items.par_chunks(CHUNK).map(Extent::of).reduce(|| Extent::EMPTY, Extent::union)
}

/// The best split of many items.
fn best_split(items: &[ItemBox], centres: &Centres) -> Option<Split> {
    let binning = Binning::of(items.len(), centres);
    let bins_of = |items| dispatch(BinsOf { items, binning });
    items.par_chunks(CHUNK).map(bins_of).reduce_with(|a, b| a.merged(&b))?.best_split()
}

/// Sorts items into bins.
struct BinsOf<'a> {
    items: &'a [ItemBox],
    binning: Binning,
}

impl Task for BinsOf<'_> {
    type Output = Bins;

    #[inline(always)]
    fn run<S: Simd>(self) -> Bins {
        let mut bins = Bins::default();
        bins.fill(self.items, self.binning);
        bins
    }
}
