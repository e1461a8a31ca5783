//! The default builder: the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies").

use super::{Bvh, MAX_DEPTH, Node};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, partition_unbounded};
use crate::math::Vec3;
use crate::pool;

pub(super) const BINS: usize = 16;
/// The cost of a box test, in units of an item test.
pub(super) const BOX_COST: f64 = 1.0;
/// Deeper nodes are halved by count, which adds at most 32 levels.
pub(super) const MAX_HEURISTIC_DEPTH: usize = MAX_DEPTH - 34;

/// Nodes of at least this many entries are divided into parts, which different threads may build.
const PARALLEL: usize = 1 << 14;

/// A node to split, with its range of entries.
struct Task {
    node: usize,
    start: usize,
    end: usize,
    depth: usize,
    centres: Aabb,
}

/// The box around some entries, and that around their centres.
#[derive(Clone, Copy)]
struct Extent {
    bounds: Aabb,
    centres: Aabb,
}

impl Extent {
    fn of(entries: &[PrimRef]) -> Extent {
        let empty = Extent { bounds: Aabb::EMPTY, centres: Aabb::EMPTY };
        entries.iter().fold(empty, |all, PrimRef { bounds, .. }| {
            let centre = bounds.centre();
            Extent {
                bounds: all.bounds.union(bounds),
                centres: all.centres.union(&Aabb { min: centre, max: centre }),
            }
        })
    }
}

/// A part of the tree. Its division into parts depends on the numbers of entries only, so the tree is the same for any
/// number of threads.
enum Part {
    /// A node with many entries, and its children.
    Split(Aabb, Box<[Part; 2]>),
    /// A subtree, whose root is its node 0.
    Whole(Vec<Node<Aabb>>),
}

/// Builds a tree. A leaf of at most `max_leaf` items is split only if the heuristic gains by it.
pub(super) fn build(boxes: &[Aabb], max_leaf: usize) -> Bvh {
    let (mut entries, unbounded) = partition_unbounded(boxes);
    let nodes = if entries.is_empty() {
        Vec::new()
    } else {
        let extent = Extent::of(&entries);
        let entries = &mut entries[..];
        if entries.len() < PARALLEL {
            build_part(entries, 0, &extent, 0, max_leaf).into_nodes()
        } else {
            pool::divided(|| build_part(entries, 0, &extent, 0, max_leaf).into_nodes())
        }
    };
    Bvh {
        nodes,
        items: entries.iter().map(|e| e.item).collect(),
        unbounded,
        has_duplicate_refs: false,
        refit_data: None,
    }
}

/// Builds the subtree of entries that are the tree's from number `start` on.
fn build_part(entries: &mut [PrimRef], start: usize, extent: &Extent, depth: usize, max_leaf: usize) -> Part {
    let mut bins = Bins::new();
    if entries.len() >= PARALLEL
        && let Some(middle) = split(entries, &extent.bounds, &extent.centres, depth, max_leaf, &mut bins)
    {
        let (left, right) = entries.split_at_mut(middle);
        let side = |entries: &mut [PrimRef], start| {
            build_part(entries, start, &Extent::of(entries), depth + 1, max_leaf)
        };
        let (left, right) = rayon::join(|| side(left, start), || side(right, start + middle));
        return Part::Split(extent.bounds, Box::new([left, right]));
    }
    let mut nodes = Vec::with_capacity(2 * entries.len());
    nodes.push(leaf(&extent.bounds, entries, start));
    split_all(
        &mut nodes,
        entries,
        start,
        Task { node: 0, start: 0, end: entries.len(), depth, centres: extent.centres },
        max_leaf,
    );
    Part::Whole(nodes)
}

impl Part {
    fn into_nodes(self) -> Vec<Node<Aabb>> {
        match self {
            Part::Whole(nodes) => nodes,
            Part::Split(bounds, _) => {
                let mut nodes = vec![Node { bounds, first: 0, count: 0 }];
                self.append(0, &mut nodes);
                nodes
            }
        }
    }

    /// Writes the root to a place that is there already, and appends everything below it.
    fn append(self, root: usize, nodes: &mut Vec<Node<Aabb>>) {
        let first = nodes.len();
        match self {
            Part::Split(bounds, children) => {
                nodes[root] = Node { bounds, first: first as u32, count: 0 };
                nodes.extend([nodes[root]; 2]);
                let [left, right] = *children;
                left.append(first, nodes);
                right.append(first + 1, nodes);
            }
            Part::Whole(part) => {
                nodes[root] = moved(&part[0], first);
                nodes.extend(part[1..].iter().map(|node| moved(node, first)));
            }
        }
    }
}

/// A node of a part whose nodes below the root come from number `first` on.
fn moved(node: &Node<Aabb>, first: usize) -> Node<Aabb> {
    let shift = if node.count == 0 { first - 1 } else { 0 };
    Node { first: node.first + shift as u32, ..*node }
}

fn leaf(bounds: &Aabb, entries: &[PrimRef], start: usize) -> Node<Aabb> {
    Node { bounds: *bounds, first: start as u32, count: entries.len() as u32 }
}

/// Splits leaves while that lowers the cost. Works depth first, so that nodes close in the tree are close in memory.
fn split_all(
    nodes: &mut Vec<Node<Aabb>>,
    entries: &mut [PrimRef],
    offset: usize,
    root: Task,
    max_leaf: usize,
) {
    let mut bins = Bins::new();
    let mut tasks = vec![root];
    while let Some(Task { node, start, end, depth, centres }) = tasks.pop() {
        let range = &mut entries[start..end];
        let Some(left) = split(range, &nodes[node].bounds, &centres, depth, max_leaf, &mut bins) else {
            continue;
        };
        let (middle, first) = (start + left, nodes.len());
        nodes[node].first = first as u32;
        nodes[node].count = 0;
        let (left, right) = range.split_at(left);
        let of = [left, right].map(Extent::of);
        nodes.push(leaf(&of[0].bounds, left, offset + start));
        nodes.push(leaf(&of[1].bounds, right, offset + middle));
        let depth = depth + 1;
        tasks.push(Task { node: first + 1, start: middle, end, depth, centres: of[1].centres });
        tasks.push(Task { node: first, start, end: middle, depth, centres: of[0].centres });
    }
}

/// Partitions the entries of a node. Returns how many go left, or `None` to keep a leaf.
fn split(
    entries: &mut [PrimRef],
    bounds: &Aabb,
    centres: &Aabb,
    depth: usize,
    max_leaf: usize,
    bins: &mut Bins,
) -> Option<usize> {
    if entries.len() < 2 {
        return None;
    }
    if depth < MAX_HEURISTIC_DEPTH
        && let Some(best) = bins.best_split(entries, centres)
    {
        let leaf_cost = bounds.half_area() * entries.len() as f64;
        if entries.len() <= max_leaf && best.cost + BOX_COST * bounds.half_area() >= leaf_cost {
            return None;
        }
        return Some(best.partition(entries, centres));
    }
    // All centres are in one bin, or the node is too deep for the heuristic: halve by count.
    if entries.len() <= max_leaf {
        return None;
    }
    Some(split_at_median(entries, centres))
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

    fn of(&self, centre: Vec3) -> usize {
        (((centre[self.axis] - self.low) * self.scale) as usize).min(BINS - 1)
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
            if bins.of(entries[i].bounds.centre()) < self.bin {
                entries.swap(i, left);
                left += 1;
            }
        }
        left
    }
}

/// The cheapest split on any axis; `None` if on every axis all centres are in one bin.
pub(super) fn best_split(entries: &[PrimRef], centres: &Aabb) -> Option<Split> {
    Bins::new().best_split(entries, centres)
}

/// The entries of a node by bin, along each axis.
struct Bins {
    /// The boxes around the entries of each bin; of an empty bin that of a node before.
    boxes: [[Aabb; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    fn new() -> Bins {
        Bins { boxes: [[Aabb::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] }
    }

    fn best_split(&mut self, entries: &[PrimRef], centres: &Aabb) -> Option<Split> {
        let binnings = [0, 1, 2].map(|axis| Binning::new(centres, axis));
        self.fill(entries, &binnings);
        let mut best = None;
        for (axis, binning) in binnings.iter().enumerate() {
            if binning.scale.is_finite() {
                self.sweep(axis, &mut best);
            }
        }
        best
    }

    fn fill(&mut self, entries: &[PrimRef], binnings: &[Binning; 3]) {
        self.counts = [[0; BINS]; 3];
        for entry in entries {
            let centre = entry.bounds.centre();
            for (axis, binning) in binnings.iter().enumerate() {
                let bin = binning.of(centre);
                let (of_bin, count) = (&mut self.boxes[axis][bin], &mut self.counts[axis][bin]);
                *of_bin = if *count == 0 { entry.bounds } else { of_bin.union(&entry.bounds) };
                *count += 1;
            }
        }
    }

    /// Compares the borders between the bins of an axis with the best split so far. Only the border behind a bin with
    /// entries is looked at, as most nodes have few: further borders up to the next such bin cost the same.
    fn sweep(&self, axis: usize, best: &mut Option<Split>) {
        let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
        let (mut filled, mut number) = ([0; BINS], 0);
        for (bin, &count) in counts.iter().enumerate() {
            filled[number] = bin;
            number += usize::from(count > 0);
        }
        let filled = &filled[..number];
        // A sweep from the right computes the cost right of each border. A sweep from the left adds the rest.
        let mut right_cost = [0.0; BINS];
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for (border, &bin) in filled.iter().enumerate().skip(1).rev() {
            bounds = bounds.union(&boxes[bin]);
            count += counts[bin];
            right_cost[border] = bounds.half_area() * f64::from(count);
        }
        let (mut bounds, mut left) = (Aabb::EMPTY, 0);
        for (border, pair) in (1..).zip(filled.windows(2)) {
            bounds = bounds.union(&boxes[pair[0]]);
            left += counts[pair[0]];
            let cost = bounds.half_area() * f64::from(left) + right_cost[border];
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                *best = Some(Split { cost, axis, bin: pair[0] + 1 });
            }
        }
    }
}

fn largest_axis(v: Vec3) -> usize {
    (0..3).max_by(|&a, &b| v[a].total_cmp(&v[b])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::prim_ref::bounding_box;
    use crate::testkit::random::Random;

    fn random_boxes(random: &mut Random, count: usize) -> Vec<Aabb> {
        let mut random_box = |_| {
            let corner = random.point(-1.0, 1.0);
            Aabb::new(corner, corner + random.point(0.0, 0.1))
        };
        (0..count).map(&mut random_box).collect()
    }

    /// The cost of every border, from the definition of the heuristic.
    fn least_cost(entries: &[PrimRef], centres: &Aabb) -> f64 {
        let mut least = f64::INFINITY;
        for axis in 0..3 {
            let binning = Binning::new(centres, axis);
            for border in 1..BINS {
                let is_left = |entry: &&PrimRef| binning.of(entry.bounds.centre()) < border;
                let left: Vec<PrimRef> = entries.iter().filter(is_left).copied().collect();
                let right: Vec<PrimRef> = entries.iter().filter(|entry| !is_left(entry)).copied().collect();
                if !left.is_empty() && !right.is_empty() {
                    let cost = |side: &[PrimRef]| bounding_box(side).half_area() * side.len() as f64;
                    least = least.min(cost(&left) + cost(&right));
                }
            }
        }
        least
    }

    #[test]
    fn no_border_between_bins_costs_less() {
        let mut random = Random::new(9);
        let mut bins = Bins::new();
        for count in (2..60).chain([500]) {
            let (mut entries, _) = partition_unbounded(&random_boxes(&mut random, count));
            let extent = Extent::of(&entries);
            let split = bins.best_split(&entries, &extent.centres).expect("they are apart");
            assert_eq!(split.cost, least_cost(&entries, &extent.centres));
            let left = split.partition(&mut entries, &extent.centres);
            let cost = |side: &[PrimRef]| bounding_box(side).half_area() * side.len() as f64;
            assert_eq!(split.cost, cost(&entries[..left]) + cost(&entries[left..]));
        }
    }

    #[test]
    fn any_number_of_threads_builds_the_same_tree() {
        let boxes = random_boxes(&mut Random::new(10), 5 * PARALLEL);
        let tree = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| build(&boxes, 1))
        };
        let (one, several) = (tree(1), tree(3));
        assert_eq!(one.items, several.items);
        let facts = |node: &Node<Aabb>| (node.bounds, node.first, node.count);
        assert!(one.nodes.iter().map(facts).eq(several.nodes.iter().map(facts)));
        assert_eq!(one.nodes.len(), 2 * boxes.len() - 1);
        // Every node is around its children, and every leaf has its item.
        for node in &one.nodes {
            let first = node.first as usize;
            let around = match node.count {
                0 => one.nodes[first].bounds.union(&one.nodes[first + 1].bounds),
                _ => boxes[one.items[first] as usize],
            };
            assert_eq!(node.bounds, around);
        }
    }
}
