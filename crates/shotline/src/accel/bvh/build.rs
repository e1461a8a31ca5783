//! Building by the surface area heuristic over bins (Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies").

use super::{Bvh, MAX_DEPTH, Node};
use crate::aabb::Aabb;
use crate::accel::bounded::{Bounded, sort_out};
use crate::math::Vec3;

const BINS: usize = 16;
/// Leaves of at most so many items are not split further unless the heuristic gains by it.
const MAX_LEAF: usize = 4;
/// What a box test costs, in tests of an item.
const BOX_COST: f64 = 1.0;
/// Below this depth nodes are halved by count, which adds at most 32 levels.
const MAX_HEURISTIC_DEPTH: usize = MAX_DEPTH - 34;

/// An item while the tree is built.
#[derive(Clone, Copy)]
struct Entry {
    bounds: Aabb,
    centre: Vec3,
    item: u32,
}

/// A range of entries that becomes a node.
struct Task {
    node: usize,
    start: usize,
    end: usize,
    depth: usize,
}

pub(super) fn build(boxes: &[Aabb]) -> Bvh {
    let (bounded, unbounded) = sort_out(boxes);
    let mut entries: Vec<Entry> = bounded
        .iter()
        .map(|&Bounded { bounds, item }| Entry { bounds, centre: bounds.centre(), item })
        .collect();
    let mut nodes = Vec::new();
    if !entries.is_empty() {
        nodes.push(leaf(&entries, 0));
        split_all(&mut nodes, &mut entries);
    }
    Bvh { nodes, items: entries.iter().map(|e| e.item).collect(), unbounded, links: None }
}

fn leaf(entries: &[Entry], start: usize) -> Node {
    let bounds = entries.iter().fold(Aabb::EMPTY, |b, e| b.union(&e.bounds));
    Node { bounds, first: start as u32, count: entries.len() as u32 }
}

/// Splits leaves until it no longer pays; depth first, so that near nodes are near in memory.
fn split_all(nodes: &mut Vec<Node>, entries: &mut [Entry]) {
    let mut tasks = vec![Task { node: 0, start: 0, end: entries.len(), depth: 0 }];
    while let Some(Task { node, start, end, depth }) = tasks.pop() {
        let range = &mut entries[start..end];
        let Some(left) = split(range, &nodes[node].bounds, depth) else { continue };
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

/// Partitions the entries of a node and answers how many go left; `None` to keep a leaf.
fn split(entries: &mut [Entry], bounds: &Aabb, depth: usize) -> Option<usize> {
    if entries.len() < 2 {
        return None;
    }
    let centres = Aabb::around(entries.iter().map(|e| e.centre));
    if depth < MAX_HEURISTIC_DEPTH
        && let Some(best) = best_split(entries, &centres)
    {
        let stay = bounds.half_area() * entries.len() as f64;
        if entries.len() <= MAX_LEAF && best.cost + BOX_COST * bounds.half_area() >= stay {
            return None;
        }
        let bin = Binning::new(&centres, best.axis);
        let left = partition(entries, |e| bin.of(e) < best.bin);
        return Some(left);
    }
    // All centres in one bin, or too deep for trust in the heuristic: halve by count.
    if entries.len() <= MAX_LEAF {
        return None;
    }
    let axis = largest_axis(centres.size());
    let middle = entries.len() / 2;
    entries.select_nth_unstable_by(middle, |a, b| {
        a.centre[axis].total_cmp(&b.centre[axis]).then(a.item.cmp(&b.item))
    });
    Some(middle)
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

    fn of(&self, entry: &Entry) -> usize {
        (((entry.centre[self.axis] - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

struct Best {
    cost: f64,
    axis: usize,
    /// Entries in lower bins go left.
    bin: usize,
}

/// The cheapest border between bins on any axis; `None` where every axis has all centres in one bin.
fn best_split(entries: &[Entry], centres: &Aabb) -> Option<Best> {
    let mut best: Option<Best> = None;
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
        // Costs of what lies right of each border, from the right; then meet them from the left.
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
                best = Some(Best { cost, axis, bin });
            }
        }
    }
    best
}

/// Moves the entries that satisfy a condition to the front and answers how many they are.
fn partition(entries: &mut [Entry], goes_left: impl Fn(&Entry) -> bool) -> usize {
    let mut left = 0;
    for i in 0..entries.len() {
        if goes_left(&entries[i]) {
            entries.swap(i, left);
            left += 1;
        }
    }
    left
}

fn largest_axis(v: Vec3) -> usize {
    (0..3).max_by(|&a, &b| v[a].total_cmp(&v[b])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(bvh: &Bvh) -> usize {
        let mut deepest = 0;
        let mut stack = vec![(0u32, 1)];
        while let Some((node, d)) = stack.pop() {
            let n = &bvh.nodes[node as usize];
            deepest = deepest.max(d);
            if n.count == 0 {
                stack.extend([(n.first, d + 1), (n.first + 1, d + 1)]);
            }
        }
        deepest
    }

    /// Boxes whose sizes grow by powers of two draw the heuristic into a chain; the stack must hold it.
    #[test]
    fn depth_is_bounded() {
        let boxes: Vec<Aabb> =
            (0..900).map(|i| Aabb::new(Vec3::ZERO, Vec3::splat(2f64.powi(i - 450)))).collect();
        assert!(depth(&build(&boxes)) < MAX_DEPTH);
        let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 5000];
        assert!(depth(&build(&same)) < 16);
    }
}
