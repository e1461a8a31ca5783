//! How objects are nested in a scene: how many instances of them there are, and how deep.

use shotline::math::Lattice;
use shotline::scene::{Node, NodeId, Scene};

/// The instances of objects in a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nesting {
    /// How many there are; an object in a shared part has one for each way to it. Not more than `u64::MAX`.
    pub instances: u64,
    /// The largest number of objects in one another.
    pub depth: u64,
}

impl Nesting {
    /// Counts the instances of a scene that has been compiled, so that it has no cycle.
    pub fn of(scene: &Scene) -> Nesting {
        let mut known: Vec<Option<Nesting>> = vec![None; scene.nodes.len()];
        let mut next = scene.objects.clone();
        while let Some(&id) = next.last() {
            let before = next.len();
            next.extend(scene.node(id).children().filter(|child| known[child.0 as usize].is_none()));
            if next.len() == before {
                next.pop();
                known[id.0 as usize] = Some(of_node(scene, id, &known));
            }
        }
        sum(&scene.objects, &known)
    }
}

fn of_node(scene: &Scene, id: NodeId, known: &[Option<Nesting>]) -> Nesting {
    let node = scene.node(id);
    let mut below = sum(&node.children().collect::<Vec<_>>(), known);
    if let Node::Lattice { lattice, elements, table } = node {
        below.instances = in_cells(lattice, elements, table.as_deref(), known);
    }
    let own = u64::from(matches!(node, Node::Object { .. }));
    Nesting { instances: below.instances.saturating_add(own), depth: below.depth + own }
}

fn sum(nodes: &[NodeId], known: &[Option<Nesting>]) -> Nesting {
    let found = nodes.iter().filter_map(|node| known[node.0 as usize]);
    found.fold(Nesting::default(), |sum, next| Nesting {
        instances: sum.instances.saturating_add(next.instances),
        depth: sum.depth.max(next.depth),
    })
}

/// The number of instances in the cells of a lattice.
fn in_cells(lattice: &Lattice, elements: &[NodeId], table: Option<&[u32]>, known: &[Option<Nesting>]) -> u64 {
    let of = |element: u32| {
        let node = elements.get(element as usize);
        node.and_then(|node| known[node.0 as usize]).map_or(0, |nesting| nesting.instances)
    };
    match table {
        None => of(0).saturating_mul(lattice.cell_count()),
        Some(table) => table.iter().fold(0, |sum: u64, &element| sum.saturating_add(of(element))),
    }
}

#[cfg(test)]
mod tests {
    use shotline::math::Affine;

    use super::*;

    #[test]
    fn instances_of_shared_objects_are_counted_once_for_each_way() {
        let mut scene = Scene::default();
        let mut inner = Vec::new();
        for i in 0..40 {
            let node = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
            let (name, contents) = (format!("o{i}"), inner);
            let object = Node::Object { name, material: None, priority: 0, node, contents, clip: true };
            let object = scene.add(object);
            inner = vec![scene.add_transform(Affine::IDENTITY, object), object];
        }
        scene.objects = inner[1..].to_vec();
        assert_eq!(Nesting::of(&scene), Nesting { instances: (1 << 40) - 1, depth: 40 });
    }
}
