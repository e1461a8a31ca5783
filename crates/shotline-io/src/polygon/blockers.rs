//! The corners that may lie in the way of a cut, in a k-d tree from which they are taken out one by one.

use super::plane::{Point, turn};

/// Points of a leaf, at most.
const LEAF: usize = 16;

/// A tree of points by their numbers.
pub(super) struct Blockers {
    points: Vec<u32>,
    nodes: Vec<Node>,
    /// The leaf of each point by its number; `NONE` for those that are not in the tree, or not any more.
    leaves: Vec<u32>,
}

struct Node {
    min: Point,
    max: Point,
    points: std::ops::Range<usize>,
    /// How many points are left below.
    left: usize,
    parent: u32,
    /// The first of two children that follow each other; `NONE` for a leaf.
    children: u32,
}

const NONE: u32 = u32::MAX;

impl Blockers {
    /// A tree of some of the points.
    pub(super) fn of(all: &[Point], mut points: Vec<u32>) -> Blockers {
        let mut nodes = vec![node(all, &points, 0..points.len(), NONE)];
        let mut leaves = vec![NONE; all.len()];
        let mut next = 0;
        // Nodes are split in the order in which they were added, so children follow each other.
        while next < nodes.len() {
            let range = nodes[next].points.clone();
            if range.len() <= LEAF {
                points[range].iter().for_each(|p| leaves[*p as usize] = next as u32);
            } else {
                let (min, max) = (nodes[next].min, nodes[next].max);
                let k = usize::from(max[1] - min[1] > max[0] - min[0]);
                let middle = range.len() / 2;
                let key = |p: &u32| all[*p as usize][k];
                points[range.clone()].select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
                let middle = range.start + middle;
                nodes[next].children = nodes.len() as u32;
                for part in [range.start..middle, middle..range.end] {
                    nodes.push(node(all, &points, part, next as u32));
                }
            }
            next += 1;
        }
        Blockers { points, nodes, leaves }
    }

    /// Takes a point out; answers whether it was there.
    pub(super) fn remove(&mut self, point: u32) -> bool {
        let mut node = std::mem::replace(&mut self.leaves[point as usize], NONE);
        let was_there = node != NONE;
        while let Some(above) = self.nodes.get_mut(node as usize) {
            above.left -= 1;
            node = above.parent;
        }
        was_there
    }

    /// Finds a point in a triangle that runs counter-clockwise, its sides included, which is in the way.
    pub(super) fn find(
        &self,
        all: &[Point],
        triangle: [Point; 3],
        is_in_way: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        let mut todo = vec![0];
        while let Some(i) = todo.pop() {
            let node: &Node = &self.nodes[i as usize];
            if node.left == 0 || !node.may_meet(triangle) {
                continue;
            }
            if node.children != NONE {
                todo.extend([node.children, node.children + 1]);
                continue;
            }
            let points = self.points[node.points.clone()].iter().copied();
            let mut left = points.filter(|p| self.leaves[*p as usize] == i);
            let found = left.find(|p| is_within(all[*p as usize], triangle) && is_in_way(*p));
            if found.is_some() {
                return found;
            }
        }
        None
    }
}

fn node(all: &[Point], points: &[u32], range: std::ops::Range<usize>, parent: u32) -> Node {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in &points[range.clone()] {
        for k in 0..2 {
            min[k] = min[k].min(all[*point as usize][k]);
            max[k] = max[k].max(all[*point as usize][k]);
        }
    }
    Node { min, max, left: range.len(), points: range, parent, children: NONE }
}

impl Node {
    /// Whether the box may have a point in common with a triangle that runs counter-clockwise.
    fn may_meet(&self, triangle: [Point; 3]) -> bool {
        let beside = |k: usize| {
            triangle.iter().all(|p| p[k] < self.min[k]) || triangle.iter().all(|p| p[k] > self.max[k])
        };
        !beside(0) && !beside(1) && sides(triangle).into_iter().all(|(a, b)| !self.is_right_of(a, b))
    }

    /// Whether the box lies to the right of a line: its corner farthest to the left does.
    fn is_right_of(&self, a: Point, b: Point) -> bool {
        let x = if b[1] > a[1] { self.min[0] } else { self.max[0] };
        let y = if b[0] > a[0] { self.max[1] } else { self.min[1] };
        turn(a, b, [x, y]) < 0.0
    }
}

fn sides([a, b, c]: [Point; 3]) -> [(Point, Point); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Whether a point lies in a triangle that runs counter-clockwise, its sides included.
fn is_within(point: Point, triangle: [Point; 3]) -> bool {
    sides(triangle).into_iter().all(|(a, b)| turn(a, b, point) >= 0.0)
}
