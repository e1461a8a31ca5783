//! Boxes of combinations of unbounded solids: they contain everything, they are finite wherever they can be, and no
//! result depends on them.

use super::touching::{boxed, csg};
use super::*;
use crate::aabb::Aabb;
use crate::accel;
use crate::compile::{Body, SolidBody};
use crate::csg::{Event, EventKind, Sweep};
use crate::ray::Line;
use crate::scene::NodeId;
use crate::testkit::membership::Membership;

/// The coefficients of `|p - c|^2 - k (u . (p - c))^2 < r` for a unit vector `u`: a sphere for `k = 0`, a cylinder
/// for `k = 1`, a cone or a hyperboloid for more, an ellipsoid for less.
fn about(c: Vec3, u: Vec3, k: f64, r: f64) -> [f64; 10] {
    let entry = |i: usize, j: usize| f64::from(u8::from(i == j)) - k * u[i] * u[j];
    let row = |i: usize| (0..3).map(|j| entry(i, j) * c[j]).sum::<f64>();
    let constant = (0..3).map(|i| row(i) * c[i]).sum::<f64>() - r;
    [
        entry(0, 0),
        entry(1, 1),
        entry(2, 2),
        2.0 * entry(0, 1),
        2.0 * entry(0, 2),
        2.0 * entry(1, 2),
        -2.0 * row(0),
        -2.0 * row(1),
        -2.0 * row(2),
        constant,
    ]
}

fn quadric(scene: &mut Scene, coefficients: [f64; 10]) -> NodeId {
    scene.add_solid("quadric", &[&coefficients]).expect("a quadric")
}

fn half_space(scene: &mut Scene, normal: Vec3, offset: f64) -> NodeId {
    scene.add_solid("halfspace", &[&normal.to_array(), &[offset]]).expect("a half-space")
}

/// Two planes perpendicular to an axis through a point, tilted by up to a fraction of a right angle.
fn cuts(scene: &mut Scene, random: &mut Random, c: Vec3, u: Vec3, tilt: f64, from: f64) -> [NodeId; 2] {
    [1.0, -1.0].map(|sign| {
        let n = (u + random.direction() * tilt) * sign * random.number(0.2, 5.0);
        let place = c + u * if sign > 0.0 { random.number(1.0, 2.0) } else { from };
        half_space(scene, n, n.dot(place))
    })
}

/// A random bounded cell whose operands are unbounded.
fn cell(scene: &mut Scene, random: &mut Random) -> NodeId {
    let c = random.point(-2.0, 2.0);
    let axes = [Vec3::X, Vec3::NEG_Z, random.direction(), random.direction()];
    let u = axes[random.below(4)];
    let tilt = [0.0, 0.5][random.below(2)];
    let mut args = Vec::new();
    match random.below(7) {
        0 => {
            // A polytope: half-spaces around a point, four of them those of a tetrahedron.
            let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
            let more = (0..random.below(8)).map(|_| random.direction()).collect::<Vec<_>>();
            for n in corners.map(Vec3::from).into_iter().chain(more) {
                let n = n * random.number(0.1, 3.0);
                args.push(half_space(scene, n, n.dot(c) + n.length() * random.number(0.3, 1.5)));
            }
        }
        1 => {
            args.push(quadric(scene, about(c, u, 1.0, random.number(0.1, 2.0))));
            args.extend(cuts(scene, random, c, u, tilt, -1.0));
        }
        2 => {
            // Half of a cone, from its apex or below.
            args.push(quadric(scene, about(c, u, random.number(1.5, 4.0), 0.0)));
            let from = [0.0, 0.2][random.below(2)];
            args.extend(cuts(scene, random, c, u, 0.3 * tilt, from));
        }
        3 => {
            args.push(quadric(scene, about(c, u, random.number(1.2, 3.0), random.number(-1.0, 1.0))));
            args.extend(cuts(scene, random, c, u, 0.3 * tilt, -1.0));
        }
        4 => {
            args.push(quadric(scene, about(c, u, random.number(-3.0, 0.9), random.number(0.1, 2.0))));
            args.push(half_space(scene, random.direction(), random.number(-1.0, 1.0)));
        }
        5 => {
            // Two cylinders as one operand of a cut.
            let tubes = [0.3, 0.6].map(|r| quadric(scene, about(c, u, 1.0, r)));
            let other = quadric(scene, about(c + random.point(-1.0, 1.0), u, 1.0, 0.5));
            args.push(scene.add_csg(Op::Union, vec![tubes[0], tubes[1], other]));
            args.extend(cuts(scene, random, c, u, tilt, -1.0));
        }
        _ => {
            // Cut by operands that are subtracted, in two steps, and drilled.
            let [top, bottom] = cuts(scene, random, c, -u, tilt, -1.0);
            let tube = quadric(scene, about(c, u, 1.0, 1.0));
            let below = half_space(scene, Vec3::X, c.x + 0.9);
            let short = scene.add_csg(Op::Difference, vec![tube, top]);
            let cut = scene.add_csg(Op::Intersection, vec![short, below]);
            let drill = quadric(scene, about(c, random.direction(), 1.0, 0.04));
            return scene.add_csg(Op::Difference, vec![cut, drill, bottom]);
        }
    }
    scene.add_csg(Op::Intersection, args)
}

/// A scene of one cell, in half of the cases rotated, stretched and moved as a whole.
fn scene_of_a_cell(random: &mut Random) -> (Scene, NodeId) {
    let mut scene = Scene::default();
    let mut node = cell(&mut scene, random);
    if random.below(2) == 0 {
        let turn = Affine::rotation_xyz(random.point(-180.0, 180.0));
        let stretch = Affine::scaling(random.point(0.4, 1.6));
        let place = Affine::translation(random.point(-3.0, 3.0)).then_after(&turn).then_after(&stretch);
        node = scene.add_transform(place, node);
    }
    scene.add_object("cell", None, node);
    (scene, node)
}

fn body(world: &World) -> &SolidBody {
    match world.body(0) {
        Body::Solid(body) => body,
        Body::Surface(_) => panic!("a mesh"),
    }
}

/// The boundaries of a body along a ray if no leaf had a box: the bits of `t` and its bound, and the direction.
fn without_boxes(body: &SolidBody, ray: &Ray, span: Span) -> Vec<(u64, u64, bool)> {
    let mut sweep = Sweep::default();
    sweep.begin(&body.program, span);
    let mut events = Vec::new();
    for (number, leaf) in (0..).zip(&body.leaves) {
        let mut list = Vec::new();
        leaf.solid.crossings(&Line::of(ray).in_frame(&leaf.local_from_body), &mut list);
        for crossing in list {
            match Event::new(number, EventKind::Membership, crossing, span.t_min()) {
                Some(event) if crossing.t < f64::INFINITY => events.push(event),
                Some(_) => {}
                None => sweep.apply(&body.program, number, EventKind::Membership),
            }
        }
    }
    events.sort_by(|a, b| a.low.total_cmp(&b.low));
    events.into_iter().for_each(|event| sweep.push(&body.program, event));
    sweep.finish(&body.program);
    let out = std::iter::from_fn(|| sweep.pop());
    let out = out.map(|b| (b.crossing.t.to_bits(), b.crossing.t_err.to_bits(), b.entering)).collect();
    sweep.end(&body.program);
    out
}

fn rays_at(b: &Aabb, random: &mut Random, n: usize) -> Vec<Ray> {
    let (centre, half) = (b.centre(), b.size() * 0.5);
    let mut one = || {
        let target = centre + random.point(-1.0, 1.0) * half;
        let o = centre + random.direction() * half.max_element() * 4.0;
        Ray::new(o, (target - o) * random.number(0.1, 3.0)).expect("a ray")
    };
    (0..n).map(|_| one()).collect()
}

#[test]
fn cells_of_open_solids_have_ends_and_no_answer_depends_on_them() {
    let mut random = Random::new(91);
    for case in 0..300 {
        let (scene, node) = scene_of_a_cell(&mut random);
        let oracle = world(&scene, accel::NAMES[case % accel::NAMES.len()]);
        let (body, bounds) = (body(&oracle), oracle.bounds());
        assert!(bounds.is_empty() || bounds.is_finite(), "case {case}: {bounds:?}");
        let around = if bounds.is_empty() { Aabb::new(Vec3::splat(-4.0), Vec3::splat(4.0)) } else { bounds };
        let membership = Membership::of(&scene);
        // Points near and far: none that is inside is outside the box.
        for k in 0..400 {
            let reach = around.size() * [0.6, 1.0, 10.0, 1e3][k % 4];
            let p = around.centre() + random.point(-1.0, 1.0) * reach;
            assert!(!membership.contains(node, p) || bounds.contains(p), "case {case}: {p} {bounds:?}");
        }
        for ray in rays_at(&around, &mut random, 40) {
            let expected = without_boxes(body, &ray, Span::FORWARD);
            let list = crossings(&oracle, &ray, Span::FORWARD);
            let found: Vec<_> = list.iter().map(|h| (h.t.to_bits(), h.t_err.to_bits(), h.entering)).collect();
            assert_eq!(found, expected, "case {case}: {ray:?}");
        }
    }
}

/// The box of the points that rays hit.
fn seen(oracle: &World, random: &mut Random) -> Aabb {
    let mut points = Vec::new();
    for ray in rays_at(&oracle.bounds(), random, 4000) {
        points.extend(crossings(oracle, &ray, Span::FORWARD).iter().map(|h| ray.at(h.t)));
    }
    Aabb::around(points)
}

#[test]
fn boxes_of_cells_are_tight() {
    let mut random = Random::new(92);
    let mut worst: f64 = 1.0;
    for case in 0..60 {
        let (scene, _) = scene_of_a_cell(&mut random);
        let oracle = world(&scene, "bvh");
        if oracle.bounds().is_empty() {
            continue;
        }
        let seen = seen(&oracle, &mut random);
        if seen.is_empty() {
            continue;
        }
        let ratio = (oracle.bounds().size() / seen.size()).max_element();
        worst = worst.max(ratio);
        assert!(ratio < 2.0, "case {case}: {:?} {seen:?}", oracle.bounds());
    }
    assert!(worst > 1.0);
}

/// The box of a scene of an intersection of quadrics and half-spaces.
fn bounds_of(solids: &[[f64; 10]], planes: &[([f64; 3], f64)]) -> Aabb {
    let mut scene = Scene::default();
    let mut args: Vec<NodeId> =
        solids.iter().map(|coefficients| quadric(&mut scene, *coefficients)).collect();
    args.extend(planes.iter().map(|(n, offset)| half_space(&mut scene, Vec3::from(*n), *offset)));
    let node = scene.add_csg(Op::Intersection, args);
    scene.add_object("cell", None, node);
    world(&scene, "bvh").bounds()
}

#[track_caller]
fn assert_tight(b: Aabb, min: [f64; 3], max: [f64; 3]) {
    let off = (Vec3::from(min) - b.min).max(b.max - Vec3::from(max));
    let size = Vec3::from(min).abs().max(Vec3::from(max).abs()).max_element();
    assert!(off.min_element() >= 0.0 && off.max_element() <= 1e-13 * size, "{b:?}");
}

#[test]
fn an_octahedron_of_half_spaces_has_the_box_of_its_corners() {
    let signs = [1.0, -1.0];
    let normals = signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(|z| [*x, *y, z])));
    let planes: Vec<_> = normals.map(|n| (n, 1.0)).collect();
    assert_tight(bounds_of(&[], &planes), [-1.0; 3], [1.0; 3]);
}

#[test]
fn a_cylinder_between_two_planes_has_the_box_of_the_cylinder() {
    let pin = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    let b = bounds_of(&[pin], &[([0.0, 0.0, 1.0], 1.0), ([0.0, 0.0, -1.0], 2.0)]);
    assert_tight(b, [-1.0, -1.0, -2.0], [1.0, 1.0, 1.0]);
    let cone = [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let b = bounds_of(&[cone], &[([0.0, 0.0, 1.0], 2.0), ([0.0, 0.0, -1.0], 0.0)]);
    assert_tight(b, [-2.0, -2.0, 0.0], [2.0, 2.0, 2.0]);
    // One plane is enough for a paraboloid.
    let bowl = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0];
    assert_tight(bounds_of(&[bowl], &[([0.0, 0.0, 1.0], 4.0)]), [-2.0, -2.0, 0.0], [2.0, 2.0, 4.0]);
}

/// A hexagonal prism that is unbounded along z, as in lattices.
#[test]
fn an_endless_prism_ends_across_its_axis() {
    let h = 0.75f64.sqrt();
    let planes = [[1.0, 0.0], [0.5, h], [-0.5, h], [-1.0, 0.0], [-0.5, -h], [0.5, -h]];
    let planes: Vec<_> = planes.map(|[x, y]| ([x, y, 0.0], 1.0)).to_vec();
    let b = bounds_of(&[], &planes);
    let r = 1.0 / h;
    assert!(b.min.z == f64::NEG_INFINITY && b.max.z == f64::INFINITY, "{b:?}");
    assert!(b.max.x >= 1.0 && b.max.x < 1.0 + 1e-12 && b.max.y >= r && b.max.y < r * 1.01, "{b:?}");
}

/// Every point in a quadric is within its box, at any size and with any coefficients zero.
#[test]
fn boxes_of_quadrics_hold_them_at_any_size() {
    let mut random = Random::new(93);
    let kind = crate::solid::kind("quadric").expect("quadrics");
    for case in 0..3000 {
        let size = libm::exp2(random.number(-480.0, 480.0).round());
        let coeffs: [f64; 10] = std::array::from_fn(|i| {
            let x = [0.0, random.number(-1.0, 1.0), random.number(-2.0, 2.0).round()][random.below(3)];
            let positive = if i < 3 && case % 3 > 0 { x.abs() + 0.1 } else { x };
            positive * [1.0, size, size * size][usize::from(i > 5) + usize::from(i > 8)]
        });
        let params = crate::solid::Params::of(kind, &[&coeffs]);
        let Ok(parts) = kind.build(&params) else { continue };
        let solid = parts.single().expect("one solid");
        let bounds = solid.bounds();
        for _ in 0..60 {
            let o = random.direction() * size * random.number(0.0, 8.0);
            let line = Line::exact(o, (random.point(-2.0, 2.0) * size - o) / size);
            let mut list = Vec::new();
            solid.crossings(&line, &mut list);
            for pair in list.chunks_exact(2) {
                let (from, to) = (pair[0], pair[1]);
                let sure = to.t - from.t > 100.0 * (from.t_err + to.t_err);
                let finite = from.t.is_finite() && to.t.is_finite() && sure;
                let p = line.at(from.t.midpoint(to.t));
                let slack = p.abs().max_element() * 1e-15;
                let far = (bounds.min - p).max(p - bounds.max).max_element();
                assert!(!finite || far <= slack, "case {case}: {coeffs:?} {bounds:?} {p}");
            }
        }
    }
}

#[test]
fn a_cell_a_power_of_two_larger_has_a_box_as_much_larger() {
    for power in [-450, -100, 100, 450] {
        let size = libm::ldexp(1.0, power);
        let pin = |s: f64| about(Vec3::new(0.5, 1.0, -1.0) * s, Vec3::new(0.6, 0.0, 0.8), 1.0, 0.5 * s * s);
        let planes = |s: f64| [([0.3, 0.1, 1.0], s), ([0.1, -0.4, -1.0], 2.0 * s)];
        let (one, other) = (bounds_of(&[pin(1.0)], &planes(1.0)), bounds_of(&[pin(size)], &planes(size)));
        assert!(one.is_finite());
        let off = (other.min / size - one.min).abs().max((other.max / size - one.max).abs());
        assert!(off.max_element() <= 1e-12, "{one:?} {other:?}");
    }
}

/// In the frame of a huge body the coefficients of squares underflow, and those of planes do not.
#[test]
fn bounds_of_huge_and_tiny_bodies_cut_nothing_off() {
    let seen = |power: i32| {
        let mut scene = Scene::default();
        let sheet = quadric(&mut scene, [5.1875, 0.0, 0.0, 0.0, 0.0, 2.59375, 0.0, 5.1875, 0.0, 0.0]);
        let block = boxed(&mut scene, [-0.5, -5.8125, -1.21875], [1.875, 1.40625, 0.03125]);
        let both = csg(&mut scene, Op::Union, vec![sheet, block]);
        let size = libm::ldexp(1.0, power);
        let node = scene.add_transform(Affine::scaling(Vec3::splat(size)), both);
        scene.add_object("object", None, node);
        let world = compile(&scene, Options::default()).unwrap();
        let (o, d) = (Vec3::new(6.8125, 1.125, -1.3125), Vec3::new(0.25, 1.3125, -5.125));
        let mut hits = Vec::new();
        let ray = Ray::new(o * size, d * size).unwrap();
        Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits).unwrap();
        hits.iter().map(|hit| (hit.t.to_bits(), hit.entering)).collect::<Vec<_>>()
    };
    let expected = seen(1);
    assert_eq!(expected.len(), 2);
    for power in [-1000, -700, -300, 300, 535, 600, 1000] {
        assert_eq!(seen(power), expected, "2^{power}");
    }
}
