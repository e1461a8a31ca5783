//! Every error of a scene is reported once, at its node.

use std::sync::Arc;

use super::{Options, SceneError, compile};
use crate::math::{Affine, Vec3};
use crate::scene::{Node, NodeId, Op, Scene};
use crate::solid::mesh::TriangleMesh;

fn errors(scene: &Scene) -> Vec<SceneError> {
    compile(scene, Options::default()).expect_err("something is wrong")
}

/// The message of the only error.
fn only_error(scene: &Scene) -> String {
    let errors = errors(scene);
    assert_eq!(errors.len(), 1, "{errors:?}");
    errors[0].to_string()
}

fn sphere(scene: &mut Scene, radius: f64) -> NodeId {
    scene.add_solid("sphere", &[&[radius]]).expect("sphere")
}

#[test]
fn cycles_are_named() {
    let mut scene = Scene::default();
    let a = scene.add_csg(Op::Union, vec![NodeId(1)]);
    let b = scene.add_csg(Op::Union, vec![a]);
    scene.defs = vec![("a".into(), a), ("b".into(), b)];
    scene.add_object("thing", None, a);
    assert_eq!(only_error(&scene), "a part contains itself: 'a' -> 'b' -> 'a'");
}

#[test]
fn all_errors_are_reported() {
    let mut scene = Scene::default();
    let bad = sphere(&mut scene, -1.0);
    let worse = sphere(&mut scene, f64::NAN);
    let flat = scene.add_transform(Affine::scaling(Vec3::new(1.0, 1.0, 0.0)), bad);
    let empty = scene.add_csg(Op::Difference, vec![]);
    for node in [bad, worse, flat, empty] {
        scene.add_object("thing", Some("unobtainium"), node);
    }
    let text = errors(&scene).iter().map(|e| format!("{e}\n")).collect::<String>();
    for part in ["radius is -1", "radius is NaN", "singular", "at least one operand", "'unobtainium'"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
}

#[test]
fn a_node_that_is_not_there_is_an_error() {
    let mut scene = Scene::default();
    let group = scene.add(Node::Group { members: vec![NodeId(99)] });
    scene.add_object("thing", None, group);
    assert_eq!(only_error(&scene), "there is no node number 99");
}

#[test]
fn objects_and_open_meshes_are_not_operands_and_are_reported_once() {
    let mut scene = Scene::default();
    let ball = sphere(&mut scene, 1.0);
    let inner = scene.add(Node::Object {
        name: "inner".into(),
        material: None,
        priority: 0,
        node: ball,
        contents: Vec::new(),
        clip: false,
    });
    let triangle = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]);
    let sheet = scene.add(Node::Mesh { mesh: Arc::new(triangle), file: None });
    let mut node = scene.add_csg(Op::Union, vec![ball, inner, sheet]);
    for _ in 0..5 {
        node = scene.add_csg(Op::Union, vec![node]);
    }
    scene.add_object("outer", None, node);
    let errors = errors(&scene);
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors[1].message.contains("3 open edges"), "{errors:?}");
}

#[test]
fn a_bomb_of_references_is_counted_not_built() {
    let mut scene = Scene::default();
    let mut node = sphere(&mut scene, 1.0);
    for _ in 0..100 {
        node = scene.add_csg(Op::Union, vec![node, node]);
    }
    scene.add_object("bomb", None, node);
    assert!(only_error(&scene).starts_with("a combination of 4194304 leaves"));
    let mut node = sphere(&mut scene, 1.0);
    for _ in 0..64 {
        node = scene.add(Node::Group { members: vec![node, node] });
    }
    let mut scene = Scene { objects: vec![], ..scene };
    scene.add_object("bomb", None, node);
    assert!(errors(&scene).iter().any(|e| e.message.contains("2^63 instances")));
}

#[test]
fn depth_is_no_matter() {
    let mut scene = Scene::default();
    let mut node = sphere(&mut scene, 1.0);
    for _ in 0..100_000 {
        node = scene.add_csg(Op::Difference, vec![node]);
    }
    scene.add_object("deep", None, node);
    assert!(compile(&scene, Options::default()).is_ok());
}

/// A combination of empty groups is not placed: it has no path, no surface and no bounds, wherever it is.
#[test]
fn combinations_without_leaves_are_not_placed() {
    let mut scene = Scene::default();
    let nothing = scene.add(Node::Group { members: vec![] });
    let empty = scene.add_csg(Op::Union, vec![nothing]);
    let emptier = scene.add_csg(Op::Intersection, vec![nothing, nothing]);
    let ball = sphere(&mut scene, 1.0);
    scene.add_object("first", None, emptier);
    scene.add_object("ball", None, ball);
    // Shared, so it would be a body of its own, and the last of all bodies.
    let both = scene.add(Node::Group { members: vec![empty, empty] });
    scene.add_object("last", None, both);
    let world = compile(&scene, Options::default()).expect("it compiles");
    assert_eq!((world.path_count(), world.stats().virtual_leaves), (1, 1));
    assert_eq!(world.surface_name(0), "sphere");
    for surface in [1, 2, 1000, u32::MAX] {
        assert_eq!(world.surface_name(surface), "");
    }
    assert!(world.bounds().contains(Vec3::X) && world.bounds().size().x < 2.1);
    let mut live = super::DynamicWorld::new(scene.clone(), Options::default()).expect("it compiles");
    assert!(live.place("first", Affine::translation(Vec3::X)).is_err() || live.world().path_count() == 1);
    scene.objects.remove(1);
    let world = compile(&scene, Options::default()).expect("it compiles");
    assert!(world.bounds().is_empty() && world.surface_name(0).is_empty());
}

/// The bounds of everything bounded, also within a group that is placed beside unbounded solids.
#[test]
fn finite_bounds_are_those_of_all_that_has_an_end() {
    let mut scene = Scene::default();
    let ball = sphere(&mut scene, 1.0);
    let up: [&[f64]; 2] = [&[0.0, 0.0, 1.0], &[-1.0]];
    let ground = scene.add_solid("halfspace", &up).expect("a half-space");
    let away = scene.add_transform(Affine::translation(Vec3::X * 4.0), ball);
    let group = scene.add(Node::Group { members: vec![ball, ground, away] });
    let turned = scene.add_transform(Affine::translation(Vec3::Y * 10.0), group);
    scene.add_object("one", None, group);
    scene.add_object("other", None, turned);
    let world = compile(&scene, Options::default()).expect("it compiles");
    assert!(!world.bounds().is_finite());
    let bounds = world.finite_bounds();
    assert!((bounds.min - Vec3::new(-1.0, -1.0, -1.0)).abs().max_element() < 1e-9, "{bounds:?}");
    assert!((bounds.max - Vec3::new(5.0, 11.0, 1.0)).abs().max_element() < 1e-9, "{bounds:?}");
    let mut scene = Scene::default();
    let ground = scene.add_solid("halfspace", &up).expect("a half-space");
    scene.add_object("ground", None, ground);
    let world = compile(&scene, Options::default()).expect("it compiles");
    assert!(world.finite_bounds().is_empty());
}
