//! Finds the pairs of boxes that intersect, by traversing a tree over the boxes against itself. The cost is `n log n`
//! plus the number of pairs found.

use crate::aabb::Aabb;
use crate::math::Vec3;

/// Up to this many boxes are compared one by one.
const MAX_LEAF_BOXES: usize = 4;

/// Neighbouring boxes: `count` of them from index `first` on, in the order of the tree.
struct Node {
    bounds: Aabb,
    first: usize,
    count: usize,
    /// The two child nodes, if there are more than a few boxes.
    children: Option<[usize; 2]>,
}

/// Whether two boxes have a volume in common.
pub(super) fn intersects(a: &Aabb, b: &Aabb) -> bool {
    a.min.max(b.min).cmplt(a.max.min(b.max)).all()
}

/// Calls `found` with each pair of boxes that have a volume in common. Each comparison of two nodes costs one unit of
/// the budget. Returns `false` if the budget ended before all pairs were found.
pub(super) fn join(boxes: &[Aabb], budget: &mut u64, mut found: impl FnMut(usize, usize)) -> bool {
    if boxes.is_empty() {
        return true;
    }
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let nodes = tree(boxes, &mut order);
    let mut waiting = vec![(0, 0)];
    while let Some((a, b)) = waiting.pop() {
        let Some(rest) = budget.checked_sub(1) else { return false };
        *budget = rest;
        let (left, right) = (&nodes[a], &nodes[b]);
        if !intersects(&left.bounds, &right.bounds) {
            continue;
        }
        match (left.children, right.children) {
            (Some([l, r]), _) if a == b => waiting.extend([(l, l), (r, r), (l, r)]),
            (Some([l, r]), _) if right.children.is_none() || left.count >= right.count => {
                waiting.extend([(l, b), (r, b)]);
            }
            (_, Some([l, r])) => waiting.extend([(a, l), (a, r)]),
            _ => {
                for i in left.first..left.first + left.count {
                    let from = if a == b { i + 1 } else { right.first };
                    for j in from..right.first + right.count {
                        let (i, j) = (order[i].min(order[j]), order[i].max(order[j]));
                        if intersects(&boxes[i], &boxes[j]) {
                            found(i, j);
                        }
                    }
                }
            }
        }
    }
    true
}

/// Builds a tree that halves the boxes by their centres along the longest axis.
fn tree(boxes: &[Aabb], order: &mut [usize]) -> Vec<Node> {
    // The clamp gives unbounded boxes a centre too.
    let far = Vec3::splat(0.25 * f64::MAX);
    let middle = |i: usize| boxes[i].min.clamp(-far, far) * 0.5 + boxes[i].max.clamp(-far, far) * 0.5;
    let mut nodes: Vec<Node> = Vec::new();
    let mut waiting = vec![(0, order.len(), None)];
    while let Some((first, count, parent)) = waiting.pop() {
        let part = &mut order[first..first + count];
        let bounds = part.iter().fold(Aabb::EMPTY, |all, i| all.union(&boxes[*i]));
        let number = nodes.len();
        if let Some((parent, half)) = parent {
            let parent: &mut Node = &mut nodes[parent];
            parent.children.get_or_insert([0, 0])[half] = number;
        }
        nodes.push(Node { bounds, first, count, children: None });
        if count > MAX_LEAF_BOXES {
            let size = Aabb::around(part.iter().map(|i| middle(*i))).size();
            let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
            let half = count / 2;
            part.select_nth_unstable_by(half, |i, j| {
                middle(*i)[axis].total_cmp(&middle(*j)[axis]).then(i.cmp(j))
            });
            waiting.push((first, half, Some((number, 0))));
            waiting.push((first + half, count - half, Some((number, 1))));
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn the_tree_finds_what_comparing_each_with_each_finds() {
        let mut random = Random::new(7);
        for count in [0, 1, 2, 5, 40, 300] {
            let mut point = |scale: f64| random.point(0.0, scale);
            let mut boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let min = point(10.0);
                    Aabb::new(min, min + point(2.0))
                })
                .collect();
            if count > 5 {
                boxes[3].max.z = f64::INFINITY;
                boxes[4] = Aabb::EVERYTHING;
                boxes[5] = boxes[2];
            }
            let mut found = Vec::new();
            assert!(join(&boxes, &mut u64::MAX.clone(), |i, j| found.push((i, j))));
            found.sort_unstable();
            let all = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
            let expected: Vec<_> = all.filter(|&(i, j)| intersects(&boxes[i], &boxes[j])).collect();
            assert_eq!(found, expected);
        }
    }

    /// A row and a grid of boxes that abut: the comparisons do not grow with the square of their number.
    #[test]
    fn boxes_that_abut_take_n_log_n() {
        for [nx, ny] in [[20_000, 1], [1, 20_000], [150, 150]] {
            let corner = |i: i32| Vec3::new(f64::from(i % nx), f64::from(i / nx), 0.0);
            let boxes: Vec<Aabb> =
                (0..nx * ny).map(|i| Aabb::new(corner(i), corner(i) + Vec3::ONE)).collect();
            let mut budget = 40 * boxes.len() as u64;
            assert!(join(&boxes, &mut budget, |i, j| panic!("{i} and {j} do not intersect")));
        }
    }
}
