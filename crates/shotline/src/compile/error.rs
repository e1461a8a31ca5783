//! Errors of scenes.

use crate::scene::NodeId;

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
