//! Builds a binary tree by the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies"), to be collapsed into a wide one.

use super::binary::{BinaryNode, Bounds, ItemBox};
use super::collapse;
use super::{Frame, LEAF_SIZE, WideBvh};
use crate::aabb::Aabb;

/// The number of bins along each axis.
const BINS: usize = 16;

/// Deeper nodes are halved by count, so that no chain of nodes exhausts the stack.
const MAX_HEURISTIC_DEPTH: usize = 64;

/// Subtrees of at least this many items are built by two threads, where there are two.
const PARALLEL: usize = 4096;

/// Builds a tree over finite boxes that are not empty. Returns it with the items of each leaf.
pub(crate) fn build(boxes: &[Aabb]) -> (WideBvh, Vec<[u32; LEAF_SIZE]>) {
    let frame = Frame::of(&boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b)));
    let item_box = |(item, bounds): (u32, &Aabb)| {
        let [low, high] = frame.outward(bounds);
        ItemBox { low, item, high, unused: 0 }
    };
    let mut items: Vec<ItemBox> = (0..).zip(boxes).map(item_box).collect();
    if items.is_empty() {
        return (WideBvh::default(), Vec::new());
    }
    let mut nodes = vec![BinaryNode::UNUSED; 2 * items.len() - 1];
    split(&mut nodes, &mut items, 0, 0);
    collapse::collapse(frame, &nodes, &items)
}

/// Builds the subtree of a range of items that begins at `first`; returns the costs of its forests.
fn split(nodes: &mut [BinaryNode], items: &mut [ItemBox], first: u32, depth: usize) -> [f32; super::WIDTH] {
    let (mut bounds, mut centres) = (Bounds::EMPTY, Bounds::EMPTY);
    for item in &*items {
        bounds = bounds.union(item.bounds());
        let centre = item.centre();
        centres = centres.union(Bounds { low: centre, high: centre });
    }
    let count = items.len();
    let mut node = BinaryNode { bounds, first, count: count as u32, ..BinaryNode::UNUSED };
    let costs = if count <= LEAF_SIZE {
        collapse::of_leaf(&mut node)
    } else {
        let middle = if depth < MAX_HEURISTIC_DEPTH { partition(items, &centres) } else { count / 2 };
        let (left_items, right_items) = items.split_at_mut(middle);
        let (left_nodes, right_nodes) = nodes[1..].split_at_mut(2 * middle - 1);
        let mut left = || split(left_nodes, left_items, first, depth + 1);
        let mut right = || split(right_nodes, right_items, first + middle as u32, depth + 1);
        let costs = if count >= PARALLEL { rayon::join(left, right) } else { (left(), right()) };
        node.left = middle as u32;
        collapse::of_node(&mut node, &costs.0, &costs.1)
    };
    nodes[0] = node;
    costs
}

/// Sorts items to both sides of the best split; returns how many go left, at least one and not all.
fn partition(items: &mut [ItemBox], centres: &Bounds) -> usize {
    let count = items.len();
    let bins = Bins::of(items, centres);
    let Some((axis, bin)) = bins.best_split(count) else { return count / 2 };
    let goes_right = |item: &ItemBox| bins.bin_of(item, axis) >= bin;
    let (mut left, mut right) = (0, count);
    loop {
        while left < right && !goes_right(&items[left]) {
            left += 1;
        }
        while left < right && goes_right(&items[right - 1]) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        items.swap(left, right - 1);
    }
}

/// The items of a node, sorted into bins by their centres.
struct Bins {
    count: usize,
    start: [f32; 4],
    /// Bins per unit; 0 along an axis on which all centres agree.
    scale: [f32; 4],
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    fn of(items: &[ItemBox], centres: &Bounds) -> Bins {
        // Few items need few bins.
        let count = if items.len() < 2 * BINS { (items.len() / 2 + 2).min(BINS) } else { BINS };
        let scale = |axis: usize| {
            let size = centres.high[axis] - centres.low[axis];
            // Slightly less than the number of bins, so that the last centre is in the last bin.
            if size > 0.0 { count as f32 * 0.9999 / size } else { 0.0 }
        };
        let mut bins = Bins {
            count,
            start: centres.low,
            scale: [scale(0), scale(1), scale(2), 0.0],
            bounds: [[Bounds::EMPTY; BINS]; 3],
            counts: [[0; BINS]; 3],
        };
        for item in items {
            let bounds = item.bounds();
            let at = bins.bins_of(item);
            for (axis, bin) in at.into_iter().take(3).enumerate() {
                let bin = bin % BINS;
                bins.bounds[axis][bin] = bins.bounds[axis][bin].union(bounds);
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    #[inline(always)]
    fn bins_of(&self, item: &ItemBox) -> [usize; 4] {
        let centre = item.centre();
        std::array::from_fn(|i| ((centre[i] - self.start[i]) * self.scale[i]) as i32 as usize)
    }

    #[inline(always)]
    fn bin_of(&self, item: &ItemBox, axis: usize) -> usize {
        ((item.low[axis] + item.high[axis] - self.start[axis]) * self.scale[axis]) as i32 as usize
    }

    /// The axis and the first bin to the right of the split with the least cost; `None` if all centres agree.
    fn best_split(&self, count: usize) -> Option<(usize, usize)> {
        let (mut best, mut least) = (None, f32::INFINITY);
        for axis in 0..3 {
            if self.scale[axis] == 0.0 {
                continue;
            }
            let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
            let mut right_costs = [0.0; BINS];
            let (mut right, mut behind) = (Bounds::EMPTY, 0);
            for bin in (1..self.count).rev() {
                right = right.union(bounds[bin]);
                behind += counts[bin];
                right_costs[bin] = if behind == 0 { 0.0 } else { right.half_area() * behind as f32 };
            }
            let (mut left, mut before) = (Bounds::EMPTY, 0);
            for bin in 1..self.count {
                left = left.union(bounds[bin - 1]);
                before += counts[bin - 1];
                let cost = left.half_area() * before as f32 + right_costs[bin];
                if before > 0 && before < count as u32 && cost < least {
                    (best, least) = (Some((axis, bin)), cost);
                }
            }
        }
        best
    }
}
