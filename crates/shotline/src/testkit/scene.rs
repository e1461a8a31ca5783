//! Random scenes: combinations, transforms, groups and shared parts of all kinds of bounded solids.

use super::random::Random;
use crate::math::Vec3;
use crate::scene::{LocalTransform, Node, NodeId, Op, Rotation, Scene};
use crate::solid::Value;

/// A scene of a few objects around the origin, about four units wide.
pub fn random_scene(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    let shared: Vec<NodeId> = (0..3).map(|_| combination(&mut scene, random, 2, &[])).collect();
    let group = shared_group(&mut scene, random, &shared);
    for i in 0..1 + random.below(3) {
        let node = match random.below(4) {
            0 => leaf(&mut scene, random),
            1 => {
                let members = (0..1 + random.below(4)).map(|_| moved(&mut scene, random, group)).collect();
                scene.add(Node::Group { members })
            }
            _ => {
                let tree = combination(&mut scene, random, 3, &shared);
                moved(&mut scene, random, tree)
            }
        };
        scene.add_object(&format!("object {i}"), None, node);
    }
    scene
}

fn shared_group(scene: &mut Scene, random: &mut Random, shared: &[NodeId]) -> NodeId {
    let members = shared.iter().map(|&part| moved(scene, random, part)).collect();
    scene.add(Node::Group { members })
}

/// A tree of operations over placed leaves and shared parts.
fn combination(scene: &mut Scene, random: &mut Random, depth: usize, shared: &[NodeId]) -> NodeId {
    if depth == 0 || random.below(5) == 0 {
        let node = match shared.len() {
            n if n > 0 && random.below(3) == 0 => shared[random.below(n)],
            _ => leaf(scene, random),
        };
        return moved(scene, random, node);
    }
    let op = [Op::Union, Op::Intersection, Op::Difference][random.below(3)];
    let args = (0..2 + random.below(2)).map(|_| combination(scene, random, depth - 1, shared)).collect();
    let node = scene.add_csg(op, args);
    if random.below(3) == 0 { moved(scene, random, node) } else { node }
}

fn leaf(scene: &mut Scene, random: &mut Random) -> NodeId {
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
    match scene.add_solid(kind, &values) {
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
