//! Random scenes: combinations, transforms, groups and shared parts of all kinds of solids.

use std::sync::Arc;

use super::meshes::Thin;
use super::random::Random;
use crate::math::Vec3;
use crate::scene::{LocalTransform, Node, NodeId, Op, Rotation, Scene};
use crate::solid::Value;

/// What leaves of a scene may be.
type Leaf = fn(&mut Scene, &mut Random) -> NodeId;

/// A scene of a few objects around the origin, about four units wide; each is bounded, and has parameters.
pub fn random_scene(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    fill(&mut scene, random, bounded);
    scene
}

/// As [`random_scene`], with meshes, solids without end, empty groups and priorities.
pub fn random_mixed_scene(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    fill(&mut scene, random, mixed);
    let empty = scene.add(Node::Group { members: Vec::new() });
    for node in &mut scene.nodes {
        match node {
            Node::Group { members } if random.below(3) == 0 && !members.is_empty() => members.push(empty),
            Node::Object { priority, .. } => *priority = random.below(3) as i32 - 1,
            _ => {}
        }
    }
    scene
}

fn fill(scene: &mut Scene, random: &mut Random, leaf: Leaf) {
    let shared: Vec<NodeId> = (0..3).map(|_| combination(scene, random, 2, &[], leaf)).collect();
    let group = shared_group(scene, random, &shared);
    for i in 0..1 + random.below(3) {
        let node = match random.below(4) {
            0 => leaf(scene, random),
            1 => {
                let members = (0..1 + random.below(4)).map(|_| moved(scene, random, group)).collect();
                scene.add(Node::Group { members })
            }
            _ => {
                let tree = combination(scene, random, 3, &shared, leaf);
                moved(scene, random, tree)
            }
        };
        scene.add_object(&format!("object {i}"), None, node);
    }
}

fn shared_group(scene: &mut Scene, random: &mut Random, shared: &[NodeId]) -> NodeId {
    let members = shared.iter().map(|&part| moved(scene, random, part)).collect();
    scene.add(Node::Group { members })
}

/// A tree of operations over placed leaves and shared parts.
fn combination(
    scene: &mut Scene,
    random: &mut Random,
    depth: usize,
    shared: &[NodeId],
    leaf: Leaf,
) -> NodeId {
    if depth == 0 || random.below(5) == 0 {
        let node = match shared.len() {
            n if n > 0 && random.below(3) == 0 => shared[random.below(n)],
            _ => leaf(scene, random),
        };
        return moved(scene, random, node);
    }
    let op = [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
    let args =
        (0..2 + random.below(2)).map(|_| combination(scene, random, depth - 1, shared, leaf)).collect();
    let node = scene.add_csg(op, args);
    if random.below(3) == 0 { moved(scene, random, node) } else { node }
}

fn bounded(scene: &mut Scene, random: &mut Random) -> NodeId {
    let mut size = || random.number(0.4, 1.4);
    let n = Value::Number;
    let (a, b, c) = (size(), size(), size());
    let (kind, values): (&str, Vec<Value>) = match random.below(8) {
        0 => ("box", vec![Value::Vector([-a, -b, -c]), Value::Vector([b, c, a])]),
        1 => ("sphere", vec![n(a)]),
        2 => ("ellipsoid", vec![Value::Vector([a, b, c])]),
        3 => ("cylinder", vec![n(a), n(-b), n(c)]),
        4 => ("cone", vec![n(a), n(if b < 0.7 { 0.0 } else { b }), n(-c), n(b)]),
        5 => ("paraboloid", vec![n(a), n(-b), n(c)]),
        6 => ("hyperboloid", vec![n(0.5 * a), n(b), n(-c), n(c)]),
        _ => ("torus", vec![n(a), n(0.4 * b)]),
    };
    solid(scene, kind, &values)
}

fn mixed(scene: &mut Scene, random: &mut Random) -> NodeId {
    let n = Value::Number;
    match random.below(8) {
        0 | 1 => {
            let mesh = Arc::new(Thin::near(random).mesh(random));
            scene.add(Node::Mesh { mesh, file: None })
        }
        2 => {
            let (a, c) = (random.number(0.2, 0.8), random.number(0.1, 0.4));
            solid(scene, "hyperboloid2", &[n(a), n(c), n(-1.2), n(0.9)])
        }
        3 => {
            let normal = Value::Vector(random.direction().to_array());
            solid(scene, "halfspace", &[normal, n(random.number(-1.0, 1.0))])
        }
        4 => {
            // Ellipsoids, cylinders, cones and hyperboloids about the origin or near it.
            let mut square = || random.number(-0.5, 2.0);
            let squares = [square(), square(), square()];
            let mut coeffs = [0.0; 10];
            coeffs[..3].copy_from_slice(&squares);
            coeffs[3..9].iter_mut().for_each(|c| *c = random.number(-0.3, 0.3));
            coeffs[9] = random.number(-1.0, 0.2);
            solid(scene, "quadric", &[Value::Ten(coeffs)])
        }
        _ => bounded(scene, random),
    }
}

fn solid(scene: &mut Scene, kind: &str, values: &[Value]) -> NodeId {
    match scene.add_solid(kind, values) {
        Some(node) => node,
        None => panic!("no kind {kind}"),
    }
}

fn moved(scene: &mut Scene, random: &mut Random, child: NodeId) -> NodeId {
    let mut factor = || random.number(0.6, 1.3) * if random.below(6) == 0 { -1.0 } else { 1.0 };
    let scale = Vec3::new(factor(), factor(), factor());
    let transform = LocalTransform::Steps {
        scale: (random.below(2) == 0).then_some(scale),
        rotate: (random.below(2) == 0).then(|| Rotation::Xyz(random.point(-180.0, 180.0))),
        translate: Some(random.point(-1.0, 1.0)),
    };
    scene.add(Node::Transform { transform, child })
}
