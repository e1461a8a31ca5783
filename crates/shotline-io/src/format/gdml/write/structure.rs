//! What is known of the nodes of a scene before any of them is written.

use shotline::scene::{Node, NodeId, Scene};

use super::traversal::postorder;

/// What is known of each node that the scene uses.
#[derive(Debug)]
pub(super) struct Structure {
    /// The nodes that are used, children first.
    order: Vec<NodeId>,
    /// How many places each node has in others and among the roots.
    places: Vec<u32>,
    /// The lowest priority of the objects at or below a node that no other object contains; `None` where there are none.
    lowest: Vec<Option<i32>>,
    /// The highest priority of the objects at or below a node.
    highest: Vec<Option<i32>>,
    /// Whether objects differ in priority.
    pub(super) has_priorities: bool,
    /// Millimetres per unit of length of the scene.
    pub(super) millimetres: f64,
}

impl Structure {
    /// `None` for a scene with a cycle, or with a number of no node.
    pub(super) fn of(scene: &Scene) -> Option<Structure> {
        let order = postorder(scene, scene.objects.iter().copied())?;
        let mut places = vec![0; scene.nodes.len()];
        let mut lowest: Vec<Option<i32>> = vec![None; scene.nodes.len()];
        let mut highest = lowest.clone();
        let mut priorities: Vec<i32> = Vec::new();
        scene.objects.iter().for_each(|id| places[id.0 as usize] += 1);
        for id in &order {
            let node = scene.node(*id);
            node.children().for_each(|child| places[child.0 as usize] += 1);
            lowest[id.0 as usize] = match node {
                Node::Object { priority, .. } => {
                    priorities.push(*priority);
                    Some(*priority)
                }
                node => node.children().filter_map(|child| lowest[child.0 as usize]).min(),
            };
            let of_object = match node {
                Node::Object { priority, .. } => Some(*priority),
                _ => None,
            };
            let below = node.children().filter_map(|child| highest[child.0 as usize]);
            highest[id.0 as usize] = below.chain(of_object).max();
        }
        priorities.dedup();
        Some(Structure {
            order,
            places,
            lowest,
            highest,
            has_priorities: priorities.len() > 1,
            millimetres: millimetres(scene),
        })
    }

    /// Whether there are objects at or below a node.
    pub(super) fn has_objects(&self, id: NodeId) -> bool {
        self.lowest[id.0 as usize].is_some()
    }

    pub(super) fn is_shared(&self, id: NodeId) -> bool {
        self.places[id.0 as usize] > 1
    }

    /// The lowest priority of the objects at or below a node that no other object contains.
    pub(super) fn lowest_priority(&self, id: NodeId) -> Option<i32> {
        self.lowest[id.0 as usize]
    }

    /// The highest priority of the objects at or below a node.
    pub(super) fn highest_priority(&self, id: NodeId) -> Option<i32> {
        self.highest[id.0 as usize]
    }

    /// The names of all objects.
    pub(super) fn object_names<'s>(&self, scene: &'s Scene) -> impl Iterator<Item = &'s str> {
        self.order.iter().filter_map(move |id| match scene.node(*id) {
            Node::Object { name, .. } => Some(name.as_str()),
            _ => None,
        })
    }
}

fn millimetres(scene: &Scene) -> f64 {
    use shotline::scene::Units;
    match scene.units {
        None | Some(Units::Millimetres) => 1.0,
        Some(Units::Nanometres) => 1e-6,
        Some(Units::Micrometres) => 1e-3,
        Some(Units::Centimetres) => 10.0,
        Some(Units::Metres) => 1e3,
        Some(Units::Kilometres) => 1e6,
        Some(Units::Inches) => 25.4,
        Some(Units::Feet) => 304.8,
    }
}
