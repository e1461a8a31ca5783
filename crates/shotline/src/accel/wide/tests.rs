//! The wide hierarchy: what is in its leaves, its boxes, its stack and its traversal.

use super::{LEAF, LEAF_SIZE, NONE, Node, WIDTH, WideBvh};
use crate::aabb::{Aabb, BoxRay};
use crate::counters::Counters;
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::testkit::random::Random;

type Leaves = Vec<[u32; LEAF_SIZE]>;

fn build(boxes: &[Aabb]) -> (WideBvh, Leaves) {
    let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    super::build(&bounds, boxes.len(), |item| boxes[item as usize])
}

fn boxes(random: &mut Random, n: usize, decades: f64, far: f64) -> Vec<Aabb> {
    let home = random.point(-far, far);
    let any = |random: &mut Random| {
        let a = home + random.point(-1.0, 1.0);
        let mut size = random.point(0.0, 0.2) * 10f64.powf(-random.number(0.0, decades + 1e-9));
        if random.below(4) == 0 {
            size[random.below(3)] = 0.0;
        }
        Aabb::new(a, a + size)
    };
    (0..n).map(|_| any(random)).collect()
}

/// Clouds of any number of boxes, equal boxes, points, chains, and extreme scales.
fn cases(random: &mut Random) -> Vec<Vec<Aabb>> {
    let mut cases: Vec<Vec<Aabb>> = [0, 1, 2, 3, 4, 5, 8, 9, 33, 300, 5000]
        .iter()
        .map(|&n| {
            let (decades, far) = ([0.0, 3.0, 12.0][random.below(3)], [0.0, 10.0, 1e6][random.below(3)]);
            boxes(random, n, decades, far)
        })
        .collect();
    for scale in [1e-300, 1e-30, 1e30, 1e300] {
        let scaled = |b: &Aabb| Aabb::new(b.min * scale, b.max * scale);
        cases.push(boxes(random, 100, 2.0, 3.0).iter().map(scaled).collect());
    }
    cases.push(vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 700]);
    cases.push(vec![Aabb::new(Vec3::ONE, Vec3::ONE); 90]);
    cases.push(chain(1.0));
    cases.push(chain(1.0).iter().map(|b| Aabb::new(b.max, b.max)).collect());
    cases.push((0..1000).map(|i| Aabb::new(Vec3::X * f64::from(i), Vec3::X * f64::from(i))).collect());
    cases
}

/// Boxes whose sizes grow by powers of two.
fn chain(first: f64) -> Vec<Aabb> {
    (0..900).map(|i| Aabb::new(Vec3::ZERO, Vec3::splat(first * 2f64.powi(i - 450)))).collect()
}

/// The box of a child.
fn child_box(node: &Node, slot: usize) -> [[f32; 3]; 2] {
    [0, 1].map(|side| [0, 1, 2].map(|axis| node.planes[2 * axis + side][slot]))
}

fn is_within(inner: [[f32; 3]; 2], outer: [[f32; 3]; 2]) -> bool {
    (0..3).all(|axis| outer[0][axis] <= inner[0][axis] && inner[1][axis] <= outer[1][axis])
}

/// What is below a node.
struct Below {
    items: Vec<u32>,
    /// The most entries that a traversal's stack has at a time, the node among them, in any order of the children.
    entries: usize,
    nodes: usize,
}

/// Checks the boxes below a node.
fn check(tree: &WideBvh, leaves: &Leaves, boxes: &[Aabb], index: usize) -> Below {
    let node = &tree.nodes[index];
    let count = node.children.iter().filter(|child| **child != NONE).count();
    let mut below = Below { items: Vec::new(), entries: count, nodes: 1 };
    for slot in 0..WIDTH {
        let (child, outer) = (node.children[slot], child_box(node, slot));
        if child == NONE {
            assert_eq!(outer, [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]);
            continue;
        }
        let items = if child & LEAF != 0 {
            leaves[(child & !LEAF) as usize].iter().copied().filter(|item| *item != NONE).collect()
        } else {
            assert!(child as usize > index);
            let inner = check(tree, leaves, boxes, child as usize);
            let of_child = &tree.nodes[child as usize];
            for slot in (0..WIDTH).filter(|&slot| of_child.children[slot] != NONE) {
                assert!(is_within(child_box(of_child, slot), outer));
            }
            below.entries = below.entries.max(count - 1 + inner.entries);
            below.nodes += inner.nodes;
            inner.items
        };
        for &item in &items {
            assert!(is_within(tree.frame.outward(&boxes[item as usize]), outer));
        }
        below.items.extend(items);
    }
    below
}

#[test]
fn every_item_is_in_one_leaf_within_all_boxes_above() {
    let mut random = Random::new(1);
    for boxes in cases(&mut random) {
        let (tree, leaves) = build(&boxes);
        if boxes.is_empty() {
            assert!(tree.nodes.is_empty() && leaves.is_empty());
            continue;
        }
        let mut below = check(&tree, &leaves, &boxes, 0);
        below.items.sort_unstable();
        assert_eq!(below.items, (0..boxes.len() as u32).collect::<Vec<_>>());
        assert_eq!(below.nodes, tree.nodes.len());
        // Used slots come first, and no leaf is empty.
        assert!(leaves.iter().all(|leaf| leaf[0] != NONE && leaf.is_sorted_by_key(|item| *item == NONE)));
        // The kernel keeps an end below the entries.
        assert!(below.entries < tree.stack_size, "{} {}", below.entries, tree.stack_size);
    }
}

#[test]
fn boxes_are_padded() {
    let mut random = Random::new(2);
    for boxes in cases(&mut random) {
        let (tree, _) = build(&boxes);
        for b in &boxes {
            let [low, high] = tree.frame.outward(b);
            let size = tree.frame.size;
            for axis in 0..3 {
                // Half of the pad is left in spite of rounding, in units of the frame.
                let scaled = |x: f64| x / size - tree.frame.centre[axis] / size;
                let slack = 0.5 * super::PAD - 4.0 * f64::EPSILON * (b.max / size).abs().max_element();
                assert!(f64::from(low[axis]) <= scaled(b.min[axis]) - slack);
                assert!(f64::from(high[axis]) >= scaled(b.max[axis]) + slack);
                assert!(f64::from(low[axis]) >= -1.001 && f64::from(high[axis]) <= 1.001);
            }
        }
    }
}

/// For boxes whose sizes grow by powers of two, the heuristic builds a chain of nodes.
#[test]
fn depth_is_bounded() {
    let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 5000];
    // At most 64 levels by the heuristic and 13 by halving, of which each wide node has at least one.
    for (boxes, most) in [(chain(1.0), 64 + 13), (chain(1e-100), 64 + 13), (same, 13)] {
        let (tree, _) = build(&boxes);
        assert!(tree.stack_size <= (WIDTH - 1) * most + WIDTH + 1, "{}", tree.stack_size);
    }
}

/// Random lines, many of them through corners and along axes.
fn line(random: &mut Random, boxes: &[Aabb]) -> Line {
    let b = boxes[random.below(boxes.len())];
    let size = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b)).size().max_element().max(1e-290);
    let p = [b.min, b.max, b.centre(), Vec3::new(b.min.x, b.max.y, b.min.z)][random.below(4)];
    let d = match random.below(4) {
        0 => Vec3::AXES[random.below(3)],
        1 => Vec3::new(1.0, -0.0, [0.0, 1.0, 1e-17][random.below(3)]),
        _ => random.direction(),
    };
    let o = p - d * (size * [0.0, 1.0, 3.0, 1e4][random.below(4)]);
    let error = [0.0, 0.0, 1e-14, 1e-6][random.below(4)];
    Line { o_err: Vec3::splat(error * size), d_err: d.abs() * error, ..Line::exact(o, d) }
}

#[test]
fn traversals_visit_the_leaves_of_all_boxes_that_are_met() {
    let mut random = Random::new(3);
    for boxes in cases(&mut random) {
        let (tree, leaves) = build(&boxes);
        let n = if boxes.is_empty() { 0 } else { 60 };
        let mut met = 0;
        for _ in 0..n {
            let line = line(&mut random, &boxes);
            let span = [Span::FORWARD, Span::new(-1e300, 1e300).expect("a span")][random.below(2)];
            let ray = BoxRay::new(&line, span);
            let mut visits = vec![0; leaves.len()];
            tree.traverse(&ray, &mut Counters::default(), &mut Vec::new(), |leaf, _| {
                visits[leaf as usize] += 1;
                span.t_max()
            });
            assert!(visits.iter().all(|visits| *visits <= 1));
            for (leaf, items) in leaves.iter().enumerate() {
                let items = items.iter().filter(|item| **item != NONE);
                let meets = items.filter(|item| ray.enter_exit(&boxes[**item as usize]).is_some()).count();
                met += meets;
                assert!(meets == 0 || visits[leaf] == 1, "{line:?} {span:?}");
            }
        }
        assert!(met > 0 || n == 0);
    }
}

/// A traversal with a limit visits the leaves of all boxes that begin before it.
#[test]
fn limits_skip_no_box_before_them() {
    let mut random = Random::new(4);
    let boxes = boxes(&mut random, 600, 1.0, 2.0);
    let (tree, leaves) = build(&boxes);
    for _ in 0..500 {
        let line = line(&mut random, &boxes);
        let ray = BoxRay::new(&line, Span::FORWARD);
        let enter = |item: u32| ray.enter_exit(&boxes[item as usize]).map(|(enter, _)| enter);
        let nearest = |items: &[u32]| {
            let items = items.iter().filter(|item| **item != NONE);
            items.filter_map(|item| enter(*item)).fold(f64::INFINITY, f64::min)
        };
        let mut limit = f64::INFINITY;
        tree.traverse(&ray, &mut Counters::default(), &mut Vec::new(), |leaf, _| {
            limit = limit.min(nearest(&leaves[leaf as usize]));
            limit
        });
        let first = (0..boxes.len() as u32).filter_map(enter).fold(f64::INFINITY, f64::min);
        assert_eq!(limit, first, "{line:?}");
    }
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let boxes = boxes(&mut Random::new(6), 150_000, 2.0, 1.0);
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (tree, leaves) = build(&boxes);
            let node = |node: &Node| (node.planes.map(|plane| plane.map(f32::to_bits)), node.children);
            (tree.nodes.iter().map(node).collect::<Vec<_>>(), leaves, tree.stack_size)
        })
    };
    let expected = with_threads(1);
    assert!([2, 3].into_iter().all(|threads| with_threads(threads) == expected));
}

fn triangles(random: &mut Random, count: usize) -> Vec<[Vec3; 3]> {
    let home = random.point(-1.0, 1.0) * [0.0, 1e3][random.below(2)];
    let needle = |random: &mut Random| {
        let (a, along, across) = (random.point(-1.0, 1.0), random.direction(), random.direction() * 0.01);
        [a, a + along, a + across].map(|v| v + home)
    };
    (0..count).map(|_| needle(random)).collect()
}

#[test]
fn parts_of_a_cut_triangle_are_in_leaves_whose_boxes_hold_them() {
    let mut random = Random::new(9);
    for count in [1, 5, 40, 6000] {
        let triangles = triangles(&mut random, count);
        let bounds = Aabb::around(triangles.iter().flatten().copied());
        let (tree, leaves) =
            super::build_with_spatial_splits(&bounds, count, |item| triangles[item as usize]);
        let references = leaves.iter().flatten().filter(|item| **item != NONE).count();
        assert!(references <= 2 * count && (count < 1000 || references > count), "{references} of {count}");
        let mut leaf_boxes = vec![None; leaves.len()];
        for node in &tree.nodes {
            for (slot, &child) in node.children.iter().enumerate().filter(|(_, child)| **child != NONE) {
                if child & LEAF != 0 {
                    leaf_boxes[(child & !LEAF) as usize] = Some(child_box(node, slot));
                } else {
                    assert!(is_within(tree.nodes[child as usize].bounds(), child_box(node, slot)));
                }
            }
        }
        for (item, [a, b, c]) in (0..).zip(&triangles) {
            let of_item = |leaf: &usize| leaves[*leaf].contains(&item);
            let homes: Vec<usize> = (0..leaves.len()).filter(of_item).collect();
            assert!(!homes.is_empty());
            for _ in 0..20 {
                let (u, v) = (random.number(0.0, 1.0), random.number(0.0, 1.0));
                let p = *a + (*b - *a) * (u * v) + (*c - *a) * (u * (1.0 - v));
                // The pad is there for the test of the boxes, so half of it has to be left.
                let p = tree.frame.coordinates(p);
                let padded = [p - Vec3::splat(0.5 * super::PAD), p + Vec3::splat(0.5 * super::PAD)];
                let is_home = |leaf: &usize| {
                    let [low, high] = leaf_boxes[*leaf].expect("a leaf with a parent");
                    (0..3).all(|i| f64::from(low[i]) <= padded[0][i] && padded[1][i] <= f64::from(high[i]))
                };
                assert!(homes.iter().any(is_home));
            }
        }
    }
}
