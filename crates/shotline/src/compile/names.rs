//! The names of instance paths, stored as links to parents, so that a million placements do not store a million
//! strings.

use std::collections::HashMap;

use crate::scene::{Node, NodeId, Scene};

/// A name: an index into [`PathNames`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NameId(u32);

const NO_INDEX: u32 = u32::MAX;

/// An empty name.
pub(super) const NO_NAME: NameId = NameId(u32::MAX);

#[derive(Clone, Copy, Debug)]
struct Link {
    /// The name above; `NO_NAME` for a name that begins with this link.
    parent: NameId,
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
    pub(super) fn add(&mut self, parent: NameId, label: &str, index: Option<usize>) -> NameId {
        let label = self.label(label);
        let index = index.map_or(NO_INDEX, |i| i as u32);
        self.links.push(Link { parent, label, index });
        NameId((self.links.len() - 1) as u32)
    }

    /// The number of a label.
    fn label(&mut self, label: &str) -> u32 {
        // A neighbour, or its parent's neighbour, mostly has the same label, and then no hash is needed.
        let mut last = self.links.iter().rev().take(2).map(|link| link.label);
        if let Some(same) = last.find(|&last| self.labels[last as usize] == label) {
            return same;
        }
        match self.by_label.get(label) {
            Some(&known) => known,
            None => {
                let new = self.labels.len() as u32;
                self.labels.push(label.to_owned());
                self.by_label.insert(label.to_owned(), new);
                new
            }
        }
    }

    /// Gives back memory that was reserved for more names.
    pub(super) fn shrink(&mut self) {
        self.links.shrink_to_fit();
    }

    /// Appends the full name to `out`, outermost component first, with a slash before each component unless `out` is
    /// empty.
    pub(super) fn write(&self, name: NameId, out: &mut String) {
        let mut links = Vec::new();
        let mut next = name;
        while next != NO_NAME {
            let link = &self.links[next.0 as usize];
            links.push(link);
            next = link.parent;
        }
        // An empty label is that of what has no name in paths.
        for link in links.iter().rev().filter(|link| !self.labels[link.label as usize].is_empty()) {
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

/// Finds the labels of nodes: the name of their definition, the label of their transform, the name of their object, or
/// their kind.
pub(super) struct Labels<'s> {
    scene: &'s Scene,
    /// Sorted by node; the last of several names of a node counts. A search is faster than a hash where there are few.
    defs: Vec<(NodeId, &'s str)>,
}

impl<'s> Labels<'s> {
    pub(super) fn new(scene: &'s Scene) -> Labels<'s> {
        let mut defs: Vec<_> = scene.defs.iter().map(|(name, node)| (*node, name.as_str())).collect();
        defs.sort_by_key(|(node, _)| *node);
        Labels { scene, defs }
    }

    /// The name of a definition.
    fn def(&self, node: NodeId) -> Option<&'s str> {
        let end = self.defs.partition_point(|(other, _)| *other <= node);
        let (last, name) = *self.defs.get(end.checked_sub(1)?)?;
        (last == node).then_some(name)
    }

    /// The label of a node, and whether the scene gives it: then it needs no index.
    pub(super) fn of(&self, node: NodeId) -> (&'s str, bool) {
        let mut at = node;
        loop {
            if let Some(name) = self.def(at) {
                return (name, false);
            }
            let label = match self.scene.node(at) {
                Node::Transform { child, .. } => match self.scene.labels.get(&at) {
                    Some(label) => return (label, true),
                    None => {
                        at = *child;
                        continue;
                    }
                },
                Node::Object { name, .. } => name,
                Node::Solid { kind, .. } => kind.name,
                Node::Mesh { .. } => "mesh",
                Node::Group { .. } => "group",
                Node::Lattice { .. } => "lattice",
                Node::Csg { op, .. } => op.name(),
            };
            return (label, false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Affine;

    #[test]
    fn names_are_written_from_the_outermost() {
        let mut names = PathNames::default();
        let world = names.add(NO_NAME, "world", None);
        let arms: Vec<NameId> = (0..3).map(|i| names.add(world, "arm", Some(i))).collect();
        let bolt = names.add(arms[2], "bolt", Some(0));
        let other = names.add(arms[1], "arm", Some(7));
        let written = |name| {
            let mut out = String::new();
            names.write(name, &mut out);
            out
        };
        assert_eq!(written(bolt), "world/arm[2]/bolt[0]");
        assert_eq!(written(other), "world/arm[1]/arm[7]");
        assert_eq!(written(world), "world");
        assert_eq!(names.labels.len(), 3);
    }

    #[test]
    fn the_last_name_of_a_definition_is_its_label() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
        let other = scene.add_solid("sphere", &[&[2.0]]).unwrap();
        let plain = scene.add_solid("sphere", &[&[3.0]]).unwrap();
        let def = |name: &str, node| (name.to_owned(), node);
        scene.defs = vec![def("b", other), def("first", ball), def("second", ball), def("a", other)];
        let placed = scene.add_transform(Affine::IDENTITY, plain);
        scene.labels.insert(placed, "third".into());
        let labels = Labels::new(&scene);
        let expected = [("second", false), ("a", false), ("sphere", false), ("third", true)];
        assert_eq!([ball, other, plain, placed].map(|node| labels.of(node)), expected);
    }
}
