//! Errors of scenes.

use std::fmt::{self, Display, Formatter};

use crate::scene::{Node, NodeId, Scene};

/// What is wrong with a scene, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct SceneError {
    /// The node at fault; a reader of scene files knows where in the file it was written.
    pub node: Option<NodeId>,
    /// The parameter at fault.
    pub param: Option<&'static str>,
    /// What is wrong.
    pub message: String,
    /// How to correct it.
    pub hint: Option<String>,
}

/// Everything that is wrong with a scene, as one error: each on a line of its own, with how to mend it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct InvalidScene {
    /// What is wrong; at least one.
    pub errors: Vec<SceneError>,
}

impl InvalidScene {
    /// Adds to each error the name of the object that contains its node, unless the message names it already.
    pub(super) fn new(scene: &Scene, errors: Vec<SceneError>) -> InvalidScene {
        let objects = innermost_objects(scene);
        let with_object =
            |error: SceneError| match error.node.and_then(|node| *objects.get(node.0 as usize)?) {
                Some(name) if !error.message.contains(&format!("'{name}'")) => {
                    SceneError { message: format!("object '{name}': {}", error.message), ..error }
                }
                _ => error,
            };
        InvalidScene { errors: errors.into_iter().map(with_object).collect() }
    }
}

/// For each node the name of the innermost object that contains it: of several, the first in the scene.
fn innermost_objects(scene: &Scene) -> Vec<Option<&str>> {
    let mut objects = vec![None; scene.nodes.len()];
    let mut seen = vec![false; scene.nodes.len()];
    let mut stack: Vec<(NodeId, Option<&str>)> = scene.objects.iter().rev().map(|&id| (id, None)).collect();
    while let Some((id, above)) = stack.pop() {
        // A scene with errors may refer to nodes that do not exist.
        let Some(node) = scene.nodes.get(id.0 as usize) else { continue };
        if std::mem::replace(&mut seen[id.0 as usize], true) {
            continue;
        }
        let innermost = match node {
            Node::Object { name, .. } => Some(name.as_str()),
            _ => above,
        };
        objects[id.0 as usize] = innermost;
        stack.extend(node.children().rev().map(|child| (child, innermost)));
    }
    objects
}

impl Display for InvalidScene {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        for (i, error) in self.errors.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { "\n" })?;
            match &error.hint {
                None => write!(f, "{error}")?,
                Some(hint) => write!(f, "{error}; {hint}")?,
            }
        }
        Ok(())
    }
}

impl SceneError {
    pub(super) fn general(message: String) -> SceneError {
        SceneError { node: None, param: None, message, hint: None }
    }

    pub(super) fn at(node: NodeId, message: String) -> SceneError {
        SceneError { node: Some(node), ..SceneError::general(message) }
    }

    pub(super) fn with_hint(self, hint: impl Into<String>) -> SceneError {
        SceneError { hint: Some(hint.into()), ..self }
    }
}
