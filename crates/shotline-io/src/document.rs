//! A file that has been read: the scene, and where in the text everything stood.

use std::ops::Range;
use std::path::{Path, PathBuf};

use shotline::compile::SceneError;
use shotline::scene::{Node, NodeId, Scene};

use crate::error::ReadError;
use crate::fault::{Fault, Faults};
use crate::note::Note;

/// A scene with its source.
#[derive(Clone, Debug)]
pub struct Document {
    /// The scene.
    pub scene: Scene,
    /// What the readers of the files passed over, dropped or repaired.
    pub notes: Vec<Note>,
    /// Where it came from.
    pub source: Source,
}

/// Where a scene came from.
#[derive(Clone, Debug, Default)]
pub struct Source {
    path: Option<PathBuf>,
    text: String,
    spans: Vec<Range<usize>>,
    find_param: Option<FindParam>,
}

/// Finds a parameter in the text of a node, for formats whose nodes have any.
pub(crate) type FindParam = fn(node: &str, param: &str) -> Option<Range<usize>>;

impl Source {
    /// A file whose nodes cannot be found in it.
    pub(crate) fn opaque(path: &Path) -> Source {
        Source { path: Some(path.into()), ..Source::default() }
    }

    /// A text, with the bytes of each node.
    pub(crate) fn text_of(
        path: Option<&Path>,
        text: String,
        spans: Vec<Range<usize>>,
        find: FindParam,
    ) -> Source {
        Source { path: path.map(Into::into), text, spans, find_param: Some(find) }
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
        Some(param.and_then(|param| self.find_param(&whole, param)).unwrap_or(whole))
    }

    fn find_param(&self, node: &Range<usize>, param: &str) -> Option<Range<usize>> {
        let inner = self.find_param?(self.text.get(node.clone())?, param)?;
        Some(node.start + inner.start..node.start + inner.end)
    }
}

impl Document {
    /// The errors of a compiled scene as problems of its file.
    pub fn explain(&self, errors: &[SceneError]) -> ReadError {
        let mut faults = Faults::default();
        for error in errors {
            // Finding a place costs reading its node, which is done only for errors that are listed.
            let node = error.node.filter(|_| !faults.is_full());
            let fault = match node.and_then(|node| self.place_of(node, error.param)) {
                Some(place) => Fault::text(place, &error.message),
                None => Fault::file(self.without_file(&error.message)),
            };
            faults.push(Fault { help: error.hint.clone(), ..fault });
        }
        ReadError::new(self.source.path(), self.source.text.as_bytes(), faults)
    }

    /// A message without the name of the mesh file at its beginning, if that is the file that was read: its path
    /// stands before every message.
    fn without_file<'m>(&self, message: &'m str) -> &'m str {
        let name = self.source.path().and_then(Path::file_name).and_then(|name| name.to_str());
        let rest = name.and_then(|name| message.strip_prefix(name)?.strip_prefix(": "));
        rest.unwrap_or(message)
    }

    /// What a message about a node points at: the parameter, the placement, or the first line of the node.
    fn place_of(&self, node: NodeId, param: Option<&str>) -> Option<Range<usize>> {
        let placement = ["transform", "scale", "rotate", "translate"];
        let placement = placement.iter().filter(|_| matches!(self.scene.node(node), Node::Transform { .. }));
        let whole = self.source.find(node, None)?;
        let inner = param.iter().chain(placement).find_map(|key| self.source.find_param(&whole, key));
        Some(inner.unwrap_or(whole))
    }
}
