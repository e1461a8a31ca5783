//! Bodies of few leaves, which are tested without an accelerator, a heap and counters: the same bits as with them.

use super::*;
use crate::scene::NodeId;
use crate::testkit::agreement;

/// Solids with faces, edges and axes at integer coordinates, so that they share them.
fn leaf(scene: &mut Scene, random: &mut Random) -> NodeId {
    let mut whole = || random.below(4) as f64;
    let (a, b, c) = (whole(), whole(), whole());
    let size = 1.0 + whole().min(2.0);
    let mut add = |kind: &str, values: &[&[f64]]| scene.add_solid(kind, values).expect("a solid");
    match random.below(6) {
        0 | 1 => add("box", &[&[a, b, c], &[a + size, b + 1.0, c + size]]),
        2 => {
            let mut normal = [0.0; 3];
            normal[random.below(3)] = if random.below(2) == 0 { 1.0 } else { -1.0 };
            add("halfspace", &[&normal, &[a - b]])
        }
        3 => add("halfspace", &[&[a - 1.0, b - 2.0, c + 1.0], &[size]]),
        4 => add("cylinder", &[&[size], &[-a], &[b + 1.0]]),
        _ => add("quadric", &[&[1.0, 1.0, c - 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -size]]),
    }
}

fn combination(scene: &mut Scene, random: &mut Random, leaf_count: usize) -> NodeId {
    let mut open: Vec<NodeId> = (0..leaf_count).map(|_| leaf(scene, random)).collect();
    while open.len() > 1 {
        let take = (2 + random.below(2)).min(open.len());
        let args = (0..take).map(|_| open.swap_remove(random.below(open.len()))).collect();
        let op = [Op::Union, Op::Intersection, Op::Intersection, Op::Difference][random.below(4)];
        open.push(scene.add_csg(op, args));
    }
    open[0]
}

/// Rays along axes and diagonals through integer and half-integer points, in faces and along edges, and random rays.
/// Spans begin at integers, and so inside, outside and at surfaces.
fn lattice_rays(random: &mut Random, count: usize) -> Vec<(Ray, Span)> {
    let one = |random: &mut Random| {
        let place = |random: &mut Random| random.below(13) as f64 * 0.5 - 1.0;
        let o = Vec3::new(place(random), place(random), place(random));
        let d = match random.below(4) {
            0 => random.direction(),
            1 => Vec3::AXES[random.below(3)],
            // Almost parallel to a face.
            2 => Vec3::AXES[random.below(3)] + random.direction() * 1e-16,
            _ => Vec3::new(1.0, random.below(3) as f64 - 1.0, random.below(2) as f64),
        };
        let t_min = [0.0, -6.0, 1.0, -f64::from(random.below(8) as u32) * 0.5][random.below(4)];
        let t_max = if random.below(2) == 0 { f64::INFINITY } else { t_min + random.below(9) as f64 * 0.5 };
        (Ray::new(o, d).expect("a ray"), Span::new(t_min, t_max).expect("an interval"))
    };
    (0..count).map(|_| one(random)).collect()
}

#[test]
fn few_leaves_are_asked_by_short_ways_with_the_same_bits() {
    let mut random = Random::new(23);
    let mut met = 0;
    for case in 0..240 {
        let mut scene = Scene::default();
        let part = combination(&mut scene, &mut random, 1 + case % 8);
        let node = match case % 3 {
            0 => part,
            // A frame of its own, with rounding errors.
            1 => scene.add_transform(Affine::rotation_xyz(Vec3::new(10.0, 20.0, 330.0)), part),
            _ => {
                let moved = scene.add_transform(Affine::translation(Vec3::new(0.1, 0.0, 1.0)), part);
                scene.add(Node::Group { members: vec![part, moved] })
            }
        };
        scene.add_object("few", None, node);
        let rays = lattice_rays(&mut random, 30);
        assert!(agreement::check_scene(&scene, &rays), "case {case}");
        let world = world(&scene, "bvh");
        met += rays.iter().map(|(ray, span)| crossings(&world, ray, *span).len()).sum::<usize>();
    }
    assert!(met > 3000, "{met}");
}

/// A fuel pin as OpenMC writes it: an infinite cylinder, cut by two planes.
#[test]
fn planes_that_a_line_stays_clear_of_are_not_intersected() {
    let mut scene = Scene::default();
    let coeffs = [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.16];
    let cylinder = scene.add_solid("quadric", &[&coeffs]).expect("a quadric");
    let mut half = |z: f64| scene.add_solid("halfspace", &[&[0.0, 0.0, z], &[1.0]]).expect("a half-space");
    let args = vec![cylinder, half(1.0), half(-1.0)];
    let pin = scene.add_csg(Op::Intersection, args);
    let pin = scene.add_transform(Affine::translation(Vec3::new(0.1, 0.2, 0.3)), pin);
    scene.add_object("pin", None, pin);
    let world = world(&scene, "bvh");
    let mut random = Random::new(31);
    // Across the pin, past it, and through its ends, also near its edges.
    let mut rays = Vec::new();
    for i in 0..3000 {
        let z = [0.3, 1.3, -0.7][i % 3] + [0.0, 0.3, 1e-9, 1e-14][i % 4] * random.number(-1.0, 1.0);
        let around = |random: &mut Random, radius: f64| {
            let v = random.direction() * radius;
            Vec3::new(0.1 + v.x, 0.2 + v.y, z)
        };
        let (o, through) = (around(&mut random, 3.0), around(&mut random, 0.35));
        let d = through - o + Vec3::Z * random.number(-1.0, 1.0) * [0.0, 1e-16, 0.01, 1.0][i % 4];
        let span = [Span::FORWARD, Span::new(1.0, 1.0 + 0.1 * random.number(0.0, 1.0)).expect("an interval")];
        rays.push((Ray::new(o, d).expect("a ray"), span[i % 2]));
    }
    assert!(agreement::check_scene(&scene, &rays));
    let mut caster = Caster::new(&world);
    let (o, d) = (Vec3::new(-3.0, 0.2, 0.3), Vec3::new(1.0, 0.01, 0.02));
    let mut hits = Vec::new();
    caster.crossings(&Ray::new(o, d).expect("a ray"), Span::FORWARD, &mut hits).expect("within limits");
    assert_eq!((hits.len(), caster.take_counters().primitive_tests), (2, 1));
}
