//! Building with planes across the diagonals too.
//!
//! What a plane is worth is judged as in `build`, by the surface of a box around the space on each side; but that
//! box may also stand on a diagonal: space is known by its intervals along all normals, and the smallest of the
//! boxes that these make is taken.

use super::build::{MAX_SPREAD, PLANE_COST, UNDECIDED, deepest};
use super::normal::NORMALS;
use super::{Bsp, Node, Normal};
use crate::aabb::Aabb;
use crate::accel::bounded::{Bounded, around, cut, sort_out};

/// Space, or a part of it: its interval along each normal.
#[derive(Clone, Copy)]
struct Cell([(f64, f64); NORMALS]);

/// Normals that are at right angles, by their numbers.
const FRAMES: [[usize; 3]; 4] = [[0, 1, 2], [3, 4, 2], [5, 6, 0], [7, 8, 1]];

/// A node whose contents are not decided. They may be listed `spare` times more than they are.
struct Task {
    node: usize,
    cell: Cell,
    items: Vec<Bounded>,
    depth: usize,
    spare: usize,
}

/// A plane, and what a ray through the node is expected to cost with it, in tests of an item.
#[derive(Clone, Copy)]
struct Split {
    cost: f64,
    normal: Normal,
    at: f64,
}

impl Cell {
    fn of(bounds: &Aabb) -> Cell {
        let mut intervals = [(0.0, 0.0); NORMALS];
        for normal in Normal::all() {
            intervals[normal.index()] = normal.project(bounds);
        }
        Cell(intervals)
    }

    /// The parts below and above a plane.
    fn cut(&self, normal: Normal, at: f64) -> (Cell, Cell) {
        let (mut low, mut high) = (*self, *self);
        low.0[normal.index()].1 = at;
        high.0[normal.index()].0 = at;
        (low.tightened(), high.tightened())
    }

    /// Intervals that follow from the others: of `i + j` from those of `i` and `j`, and of `i` from those of
    /// `i + j` and `j`.
    fn tightened(mut self) -> Cell {
        for _ in 0..2 {
            for normal in Normal::all().filter(|n| n.axis().is_none()) {
                let (i, j, sign) = normal.pair();
                let ((a, b), (low, high)) = (self.0[i], self.0[j]);
                let (c, d) = if sign > 0.0 { (low, high) } else { (-high, -low) };
                let (e, f) = self.0[normal.index()];
                let (e, f) = (e.max(a + c), f.min(b + d));
                self.0[normal.index()] = (e, f);
                self.0[i] = (a.max(e - d), b.min(f - c));
                let (c, d) = (c.max(e - b), d.min(f - a));
                self.0[j] = if sign > 0.0 { (c, d) } else { (-d, -c) };
            }
        }
        self
    }

    fn length(&self, normal: usize) -> f64 {
        let (low, high) = self.0[normal];
        length(normal, low, high)
    }

    /// How the measures of the parts cut off by a plane depend on their length: in each frame that the normal is of.
    fn parts(&self, normal: usize) -> impl Iterator<Item = Linear> {
        let frames = FRAMES.iter().filter(move |frame| frame.contains(&normal));
        frames.map(move |frame| self.frame(normal, frame))
    }

    /// The half surface of a box on a frame, as its length along one of the normals varies; where that is nothing
    /// the sum of its edges.
    fn frame(&self, along: usize, frame: &[usize; 3]) -> Linear {
        let mut others = frame.iter().filter(|&&n| n != along).map(|&n| self.length(n));
        let (a, b) = (others.next().unwrap_or(0.0), others.next().unwrap_or(0.0));
        if a + b > 0.0 { Linear { slope: a + b, rest: a * b } } else { Linear { slope: 1.0, rest: a + b } }
    }
}

/// The length of an interval along a normal.
fn length(normal: usize, low: f64, high: f64) -> f64 {
    let length = (high - low).max(0.0);
    if normal < 3 { length } else { length * std::f64::consts::FRAC_1_SQRT_2 }
}

/// A measure that grows with a length.
#[derive(Clone, Copy)]
struct Linear {
    slope: f64,
    rest: f64,
}

impl Linear {
    fn of(self, length: f64) -> f64 {
        self.slope * length + self.rest
    }
}

pub(super) fn build(boxes: &[Aabb]) -> Bsp {
    let (items, unbounded) = sort_out(boxes);
    let bounds = around(&items);
    let mut tree = Bsp { bounds, nodes: Vec::new(), items: Vec::new(), unbounded };
    if items.is_empty() {
        return tree;
    }
    tree.nodes.push(UNDECIDED);
    let spare = items.len() * (MAX_SPREAD - 1);
    let depth = deepest(items.len());
    let mut tasks = vec![Task { node: 0, cell: Cell::of(&bounds), items, depth, spare }];
    while let Some(task) = tasks.pop() {
        decide(&mut tree, task, &mut tasks);
    }
    tree
}

fn decide(tree: &mut Bsp, task: Task, tasks: &mut Vec<Task>) {
    let Task { node, cell, items, depth, spare } = task;
    let stay = items.len() as f64;
    if depth > 0
        && let Some(Split { normal, at, .. }) = best_split(&cell, &items).filter(|s| s.cost < stay)
    {
        let (low, high) = cell.cut(normal, at);
        let (below, above) = divide(&items, normal, at);
        let listed = below.len() + above.len();
        if listed - items.len() <= spare {
            let first = tree.nodes.len();
            tree.nodes[node] = Node::Plane { normal, first: first as u32, at };
            tree.nodes.extend([UNDECIDED; 2]);
            let spare = spare - (listed - items.len());
            for (node, cell, items) in [(first + 1, high, above), (first, low, below)] {
                let spare = spare * items.len() / listed;
                tasks.push(Task { node, cell, items, depth: depth - 1, spare });
            }
            return;
        }
    }
    tree.nodes[node] = Node::Leaf { first: tree.items.len() as u32, count: items.len() as u32 };
    tree.items.extend(items.iter().map(|b| b.item));
}

/// Items below and above a plane. A plane across an axis cuts their boxes; one across a diagonal does not, since
/// what is left would be no box, and an item is listed with its whole box on each side that it reaches into.
fn divide(items: &[Bounded], normal: Normal, at: f64) -> (Vec<Bounded>, Vec<Bounded>) {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for &Bounded { bounds, item } in items {
        let (low, high) = normal.axis().map_or((bounds, bounds), |axis| cut(&bounds, axis, at));
        let (start, end) = normal.project(&bounds);
        let is_above = end > at;
        if is_above {
            above.push(Bounded { bounds: high, item });
        }
        if start < at || !is_above {
            below.push(Bounded { bounds: low, item });
        }
    }
    (below, above)
}

/// The cheapest plane through an edge of an interval; `None` if there is none inside.
fn best_split(cell: &Cell, items: &[Bounded]) -> Option<Split> {
    let mut best: Option<Split> = None;
    for normal in Normal::all() {
        let (mut starts, mut ends): (Vec<f64>, Vec<f64>) =
            items.iter().map(|b| normal.project(&b.bounds)).unzip();
        starts.sort_unstable_by(f64::total_cmp);
        ends.sort_unstable_by(f64::total_cmp);
        let (low_end, high_end) = cell.0[normal.index()];
        let length = |low, high| length(normal.index(), low, high);
        let parts: Vec<Linear> = cell.parts(normal.index()).collect();
        // Judged in the frame that thinks best of it.
        let expected = |at, below: usize, above: usize| {
            let (low, high) = (length(low_end, at), length(at, high_end));
            let share = |p: &Linear| {
                (p.of(low) * below as f64 + p.of(high) * above as f64) / p.of(length(low_end, high_end))
            };
            parts.iter().map(share).fold(f64::INFINITY, f64::min)
        };
        // How many begin before the plane, and how many end at or before it.
        let (mut begun, mut ended) = (0, 0);
        while ended < items.len() {
            let at = if begun < items.len() { starts[begun].min(ends[ended]) } else { ends[ended] };
            while ended < items.len() && ends[ended] <= at {
                ended += 1;
            }
            if low_end < at && at < high_end {
                let (below, above) = (begun.max(ended), items.len() - ended);
                let cost = PLANE_COST + expected(at, below, above);
                if best.is_none_or(|b| cost < b.cost) {
                    best = Some(Split { cost, normal, at });
                }
            }
            while begun < items.len() && starts[begun] <= at {
                begun += 1;
            }
        }
    }
    best
}
