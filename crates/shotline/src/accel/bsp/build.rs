//! Building by the surface area heuristic over the edges of all boxes (Wald and Havran 2006, "On building fast
//! kd-trees for ray tracing, and on doing that in O(N log N)").

use super::{Bsp, MAX_DEPTH, Node};
use crate::aabb::Aabb;
use crate::accel::bounded::{Bounded, around, cut, divide, measure, sort_out};

/// What passing a plane costs, in tests of an item.
const PLANE_COST: f64 = 1.0;
/// How many times an item may be listed, in the mean. It bounds the memory.
const MAX_SPREAD: usize = 8;

/// A node whose contents are not decided. They may be listed `spare` times more than they are.
struct Task {
    node: usize,
    bounds: Aabb,
    items: Vec<Bounded>,
    depth: usize,
    spare: usize,
}

/// A plane, and what a ray through the node is expected to cost with it, in tests of an item.
#[derive(Clone, Copy)]
struct Split {
    cost: f64,
    axis: usize,
    at: f64,
}

pub(super) fn build(boxes: &[Aabb]) -> Bsp {
    let (items, unbounded) = sort_out(boxes);
    let bounds = around(&items);
    let mut tree = Bsp { bounds, nodes: Vec::new(), items: Vec::new(), unbounded };
    if items.is_empty() {
        return tree;
    }
    tree.nodes.push(UNDECIDED);
    let deepest = (8.0 + 1.3 * (items.len() as f64).log2()) as usize;
    let spare = items.len() * (MAX_SPREAD - 1);
    let mut tasks = vec![Task { node: 0, bounds, items, depth: deepest.min(MAX_DEPTH - 1), spare }];
    while let Some(task) = tasks.pop() {
        decide(&mut tree, task, &mut tasks);
    }
    tree
}

const UNDECIDED: Node = Node::Leaf { first: 0, count: 0 };

fn decide(tree: &mut Bsp, task: Task, tasks: &mut Vec<Task>) {
    let Task { node, bounds, items, depth, spare } = task;
    let stay = items.len() as f64;
    if depth > 0
        && let Some(Split { axis, at, .. }) = best_split(&bounds, &items).filter(|s| s.cost < stay)
    {
        let (low, high) = cut(&bounds, axis, at);
        let (below, above) = divide(&items, axis, at);
        let listed = below.len() + above.len();
        if listed - items.len() <= spare {
            let first = tree.nodes.len();
            tree.nodes[node] = Node::Plane { axis: axis as u8, first: first as u32, at };
            tree.nodes.extend([UNDECIDED; 2]);
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

/// The cheapest plane through an edge of a box; `None` if there is none inside.
fn best_split(bounds: &Aabb, items: &[Bounded]) -> Option<Split> {
    let measure = measure(bounds);
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        let sorted = |end: fn(&Aabb) -> crate::math::Vec3| {
            let mut ends: Vec<f64> = items.iter().map(|b| end(&b.bounds)[axis]).collect();
            ends.sort_unstable_by(f64::total_cmp);
            ends
        };
        let (starts, ends) = (sorted(|b| b.min), sorted(|b| b.max));
        // How many begin before the plane, and how many end at or before it.
        let (mut begun, mut ended) = (0, 0);
        while begun < items.len() || ended < items.len() {
            let at = if begun < items.len() { starts[begun].min(ends[ended]) } else { ends[ended] };
            while ended < items.len() && ends[ended] <= at {
                ended += 1;
            }
            if bounds.min[axis] < at && at < bounds.max[axis] {
                let (below, above) = (begun.max(ended), items.len() - ended);
                let (low, high) = cut(bounds, axis, at);
                let expected =
                    (measure(&low) * below as f64 + measure(&high) * above as f64) / measure(bounds);
                let cost = PLANE_COST + expected;
                if best.is_none_or(|b| cost < b.cost) {
                    best = Some(Split { cost, axis, at });
                }
            }
            while begun < items.len() && starts[begun] <= at {
                begun += 1;
            }
        }
    }
    best
}
