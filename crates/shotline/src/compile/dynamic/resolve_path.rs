//! Resolves the names of paths to nodes of the scene.

use super::super::names::Labels;
use crate::scene::{LocalTransform, Node, NodeId, Scene};

/// A member of a group, or a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Member {
    /// The group; `None` for the roots of the scene.
    pub group: Option<NodeId>,
    /// Its index among the members.
    pub index: usize,
    /// The member's node: the node that is placed, or a transform above it.
    pub node: NodeId,
}

/// The member that the name of a path, or the beginning of one, ends in. If roots share a name, the first is used.
pub(super) fn resolve(scene: &Scene, path: &str) -> Option<Member> {
    let labels = Labels::new(scene);
    let (mut group, mut members, mut rest) = (None, scene.objects.as_slice(), path);
    loop {
        let name_of = |index: usize, node: NodeId| match group {
            None => labels.of(node).to_owned(),
            Some(_) => format!("{}[{index}]", labels.of(node)),
        };
        // Names may contain slashes, so the path is matched against the names of members instead of being split.
        let (member, after) = members.iter().enumerate().find_map(|(index, &node)| {
            let after = after_name(rest, &name_of(index, node))?;
            Some((Member { group, index, node }, after))
        })?;
        if after.is_empty() {
            return Some(member);
        }
        let (below, inner) = group_below(scene, member.node)?;
        (group, members, rest) = (Some(below), inner, &after[1..]);
    }
}

/// The number of root objects that have the name with which a path begins.
pub(super) fn namesakes(scene: &Scene, path: &str) -> usize {
    let labels = Labels::new(scene);
    let names = || scene.objects.iter().map(|&root| labels.of(root));
    let first = names().find(|name| after_name(path, name).is_some());
    first.map_or(0, |first| names().filter(|name| *name == first).count())
}

/// The rest of a path after a name at its beginning; `None` if the path begins differently.
fn after_name<'p>(path: &'p str, name: &str) -> Option<&'p str> {
    path.strip_prefix(name).filter(|after| after.is_empty() || after.starts_with('/'))
}

/// The group that a member is, below its transforms and its object, and its members; `None` if it is not a group.
fn group_below(scene: &Scene, mut node: NodeId) -> Option<(NodeId, &[NodeId])> {
    loop {
        match scene.node(node) {
            Node::Transform { child, .. } => node = *child,
            Node::Object { node: shape, .. } => node = *shape,
            Node::Group { members } => return Some((node, members)),
            Node::Solid { .. } | Node::Mesh { .. } | Node::Csg { .. } => return None,
        }
    }
}

/// The transforms between a member and the node that it places, outermost first: those above its object and below it.
pub(super) fn transforms(scene: &Scene, member: Member) -> Vec<NodeId> {
    let (mut found, mut node) = (Vec::new(), member.node);
    loop {
        match scene.node(node) {
            Node::Transform { child, .. } => {
                found.push(node);
                node = *child;
            }
            Node::Object { node: shape, .. } => node = *shape,
            _ => return found,
        }
    }
}

/// Inserts a transform above a member. A root must be an object, so there it is inserted between the object and its
/// shape.
pub(super) fn insert_transform_above(scene: &mut Scene, member: Member, transform: LocalTransform) {
    let child = match (member.group, scene.node(member.node)) {
        (None, Node::Object { node, .. }) => *node,
        _ => member.node,
    };
    let placed = scene.add(Node::Transform { transform, child });
    match &mut scene.nodes[member.group.unwrap_or(member.node).0 as usize] {
        Node::Object { node, .. } => *node = placed,
        Node::Group { members } => members[member.index] = placed,
        _ => {}
    }
}
