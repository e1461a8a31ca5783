//! Builds the tree by the surface area heuristic, with candidate planes at the ends of all boxes (Wald and Havran
//! 2006, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)").

use super::direction::Direction;
use super::{Bsp, MAX_DEPTH, Node};
use crate::aabb::Aabb;
use crate::accel::prim_ref::{PrimRef, bounding_box, partition_unbounded};

/// Maximum mean number of references to an item. It bounds the memory.
const MAX_SPREAD: usize = 8;

/// A node to split or to keep as a leaf. Splits in its subtree may add at most `spare` references and `depth` levels.
struct Task {
    node: usize,
    bounds: Aabb,
    items: Vec<PrimRef>,
    depth: usize,
    spare: usize,
}

/// A plane, and the expected cost of a ray through the node if it is split there, in units of an item test.
#[derive(Clone, Copy)]
struct Split<D> {
    cost: f64,
    direction: D,
    at: f64,
}

pub(super) fn build<D: Direction>(boxes: &[Aabb]) -> Bsp<D> {
    let (items, unbounded) = partition_unbounded(boxes);
    let bounds = bounding_box(&items);
    let mut tree = Bsp { bounds, nodes: Vec::new(), items: Vec::new(), unbounded };
    if items.is_empty() {
        return tree;
    }
    tree.nodes.push(new_leaf());
    let deepest = (8.0 + 1.3 * (items.len() as f64).log2()) as usize;
    let spare = items.len() * (MAX_SPREAD - 1);
    let mut tasks = vec![Task { node: 0, bounds, items, depth: deepest.min(MAX_DEPTH - 1), spare }];
    while let Some(task) = tasks.pop() {
        split_or_keep(&mut tree, task, &mut tasks);
    }
    tree
}

fn new_leaf<D>() -> Node<D> {
    Node::Leaf { first: 0, count: 0 }
}

fn split_or_keep<D: Direction>(tree: &mut Bsp<D>, task: Task, tasks: &mut Vec<Task>) {
    let Task { node, bounds, items, depth, spare } = task;
    let leaf_cost = items.len() as f64;
    if depth > 0
        && let Some(Split { direction, at, .. }) =
            best_split::<D>(&bounds, &items).filter(|s| s.cost < leaf_cost)
    {
        let (low, high) = direction.cut(&bounds, at);
        let (below, above) = direction.partition_by_plane(&items, at);
        let listed = below.len() + above.len();
        if listed - items.len() <= spare {
            let first = tree.nodes.len();
            tree.nodes[node] = Node::Plane { direction, first: first as u32, at };
            tree.nodes.extend([new_leaf(), new_leaf()]);
            let spare = spare - (listed - items.len());
            for (node, bounds, items) in [(first + 1, high, above), (first, low, below)] {
                let spare = spare * items.len() / listed;
                tasks.push(Task { node, bounds, items, depth: depth - 1, spare });
            }
            return;
        }
    }
    tree.nodes[node] = Node::Leaf { first: tree.items.len() as u32, count: items.len() as u32 };
    tree.items.extend(items.iter().map(|b| b.item));
}

/// The cheapest plane through an end of an item's box; `None` if no such plane is inside the node.
fn best_split<D: Direction>(bounds: &Aabb, items: &[PrimRef]) -> Option<Split<D>> {
    let mut best: Option<Split<D>> = None;
    for &direction in D::ALL {
        let extent = direction.extent(bounds);
        let (mut starts, mut ends): (Vec<f64>, Vec<f64>) =
            items.iter().map(|b| direction.extent(&b.bounds)).unzip();
        starts.sort_unstable_by(f64::total_cmp);
        ends.sort_unstable_by(f64::total_cmp);
        // The numbers of items that begin before the plane, and that end at or before it.
        let (mut begun, mut ended) = (0, 0);
        while begun < items.len() || ended < items.len() {
            let at = if begun < items.len() { starts[begun].min(ends[ended]) } else { ends[ended] };
            while ended < items.len() && ends[ended] <= at {
                ended += 1;
            }
            if extent.0 < at && at < extent.1 {
                let (below, above) = (begun.max(ended), items.len() - ended);
                let cost = direction.cost(bounds, at, [below, above]);
                if best.is_none_or(|b| cost < b.cost) {
                    best = Some(Split { cost, direction, at });
                }
            }
            while begun < items.len() && starts[begun] <= at {
                begun += 1;
            }
        }
    }
    best
}
