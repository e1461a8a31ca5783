//! Random scenes: combinations, transforms, groups and shared nodes with solids of all kinds.

use std::sync::Arc;

use super::leaf::{add_varied, place};
use super::meshes::Thin;
use super::random::Random;
use crate::aabb::Aabb;
use crate::math::{Lattice, Vec3};
use crate::scene::{EMPTY_CELL, LocalTransform, Node, NodeId, Op, Rotation, Scene};

/// A function that adds a leaf of the scene.
type Leaf = fn(&mut Scene, &mut Random) -> NodeId;

/// A scene of a few objects around the origin, about four units wide. All solids are bounded and have parameters.
pub fn random_scene(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    fill(&mut scene, random, bounded);
    scene
}

/// Like [`random_scene`], with meshes, unbounded solids, empty groups and priorities.
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

/// Many placed solids and combinations without meshes, some of them in shared groups: so many that rays are cast at them in
/// waves.
pub fn random_crowd(random: &mut Random) -> Scene {
    let mut scene = Scene::default();
    let leaf = |scene: &mut Scene, random: &mut Random| {
        let solid = any_kind(scene, random);
        place(scene, solid, random.number(0.2, 0.7))
    };
    let shared: Vec<NodeId> = (0..3).map(|_| combination(&mut scene, random, 2, &[], leaf)).collect();
    let group = shared_group(&mut scene, random, &shared);
    let outer = shared_group(&mut scene, random, &[group, shared[0], group]);
    for i in 0..10 + random.below(30) {
        let node = match random.below(8) {
            0 => group,
            1 => outer,
            2 => shared[random.below(3)],
            3 => combination(&mut scene, random, 2, &shared, leaf),
            _ => leaf(&mut scene, random),
        };
        let node = moved(&mut scene, random, node);
        scene.add_object(&format!("object {i}"), None, node);
    }
    scene
}

fn fill(scene: &mut Scene, random: &mut Random, leaf: Leaf) {
    let shared: Vec<NodeId> = (0..3).map(|_| combination(scene, random, 2, &[], leaf)).collect();
    let group = shared_group(scene, random, &shared);
    for i in 0..1 + random.below(3) {
        let node = match random.below(4) {
            0 => leaf(scene, random),
            1 if random.below(3) == 0 => {
                let lattice = random_lattice(scene, random, &[group, shared[0]], 2.0);
                moved(scene, random, lattice)
            }
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

/// A lattice of a few cells, of any arrangement, that holds the first element or any of them. Neighbours are about `pitch`
/// apart.
pub fn random_lattice(scene: &mut Scene, random: &mut Random, elements: &[NodeId], pitch: f64) -> NodeId {
    let mut distance = || pitch * random.number(0.5, 1.5);
    let distances = [distance(), distance(), distance()];
    let lattice = match random.below(3) {
        0 => Lattice::Hexagonal {
            rings: 1 + random.below(3) as u32,
            pitch: distances[0],
            layers: 1 + random.below(2) as u32,
            height: distances[2],
        },
        kind => Lattice::Rectangular {
            counts: std::array::from_fn(|_| 1 + random.below(4) as u32),
            pitch: distances,
            stagger: kind == 1,
        },
    };
    let choices = [&(0..elements.len() as u32).collect::<Vec<u32>>()[..], &[EMPTY_CELL]].concat();
    let table = (0..lattice.cell_count()).map(|_| choices[random.below(choices.len())]);
    let table = Some(table.collect()).filter(|_| random.below(2) == 0);
    scene.add(Node::Lattice { lattice, elements: elements.to_vec(), table })
}

/// A tree of operations over placed leaves and shared nodes.
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
    loop {
        let solid = any_kind(scene, random);
        if solid.1.is_finite() {
            return place(scene, solid, random.number(0.4, 1.4));
        }
    }
}

fn mixed(scene: &mut Scene, random: &mut Random) -> NodeId {
    if random.below(4) == 0 {
        let mesh = Arc::new(Thin::near(random).mesh(random));
        return scene.add(Node::Mesh { mesh, file: None });
    }
    let solid = any_kind(scene, random);
    place(scene, solid, random.number(0.4, 1.4))
}

fn any_kind(scene: &mut Scene, random: &mut Random) -> (NodeId, Aabb) {
    let mut other = Random::new(random.bits());
    add_varied(scene, |n| random.below(n), || other.number(0.7, 1.4))
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
