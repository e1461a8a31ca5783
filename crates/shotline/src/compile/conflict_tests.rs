use super::*;
use crate::compile::{Options, compile};
use crate::math::Vec3;
use crate::scene::{Node, NodeId, Op, Scene};

fn ball(scene: &mut Scene, at: [f64; 3]) -> NodeId {
    let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
    scene.add_transform(Affine::translation(Vec3::from_array(at)), ball)
}

fn conflict_candidates(scene: &Scene) -> ConflictCandidates {
    compile(scene, Options::default()).unwrap().conflict_candidates(100, 1 << 20)
}

#[test]
fn pairs_are_those_of_leaves_of_different_objects_of_equal_priority() {
    let mut scene = Scene::default();
    let [a, b, far, off] = [[0.0; 3], [1.5, 0.0, 0.0], [100.0; 3], [50.0; 3]].map(|at| ball(&mut scene, at));
    let two = scene.add_csg(Op::Union, vec![a, far]);
    scene.add_object("two", None, two);
    scene.add_object("b", None, b);
    // In the box of the union, but in none of the boxes of its leaves.
    scene.add_object("off", None, off);
    let found = conflict_candidates(&scene);
    assert!(found.complete && found.count == 1, "{found:?}");
    assert_eq!(found.pairs[0].objects, [0, 1]);
    let common = found.pairs[0].place;
    assert!((common.min.x - 0.5).abs() < 1e-12 && (common.max.x - 1.0).abs() < 1e-12, "{common:?}");
}

#[test]
fn pairs_within_a_shared_group_are_found_at_one_place() {
    let mut scene = Scene::default();
    let [a, b] = [[0.0; 3], [1.5, 0.0, 0.0]].map(|at| ball(&mut scene, at));
    let members = [("a", a), ("b", b)].map(|(name, node)| {
        scene.add(Node::Object {
            name: name.into(),
            material: None,
            priority: 0,
            node,
            contents: Vec::new(),
            clip: false,
        })
    });
    let mut group = scene.add(Node::Group { members: members.to_vec() });
    for k in 0..40 {
        let step = 4.0 * f64::powi(2.0, k);
        let moved = scene.add_transform(Affine::translation(Vec3::new(0.0, step, 0.0)), group);
        group = scene.add(Node::Group { members: vec![group, moved] });
    }
    scene.add_object("all", None, group);
    let found = conflict_candidates(&scene);
    assert!(found.complete && found.count == 1, "{found:?}");
}

#[test]
fn comparisons_that_are_too_few_are_told() {
    let mut scene = Scene::default();
    for i in 0..100 {
        let ball = ball(&mut scene, [0.1 * f64::from(i), 0.0, 0.0]);
        scene.add_object(&format!("ball {i}"), None, ball);
    }
    let world = compile(&scene, Options::default()).unwrap();
    let few = world.conflict_candidates(10, 200);
    assert!(!few.complete, "{few:?}");
    let all = world.conflict_candidates(10, 1 << 20);
    assert!(all.complete && all.count > 1000 && all.pairs.len() == 10, "{}", all.count);
}
