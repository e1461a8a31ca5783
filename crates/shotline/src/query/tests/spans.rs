//! All queries agree, wherever the span begins and ends: at crossings, just before and after them, inside walls and
//! between them.

use super::*;
use crate::testkit::agreement::{check_scene, check_world, contains_agrees, spans_of};
use crate::testkit::meshes::{Thin, cuboid, rays_at, tray};
use crate::testkit::scene::random_mixed_scene;

fn mesh_scene(mesh: TriangleMesh) -> Scene {
    let mut scene = Scene::default();
    let mesh = scene.add(Node::Mesh { mesh: Arc::new(mesh), file: None });
    scene.add_object("mesh", None, mesh);
    scene
}

/// Each ray with some of the spans that are critical for it.
fn with_spans(random: &mut Random, world: &World, rays: &[Ray], most: usize) -> Vec<(Ray, Span)> {
    let mut out = Vec::new();
    for ray in rays {
        let spans = spans_of(world, ray);
        out.push((*ray, Span::FORWARD));
        out.extend((0..most.min(spans.len())).map(|_| (*ray, spans[random.below(spans.len())])));
    }
    out
}

#[test]
fn queries_agree_on_every_span_of_random_scenes() {
    let mut random = Random::new(21);
    let (mut spans, mut points) = (0, 0);
    for case in 0..120 {
        let scene = if case % 3 == 0 { random_scene(&mut random) } else { random_mixed_scene(&mut random) };
        let world = world(&scene, "bvh");
        let rays = rays(&mut random, 12);
        let cast = with_spans(&mut random, &world, &rays, 20);
        check_world(&world, &cast);
        spans += cast.len();
        points += rays.iter().map(|ray| contains_agrees(&world, ray)).sum::<usize>();
    }
    assert!(spans > 15_000 && points > 1_000, "{spans} {points}");
}

#[test]
fn queries_agree_on_every_span_under_every_accelerator() {
    let mut random = Random::new(22);
    for _ in 0..12 {
        let scene = random_mixed_scene(&mut random);
        let world = world(&scene, "bvh");
        let rays = rays(&mut random, 8);
        assert!(check_scene(&scene, &with_spans(&mut random, &world, &rays, 6)));
    }
}

#[test]
fn queries_agree_on_every_span_of_meshes_with_thin_walls() {
    let mut random = Random::new(23);
    let mut spans = 0;
    for _ in 0..150 {
        let thin = Thin::any(&mut random);
        let mesh = thin.mesh(&mut random);
        let world = world(&mesh_scene(mesh.clone()), "bvh");
        let rays = rays_at(&mut random, &mesh, &thin, 12);
        let cast = with_spans(&mut random, &world, &rays, 24);
        check_world(&world, &cast);
        spans += cast.len();
    }
    assert!(spans > 25_000, "{spans}");
}

/// Regression: a wall behind the start of the ray was taken for one that the ray enters, and was cut off before its
/// end.
#[test]
fn a_ray_that_has_left_a_thin_wall_does_not_begin_inside() {
    for wall in [1e-2, 1e-4, 1e-6] {
        let world = world(&mesh_scene(tray(wall)), "bvh");
        let up = Ray::new(Vec3::new(0.43, 0.52, 1.5 * wall), Vec3::Z).expect("a ray");
        check_world(&world, &[(up, Span::FORWARD)]);
        let mut caster = Caster::new(&world);
        assert!(
            caster.any(&up, Span::FORWARD) == Ok(false) && caster.closest(&up, Span::FORWARD) == Ok(None)
        );
        let from_within = Ray::new(Vec3::new(0.43, 0.52, 0.5 * wall), Vec3::Z).expect("a ray");
        assert_eq!(
            caster.closest(&from_within, Span::FORWARD).expect("within limits").map(|hit| hit.kind),
            Some(HitKind::Start)
        );
    }
    // The same far from the origin, where the look-back distance was as long as the coordinates.
    let far = Vec3::splat(1e4);
    let block = cuboid(far + Vec3::new(0.5, -1.0, -1.0), far + Vec3::ONE);
    let world = world(&mesh_scene(block), "bvh");
    let ray = Ray::new(far, Vec3::X).expect("a ray");
    let hit =
        Caster::new(&world).closest(&ray, Span::FORWARD).expect("within limits").expect("a block ahead");
    assert_eq!((hit.t, hit.kind), (0.5, HitKind::Surface));
    let behind = Ray::new(far + Vec3::X * 1.25, Vec3::X).expect("a ray");
    assert_eq!(Caster::new(&world).any(&behind, Span::FORWARD), Ok(false));
}
