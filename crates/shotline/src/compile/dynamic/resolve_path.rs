//! Resolves the names of paths to nodes of the scene.

use super::super::names::Labels;
use crate::scene::{LocalTransform, Node, NodeId, Scene};

/// A member of a group, a part of the contents of an object, or a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Member {
    /// The group, or the object that contains it; `None` for the roots of the scene.
    pub group: Option<NodeId>,
    /// Its index among the members.
    pub index: usize,
    /// The member's node: the node that is placed, or a transform above it.
    pub node: NodeId,
}

/// The member that the name of a path, or the beginning of one, ends in. If siblings share a name, the first is used.
pub(super) fn resolve(scene: &Scene, path: &str) -> Option<Member> {
    let labels = Labels::new(scene);
    let (mut lists, mut rest) = (vec![(None, scene.objects.as_slice())], path);
    loop {
        let name_of = |group: Option<NodeId>, index: usize, node: NodeId| match (group, labels.of(node)) {
            (None, (label, _)) | (Some(_), (label, true)) => label.to_owned(),
            (Some(_), (label, false)) => format!("{label}[{index}]"),
        };
        let members = lists.iter().flat_map(|(group, members)| {
            members.iter().enumerate().map(|(index, &node)| Member { group: *group, index, node })
        });
        // Names may contain slashes, so the path is matched against the names of members instead of being split.
        let (member, after) = { members }.find_map(|member| {
            let after = after_name(rest, &name_of(member.group, member.index, member.node))?;
            Some((member, after))
        })?;
        if after.is_empty() {
            return Some(member);
        }
        (lists, rest) = (lists_below(scene, member.node), &after[1..]);
    }
}

/// The number of root objects that have the name with which a path begins.
pub(super) fn namesakes(scene: &Scene, path: &str) -> usize {
    let labels = Labels::new(scene);
    let names = || scene.objects.iter().map(|&root| labels.of(root).0);
    let first = names().find(|name| after_name(path, name).is_some());
    first.map_or(0, |first| names().filter(|name| *name == first).count())
}

/// The rest of a path after a name at its beginning; `None` if the path begins differently.
fn after_name<'p>(path: &'p str, name: &str) -> Option<&'p str> {
    path.strip_prefix(name).filter(|after| after.is_empty() || after.starts_with('/'))
}

/// The members of the group that a member is, below its transforms and its object, and the contents of that object.
fn lists_below(scene: &Scene, mut node: NodeId) -> Vec<(Option<NodeId>, &[NodeId])> {
    let mut lists = Vec::new();
    loop {
        match scene.node(node) {
            Node::Transform { child, .. } => node = *child,
            Node::Object { node: shape, contents, .. } => {
                lists.push((Some(node), contents.as_slice()));
                node = *shape;
            }
            Node::Group { members } => {
                lists.push((Some(node), members));
                return lists;
            }
            // The cells of a lattice do not move one by one.
            Node::Solid { .. } | Node::Mesh { .. } | Node::Csg { .. } | Node::Lattice { .. } => return lists,
        }
    }
}

/// The transforms between a member and the node that it places, outermost first: those above its object and below it. Below an
/// object with contents there are none that move all of it.
pub(super) fn transforms(scene: &Scene, member: Member) -> Vec<NodeId> {
    let (mut found, mut node) = (Vec::new(), member.node);
    loop {
        match scene.node(node) {
            Node::Transform { child, .. } => {
                found.push(node);
                node = *child;
            }
            Node::Object { node: shape, contents, .. } if contents.is_empty() => node = *shape,
            _ => return found,
        }
    }
}

/// Inserts a transform above a member. An object without contents keeps its place among the roots: the transform is inserted
/// between it and its shape.
pub(super) fn insert_transform_above(scene: &mut Scene, member: Member, transform: LocalTransform) {
    let (child, parent) = match (member.group, scene.node(member.node)) {
        (None, Node::Object { node, contents, .. }) if contents.is_empty() => (*node, Some(member.node)),
        (group, _) => (member.node, group),
    };
    let placed = scene.add(Node::Transform { transform, child });
    match parent.map(|parent| &mut scene.nodes[parent.0 as usize]) {
        None => scene.objects[member.index] = placed,
        Some(Node::Object { node, .. }) if *node == child => *node = placed,
        Some(Node::Object { contents: members, .. } | Node::Group { members }) => {
            members[member.index] = placed;
        }
        Some(_) => {}
    }
}
