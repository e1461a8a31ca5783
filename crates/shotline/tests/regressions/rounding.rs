//! Rays and scenes at the edge of what numbers can tell: near infinity, near tangents, very far and very small.

use shotline::accel;

use super::*;

/// The far crossing of a plane that is parallel to the ray but for rounding had bounds that covered the whole scene,
/// and the ball, which the plane does not touch, vanished.
#[test]
fn a_plane_parallel_to_the_ray_but_for_rounding_swallows_nothing() {
    let turned = Shape::halfspace([-0.499_999_999_999_999_94, 0.866_025_403_784_438_7, 0.0], 0.0).unwrap();
    let half_space = turned.rotate([0.0, 0.0, 330.0]);
    let ball = Shape::sphere(1.0).unwrap();
    let chord = f64::sqrt(1.0 - 0.04 - 0.25);
    let ends = [3.0 - chord, 3.0 + chord];
    // In front of the plane, y = 0, and behind it.
    let (front, back) = ([-3.0, 0.2, 0.5], [-3.0, -0.2, 0.5]);
    let cut = Shape::cuboid([-1.0; 3], [1.0; 3]).unwrap() & &half_space;
    assert_near(&seen(&ball | cut, front, Vec3::X), &ends, 1e-14);
    assert_near(&seen(&ball - &half_space, front, Vec3::X), &ends, 1e-14);
    assert_near(&seen(&ball & &half_space, back, Vec3::X), &ends, 1e-14);
    assert!(seen(&ball & &half_space, front, Vec3::X).is_empty());
    assert!(seen(&ball - &half_space, back, Vec3::X).is_empty());
}

/// The same happened with an endless quadric: a ball minus a drill vanished for rays that run along the drill, beside
/// it.
#[test]
fn a_ray_along_an_endless_drill_sees_the_ball_beside_it() {
    let drill = Shape::quadric([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.09]).unwrap();
    let drilled = Shape::sphere(1.0).unwrap() - drill.rotate([10.0, 20.0, 30.0]);
    let o = [-0.669_336_790_826_247_2, 0.271_951_058_489_849_9, -2.973_303_025_632_044_5];
    let d = [0.378_522_306_369_792_45, 0.018_028_311_236_297_265, 0.925_416_578_398_323_4];
    let half = f64::sqrt(1.0 - 0.36 - 0.0025);
    assert_near(&seen(drilled, o, d), &[3.0 - half, 3.0 + half], 1e-13);
}

/// Layers each thinner than the bounds of their faces were one chain of events, and the stack vanished, though its ends
/// are thousands of bounds apart.
#[test]
fn a_chain_of_thin_layers_does_not_swallow_the_stack() {
    let layer =
        |i: u32| Shape::cuboid([0.0, 0.0, f64::from(i) * 1e-6], [1.0, 1.0, f64::from(i + 1) * 1e-6]).unwrap();
    let world = world_of(Shape::union((0..1000).map(layer)));
    let hits = crossings(&world, &ray([0.3, 0.4, -1e9], Vec3::Z), Span::FORWARD);
    assert_eq!(hits.len(), 2, "{hits:?}");
    let ends = [1e9, 1e9 + 1e-3];
    assert!(hits.iter().zip(ends).all(|(hit, t)| (hit.t - t).abs() <= hit.t_err + 1e-7), "{hits:?}");
}

/// Two thin objects that overlap make one chain, and the segment of one was swallowed.
#[test]
fn thin_objects_that_overlap_keep_their_segments() {
    let layer = |z: f64| Shape::cuboid([0.0, 0.0, z], [1.0, 1.0, z + 4e-6]).unwrap();
    let scene = Scene::of([Object::new("below", layer(0.0)), Object::new("above", layer(2e-6))]);
    let (world, mut segments) = (scene.compile().unwrap(), Vec::new());
    let up = ray([0.3, 0.4, -1e9], Vec3::Z);
    Caster::new(&world).segments(&up, Span::FORWARD, Overlaps::Priority, &mut segments).unwrap();
    assert_eq!(segments.iter().map(|s| s.object).collect::<Vec<_>>(), [0, 1]);
    let [below, above] = [segments[0].length, segments[1].length];
    assert!((below - 2e-6).abs() < 2.3e-6 && (above - 4e-6).abs() < 3e-7, "{below} {above}");
}

/// Both crossings of a near tangent were lost in their bounds, and those of a torus had bounds that were too small.
#[test]
fn near_tangents_of_balls_and_tori_are_within_their_bounds() {
    let e = 0.5f64.powi(40);
    let within = |shape: Shape, y: f64, chords: &[f64]| {
        let hits = crossings(&world_of(shape), &ray([-8.0, y, 0.0], Vec3::X), Span::FORWARD);
        let ends = chords.iter().map(|half| 8.0 - half).chain(chords.iter().rev().map(|half| 8.0 + half));
        let ends: Vec<f64> = ends.collect();
        assert_eq!(hits.len(), ends.len(), "{hits:?}");
        for (hit, end) in hits.iter().zip(ends) {
            assert!((hit.t - end).abs() <= hit.t_err && hit.t_err < 1e-8, "{end}: {hit:?}");
        }
    };
    // Half a chord of a circle of radius r, at a distance of r - e from its middle.
    let half = |r: f64| f64::sqrt(e * (2.0 * r - e));
    within(Shape::sphere(1.0).unwrap(), 1.0 - e, &[half(1.0)]);
    let torus = Shape::torus(2.0, 1.0).unwrap();
    within(torus.clone(), 3.0 - e, &[half(3.0)]);
    let outer = f64::sqrt(9.0 - (1.0 - e) * (1.0 - e));
    within(torus, 1.0 - e, &[outer, half(1.0)]);
}

/// The frame of a solid was inverted by its determinant, which underflows for tiny models: their sectors were lost.
#[test]
fn sectors_of_tiny_models_are_found() {
    let tiny = Shape::tube_sector(0.5, 1.0, 0.0, 1.0, 0.0, 90.0).unwrap().scale(1e-120);
    let list = seen(tiny, [0.0, 0.0, 0.5e-120], [0.6e-120, 0.8e-120, 0.0]);
    assert_near(&list, &[0.5, 1.0], 1e-15);
}

/// The radius of the sphere around a tiny box was 0, since squares underflow, and the box was not met.
#[test]
fn spheres_around_tiny_boxes_hold_them() {
    let ball = Shape::sphere(1e-170).unwrap();
    let row = Shape::group((0..4).map(|i| ball.translate([f64::from(i) * 3e-170, 0.0, 0.0])));
    for name in accel::NAMES {
        let list = seen(row.with_accel(name), [-2e-170, 0.0, 0.0], Vec3::X * 1e-170);
        assert_near(&list, &[1.0, 3.0, 4.0, 6.0, 7.0, 9.0, 10.0, 12.0], 1e-14);
    }
}

/// A transform of condition 5e13 was accepted, and crossings vanished between their bounds.
#[test]
fn transforms_that_leave_no_digits_are_refused() {
    let stretched = |z: f64| scene_of(Shape::sphere(1.0).unwrap().scale_axes([1.0, 1.0, z])).compile();
    let said = stretched(5e13).unwrap_err().to_string();
    assert!(said.contains("condition"), "{said}");
    let world = stretched(5e11).unwrap();
    let up = ray([0.0, 0.0, -1e12], Vec3::Z * 5e11);
    let list: Vec<f64> = crossings(&world, &up, Span::FORWARD).iter().map(|hit| hit.t).collect();
    assert_near(&list, &[1.0, 3.0], 1e-14);
}
