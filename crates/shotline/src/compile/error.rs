//! Errors of scenes.

use std::fmt::{self, Display, Formatter};

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

/// Everything that is wrong with a scene, as one error: each on a line of its own, with how to mend it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub struct InvalidScene {
    /// What is wrong; at least one.
    pub errors: Vec<SceneError>,
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
