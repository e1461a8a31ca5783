use super::*;
use crate::compile::{Options, compile};
use crate::math::{Lattice, Vec3};
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

/// Of a large lattice only the cells near a corner are compared, and the result says so.
#[test]
fn neighbours_in_lattices_are_compared() {
    let found = |counts: [u32; 3], pitch: f64| {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
        let (name, material) = ("ball".to_owned(), None);
        let ball = scene.add(Node::Object {
            name,
            material,
            priority: 0,
            node: ball,
            contents: Vec::new(),
            clip: false,
        });
        let lattice = Lattice::rectangular(counts, [pitch; 3]);
        let lattice = scene.add(Node::Lattice { lattice, elements: vec![ball], table: None });
        scene.add_object("all", None, lattice);
        let found = conflict_candidates(&scene);
        (found.count, !found.has_cut_lattices)
    };
    assert_eq!(found([3, 2, 1], 1.9), (7 + 4, true));
    assert_eq!(found([3, 2, 1], 2.1), (0, true));
    assert_eq!(found([1000, 1000, 1000], 2.1), (0, false));
    let (count, complete) = found([1000, 1, 1000], 1.9);
    assert!(count > 1000 && !complete);
}
