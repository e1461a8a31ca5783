//! Objects of which there is nothing.

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::measure::object_bounds;
use shotline::query::Caster;
use shotline::ray::Span;
use shotline::scene::{Node, NodeId, Scene};

use crate::survey::spread;

/// Rays that look for one object before it is said to be missed, and for all that the survey has not met.
const RAYS: usize = 1 << 14;
const ALL_RAYS: usize = 1 << 18;

/// Boxes of parts of an object through which they are cast, and steps to find them.
const BOXES: usize = 1024;
const STEPS: u64 = 1 << 20;

/// The numbers of objects that are empty by construction, as the intersection of solids that are apart. An object that only
/// gives a name to a group of other objects is not among them.
pub fn by_construction(world: &World, scene: &Scene) -> Vec<u32> {
    let Ok(bounds) = object_bounds(world) else { return Vec::new() };
    let empty: Vec<u32> =
        (0..).zip(&bounds).filter(|(_, bounds)| bounds.is_empty()).map(|(object, _)| object).collect();
    if empty.is_empty() {
        return empty;
    }
    let groups = names_of_groups(scene);
    empty
        .into_iter()
        .filter(|object| !groups.contains(&world.object_names()[*object as usize].as_str()))
        .collect()
}

/// The names of objects that hold other objects.
fn names_of_groups(scene: &Scene) -> Vec<&str> {
    let holds_object = |node: NodeId| {
        let (mut seen, mut waiting) = (vec![false; scene.nodes.len()], vec![node]);
        while let Some(id) = waiting.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            if let Node::Object { .. } = scene.node(id) {
                return true;
            }
            waiting.extend(scene.node(id).children());
        }
        false
    };
    let name = |node: &'_ Node| match node {
        Node::Object { node, .. } => holds_object(*node),
        _ => false,
    };
    let named = scene.nodes.iter().filter(|node| name(node));
    named
        .filter_map(|node| if let Node::Object { name, .. } = node { Some(name.as_str()) } else { None })
        .collect()
}

/// The numbers of objects that have a box, and are not met by very many rays through it and through the boxes of their
/// parts; with the number of rays. Those that the survey has met are passed over.
pub fn unmet(world: &World, met: &[bool]) -> Vec<(u32, usize)> {
    let Ok(bounds) = object_bounds(world) else { return Vec::new() };
    let has_end = |bounds: &Aabb| !bounds.is_empty() && bounds.is_finite();
    let wanted: Vec<bool> = bounds.iter().zip(met).map(|(bounds, met)| !met && has_end(bounds)).collect();
    if !wanted.contains(&true) {
        return Vec::new();
    }
    let parts = world.leaf_boxes(&wanted, BOXES, STEPS);
    let (mut caster, mut rays, mut found) = (Caster::new(world), 0, Vec::new());
    for (object, (own, parts)) in (0..).zip(bounds.iter().zip(&parts)) {
        if wanted[object as usize] && rays + RAYS <= ALL_RAYS {
            let boxes = [&[*own][..], parts].concat();
            rays += 1;
            if is_missed(&mut caster, object, &boxes, &mut rays) {
                found.push((object, RAYS));
            }
        }
    }
    found
}

/// Whether no ray through some boxes meets an object.
fn is_missed(caster: &mut Caster, object: u32, boxes: &[Aabb], rays: &mut usize) -> bool {
    let mut hits = Vec::new();
    for i in 0..RAYS {
        let (bounds, turn) = (&boxes[i % boxes.len()], i / boxes.len());
        let axis = turn % 3;
        let Some(ray) = spread(bounds, axis, (turn / 3) as u32) else { return false };
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
