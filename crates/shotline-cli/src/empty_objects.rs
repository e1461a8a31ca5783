//! Empty objects: those that contain no point.

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::measure::object_bounds;
use shotline::query::Caster;
use shotline::ray::Span;
use shotline::scene::{Node, NodeId, Scene};

use crate::overlap::axis_ray;

/// The number of rays for one object before it is reported as not met, and the maximum for all objects.
const RAYS: usize = 1 << 14;
const MAX_ALL_RAYS: usize = 1 << 18;

/// The maximum number of leaf boxes of an object through which rays are cast, and of steps to find these boxes.
const MAX_BOXES: usize = 1024;
const MAX_STEPS: u64 = 1 << 20;

/// The numbers of objects that are empty by construction, such as the intersection of disjoint solids. An object that
/// only gives a name to a group of other objects is not included.
pub fn by_construction(world: &World, scene: &Scene) -> Vec<u32> {
    let Ok(bounds) = object_bounds(world) else { return Vec::new() };
    let empty: Vec<u32> =
        (0..).zip(&bounds).filter(|(_, bounds)| bounds.is_empty()).map(|(object, _)| object).collect();
    if empty.is_empty() {
        return empty;
    }
    let containers = names_of_containers(scene);
    empty
        .into_iter()
        .filter(|object| !containers.contains(&world.object_names()[*object as usize].as_str()))
        .collect()
}

/// The names of objects that contain other objects.
fn names_of_containers(scene: &Scene) -> Vec<&str> {
    let contains_object = |node: NodeId| {
        let (mut visited, mut pending) = (vec![false; scene.nodes.len()], vec![node]);
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut visited[id.0 as usize], true) {
                continue;
            }
            if let Node::Object { .. } = scene.node(id) {
                return true;
            }
            pending.extend(scene.node(id).children());
        }
        false
    };
    let is_container = |node: &'_ Node| match node {
        Node::Object { node, contents, .. } => !contents.is_empty() || contains_object(*node),
        _ => false,
    };
    let named = scene.nodes.iter().filter(|node| is_container(node));
    named
        .filter_map(|node| if let Node::Object { name, .. } = node { Some(name.as_str()) } else { None })
        .collect()
}

/// The numbers of bounded objects that none of very many rays meets, with the number of rays. The rays run through the
/// box of the object and the boxes of its leaves. Objects that other rays have `met` already are skipped.
pub fn unmet(world: &World, met: &[bool]) -> Vec<(u32, usize)> {
    let Ok(bounds) = object_bounds(world) else { return Vec::new() };
    let is_bounded = |bounds: &Aabb| !bounds.is_empty() && bounds.is_finite();
    let wanted: Vec<bool> = bounds.iter().zip(met).map(|(bounds, met)| !met && is_bounded(bounds)).collect();
    if !wanted.contains(&true) {
        return Vec::new();
    }
    let leaves = world.leaf_boxes(&wanted, MAX_BOXES, MAX_STEPS);
    let (mut caster, mut rays, mut found) = (Caster::new(world), 0, Vec::new());
    for (object, (own, leaves)) in (0..).zip(bounds.iter().zip(&leaves)) {
        if wanted[object as usize] && rays + RAYS <= MAX_ALL_RAYS {
            let boxes = [&[*own][..], leaves].concat();
            rays += 1;
            if is_missed(&mut caster, object, &boxes, &mut rays) {
                found.push((object, RAYS));
            }
        }
    }
    found
}

/// Whether no ray through the boxes meets an object.
fn is_missed(caster: &mut Caster, object: u32, boxes: &[Aabb], rays: &mut usize) -> bool {
    let mut hits = Vec::new();
    for i in 0..RAYS {
        let (bounds, round) = (&boxes[i % boxes.len()], i / boxes.len());
        let axis = round % 3;
        let Some(ray) = axis_ray(bounds, axis, (round / 3) as u32) else { return false };
        let from = bounds.min[axis] - ray.origin()[axis];
        let Ok(span) = Span::new(from, from + bounds.size()[axis]) else { return false };
        *rays += 1;
        hits.clear();
        if caster.crossings(&ray, span, &mut hits).is_err() || hits.iter().any(|hit| hit.object == object) {
            return false;
        }
    }
    true
}
