//! Every ray ends, none fills the memory, and any can be cancelled.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::*;
use crate::accel;
use crate::query::batch::BatchError;
use crate::query::{Limits, QueryError, Scope, Watch};
use crate::scene::NodeId;

/// A node placed 2^40 times: each group contains the previous one twice, the second time moved.
fn doubled(part: impl Fn(&mut Scene) -> NodeId, moved: impl Fn(i32) -> Vec3) -> Scene {
    let mut scene = Scene::default();
    let mut node = part(&mut scene);
    for i in 0..40 {
        let second = scene.add_transform(Affine::translation(moved(i)), node);
        node = scene.add(Node::Group { members: vec![node, second] });
    }
    scene.add_object("all", None, node);
    scene
}

fn ball(scene: &mut Scene) -> NodeId {
    scene.add_solid("sphere", &[&[1.0]]).expect("a sphere")
}

fn across(y: f64) -> Ray {
    Ray::new(Vec3::new(-5.0, y, 0.2), Vec3::X).expect("a ray")
}

const FEW: Limits = Limits { steps: 20_000, crossings: 1000 };
const TOO_LONG: QueryError = QueryError::TooLong { most: FEW.steps };
const TOO_MANY: QueryError = QueryError::TooMany { most: FEW.crossings };

/// Coincident spheres, almost coincident ones, and spheres in a row along the ray. Every query ends, and its memory
/// grows with the depth of the groups, not with the number of hits.
#[test]
fn a_ray_through_a_million_million_spheres_ends() {
    let places: [fn(i32) -> Vec3; 3] =
        [|_| Vec3::ZERO, |i| Vec3::Y * (1e-9 * f64::from(i)), |i| Vec3::X * (3.0 * f64::from(i).exp2())];
    for (case, place) in places.into_iter().enumerate() {
        let scene = doubled(ball, place);
        for name in accel::NAMES {
            let world = world(&scene, name);
            let mut caster = Caster::new(&world);
            caster.limit(FEW);
            let (ray, span, context) = (across(0.1), Span::FORWARD, format!("case {case}, {name}"));
            let in_a_row = case == 2;
            let closest = caster.closest(&ray, span).map(|hit| hit.map(|hit| hit.path));
            assert_eq!(closest, if in_a_row { Ok(Some(0)) } else { Err(TOO_LONG) }, "{context}");
            assert_eq!(caster.any(&ray, span), Ok(true), "{context}");
            assert_eq!(caster.any(&across(50.0), span), Ok(false), "{context}");
            assert_eq!(caster.count(&ray, span), Err(TOO_LONG), "{context}");
            let mut hits = Vec::new();
            assert_eq!(caster.crossings(&ray, span, &mut hits), Err(TOO_MANY), "{context}");
            assert!(hits.is_empty());
            for overlaps in [Overlaps::Error, Overlaps::Priority, Overlaps::All] {
                let segments = caster.segments(&ray, span, overlaps, &mut Vec::new());
                assert_eq!(segments, Err(TOO_MANY), "{context}");
            }
            let contains = caster.contains(Vec3::new(0.1, 0.2, 0.3), &mut Vec::new());
            assert_eq!(contains, if in_a_row { Ok(()) } else { Err(TOO_LONG) }, "{context}");
            let kept = caster.traversal.kept_visits();
            assert!(kept < 200, "{context}: {kept} visits");
        }
    }
}

/// The ray hits every box and no sphere, so that no hit bounds the search.
#[test]
fn a_ray_past_a_million_million_spheres_ends() {
    let world = world(&doubled(ball, |_| Vec3::ZERO), "bvh");
    let mut caster = Caster::new(&world);
    caster.limit(FEW);
    let ray = Ray::new(Vec3::new(-5.0, 0.9, 0.9), Vec3::X).expect("a ray");
    assert_eq!(caster.any(&ray, Span::FORWARD), Err(TOO_LONG));
    assert_eq!(caster.any(&ray, Scope::surfaces(Span::FORWARD)), Err(TOO_LONG));
    assert_eq!(caster.any_with_hint(&mut CoherenceHint::default(), &ray, Span::FORWARD), Err(TOO_LONG));
    assert_eq!(caster.closest(&ray, Span::FORWARD), Err(TOO_LONG));
    assert_eq!(caster.count(&ray, Span::FORWARD), Err(TOO_LONG));
}

#[test]
fn a_ray_through_a_million_million_sheets_ends() {
    let sheet = |scene: &mut Scene| {
        let vertices = [(-1.0, 0.0), (1.0, -2.0), (1.0, 2.0)].map(|(y, z)| Vec3::new(0.0, y, z)).to_vec();
        scene.add(Node::Mesh { mesh: Arc::new(TriangleMesh::new(vertices, vec![[0, 1, 2]])), file: None })
    };
    let world = world(&doubled(sheet, |_| Vec3::ZERO), "bvh");
    let mut caster = Caster::new(&world);
    caster.limit(FEW);
    assert_eq!(caster.closest(&across(0.1), Span::FORWARD).map(|hit| hit.map(|hit| hit.t)), Err(TOO_LONG));
    assert_eq!(caster.count(&across(0.1), Span::FORWARD), Err(TOO_LONG));
    assert_eq!(caster.any(&across(0.1), Span::FORWARD), Ok(true));
}

/// After an error the caster returns the same as a new one.
#[test]
fn a_ray_that_was_given_up_leaves_nothing_behind() {
    let mut scene = doubled(ball, |_| Vec3::ZERO);
    let far = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
    let far = scene.add_transform(Affine::translation(Vec3::Y * 9.0), far);
    scene.add_object("far", None, far);
    for name in accel::NAMES {
        let world = world(&scene, name);
        let mut caster = Caster::new(&world);
        caster.limit(FEW);
        for y in [9.0, 8.5] {
            assert!(caster.count(&across(0.1), Span::FORWARD).is_err());
            let mut hits = Vec::new();
            caster.crossings(&across(y), Span::FORWARD, &mut hits).expect("a sphere");
            assert_same(&hits, &crossings(&world, &across(y), Span::FORWARD), name);
            assert_eq!(hits.len(), 2);
        }
    }
}

#[test]
fn the_ray_beyond_its_limits_is_named() {
    let world = world(&doubled(ball, |_| Vec3::ZERO), "bvh");
    let rays = [across(50.0), across(50.0), across(0.1)];
    let error =
        batch::crossings(&world, &rays, Span::FORWARD, Run::default()).map(drop).expect_err("too many");
    let most = Limits::default().crossings;
    assert_eq!(error, BatchError::Query { row: 2, error: QueryError::TooMany { most } });
    assert!(
        error.to_string().starts_with("ray 2: ") && error.to_string().contains(&most.to_string()),
        "{error}"
    );
}

/// The cancel flag is checked within a ray, and the progress callback is called.
#[test]
fn one_ray_can_be_cancelled() {
    let scene = doubled(ball, |_| Vec3::ZERO);
    let world = world(&scene, "bvh");
    let (cancel, looks) = (AtomicBool::new(false), AtomicU64::new(0));
    let progress = |rows: u64| {
        assert_eq!(rows, 0);
        cancel.store(looks.fetch_add(1, Ordering::Relaxed) >= 3, Ordering::Relaxed);
    };
    let watch = Watch { cancel: Some(&cancel), progress: Some(&progress) };
    let mut caster = Caster::new(&world);
    caster.watch(watch);
    caster.limit(Limits { steps: u64::MAX, crossings: usize::MAX });
    let (ray, span) = (across(0.1), Span::FORWARD);
    let past = Ray::new(Vec3::new(-5.0, 0.9, 0.9), Vec3::X).expect("a ray");
    type Ask<'a> = &'a dyn Fn(&mut Caster) -> Result<(), QueryError>;
    let ask: [Ask; 7] = [
        &|caster| caster.closest(&ray, span).map(drop),
        &|caster| caster.any(&past, span).map(drop),
        &|caster| caster.count(&ray, span).map(drop),
        &|caster| caster.crossings(&ray, span, &mut Vec::new()),
        &|caster| caster.segments(&ray, span, Overlaps::Error, &mut Vec::new()).map(drop),
        &|caster| caster.object_intervals(0, &ray, span, &mut Vec::new()).map(drop),
        &|caster| caster.contains(Vec3::new(0.1, 0.2, 0.3), &mut Vec::new()),
    ];
    for (i, ask) in ask.iter().enumerate() {
        looks.store(0, Ordering::Relaxed);
        assert_eq!(ask(&mut caster), Err(QueryError::Cancelled), "query {i}");
        assert_eq!(looks.load(Ordering::Relaxed), 4, "query {i}");
    }
    let run = Run { cancel: Some(&cancel), progress: Some(&progress), ..Run::default() };
    looks.store(0, Ordering::Relaxed);
    cancel.store(false, Ordering::Relaxed);
    assert_eq!(batch::count(&world, &[ray], span, run), Err(BatchError::Cancelled));
}

/// A level of many placements that is visited many times only uses memory for the placements that are hit.
#[test]
fn tags_of_a_visit_do_not_cost_the_size_of_its_level() {
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[0.4]]).expect("a sphere");
    let place = |i: i32| Affine::translation(Vec3::new(f64::from(i % 100), f64::from(i / 100), 0.0));
    let members = (0..10_000).map(|i| scene.add_transform(place(i), ball)).collect();
    let layer = scene.add(Node::Group { members });
    let layers = (0..200).map(|i| scene.add_transform(Affine::translation(Vec3::Z * f64::from(i)), layer));
    let layers = layers.collect();
    let all = scene.add(Node::Group { members: layers });
    scene.add_object("layers", None, all);
    let world = world(&scene, "grid");
    let mut caster = Caster::new(&world);
    let up = Ray::new(Vec3::new(50.1, 50.1, -5.0), Vec3::Z).expect("a ray");
    assert_eq!(caster.count(&up, Span::FORWARD), Ok(400));
    let kept = caster.traversal.kept_tags();
    assert!(kept <= 4096, "{kept} tags");
}
