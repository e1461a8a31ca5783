//! Queries for surfaces only, and crossings at the ends of a span.

use super::structures::crowded_scene;
use super::*;
use crate::accel;
use crate::query::{Kinds, Scope};
use crate::testkit::scene::random_scene;

fn scope(span: Span) -> Scope {
    Scope::surfaces(span)
}

/// Compares queries for surfaces to the crossings without those of kind `start` and `end`: the list, its first
/// element, whether there is any, and the count.
fn assert_surfaces_are_those_of_the_list(
    world: &World,
    hints: &mut [CoherenceHint; 2],
    ray: &Ray,
    span: Span,
    of: &str,
) {
    let mut caster = Caster::new(world);
    let mut expected = crossings(world, ray, span);
    expected.retain(|hit| hit.kind == HitKind::Surface);
    let mut list = Vec::new();
    caster.crossings(ray, scope(span), &mut list).expect("within limits");
    assert_same(&list, &expected, of);
    let first = &expected[..expected.len().min(1)];
    let closest = caster.closest(ray, scope(span)).expect("within limits");
    assert_same(closest.as_slice(), first, of);
    let hinted = caster.closest_with_hint(&mut hints[0], ray, scope(span)).expect("within limits");
    assert_same(hinted.as_slice(), first, of);
    assert_eq!(caster.any(ray, scope(span)), Ok(!expected.is_empty()), "{of}");
    assert_eq!(caster.any_with_hint(&mut hints[1], ray, scope(span)), Ok(!expected.is_empty()), "{of}");
    assert_eq!(caster.count(ray, scope(span)), Ok(expected.len() as u64), "{of}");
}

/// For any scene, span and accelerator. The scenes contain closed and open meshes, combinations and unbounded solids,
/// and many rays begin and end inside.
#[test]
fn surfaces_only_leaves_out_what_is_no_surface() {
    let mut random = Random::new(51);
    let spans = [(0.0, f64::INFINITY), (0.0, 0.7), (0.5, 1.25), (1.0, 1.0), (-3.0, 0.4)];
    let spans = spans.map(|(from, to)| Span::new(from, to).expect("an interval"));
    let mut begun_inside = 0;
    for case in 0..12 {
        let scene = if case % 4 == 0 { crowded_scene(&mut random) } else { random_scene(&mut random) };
        let rays = rays(&mut random, 40);
        for name in accel::NAMES {
            let world = world(&scene, name);
            let mut hints = [CoherenceHint::default(), CoherenceHint::default()];
            for (i, ray) in rays.iter().enumerate() {
                let span = spans[i % spans.len()];
                begun_inside +=
                    usize::from(crossings(&world, ray, span).iter().any(|h| h.kind == HitKind::Start));
                let of = format!("scene {case}, {name}, {ray:?}, {span:?}");
                assert_surfaces_are_those_of_the_list(&world, &mut hints, ray, span, &of);
            }
        }
    }
    assert!(begun_inside > 300, "{begun_inside}");
}

/// From the middle of a room, a lidar sees the wall.
#[test]
fn from_inside_a_box_only_its_wall_is_a_surface() {
    let mut scene = Scene::default();
    let room = scene.add_solid("box", &[&[-1.0; 3], &[1.0; 3]]).expect("a box");
    scene.add_object("room", None, room);
    let world = world(&scene, "bvh");
    let mut caster = Caster::new(&world);
    let ray = Ray::new(Vec3::ZERO, Vec3::X).expect("a ray");
    let near = Span::new(0.0, 0.1).expect("an interval");
    let closest =
        |caster: &mut Caster, scope: Scope| caster.closest(&ray, scope).expect("within limits").map(|h| h.t);
    assert_eq!(closest(&mut caster, Span::FORWARD.into()), Some(0.0));
    assert_eq!(closest(&mut caster, scope(Span::FORWARD)), Some(1.0));
    assert_eq!((caster.any(&ray, near), caster.any(&ray, scope(near))), (Ok(true), Ok(false)));
    assert_eq!(caster.count(&ray, Span::FORWARD), Ok(2));
    assert_eq!(caster.count(&ray, scope(Span::FORWARD)), Ok(1));
    let rows = batch::crossings(&world, &[ray], scope(Span::FORWARD), Run::default()).expect("rows");
    assert_eq!((rows.ray_splits, rows.t, rows.entering), (vec![0, 1], vec![1.0], vec![false]));
    assert_eq!(Kinds::default(), Kinds::All);
}

/// An interval that begins where the span ends has no length in it; one that ends there does.
#[test]
fn nothing_begins_where_the_span_ends() {
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
    scene.add_object("ball", None, ball);
    let world = world(&scene, "bvh");
    let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).expect("a ray");
    for (t_max, expected) in
        [(4.0, vec![]), (6.0, vec![4.0, 6.0]), (4.0f64.next_up(), vec![4.0, 4.0f64.next_up()])]
    {
        let span = Span::new(0.0, t_max).expect("an interval");
        let list: Vec<f64> = crossings(&world, &ray, span).iter().map(|h| h.t).collect();
        assert_eq!(list, expected);
        let closest = Caster::new(&world).closest(&ray, span).expect("within limits");
        assert_eq!(closest.map(|h| h.t), expected.first().copied());
        assert_eq!(Caster::new(&world).any(&ray, span), Ok(!expected.is_empty()));
    }
}

/// Of two bodies that begin at the same `t`, the one with the lower path is the closest, whichever is tested first.
#[test]
fn bodies_that_begin_together_are_told_apart_by_their_paths() {
    let mut scene = Scene::default();
    let corner = |x: f64, y: f64| [x, y, y];
    for y in [3.0, 2.0, 1.0] {
        let block = scene.add_solid("box", &[&corner(0.0, -y), &corner(y, y)]).expect("a box");
        scene.add_object("block", None, block);
    }
    for name in accel::NAMES {
        let world = world(&scene, name);
        let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X).expect("a ray");
        let closest =
            Caster::new(&world).closest(&ray, Span::FORWARD).expect("within limits").expect("a block");
        assert_eq!((closest.t, closest.path), (1.0, 0), "{name}");
    }
}

/// From a face into a solid, and with negative zeros.
#[test]
fn no_crossing_is_at_minus_zero() {
    let mut scene = Scene::default();
    let block = scene.add_solid("box", &[&[0.0; 3], &[1.0; 3]]).expect("a box");
    scene.add_object("block", None, block);
    let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
    scene.add_object("ball", None, ball);
    let world = world(&scene, "bvh");
    let origins = [
        (0.0, 0.5, 0.5),
        (-0.0, 0.5, 0.5),
        (1.0, 0.5, 0.5),
        (-1.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (0.1, 0.2, 0.2),
    ];
    for (x, y, z) in origins {
        for d in [Vec3::X, -Vec3::X, Vec3::new(1.0, -0.0, 0.0)] {
            for t_min in [0.0, -0.0] {
                let ray = Ray::new(Vec3::new(x, y, z), d).expect("a ray");
                let span = Span::new(t_min, f64::INFINITY).expect("an interval");
                let list = crossings(&world, &ray, span);
                assert!(list.iter().all(|h| h.t.is_sign_positive()), "{ray:?} {list:?}");
                let mut segments = Vec::new();
                let met = Caster::new(&world).segments(&ray, span, Overlaps::All, &mut segments);
                assert!(
                    met.is_ok() && segments.iter().all(|s| s.t_in.is_sign_positive()),
                    "{ray:?} {segments:?}"
                );
            }
        }
    }
}
