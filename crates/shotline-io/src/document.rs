//! A file that has been read: the scene, and where in the text everything stood.

use std::ops::Range;
use std::path::{Path, PathBuf};

use shotline::compile::SceneError;
use shotline::scene::{NodeId, Scene};

use crate::error::ReadError;
use crate::fault::{Fault, Faults};
use crate::scene_json;

/// A scene with its source.
#[derive(Clone, Debug)]
pub struct Document {
    /// The scene.
    pub scene: Scene,
    /// What a user may want to know about the files, as in "12 polygons were cut into triangles".
    pub notes: Vec<String>,
    /// Where it came from.
    pub source: Source,
}

/// Where a scene came from.
#[derive(Clone, Debug, Default)]
pub struct Source {
    path: Option<PathBuf>,
    text: String,
    spans: Vec<Range<usize>>,
}

impl Source {
    pub(crate) fn new(path: Option<&Path>, text: String, spans: Vec<Range<usize>>) -> Source {
        Source { path: path.map(Into::into), text, spans }
    }

    /// The file.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The text of a scene file; empty for a mesh.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The bytes of the text at which a node was written, or one of its parameters.
    pub fn find(&self, node: NodeId, param: Option<&str>) -> Option<Range<usize>> {
        let whole = self.spans.get(node.0 as usize)?.clone();
        let inner = param.and_then(|param| scene_json::find_param(self.text.get(whole.clone())?, param));
        Some(inner.map_or(whole.clone(), |r| whole.start + r.start..whole.start + r.end))
    }
}

impl Document {
    /// The errors of a compiled scene as problems of its file.
    pub fn explain(&self, errors: &[SceneError]) -> ReadError {
        let mut faults = Faults::default();
        for error in errors {
            let place = error.node.and_then(|node| self.source.find(node, error.param));
            let fault = match (place, error.param) {
                (Some(place), _) => Fault::text(place, &error.message),
                (None, _) => Fault::file(&error.message),
            };
            faults.push(Fault { help: error.hint.clone(), ..fault });
        }
        ReadError::new(self.source.path(), self.source.text.as_bytes(), faults)
    }
}
