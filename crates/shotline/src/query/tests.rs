//! Tests of whole worlds: every query agrees with every other query, with membership, and with every accelerator.

mod bounds;
mod bundles;
mod contacts;
mod first;
mod first_visible;
mod growth;
mod lanes;
mod large_bodies;
mod lattices;
mod limits;
mod meshes_of_hits;
mod ownership;
mod rulings;
mod small_body;
mod spans;
mod structures;
mod surfaces;
mod thin;
mod touching;
mod turned_boxes;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::batch::{self, Run};
use super::{Caster, CoherenceHint, Hit, HitKind, Overlaps};
use crate::compile::{Options, World, compile};
use crate::math::{Affine, Vec3};
use crate::ray::{Ray, Span};
use crate::scene::{Node, Op, Scene};
use crate::solid::mesh::TriangleMesh;
use crate::testkit::random::Random;
use crate::testkit::scene::random_scene;

fn world(scene: &Scene, accel: &'static str) -> World {
    compile(scene, Options { accel: Some(accel) }).unwrap_or_else(|e| panic!("{e:?}"))
}

fn rays(random: &mut Random, n: usize) -> Vec<Ray> {
    let mut out = Vec::new();
    for i in 0..n {
        let o = if i % 3 == 0 { random.point(-1.0, 1.0) } else { random.direction() * 6.0 };
        let d = random.point(-1.5, 1.5) - o;
        out.push(Ray::new(o, d * random.number(0.1, 3.0)).expect("a ray"));
    }
    for axis in 0..3 {
        let mut d = Vec3::ZERO;
        d[axis] = 1.0;
        out.push(Ray::new(random.point(-0.5, 0.5) - d * 8.0, d).expect("a ray"));
    }
    out
}

fn crossings(world: &World, ray: &Ray, span: Span) -> Vec<Hit> {
    let mut out = Vec::new();
    Caster::new(world).crossings(ray, span, &mut out).expect("within limits");
    out
}

/// Compares as text, so that NaN normals are equal.
fn assert_same(a: &[Hit], b: &[Hit], context: &str) {
    assert_eq!(format!("{a:?}"), format!("{b:?}"), "{context}");
}

/// The matrix of a path maps its solid to where the ray hits it, through nested levels.
#[test]
fn paths_have_matrices() {
    let mut random = Random::new(17);
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
    let mut node = ball;
    for _ in 0..6 {
        let mut place = |node| {
            let turn = Affine::rotation_xyz(random.point(-90.0, 90.0));
            let shrunk = turn.then_after(&Affine::scaling(Vec3::new(0.5, 0.6, 0.7)));
            scene.add_transform(Affine::translation(random.point(-2.0, 2.0)).then_after(&shrunk), node)
        };
        let members = (0..4).map(|_| place(node)).collect();
        node = scene.add(Node::Group { members });
    }
    scene.add_object("tree", None, node);
    let world = world(&scene, "bvh");
    let mut caster = Caster::new(&world);
    let mut met = 0;
    for path in (0..world.path_count()).step_by(17) {
        let transform = world.path_transform(path).expect("it is in use");
        let o = random.direction() * 20.0;
        let ray = Ray::new(o, transform.point(Vec3::ZERO) - o).expect("a ray");
        let mut hits = Vec::new();
        caster.crossings(&ray, Span::FORWARD, &mut hits).expect("within limits");
        let own: Vec<&Hit> = hits.iter().filter(|hit| hit.path == path).collect();
        assert_eq!(own.len(), 2, "path {path}");
        for hit in own {
            let inside = transform.inverse().expect("it has one").point(ray.at(hit.t));
            assert!((inside.length() - 1.0).abs() < 1e-9, "path {path}: {inside}");
            met += 1;
        }
    }
    assert!(met > 400 && world.path_transform(world.path_count()).is_none());
}

/// Between crossings, membership is what `contains` returns, and crossings of a path alternate.
#[test]
fn crossings_agree_with_membership() {
    let mut random = Random::new(4);
    for case in 0..60 {
        let scene = random_scene(&mut random);
        let world = world(&scene, "bvh");
        let mut caster = Caster::new(&world);
        for ray in rays(&mut random, 30) {
            let hits = crossings(&world, &ray, Span::FORWARD);
            let mut ts: Vec<f64> = hits.iter().map(|h| h.t).collect();
            ts.insert(0, 0.0);
            ts.push(ts[ts.len() - 1] + 1.0);
            for w in ts.windows(2).filter(|w| w[1] - w[0] > 1e-7) {
                let t = 0.5 * (w[0] + w[1]);
                let mut inside: BTreeMap<u64, u32> = BTreeMap::new();
                for hit in hits.iter().filter(|h| h.t < t) {
                    let odd = inside.remove(&hit.path).is_none();
                    assert_eq!(hit.entering, odd, "scene {case}, {ray:?}: {hits:?}");
                    if odd {
                        inside.insert(hit.path, hit.object);
                    }
                }
                let mut expected: Vec<u32> = inside.into_values().collect();
                expected.sort_unstable();
                expected.dedup();
                let mut held = Vec::new();
                caster.contains(ray.at(t), &mut held).expect("solids only");
                assert_eq!(held, expected, "scene {case}, {ray:?} at {t}");
            }
        }
    }
}

#[test]
fn normals_are_unit_and_point_out() {
    let mut random = Random::new(5);
    for _ in 0..40 {
        let world = world(&random_scene(&mut random), "bvh");
        for ray in rays(&mut random, 30) {
            for hit in crossings(&world, &ray, Span::FORWARD) {
                if hit.kind == HitKind::Surface {
                    assert!((hit.normal.length() - 1.0).abs() < 1e-12);
                    let slope = hit.normal.dot(ray.direction().normalize());
                    assert!(slope.abs() < 1e-6 || (slope < 0.0) == hit.entering, "{ray:?} {hit:?}");
                }
            }
        }
    }
}

#[test]
fn shot_from_the_far_end_the_list_is_mirrored() {
    let mut random = Random::new(6);
    for _ in 0..40 {
        let world = world(&random_scene(&mut random), "bvh");
        for ray in rays(&mut random, 30) {
            let end = 4.0;
            let span = Span::new(0.0, end).expect("an interval");
            let back = Ray::new(ray.at(end), -ray.direction()).expect("a ray");
            let there = crossings(&world, &ray, span);
            let mut here = crossings(&world, &back, span);
            here.reverse();
            let key = |h: &Hit| (h.path, h.t);
            let sorted = |hits: &[Hit], mirror: bool| {
                let mut keys: Vec<(u64, f64)> = hits.iter().map(key).collect();
                keys.iter_mut().for_each(|k| k.1 = if mirror { end - k.1 } else { k.1 });
                keys.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
                keys
            };
            let (a, b) = (sorted(&there, false), sorted(&here, true));
            assert_eq!(a.len(), b.len(), "{ray:?}\n{there:?}\n{here:?}");
            for (x, y) in a.iter().zip(&b) {
                assert!(x.0 == y.0 && (x.1 - y.1).abs() < 1e-7, "{ray:?} {x:?} {y:?}");
            }
        }
    }
}

#[test]
fn any_split_and_any_number_of_threads_give_the_same_bits() {
    let mut random = Random::new(8);
    let world = world(&random_scene(&mut random), "bvh");
    let rays = rays(&mut random, 10_000);
    let run = |threads| Run { threads, ..Run::default() };
    let print = |threads| {
        let all = batch::crossings(&world, &rays, Span::FORWARD, run(threads)).expect("not cancelled");
        let closest = batch::closest(&world, &rays, Span::FORWARD, run(threads)).expect("not cancelled");
        let any = batch::any(&world, &rays, Span::FORWARD, run(threads)).expect("not cancelled");
        let count = batch::count(&world, &rays, Span::FORWARD, run(threads)).expect("not cancelled");
        format!("{all:?}{closest:?}{any:?}{count:?}")
    };
    let alone = print(1);
    assert!(alone == print(2) && alone == print(3));
    let halves: Vec<i64> = rays
        .chunks(5003)
        .flat_map(|half| batch::count(&world, half, Span::FORWARD, run(1)).expect("not cancelled"))
        .collect();
    assert_eq!(halves, batch::count(&world, &rays, Span::FORWARD, run(2)).expect("not cancelled"));
}

#[test]
fn powers_of_two_scale_every_t_exactly() {
    let mut random = Random::new(9);
    for _ in 0..20 {
        let world = world(&random_scene(&mut random), "bvh");
        for ray in rays(&mut random, 30) {
            let a = crossings(&world, &ray, Span::FORWARD);
            for factor in [8.0, 2f64.powi(-300), 2f64.powi(300)] {
                let longer = Ray::new(ray.origin(), ray.direction() * factor).expect("a ray");
                let b = crossings(&world, &longer, Span::FORWARD);
                assert_eq!(a.len(), b.len());
                for (x, y) in a.iter().zip(&b) {
                    assert_eq!(x.t, y.t * factor, "{ray:?}");
                }
            }
        }
    }
}

/// The same model in another frame: every object below one more transform.
fn moved(scene: &Scene, by: &Affine) -> Scene {
    let mut moved = scene.clone();
    for i in 0..moved.objects.len() {
        let object = moved.objects[i].0 as usize;
        let Node::Object { node: inner, .. } = moved.nodes[object] else { panic!("an object") };
        let outer = moved.add_transform(*by, inner);
        if let Node::Object { node, .. } = &mut moved.nodes[object] {
            *node = outer;
        }
    }
    moved
}

/// At a distance of a million times its size, a model has as many crossings.
#[test]
fn far_from_the_origin_the_counts_are_the_same() {
    let mut random = Random::new(12);
    for _ in 0..30 {
        let scene = random_scene(&mut random);
        let away = random.direction() * 4e6;
        let (near, far) = (world(&scene, "bvh"), world(&moved(&scene, &Affine::translation(away)), "bvh"));
        for ray in rays(&mut random, 30) {
            let there = Ray::new(ray.origin() + away, ray.direction()).expect("a ray");
            let (a, b) = (crossings(&near, &ray, Span::FORWARD), crossings(&far, &there, Span::FORWARD));
            assert_eq!(a.len(), b.len(), "{ray:?} moved by {away}\n{a:?}\n{b:?}");
        }
    }
}

/// The same model and ray, scaled by powers of two, have the same bits.
#[test]
fn the_size_of_the_world_is_no_matter() {
    let mut random = Random::new(10);
    for _ in 0..20 {
        let scene = random_scene(&mut random);
        let rays = rays(&mut random, 30);
        for factor in [-300, -20, 20, 300].map(|k| 2f64.powi(k)) {
            let scaled = moved(&scene, &Affine::scaling(Vec3::splat(factor)));
            let (small, large) = (world(&scene, "bvh"), world(&scaled, "bvh"));
            for ray in &rays {
                let there = Ray::new(ray.origin() * factor, ray.direction() * factor).expect("a ray");
                let ts = |hits: Vec<Hit>| hits.iter().map(|h| h.t.to_bits()).collect::<Vec<_>>();
                let (a, b) =
                    (crossings(&small, ray, Span::FORWARD), crossings(&large, &there, Span::FORWARD));
                assert_eq!(ts(a), ts(b), "{ray:?} by {factor}");
            }
        }
    }
}

/// Two adjacent boxes as objects, given the priority of the right one and how far it extends into the left one.
fn two_boxes(priority: i32, into: f64) -> World {
    let mut scene = Scene::default();
    let corner = |x: f64, y: f64| [x, y, y];
    let left = scene.add_solid("box", &[&corner(0.0, -1.0), &corner(2.0, 1.0)]).expect("box");
    let right = scene.add_solid("box", &[&corner(2.0 - into, -1.0), &corner(4.0, 1.0)]).expect("box");
    scene.add_object("left", None, left);
    let id = scene.add_object("right", None, right);
    if let Node::Object { priority: p, .. } = &mut scene.nodes[id.0 as usize] {
        *p = priority;
    }
    world(&scene, "bvh")
}

#[test]
fn segments_resolve_overlaps_by_priority() {
    let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X * 2.0).expect("a ray");
    let segments = |world: &World, overlaps| {
        let mut out = Vec::new();
        let count = Caster::new(world).segments(&ray, Span::FORWARD, overlaps, &mut out);
        (count, out.iter().map(|s| (s.t_in, s.t_out, s.length, s.object)).collect::<Vec<_>>())
    };
    let abutting = two_boxes(0, 0.0);
    let expected = vec![(0.5, 1.5, 2.0, 0), (1.5, 2.5, 2.0, 1)];
    assert_eq!(segments(&abutting, Overlaps::Error), (Ok(0), expected));
    let overlapping = two_boxes(0, 1.0);
    let (error, _) = segments(&overlapping, Overlaps::Error);
    let text = error.expect_err("an overlap").to_string();
    assert!(text.contains("'left'") && text.contains("'right'") && text.contains("t = 1"), "{text}");
    let expected = vec![(0.5, 1.0, 1.0, 0), (1.0, 2.5, 3.0, 1)];
    assert_eq!(segments(&overlapping, Overlaps::Priority), (Ok(1), expected));
    let expected = vec![(0.5, 1.5, 2.0, 0), (1.0, 2.5, 3.0, 1)];
    assert_eq!(segments(&overlapping, Overlaps::All), (Ok(0), expected));
    let expected = vec![(0.5, 1.5, 2.0, 0), (1.5, 2.5, 2.0, 1)];
    assert_eq!(segments(&two_boxes(-1, 1.0), Overlaps::Error), (Ok(0), expected));
}

#[test]
fn instances_are_compiled_once_and_named() {
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[0.25]]).expect("sphere");
    scene.defs.push(("ball".into(), ball));
    let mut part = ball;
    // Each level contains ten of the level below: 10^12 spheres.
    for level in 0..12 {
        let step = 10f64.powi(level);
        let members = (0..10)
            .map(|i| {
                let move_by = Affine::translation(Vec3::X * (step * f64::from(i)));
                scene.add_transform(move_by, part)
            })
            .collect();
        part = scene.add(Node::Group { members });
        scene.defs.push((format!("level{level}"), part));
    }
    scene.add_object("world", None, part);
    let world = world(&scene, "bvh");
    assert_eq!(world.stats().leaves, 1);
    assert_eq!(world.stats().virtual_leaves, 1_000_000_000_000);
    assert_eq!(world.path_count(), 1_000_000_000_000);
    assert!(world.stats().memory_bytes < 100_000);
    let down = Ray::new(Vec3::new(123_456_789_012.0, 0.0, 5.0), -Vec3::Z).expect("a ray");
    let hit =
        Caster::new(&world).closest(&down, Span::FORWARD).expect("within limits").expect("a sphere below");
    assert_eq!(hit.path, 123_456_789_012);
    let name = world.path_name(hit.path);
    assert!(name.starts_with("world/level10[1]/level9[2]/level8[3]/"), "{name}");
    assert!(name.ends_with("/level0[1]/ball[2]"), "{name}");
}

#[test]
fn a_box_of_many_holes_costs_what_the_ray_meets() {
    let mut scene = Scene::default();
    let mut random = Random::new(12);
    let block = scene.add_solid("box", &[&[-1.0; 3], &[1.0; 3]]).expect("box");
    let hole = scene.add_solid("sphere", &[&[0.01]]).expect("sphere");
    let mut args = vec![block];
    for _ in 0..10_000 {
        let p = random.point(-1.0, 1.0);
        args.push(scene.add_transform(Affine::translation(p), hole));
    }
    let node = scene.add_csg(Op::Difference, args);
    scene.add_object("sponge", None, node);
    let world = world(&scene, "bvh");
    let mut caster = Caster::new(&world);
    for ray in rays(&mut random, 50) {
        caster.closest(&ray, Span::FORWARD).expect("within limits");
    }
    let counters = caster.take_counters();
    assert!(counters.primitive_tests < 53 * 40, "{counters:?}");
}

/// A world with a surface in it has no segments, whatever the ray hits.
#[test]
fn surfaces_have_hits_but_no_inside() {
    let mut scene = Scene::default();
    let vertices = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let sheet = TriangleMesh::new(vertices, vec![[0, 1, 2]]);
    let sheet = scene.add(Node::Mesh { mesh: Arc::new(sheet), file: None });
    let group = scene.add(Node::Group { members: vec![sheet, sheet] });
    let ball = scene.add_solid("sphere", &[&[0.1]]).expect("sphere");
    scene.add_object("ball", None, ball);
    scene.add_object("sheet", None, group);
    let world = world(&scene, "bvh");
    let mut caster = Caster::new(&world);
    let down = |x: f64| Ray::new(Vec3::new(x, 0.2, 1.0), -Vec3::Z).expect("a ray");
    assert_eq!(caster.count(&down(0.3), Span::FORWARD).expect("within limits"), 2);
    for ray in [down(0.3), down(50.0)] {
        let answer = caster.segments(&ray, Span::FORWARD, Overlaps::All, &mut Vec::new());
        let text = answer.expect_err("no inside").to_string();
        assert!(text.contains("'sheet'") && text.contains("3 open edges"), "{text}");
        let rows = batch::segments(&world, &[ray], Span::FORWARD, Overlaps::All, Run::default());
        assert!(matches!(rows, Err(batch::BatchError::World(_))));
    }
    assert!(caster.contains(Vec3::ZERO, &mut Vec::new()).is_err());
}
