//! The names of instance paths, stored as links to parents, so that a million placements do not store a million
//! strings.

use std::collections::HashMap;

use crate::scene::{Node, NodeId, Scene};

/// A name: an index into [`PathNames`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NameId(u32);

const NO_INDEX: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Link {
    parent: Option<NameId>,
    label: u32,
    /// The index among the members of a group; `NO_INDEX` where the name has none.
    index: u32,
}

/// All names of a world.
#[derive(Clone, Debug, Default)]
pub(super) struct PathNames {
    links: Vec<Link>,
    labels: Vec<String>,
    by_label: HashMap<String, u32>,
}

impl PathNames {
    /// Adds a name below another.
    pub(super) fn add(&mut self, parent: Option<NameId>, label: &str, index: Option<usize>) -> NameId {
        let label = match self.by_label.get(label) {
            Some(&known) => known,
            None => {
                let new = self.labels.len() as u32;
                self.labels.push(label.to_owned());
                self.by_label.insert(label.to_owned(), new);
                new
            }
        };
        let index = index.map_or(NO_INDEX, |i| i as u32);
        self.links.push(Link { parent, label, index });
        NameId((self.links.len() - 1) as u32)
    }

    /// Appends the full name to `out`, outermost component first, with a slash before each component unless `out` is
    /// empty.
    pub(super) fn write(&self, name: NameId, out: &mut String) {
        let mut links = Vec::new();
        let mut next = Some(name);
        while let Some(id) = next {
            let link = &self.links[id.0 as usize];
            links.push(link);
            next = link.parent;
        }
        for link in links.iter().rev() {
            if !out.is_empty() {
                out.push('/');
            }
            out.push_str(&self.labels[link.label as usize]);
            if link.index != NO_INDEX {
                out.push_str(&format!("[{}]", link.index));
            }
        }
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(self.links.as_slice()) + self.labels.iter().map(|l| 2 * l.len() + 64).sum::<usize>()
    }
}

/// Finds the labels of nodes: the name of their definition, the name of their object, or their kind.
pub(super) struct Labels<'s> {
    scene: &'s Scene,
    defs: HashMap<NodeId, &'s str>,
}

impl<'s> Labels<'s> {
    pub(super) fn new(scene: &'s Scene) -> Labels<'s> {
        let defs = scene.defs.iter().map(|(name, node)| (*node, name.as_str())).collect();
        Labels { scene, defs }
    }

    pub(super) fn of(&self, node: NodeId) -> &'s str {
        let mut at = node;
        loop {
            if let Some(name) = self.defs.get(&at) {
                return name;
            }
            match self.scene.node(at) {
                Node::Transform { child, .. } => at = *child,
                Node::Object { name, .. } => return name,
                Node::Solid { kind, .. } => return kind.name,
                Node::Mesh { .. } => return "mesh",
                Node::Group { .. } => return "group",
                Node::Csg { op, .. } => return op.name(),
            }
        }
    }
}
