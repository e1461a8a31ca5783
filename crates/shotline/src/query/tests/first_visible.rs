//! What is seen first where objects are hidden, against the owners of points on the ray.

use std::sync::Arc;

use super::ownership::{Nest, Walk};
use super::world;
use crate::compile::World;
use crate::csg::HitKind;
use crate::math::Vec3;
use crate::prelude::*;
use crate::query::{Hit, Kinds, Overlaps, Scope};
use crate::scene::Node;
use crate::solid::mesh::TriangleMesh;
use crate::testkit::random::Random;

/// What is expected of a hit: its `t`, its object, its path, whether the owner begins there, and the kind.
type Expected = (f64, u32, u64, bool, HitKind);

/// Steps of one unit along a ray from the middle of a cell: the faces of all boxes are between them.
const STEPS: usize = 60;

/// A ray along an axis through the middles of cells.
fn random_ray(random: &mut Random) -> Ray {
    let direction = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z][random.below(4)];
    let across = [0; 3].map(|_| random.below(8) as f64 + 0.5);
    let origin = Vec3::from(across) * (Vec3::ONE - direction.abs()) - direction * 25.5;
    Ray::new(origin, direction).expect("a ray")
}

/// The owner of each step, as a body with its object.
fn owners(walk: &Walk, ray: &Ray) -> Vec<Option<(u64, u32)>> {
    let owner = |step: usize| {
        let (body, _) = walk.owner_at(ray.at(step as f64))?;
        Some((body as u64, walk.instances[walk.bodies[body].instance].object))
    };
    (0..STEPS).map(owner).collect()
}

/// What a ray sees first from the middle of a step on.
fn expected(owners: &[Option<(u64, u32)>], first: usize, kinds: Kinds, hidden: &[bool]) -> Option<Expected> {
    let is_shown = |object: u32| !hidden[object as usize];
    let shown = |step: usize| owners[step].filter(|&(_, object)| is_shown(object));
    let begin = |step: usize| {
        let (path, object) = shown(step)?;
        let (t, kind) =
            if step == first { (step as f64, HitKind::Start) } else { (step as f64 - 0.5, HitKind::Surface) };
        Some((t, object, path, true, kind))
    };
    let Some((path, object)) = shown(first).filter(|_| kinds == Kinds::Surfaces) else {
        return (first..STEPS).find_map(begin);
    };
    let left = (first..STEPS).find(|&step| owners[step].map(|owner| owner.0) != Some(path))?;
    begin(left).or(Some((left as f64 - 0.5, object, path, false, HitKind::Surface)))
}

fn check_hit(ray: &Ray, hit: Option<&Hit>, expected: Option<Expected>) {
    assert_eq!(hit.map(|hit| (hit.t, hit.object, hit.path, hit.entering, hit.kind)), expected, "{ray:?}");
    let Some(hit) = hit else { return };
    if hit.kind == HitKind::Start {
        assert!(hit.normal.is_nan() && hit.surface.is_none());
    } else {
        assert!(hit.surface.is_some());
        assert_eq!(hit.normal, if hit.entering { -ray.direction() } else { ray.direction() });
    }
}

/// The first of the segments that is visible. It has the bits of the query.
fn first_segment(caster: &mut Caster, ray: &Ray, span: Span, hidden: &[bool]) -> Option<(f64, u32, u64)> {
    let mut segments = Vec::new();
    caster.segments(ray, span, Overlaps::Priority, &mut segments).expect("solids");
    let shown = segments.iter().find(|segment| !hidden[segment.object as usize])?;
    Some((shown.t_in, shown.object, shown.path))
}

#[test]
fn it_is_the_first_visible_owner_of_a_walk_over_the_scene() {
    let mut random = Random::new(82);
    let mut seen = [0; 4];
    for case in 0..1500 {
        let nest = Nest::random(&mut random, case % 2 == 0);
        let world = world(&nest.scene, ["bvh", "grid", "brute"][case % 3]);
        let walk = Walk::of(&nest.scene, &world);
        let hidden: Vec<bool> = world.object_names().iter().map(|_| random.below(3) == 0).collect();
        let mut caster = Caster::new(&world);
        for _ in 0..8 {
            let ray = random_ray(&mut random);
            let owners = owners(&walk, &ray);
            for kinds in [Kinds::All, Kinds::Surfaces] {
                // From outside, or from the middle.
                let first = [0, 24 + random.below(8)][random.below(2)];
                let span = Span::new(first as f64, f64::INFINITY).expect("a span");
                let hit = caster.first_visible(&ray, Scope { span, kinds }, &hidden).expect("solids");
                let expected = expected(&owners, first, kinds, &hidden);
                check_hit(&ray, hit.as_ref(), expected);
                if kinds == Kinds::All {
                    let hit = hit.as_ref().map(|hit| (hit.t, hit.object, hit.path));
                    assert_eq!(hit, first_segment(&mut caster, &ray, span, &hidden), "{ray:?}");
                }
                let case = match expected {
                    None => 0,
                    Some((.., false, _)) => 1,
                    Some((.., HitKind::Start)) => 2,
                    Some(_) => 3,
                };
                seen[case] += 1;
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 300), "{seen:?}");
}

/// Rays in any direction through spheres and boxes of which many are hidden: the segments say the same, bit for bit.
#[test]
fn it_begins_the_first_visible_segment() {
    let mut random = Random::new(83);
    let mut met = 0;
    for _ in 0..200 {
        let mut part = |number: usize, size: f64, contents: Vec<Object>| {
            let shape = match random.below(2) {
                0 => Shape::sphere(size).expect("a ball"),
                _ => Shape::cuboid(Vec3::splat(-0.7 * size), Vec3::splat(0.6 * size)).expect("a box"),
            };
            let object = Object::new(format!("part {number}"), shape).containing(contents);
            if random.below(2) == 0 { object.clip() } else { object }
        };
        let mut inner = Vec::new();
        for number in 0..8 {
            let object = part(number, 1.0 + 0.3 * number as f64, std::mem::take(&mut inner));
            inner.push(object);
        }
        let world = Scene::of(inner).compile().expect("a world");
        let hidden: Vec<bool> = world.object_names().iter().map(|_| random.below(2) == 0).collect();
        let mut caster = Caster::new(&world);
        for _ in 0..50 {
            let (from, to) = (random.point(-5.0, 5.0), random.point(-1.0, 1.0));
            let ray = Ray::new(from, to - from).expect("a ray");
            let hit = caster.first_visible(&ray, Span::FORWARD, &hidden).expect("solids");
            let expected = first_segment(&mut caster, &ray, Span::FORWARD, &hidden);
            assert_eq!(hit.map(|hit| (hit.t, hit.object, hit.path)), expected);
            met += usize::from(hit.is_some());
            if let Some(hit) = hit.filter(|hit| hit.kind == HitKind::Surface) {
                assert!(
                    hit.normal.dot(ray.direction()) <= 1e-12 && (hit.normal.length() - 1.0).abs() < 1e-12
                );
            }
        }
    }
    assert!(met > 5000, "{met}");
}

/// A mesh that is not closed hides what is behind it, and nothing if it is hidden.
#[test]
fn surfaces_without_an_inside_are_seen() {
    let ball = |name: &str, radius: f64| Object::new(name, Shape::sphere(radius).expect("a ball"));
    let mut scene = Scene::of([ball("shell", 3.0).containing([ball("core", 1.0)])]);
    let vertices = [[-2.0, -9.0, -9.0], [-2.0, 9.0, 0.0], [-2.0, -9.0, 9.0]].map(Vec3::from).to_vec();
    let mesh = Arc::new(TriangleMesh::new(vertices, vec![[0, 1, 2]]));
    let node = scene.add(Node::Mesh { mesh, file: None });
    scene.add_object("sheet", None, node);
    let world = scene.compile().expect("a world");
    let ray = Ray::new(Vec3::X * -9.0, Vec3::X).expect("a ray");
    let name = |world: &World, hit: &Hit| world.object_names()[hit.object as usize].clone();
    let first = |hidden: [bool; 3]| {
        let hit = Caster::new(&world).first_visible(&ray, Span::FORWARD, &hidden).expect("no limit")?;
        Some((name(&world, &hit), hit.t))
    };
    assert_eq!(world.object_names(), ["shell", "core", "sheet"]);
    assert_eq!(first([false; 3]), Some(("shell".into(), 6.0)));
    assert_eq!(first([true, false, false]), Some(("sheet".into(), 7.0)));
    assert_eq!(first([true, false, true]), Some(("core".into(), 8.0)));
    assert_eq!(first([true; 3]), None);
}
