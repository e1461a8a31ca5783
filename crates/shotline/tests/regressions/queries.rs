//! Queries: rays without an end, answers of several paths, the ends of spans, and what a point costs.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use shotline::query::{Limits, QueryError, Scope, Watch};

use super::*;

/// A ball placed 2^40 times in one place: each group holds the one before twice.
fn two_to_the_forty_balls() -> World {
    let ball = Shape::sphere(1.0).unwrap();
    world_of((0..40).fold(ball, |part, _| Shape::group([part.clone(), part])))
}

/// `count` and `closest` had no end, and memory grew with every ball that was met until the process was killed.
#[test]
fn one_ray_through_2_to_the_40_spheres_has_an_end() {
    let world = two_to_the_forty_balls();
    let mut caster = Caster::new(&world);
    let limits = Limits { steps: 20_000, crossings: 1000 };
    caster.limit(limits);
    let (across, span) = (ray([-5.0, 0.1, 0.2], Vec3::X), Span::FORWARD);
    let too_long = QueryError::TooLong { most: limits.steps };
    let too_many = QueryError::TooMany { most: limits.crossings };
    assert_eq!(caster.any(&across, span), Ok(true));
    assert_eq!(caster.count(&across, span), Err(too_long.clone()));
    assert_eq!(caster.closest(&across, span), Err(too_long));
    assert_eq!(caster.crossings(&across, span, &mut Vec::new()), Err(too_many.clone()));
    assert_eq!(caster.segments(&across, span, Overlaps::All, &mut Vec::new()), Err(too_many));
}

/// The cancel flag was read between rays only, so that nothing ended a single one.
#[test]
fn one_ray_through_2_to_the_40_spheres_can_be_cancelled() {
    let world = two_to_the_forty_balls();
    let (cancel, looks) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |_| cancel.store(looks.fetch_add(1, Ordering::Relaxed) >= 3, Ordering::Relaxed);
    let mut caster = Caster::new(&world);
    caster.watch(Watch { cancel: Some(&cancel), progress: Some(&progress) });
    let across = ray([-5.0, 0.1, 0.2], Vec3::X);
    assert_eq!(caster.count(&across, Span::FORWARD), Err(QueryError::Cancelled));
    looks.store(0, Ordering::Relaxed);
    let crossings = caster.crossings(&across, Span::FORWARD, &mut Vec::new());
    assert_eq!(crossings, Err(QueryError::Cancelled));
}

/// A walk returned nothing both when it was done and when it was out of steps: a ray that needed its last step was an
/// error or had a short list.
#[test]
fn a_ray_with_few_steps_has_its_whole_list_or_an_error() {
    let ball = Shape::sphere(1.0).unwrap();
    let world = world_of(Shape::group((0..12).map(|i| ball.translate([3.0 * f64::from(i), 0.0, 0.0]))));
    let (along, span) = (ray([-5.0, 0.0, 0.0], Vec3::X), Span::FORWARD);
    let mut caster = Caster::new(&world);
    let mut answered = [0; 3];
    for steps in 0..100 {
        caster.limit(Limits { steps, ..Limits::default() });
        let mut segments = Vec::new();
        let answers = [
            caster.count(&along, span),
            caster.closest(&along, span).map(|hit| u64::from(hit.is_some_and(|hit| hit.t == 4.0))),
            caster.segments(&along, span, Overlaps::Error, &mut segments).map(|_| segments.len() as u64),
        ];
        for (i, (answer, right)) in answers.into_iter().zip([24, 1, 12]).enumerate() {
            let expected = if answered[i] > 0 { Ok(right) } else { Err(QueryError::TooLong { most: steps }) };
            assert!(answer == expected || answer == Ok(right), "query {i} with {steps} steps: {answer:?}");
            answered[i] += u32::from(answer.is_ok());
        }
    }
    assert!(answered.iter().all(|&times| (1..100).contains(&times)), "{answered:?}");
}

/// A combination of empty groups had a path and no leaves, and asking for the name of a surface behind it was a panic.
#[test]
fn combinations_of_empty_groups_are_not_placed() {
    let nothing = Shape::union([Shape::group([])]);
    let scene =
        Scene::of([Object::new("ball", Shape::sphere(1.0).unwrap()), Object::new("nothing", nothing)]);
    let world = scene.compile().unwrap();
    assert_eq!((world.path_count(), world.surface_name(0)), (1, "sphere".into()));
    assert!([1, 2, u32::MAX].iter().all(|&surface| world.surface_name(surface).is_empty()));
}

/// Parts of several paths of one object that abut were one segment, which had the path of its first part, and later none.
#[test]
fn a_segment_has_one_path() {
    let cell = Shape::cuboid([0.0; 3], [1.0; 3]).unwrap();
    let world = world_of(Shape::group([0.0, 1.0, 3.0].map(|x| cell.translate([x, 0.0, 0.0]))));
    let mut segments = Vec::new();
    let along = ray([-1.0, 0.5, 0.5], Vec3::X);
    Caster::new(&world).segments(&along, Span::FORWARD, Overlaps::Error, &mut segments).unwrap();
    let found: Vec<_> = segments.iter().map(|s| (s.t_in, s.t_out, s.path)).collect();
    assert_eq!(found, [(1.0, 2.0, 0), (2.0, 3.0, 1), (4.0, 5.0, 2)]);
}

/// `contains` asked every operand: 137 microseconds a point for a box with 10,000 holes.
#[test]
fn a_point_asks_only_operands_whose_boxes_hold_it() {
    let hole = Shape::sphere(0.25).unwrap();
    let place = |i: u32| [0.5 + f64::from(i % 50), 0.5 + f64::from(i / 50), 0.5];
    let block = Shape::cuboid([0.0; 3], [50.0, 50.0, 1.0]).unwrap();
    let world = world_of(block.difference((0..2500).map(|i| hole.translate(place(i)))));
    let mut caster = Caster::new(&world);
    for (p, inside) in [([10.5, 7.5, 0.5], false), ([10.0, 7.0, 0.5], true), ([10.5, 7.5, 1.5], false)] {
        let mut objects = Vec::new();
        caster.contains(p.into(), &mut objects).unwrap();
        assert_eq!(!objects.is_empty(), inside, "{p:?}");
        let tests = caster.take_counters().primitive_tests;
        assert!(tests <= 3, "{tests} operands asked");
    }
}

/// Ownership took the square of nested objects: a minute a ray for 10^5 of them.
#[test]
fn nested_objects_have_a_segment_on_each_side_of_the_next() {
    let n = 2000;
    let ball = |i: i32| Object::new(format!("{i}"), Shape::sphere(f64::from(n - i)).unwrap()).priority(i);
    let world = Scene::of((0..n).map(ball)).compile().unwrap();
    let (mut segments, far) = (Vec::new(), f64::from(n + 1));
    let along = ray([-far, 0.0, 0.0], Vec3::X);
    Caster::new(&world).segments(&along, Span::FORWARD, Overlaps::Priority, &mut segments).unwrap();
    assert_eq!(segments.len(), 2 * n as usize - 1);
    for (i, segment) in segments.iter().enumerate() {
        let nested = i.min(2 * n as usize - 2 - i);
        let length = if nested == n as usize - 1 { 2.0 } else { 1.0 };
        assert_eq!((segment.object as usize, segment.length), (nested, length));
    }
}

/// A ray from inside of a room met the start of the room at t = 0, and there was no way to ask for its walls.
#[test]
fn from_inside_a_room_its_walls_can_be_asked_for() {
    let world = world_of(Shape::cuboid([-1.0; 3], [1.0; 3]).unwrap());
    let (mut caster, out) = (Caster::new(&world), ray(Vec3::ZERO, Vec3::X));
    let walls = Scope::surfaces(Span::FORWARD);
    assert_eq!(caster.closest(&out, walls).unwrap().map(|hit| (hit.t, hit.entering)), Some((1.0, false)));
    assert_eq!(caster.any(&out, Scope::surfaces(Span::new(0.0, 0.1).unwrap())), Ok(false));
    assert_eq!(caster.count(&out, walls), Ok(1));
    assert_eq!(caster.closest(&out, Span::FORWARD).unwrap().map(|hit| hit.t), Some(0.0));
}

/// A ball that begins exactly at `t_max` was listed as a pair without a length, which `segments` did not have.
#[test]
fn nothing_begins_where_the_span_ends() {
    let world = world_of(Shape::sphere(1.0).unwrap());
    let along = ray([-5.0, 0.0, 0.0], Vec3::X);
    let up_to = |t_max: f64| {
        let hits = crossings(&world, &along, Span::new(0.0, t_max).unwrap());
        hits.iter().map(|hit| hit.t).collect::<Vec<_>>()
    };
    assert!(up_to(4.0).is_empty());
    assert_eq!(up_to(4.5), [4.0, 4.5]);
    assert_eq!(up_to(6.0), [4.0, 6.0]);
}

/// A ray that begins on a face and goes in had t = -0.0.
#[test]
fn no_crossing_is_at_minus_zero() {
    let world = world_of(Shape::cuboid([0.0; 3], [1.0; 3]).unwrap());
    for (x, d) in [(0.0, 1.0), (-0.0, 1.0), (1.0, -1.0)] {
        for t_min in [0.0, -0.0] {
            let span = Span::new(t_min, f64::INFINITY).unwrap();
            let hits = crossings(&world, &ray([x, 0.5, 0.5], [d, -0.0, 0.0]), span);
            assert_eq!(hits.len(), 2, "from {x}");
            assert!(hits[0].t == 0.0 && hits[0].t.is_sign_positive(), "from {x}: {hits:?}");
        }
    }
}

/// Copies of one part that are placed over each other 2^22 times were all built before the scene was refused.
#[test]
fn a_combination_of_too_many_leaves_is_counted_and_refused() {
    let ball = Shape::sphere(1.0).unwrap();
    let bomb = (0..100).fold(ball, |part, _| Shape::union([part.clone(), part]));
    let said = scene_of(bomb).compile().unwrap_err();
    assert_eq!(said.errors.len(), 1, "{said}");
    assert!(said.to_string().contains("a combination of 4194304 leaves"), "{said}");
}

/// An open mesh in a combination was reported once for each combination above it.
#[test]
fn what_is_wrong_with_an_operand_is_reported_once() {
    let sheet = Shape::mesh([Vec3::ZERO, Vec3::X, Vec3::Y], [[0, 1, 2]]).unwrap();
    let ball = Shape::sphere(1.0).unwrap();
    let nested = (0..5).fold(sheet | ball, |part, _| Shape::union([part]));
    let errors = scene_of(nested).compile().unwrap_err().errors;
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].message.contains("3 open edges"), "{errors:?}");
}

/// The crossing of one event with the box of a body may lie before that box, by rounding. `closest` missed it if another
/// body had a crossing between the two.
#[test]
fn closest_finds_a_crossing_before_the_box_of_its_body() {
    let from = |x: f64| Shape::cuboid([x, -1.0, -1.0], [1.0; 3]).unwrap();
    let both = Shape::intersection([from(3.0 * f64::EPSILON), from(8.0 * f64::EPSILON)]);
    let before = Shape::cuboid([-1.0; 3], [5.0 * f64::EPSILON, 1.0, 1.0]).unwrap();
    let objects = [Object::new("both", both), Object::new("before", before)];
    let world = Scene::of(objects).compile().unwrap();
    let (mut caster, scope) = (Caster::new(&world), Scope::surfaces(Span::FORWARD));
    for (x, length) in [(0.5, 1.0), (0.5, 0.194), (0.5, 3.0), (0.75, 2.0)] {
        let (ray, mut all) = (ray([-x, -0.5, 0.0], [length, 0.0, 0.0]), Vec::new());
        caster.crossings(&ray, scope, &mut all).unwrap();
        assert_eq!(caster.closest(&ray, scope).unwrap(), Some(all[0]));
        assert_eq!((all[0].object, all[0].t), (0, (x + 3.0 * f64::EPSILON) / length));
    }
}
