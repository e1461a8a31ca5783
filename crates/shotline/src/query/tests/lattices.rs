//! Lattices return the bits of the same placements listed one by one.

use super::*;
use crate::math::Lattice;
use crate::prelude::{Object, Shape};
use crate::query::Segment;
use crate::query::batch::RowsOfSix;
use crate::scene::{LocalTransform, NodeId};
use crate::testkit::scene::random_lattice;

/// Lattices of solids, of combinations, of objects with contents and of lattices. All of them are placed twice, so that the
/// groups that replace them are levels of their own too.
fn random_lattices(random: &mut Random) -> Scene {
    let mut scene = random_scene(random);
    let roots = std::mem::take(&mut scene.objects);
    let shapes: Vec<NodeId> = roots
        .iter()
        .map(|root| match scene.node(*root) {
            Node::Object { node, .. } => *node,
            other => panic!("{other:?}"),
        })
        .collect();
    let mut elements = shapes.clone();
    let turn = LocalTransform::Matrix(Affine::rotation_xyz(random.point(-90.0, 90.0)));
    elements.push(scene.add(Node::Transform { transform: turn, child: shapes[0] }));
    let corner = [-0.5, 0.0][random.below(2)];
    elements.push(scene.add_solid("box", &[&[corner; 3], &[corner + 1.0; 3]]).unwrap());
    let first = elements[random.below(elements.len())];
    let second = elements[random.below(elements.len())];
    let pitch = [0.5, 1.0, 3.0][random.below(3)];
    let inner = random_lattice(&mut scene, random, &[first, second], pitch);
    let object = |scene: &mut Scene, name: &str, node, contents| {
        let (name, material) = (name.to_owned(), None);
        scene.add(Node::Object { name, material, priority: 0, node, contents, clip: false })
    };
    let core = object(&mut scene, "core", elements[0], Vec::new());
    let cell = object(&mut scene, "cell", inner, vec![core]);
    let outer = random_lattice(&mut scene, random, &[cell, core], 4.0);
    let around = scene.add_solid("sphere", &[&[9.0]]).unwrap();
    let world = object(&mut scene, "world", around, vec![outer]);
    for shift in [random.point(-1.0, 1.0), random.point(-20.0, -10.0)] {
        let turned = Affine::rotation_xyz([Vec3::ZERO, random.point(-90.0, 90.0)][random.below(2)]);
        let placed = scene.add_transform(Affine::translation(shift).then_after(&turned), world);
        scene.objects.push(placed);
    }
    scene
}

fn some_rays(random: &mut Random) -> Vec<Ray> {
    let mut all = rays(random, 12);
    for ray in rays(random, 12) {
        // Through the corners and along the faces of cells.
        let round = |v: Vec3| (v * 2.0).round() * 0.5;
        all.extend(Ray::new(round(ray.origin()), round(ray.direction())));
    }
    all
}

/// What all queries find on a ray.
fn found(world: &World, ray: &Ray, span: Span) -> String {
    let mut caster = Caster::new(world);
    let (mut hits, mut segments): (Vec<Hit>, Vec<Segment>) = Default::default();
    caster.crossings(ray, span, &mut hits).expect("within limits");
    let mut closest = caster.closest(ray, span).expect("within limits");
    let frames: Vec<_> = hits.iter().map(|hit| world.path_transform(hit.path)).collect();
    caster.segments(ray, span, Overlaps::Priority, &mut segments).expect("solids");
    // Objects and surfaces are numbered in another order.
    let names = world.object_names();
    let mut named = String::new();
    for hit in hits.iter_mut().chain(&mut closest) {
        let surface = hit.surface.take().map(|surface| world.surface_name(surface));
        let object = std::mem::take(&mut hit.object);
        named += &format!("{hit:?} {} {surface:?}\n", names[object as usize]);
    }
    for segment in &mut segments {
        let object = std::mem::take(&mut segment.object);
        named += &format!("{segment:?} {}\n", names[object as usize]);
    }
    let owner = caster.owner_at(ray.at(1.0)).expect("within limits").map(|(_, path)| path);
    format!("{named}{frames:?} {owner:?}")
}

#[test]
fn lattices_are_their_placements_listed_one_by_one() {
    let mut random = Random::new(94);
    let mut crossings = 0;
    for case in 0..150 {
        let scene = random_lattices(&mut random);
        let accel = crate::accel::NAMES[case % crate::accel::NAMES.len()];
        let (lattice, listed) =
            (world(&scene, "bvh"), world(&scene.with_lattices_listed(1 << 20).unwrap(), accel));
        assert_eq!(lattice.path_count(), listed.path_count());
        assert_eq!(lattice.stats().virtual_leaves, listed.stats().virtual_leaves);
        let rays = some_rays(&mut random);
        for ray in &rays {
            for span in [Span::FORWARD, Span::new(0.5, 2.0).unwrap()] {
                let [a, b] = [&lattice, &listed].map(|world| found(world, ray, span));
                assert_eq!(a, b, "case {case}, {accel}, {ray:?}");
            }
            crossings += super::crossings(&lattice, ray, Span::FORWARD).len();
        }
        let batch = |world: &World| {
            let rows: Vec<[f64; 6]> = rays
                .iter()
                .map(|ray| {
                    let (o, d) = (ray.origin(), ray.direction());
                    [o.x, o.y, o.z, d.x, d.y, d.z]
                })
                .collect();
            let rows: Vec<[f64; 6]> = rows.iter().cycle().take(200).copied().collect();
            batch_crossings(world, &rows)
        };
        assert_eq!(batch(&lattice), batch(&listed), "case {case}");
    }
    assert!(crossings > 20_000, "{crossings}");
}

fn batch_crossings(world: &World, rows: &[[f64; 6]]) -> String {
    let run = Run::default();
    let closest = batch::closest(world, &RowsOfSix(rows), Span::FORWARD, run).expect("valid rays");
    let crossings = batch::crossings(world, &RowsOfSix(rows), Span::FORWARD, run).expect("valid rays");
    format!("{:?} {:?} {:?} {:?} {:?}", closest.t, closest.normal, closest.path, crossings.t, crossings.path)
}

fn ball_lattice(counts: [u32; 3]) -> World {
    let balls = Shape::sphere(0.25).unwrap().lattice(Lattice::rectangular(counts, [1.0; 3]));
    Scene::of([Object::new("balls", balls)]).compile().unwrap()
}

#[test]
fn a_billion_cells_take_no_memory_and_no_time() {
    let world = ball_lattice([1000; 3]);
    assert_eq!((world.path_count(), world.stats().virtual_leaves), (1_000_000_000, 1_000_000_000));
    assert!(world.stats().memory_bytes < 8_000, "{}", world.stats().memory_bytes);
    assert_eq!(world.path_name(999_999_999), "balls/sphere[999,999,999]");
    assert_eq!(world.path_transform(1_002_003).unwrap(), Affine::translation(Vec3::new(3.0, 2.0, 1.0)));
    let mut caster = Caster::new(&world);
    let along = |o: [f64; 3], d: [f64; 3]| Ray::new(Vec3::from(o), Vec3::from(d)).unwrap();
    for (ray, cells) in [
        (along([-5.0, 7.0, 11.0], [1.0, 0.0, 0.0]), 1000),
        (along([3.0, 2000.0, 11.0], [0.0, -1.0, 0.0]), 1000),
        (along([-5.0; 3], [1.0; 3]), 1000),
        (along([999.0, 999.0, 1.5], [0.0, 0.0, 3.0]), 998),
        (along([0.5, 0.5, -5.0], [0.0, 0.0, 1.0]), 0),
    ] {
        assert_eq!(caster.count(&ray, Span::FORWARD), Ok(2 * cells), "{ray:?}");
    }
    let hit = caster.closest(&along([-5.0; 3], [1.0; 3]), Span::FORWARD).unwrap().unwrap();
    assert_eq!(hit.path, 0);
}

/// The work on a ray is that of the cells that it meets, also where the lattice is turned and the ray runs along its rows.
#[test]
fn rays_cost_the_cells_that_they_meet() {
    let balls = Shape::sphere(0.25).unwrap().lattice(Lattice::rectangular([1000; 3], [1.0; 3]));
    let turn = Vec3::new(10.0, 20.0, 30.0);
    let world = Scene::of([Object::new("balls", balls.rotate(turn))]).compile().unwrap();
    let map = Affine::rotation_xyz(turn);
    let mut caster = Caster::new(&world);
    for (o, d, cells) in [
        ([-5.0, 7.0, 11.0], [1.0, 0.0, 0.0], 1000),
        ([7.0, 11.0, -5.0], [0.0, 0.0, 1.0], 1000),
        ([-5.0, 7.5, 11.5], [1.0, 0.0, 0.0], 0),
        ([-5.0, -5.0, 3.0], [1.0, 1.0, 0.0], 1000),
    ] {
        let ray = Ray::new(map.point(Vec3::from(o)), map.vector(Vec3::from(d))).unwrap();
        caster.take_counters();
        assert_eq!(caster.count(&ray, Span::FORWARD), Ok(2 * cells), "{ray:?}");
        let boxes = caster.take_counters().boxes;
        assert!(boxes < 8000, "{boxes} boxes for {cells} cells, {ray:?}");
    }
}
