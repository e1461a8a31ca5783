//! The reflex vertices of a polygon, which may lie within an ear, in a k-d tree that supports removal.

use super::projection::{Point, orientation};

/// The maximum number of points of a leaf.
const LEAF_SIZE: usize = 16;

/// A k-d tree of points, stored by their index.
pub(super) struct ReflexVertices {
    points: Vec<u32>,
    nodes: Vec<Node>,
    /// The leaf of each point by its index; `NONE` for those that are not in the tree or were removed.
    leaves: Vec<u32>,
}

struct Node {
    min: Point,
    max: Point,
    points: std::ops::Range<usize>,
    /// The number of points below that were not removed.
    remaining: usize,
    parent: u32,
    /// The first of two consecutive children; `NONE` for a leaf.
    children: u32,
}

const NONE: u32 = u32::MAX;

impl ReflexVertices {
    /// Builds the tree of some of the points.
    pub(super) fn of(all: &[Point], mut points: Vec<u32>) -> ReflexVertices {
        let mut nodes = vec![node(all, &points, 0..points.len(), NONE)];
        let mut leaves = vec![NONE; all.len()];
        let mut next = 0;
        // Nodes are split in the order in which they were added, so siblings are consecutive.
        while next < nodes.len() {
            let range = nodes[next].points.clone();
            if range.len() <= LEAF_SIZE {
                points[range].iter().for_each(|p| leaves[*p as usize] = next as u32);
            } else {
                let (min, max) = (nodes[next].min, nodes[next].max);
                let k = usize::from(max[1] - min[1] > max[0] - min[0]);
                let middle = range.len() / 2;
                let key = |p: &u32| all[*p as usize][k];
                points[range.clone()].select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
                let middle = range.start + middle;
                nodes[next].children = nodes.len() as u32;
                for half in [range.start..middle, middle..range.end] {
                    nodes.push(node(all, &points, half, next as u32));
                }
            }
            next += 1;
        }
        ReflexVertices { points, nodes, leaves }
    }

    /// Removes a point; returns whether it was in the tree.
    pub(super) fn remove(&mut self, point: u32) -> bool {
        let mut node = std::mem::replace(&mut self.leaves[point as usize], NONE);
        let was_present = node != NONE;
        while let Some(above) = self.nodes.get_mut(node as usize) {
            above.remaining -= 1;
            node = above.parent;
        }
        was_present
    }

    /// Finds a point in a counter-clockwise triangle, its sides included, for which `blocks` returns true.
    pub(super) fn find(
        &self,
        all: &[Point],
        triangle: [Point; 3],
        blocks: impl Fn(u32) -> bool,
    ) -> Option<u32> {
        let mut todo = vec![0];
        while let Some(i) = todo.pop() {
            let node: &Node = &self.nodes[i as usize];
            if node.remaining == 0 || !node.may_intersect(triangle) {
                continue;
            }
            if node.children != NONE {
                todo.extend([node.children, node.children + 1]);
                continue;
            }
            let points = self.points[node.points.clone()].iter().copied();
            let mut remaining = points.filter(|p| self.leaves[*p as usize] == i);
            let found = remaining.find(|p| is_within(all[*p as usize], triangle) && blocks(*p));
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
    Node { min, max, remaining: range.len(), points: range, parent, children: NONE }
}

impl Node {
    /// Whether the box may intersect a counter-clockwise triangle; conservative.
    fn may_intersect(&self, triangle: [Point; 3]) -> bool {
        let is_separated = |k: usize| {
            triangle.iter().all(|p| p[k] < self.min[k]) || triangle.iter().all(|p| p[k] > self.max[k])
        };
        !is_separated(0)
            && !is_separated(1)
            && sides(triangle).into_iter().all(|(a, b)| !self.is_right_of(a, b))
    }

    /// Whether the box lies to the right of a line. Tests the corner of the box that is farthest to the left.
    fn is_right_of(&self, a: Point, b: Point) -> bool {
        let x = if b[1] > a[1] { self.min[0] } else { self.max[0] };
        let y = if b[0] > a[0] { self.max[1] } else { self.min[1] };
        orientation(a, b, [x, y]) < 0.0
    }
}

fn sides([a, b, c]: [Point; 3]) -> [(Point, Point); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Whether a point lies in a counter-clockwise triangle, its sides included.
fn is_within(point: Point, triangle: [Point; 3]) -> bool {
    sides(triangle).into_iter().all(|(a, b)| orientation(a, b, point) >= 0.0)
}
