//! Lattices written out as groups, for formats that have none.

use super::{LocalTransform, Node, NodeId, Scene};

impl Scene {
    /// The same scene with each lattice replaced by a group of its cells, which has the same crossings. `None` if these are
    /// more than `most` in all.
    pub fn with_lattices_listed(&self, most: u64) -> Option<Scene> {
        let count = |node: &Node| match node {
            Node::Lattice { lattice, .. } => lattice.cell_count(),
            _ => 0,
        };
        if self.nodes.iter().fold(0, |sum: u64, node| sum.saturating_add(count(node))) > most {
            return None;
        }
        let mut listed = self.clone();
        for (id, node) in (0..).map(NodeId).zip(&self.nodes) {
            let Node::Lattice { lattice, .. } = node else { continue };
            let cells = node.cells().map(|(cell, shift, child)| {
                let transform = LocalTransform::translation(shift);
                let placed = listed.add(Node::Transform { transform, child });
                // A labelled element needs the name of its cell too.
                if let Some(label) = self.labels.get(&child) {
                    listed.labels.insert(placed, format!("{label}[{}]", lattice.cell_name(cell)));
                }
                placed
            });
            let members = cells.collect();
            listed.nodes[id.0 as usize] = Node::Group { members };
        }
        Some(listed)
    }
}
