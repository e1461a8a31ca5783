//! Rays along rulings, where the tangent planes of quadrics rotate around the ray and their curvatures change along
//! it.

use super::touching::{boxed, csg, halfspace, seen};
use super::*;
use crate::scene::NodeId;

/// `a x + b y + z (c x + d y) + e x^2 + f x y + g y^2 < 0`: every quadric that contains the z axis.
type Quadric = [f64; 7];

fn leaf(scene: &mut Scene, [a, b, c, d, e, f, g]: Quadric) -> NodeId {
    scene.add_solid("quadric", &[&[e, g, 0.0, f, c, d, a, b, 0.0, 0.0]]).expect("a quadric")
}

/// A combination of quadrics, or a single quadric, by its number.
#[derive(Debug)]
enum Node {
    Leaf(usize),
    Op(Op, Box<[Node; 2]>),
}

impl Node {
    fn random(random: &mut Random, leaves: std::ops::Range<usize>) -> Node {
        if leaves.len() == 1 {
            return Node::Leaf(leaves.start);
        }
        let middle = leaves.start + 1 + random.below(leaves.len() - 1);
        let op = [Op::Union, Op::Union, Op::Intersection, Op::Difference][random.below(4)];
        Node::Op(
            op,
            Box::new([leaves.start..middle, middle..leaves.end].map(|part| Node::random(random, part))),
        )
    }

    fn add(&self, scene: &mut Scene, leaves: &[NodeId]) -> NodeId {
        match self {
            Node::Leaf(leaf) => leaves[*leaf],
            Node::Op(op, args) => {
                let args = args.iter().map(|arg| arg.add(scene, leaves)).collect();
                csg(scene, *op, args)
            }
        }
    }

    fn contains(&self, inside: &[bool]) -> bool {
        match self {
            Node::Leaf(leaf) => inside[*leaf],
            Node::Op(op, args) => {
                let [a, b] = [&args[0], &args[1]].map(|arg| arg.contains(inside));
                match op {
                    Op::Union => a || b,
                    Op::Intersection => a && b,
                    Op::Difference => a && !b,
                }
            }
        }
    }
}

/// The radius of the circles around the ray on which the oracle samples, and the narrowest sector that it sees, in
/// radians.
const RADIUS: f64 = 1e-5;
const NARROWEST: f64 = 1e-9;

/// Whether everything on a small circle around the z axis is inside. The circle is cut where the quadrics cross it.
fn surrounds(node: &Node, quadrics: &[Quadric], z: f64) -> bool {
    let value = |[a, b, c, d, e, f, g]: Quadric, angle: f64| {
        let (y, x) = angle.sin_cos();
        (a + c * z) * x + (b + d * z) * y + RADIUS * (e * x * x + f * x * y + g * y * y)
    };
    let mut cuts = Vec::new();
    for &quadric in quadrics {
        let [a, b, c, d, ..] = quadric;
        let tangent = f64::atan2(b + d * z, a + c * z) + std::f64::consts::FRAC_PI_2;
        for start in [tangent, tangent + std::f64::consts::PI] {
            // Bisection, between angles at which the signs certainly differ.
            let (mut low, mut high) = (start - 0.5, start + 0.5);
            let sign = value(quadric, low) < 0.0;
            for _ in 0..45 {
                let middle = low.midpoint(high);
                if (value(quadric, middle) < 0.0) == sign { low = middle } else { high = middle }
            }
            cuts.push(low.rem_euclid(std::f64::consts::TAU));
        }
    }
    cuts.sort_by(f64::total_cmp);
    let next = cuts.iter().skip(1).copied().chain([cuts[0] + std::f64::consts::TAU]);
    cuts.iter().zip(next).filter(|(from, to)| to - *from > NARROWEST).all(|(from, to)| {
        let inside: Vec<bool> = quadrics.iter().map(|&q| value(q, from.midpoint(to)) < 0.0).collect();
        node.contains(&inside)
    })
}

/// The oracle samples small circles around the ray, at many points of it.
#[test]
fn rays_along_rulings_see_what_is_all_around_them() {
    let mut random = Random::new(41);
    let (mut lists, mut turns) = (0, 0);
    for case in 0..600 {
        let count = 2 + random.below(3);
        let mut quadrics: Vec<Quadric> = Vec::new();
        for _ in 0..count {
            let linear = random.below(3) == 0;
            let mut quadric: Quadric =
                std::array::from_fn(|i| if linear && i >= 2 { 0.0 } else { random.below(7) as f64 - 3.0 });
            if let Some(other) = quadrics.last().filter(|_| random.below(4) == 0) {
                // Tangent to the previous quadric everywhere, on the same side or on the other.
                let sign = [1.0, -1.0][random.below(2)];
                quadric[..4].copy_from_slice(&other[..4]);
                quadric[..4].iter_mut().for_each(|x| *x *= sign);
            }
            if quadric[..2] == [0.0; 2] {
                quadric[0] = 1.0;
            }
            quadrics.push(quadric);
        }
        let node = Node::random(&mut random, 0..count);
        let mut scene = Scene::default();
        let leaves: Vec<NodeId> = quadrics.iter().map(|&quadric| leaf(&mut scene, quadric)).collect();
        let slab = boxed(&mut scene, [-2.0, -2.0, -4.0], [2.0, 2.0, 4.0]);
        let whole = node.add(&mut scene, &leaves);
        let whole = csg(&mut scene, Op::Intersection, vec![slab, whole]);
        let list = seen(scene.clone(), whole, [0.0, 0.0, -9.0], [0.0, 0.0, 1.0]);
        lists += usize::from(!list.is_empty());
        turns += list.iter().filter(|t| (t.abs() - 9.0).abs() < 3.9).count();
        for k in 0..80 {
            let z = -4.0 + 0.1 * (f64::from(k) + 0.437);
            let near = |z: f64| surrounds(&node, &quadrics, z);
            if near(z - 0.01) != near(z) || near(z + 0.01) != near(z) {
                continue;
            }
            let inside = list.iter().filter(|t| **t < z + 9.0).count() % 2 == 1;
            if list.iter().any(|t| (t - z - 9.0).abs() < 0.01) {
                continue;
            }
            assert_eq!(inside, near(z), "case {case} at z = {z}: {list:?} of {node:?} {quadrics:?}");
        }
    }
    assert!(lists > 60 && turns > 60, "{lists} {turns}");
}

/// Around a ray along a ruling, the saddle rotates until it passes the face of another solid.
#[test]
fn a_saddle_that_turns_past_a_face_closes_a_gap_until_there() {
    let mut scene = Scene::default();
    let saddle = leaf(&mut scene, [1.0, -3.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let (left, front) =
        (halfspace(&mut scene, [0.0, 1.0, 0.0], 0.0), halfspace(&mut scene, [-1.0, 0.0, 0.0], 0.0));
    let (o, d) = ([0.0, 0.0, -9.0], [0.0, 0.0, 1.0]);
    let mut within = |z1: f64, args: Vec<NodeId>| {
        let slab = boxed(&mut scene, [-50.0, -50.0, 2.0], [50.0, 50.0, z1]);
        let all = csg(&mut scene, Op::Union, args);
        let cut = csg(&mut scene, Op::Intersection, vec![slab, all]);
        seen(scene.clone(), cut, o, d)
    };
    assert_eq!(within(5.0, vec![left, front, saddle]), [11.0, 12.0]);
    assert!(within(4.0, vec![front, saddle]).is_empty());
}

/// A parabolic cylinder and a cone are tangent along a ray. The curvature of the cone decreases with the distance
/// from its apex.
#[test]
fn curvatures_are_compared_where_the_ray_is() {
    let mut scene = Scene::default();
    let cylinder = leaf(&mut scene, [3.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
    let cone = leaf(&mut scene, [0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]);
    let slab = boxed(&mut scene, [-50.0, -50.0, 1.0], [50.0, 50.0, 6.0]);
    let both = csg(&mut scene, Op::Union, vec![cylinder, cone]);
    let cut = csg(&mut scene, Op::Intersection, vec![slab, both]);
    assert_eq!(seen(scene, cut, [0.0, 0.0, -9.0], [0.0, 0.0, 1.0]), [12.0, 15.0]);
}

/// Where a gradient vanishes, the order of the surfaces changes at once, and one of two sheets may rotate up to the
/// other without passing it.
#[test]
fn surfaces_are_told_apart_behind_an_apex() {
    type Case<'a> = (&'a [[f64; 10]], [f64; 3], [f64; 3], &'a [f64]);
    let cases: [Case; 5] = [
        (
            &[[0., 0., 0., 0., 1., 0., 0., 0., -1., 0.], [0., 0., 0., 1., 0., 0., 0., -1., -1., 0.]],
            [-6., 0., 0.],
            [1., 0., 0.],
            &[],
        ),
        (
            &[
                [0., 0., 0., 0., 1., 0., 0., 0., -6., 0.],
                [0., 1., 0., 2., 0., 0., 0., -12., -1., 0.],
                [0., 0., 0., 0., 0., 0., 0., -1., 0., 0.],
            ],
            [0., 0., 0.],
            [1., 0., 0.],
            &[6., f64::INFINITY],
        ),
        (
            &[
                [0., 0., 0., 0., 0., -1., 0., 0., 2., 0.],
                [2., 6., -1., -7., -1., 1., 6., -10., -1., 4.],
                [3., 10., 0., -11., -2., 2., 11., -20., -3., 10.],
            ],
            [14., 8., 0.],
            [-2., -1., 0.],
            &[6., 7.],
        ),
        (
            &[
                [1., 4., 2., -4., 3., -4., -8., 16., -6., 16.],
                [0., 0., -1., 0., -1., 3., -1., 2., 5., 4.],
                [0., 2., 1., -1., -1., 1., -2., 8., 2., 8.],
            ],
            [1., -1.5, 0.],
            [-2., -1., 0.],
            &[0.5, 1.5],
        ),
        // A single surface: a ray in it is not inside anything.
        (&[[0., 2., 0., 0., -2., 1., 0., 0., 2., 0.]], [7., 0., 0.], [1., 0., 0.], &[]),
    ];
    for (quadrics, o, d, expected) in cases {
        let mut scene = Scene::default();
        let leaves = quadrics.iter().map(|q| scene.add_solid("quadric", &[q]).expect("a quadric")).collect();
        let node = csg(&mut scene, Op::Union, leaves);
        let list = seen(scene, node, o, d);
        let near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-6;
        assert!(
            list.len() == expected.len() && list.iter().zip(expected).all(near),
            "{list:?}, not {expected:?}"
        );
    }
}

/// The same in a frame whose inverse is not exact.
#[test]
fn a_ray_in_a_surface_of_a_placed_quadric_is_in_nothing() {
    let mut scene = Scene::default();
    let quadric =
        scene.add_solid("quadric", &[&[0., 2., 0., 0., -2., 1., 0., 0., 2., 0.]]).expect("a quadric");
    let map = Affine::from_row_major([3., 3., 0., -1., 3., 0., 3., 0., 0., 3., 3., 0.]);
    let placed = scene.add_transform(map, quadric);
    for t in [-4.0, 0.0, 0.5, 1.0, 2.0, 7.0, 40.0] {
        for d in [1.0, -1.0] {
            let o = map.point(Vec3::new(t, 0.0, 0.0)).to_array();
            let list = seen(scene.clone(), placed, o, [3.0 * d, 3.0 * d, 0.0]);
            assert!(list.is_empty(), "from {t} along {d}: {list:?}");
        }
    }
}
