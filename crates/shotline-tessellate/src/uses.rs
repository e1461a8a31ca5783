//! How often the nodes of a scene are placed, and how large.

use shotline::scene::{Node, NodeId, Scene};

use crate::graph::{matrix, stretch};

/// How a node is placed.
#[derive(Clone, Debug)]
pub struct Use {
    /// How often, if all groups are counted member by member; a combination is not entered.
    pub count: f64,
    /// By how much its lengths are enlarged at most.
    pub stretch: f64,
    /// The object that it belongs to; the first, if it belongs to several.
    pub object: Option<NodeId>,
}

const NEVER: Use = Use { count: 0.0, stretch: 0.0, object: None };

/// How each node is placed, by its number. `order` has children before parents.
pub fn uses(scene: &Scene, order: &[NodeId]) -> Vec<Use> {
    let mut uses = vec![NEVER; scene.nodes.len()];
    for root in &scene.objects {
        let root = &mut uses[root.0 as usize];
        (root.count, root.stretch) = (root.count + 1.0, 1.0);
    }
    for id in order.iter().rev() {
        let above = uses[id.0 as usize].clone();
        let node = scene.node(*id);
        let (object, enlarged) = match node {
            Node::Object { .. } => (Some(*id), 1.0),
            Node::Transform { transform, .. } => (above.object, stretch(&matrix([transform]))),
            Node::Csg { .. } => continue,
            _ => (above.object, 1.0),
        };
        let of_elements = node.element_uses();
        for (index, child) in node.children().enumerate() {
            let times = of_elements.as_ref().map_or(1.0, |uses| uses[index] as f64);
            let below = &mut uses[child.0 as usize];
            below.count += above.count * times;
            below.stretch = below.stretch.max(above.stretch * enlarged);
            below.object = below.object.or(object);
        }
    }
    uses
}
