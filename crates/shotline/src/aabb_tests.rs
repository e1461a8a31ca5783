//! Boxes and the lines that are tested against them.

use crate::aabb::*;
use crate::math::{Vec3, length};
use crate::ray::{Line, Span};
use proptest::prelude::*;

fn enter_exit(o: [f64; 3], d: [f64; 3], b: &Aabb) -> Option<(f64, f64)> {
    BoxRay::new(&Line::exact(o.into(), d.into()), Span::FORWARD).enter_exit(b)
}

const UNIT: Aabb = Aabb::new(Vec3::ZERO, Vec3::ONE);

#[test]
fn parallel_rays_in_outside_and_on_a_face() {
    assert!(enter_exit([0.5, 0.5, -1.0], [0.0, -0.0, 1.0], &UNIT).is_some());
    assert!(enter_exit([1.5, 0.5, -1.0], [0.0, 0.0, 1.0], &UNIT).is_none());
    assert!(enter_exit([1.5, 0.5, -1.0], [-0.0, 0.0, 1.0], &UNIT).is_none());
    assert!(enter_exit([1.0, 0.0, -1.0], [0.0, 0.0, 1.0], &UNIT).is_some());
}

#[test]
fn unbounded_and_empty_boxes() {
    assert_eq!(enter_exit([0.0; 3], [1.0, 0.0, 0.0], &Aabb::EVERYTHING), Some((0.0, f64::INFINITY)));
    assert_eq!(enter_exit([0.0; 3], [1.0, 1.0, 0.0], &Aabb::EMPTY), None);
}

proptest! {
    /// The interval contains the `t` of a point of the box at which the line is aimed, however flat the box is.
    #[test]
    fn the_interval_holds_every_point_of_the_box(
        o in prop::array::uniform3(-1e3..1e3f64),
        a in prop::array::uniform3(-1.0..1.0f64),
        flat in 0..4usize,
        w in prop::array::uniform3(0.0..1.0f64),
    ) {
        let (o, a) = (Vec3::from(o), Vec3::from(a));
        let mut size = Vec3::new(0.5, 0.25, 1.0);
        if flat < 3 { size[flat] = 0.0; }
        let b = Aabb::new(a, a + size);
        let p = a + size * Vec3::from(w);
        // `o + d` may differ from `p` by rounding, so the box is extended to contain it.
        let d = p - o;
        let near = b.union(&Aabb::new(o + d, o + d));
        let (enter, exit) = BoxRay::new(&Line::exact(o, d), Span::FORWARD).enter_exit(&near).unwrap();
        prop_assert!(enter <= 1.0 && 1.0 <= exit);
    }

    #[test]
    fn transformed_boxes_hold_transformed_points(
        t in crate::math::tests_support::affine_strategy(),
        w in prop::array::uniform3(0.0..1.0f64),
    ) {
        let p = Vec3::from(w);
        prop_assert!(UNIT.transformed(&t).contains(t.point(p)));
        let (c, r) = UNIT.transformed(&t).bounding_sphere();
        prop_assert!((t.point(p) - c).length() <= r);
    }
}

/// Also where the squares of the size and of the reciprocal direction have a product that underflows.
#[test]
fn a_sphere_is_met_where_a_box_in_it_is() {
    let (mut random, mut met) = (crate::testkit::random::Random::new(6), 0);
    for i in 0..6000 {
        let (size, stretch) = ([1e-120, 1e-91, 1.0, 1e60][i % 4], [1e-130, 1.0, 1e91][i / 4 % 3]);
        let a = random.point(-1.0, 1.0);
        let b = Aabb::new(a * size, (a + random.point(0.0, 0.5)) * size);
        let (o, aim) = (random.point(-3.0, 3.0), a + random.point(-0.2, 0.7));
        let ray = BoxRay::new(&Line::exact(o * size, (aim - o) * stretch), Span::FORWARD);
        let Some((enter, _)) = ray.enter_exit(&b) else { continue };
        let (centre, radius) = b.bounding_sphere();
        assert!(SphereRay::new(&ray).enter(centre, radius).is_some_and(|t| t <= enter), "{ray:?} {b:?}");
        met += 1;
    }
    assert!(met > 500, "{met}");
}

#[test]
fn tiny_boxes_have_a_sphere_around_them() {
    for size in [1e-200, 1e-310, 1e160] {
        let (c, r) = Aabb::new(Vec3::ZERO, Vec3::splat(size)).bounding_sphere();
        assert!(r >= 0.86 * size && length(c) <= r, "{c} {r}");
    }
}
