//! A file that has been read: the scene, and the location of each node in the text.

use std::ops::Range;
use std::path::{Path, PathBuf};

use shotline::compile::SceneError;
use shotline::scene::{Node, NodeId, Scene};

use crate::diagnostic::{Diagnostics, RawDiagnostic};
use crate::error::ReadError;
use crate::note::Note;

/// A scene with its source.
#[derive(Clone, Debug)]
pub struct Document {
    /// The scene.
    pub scene: Scene,
    /// What the readers of the files skipped, dropped or repaired.
    pub notes: Vec<Note>,
    /// The file and text it was read from.
    pub source: Source,
}

/// The file and text that a scene was read from.
#[derive(Clone, Debug, Default)]
pub struct Source {
    path: Option<PathBuf>,
    text: String,
    spans: Vec<Range<usize>>,
    find_param: Option<FindParam>,
    included: Included,
    /// Other files that were read, but for those that the scene names.
    files: Vec<PathBuf>,
}

/// The files that a file includes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Included {
    /// Their paths and texts.
    pub(crate) texts: Vec<(PathBuf, String)>,
    /// For each node the text that it stands in: 0 for the file itself, then these. Without any, all stand in the file itself.
    pub(crate) text_of: Vec<u32>,
}

/// Finds a parameter in the text of a node, in formats that have parameters.
pub(crate) type FindParam = fn(node: &str, param: &str) -> Option<Range<usize>>;

impl Source {
    /// A file whose nodes have no location.
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
        let path = path.map(Into::into);
        Source { path, text, spans, find_param: Some(find), ..Source::default() }
    }

    /// A text and those that it includes, with the bytes of each node in its own text.
    pub(crate) fn including(
        path: &Path,
        text: String,
        spans: Vec<Range<usize>>,
        included: Included,
    ) -> Source {
        Source { path: Some(path.into()), text, spans, included, ..Source::default() }
    }

    /// With other files that were read.
    pub(crate) fn with_files(self, files: Vec<PathBuf>) -> Source {
        Source { files, ..self }
    }

    /// What else was read for it: the files that it includes, those of buffers and of materials. The meshes that a scene names
    /// are in its nodes.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let included = self.included.texts.iter().map(|(path, _)| path.as_path());
        included.chain(self.files.iter().map(PathBuf::as_path))
    }

    /// The file.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The text of a scene file; empty for a mesh.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The bytes of the text that define a node, or one of its parameters. `None` for a node of an included file.
    pub fn find(&self, node: NodeId, param: Option<&str>) -> Option<Range<usize>> {
        let whole = self.spans.get(node.0 as usize).filter(|_| self.text_number(node) == 0)?.clone();
        Some(param.and_then(|param| self.find_param(&whole, param)).unwrap_or(whole))
    }

    /// The number of the text that a node stands in.
    fn text_number(&self, node: NodeId) -> usize {
        self.included.text_of.get(node.0 as usize).map_or(0, |number| *number as usize)
    }

    fn find_param(&self, node: &Range<usize>, param: &str) -> Option<Range<usize>> {
        let inner = self.find_param?(self.text.get(node.clone())?, param)?;
        Some(node.start + inner.start..node.start + inner.end)
    }
}

impl Document {
    /// The errors of the compiler as diagnostics of the file.
    pub fn diagnostics(&self, errors: &[SceneError]) -> ReadError {
        let Source { path, text, included, .. } = &self.source;
        // Locating an error means parsing its node again, so only errors that are listed are located.
        let listed = &errors[..errors.len().min(Diagnostics::MAX_LISTED)];
        let diagnostic = |error: &SceneError| {
            let found = error.node.and_then(|node| Some((node, self.location_of(node, error.param)?)));
            let (number, diagnostic) = match found {
                Some((node, range)) => {
                    (self.source.text_number(node), RawDiagnostic::text(range, &error.message))
                }
                None => (0, RawDiagnostic::file(self.without_file(&error.message))),
            };
            (number, RawDiagnostic { help: error.hint.clone(), ..diagnostic })
        };
        let main = (path.as_deref().unwrap_or(Path::new("")), text.as_str());
        let others = included.texts.iter().map(|(path, text)| (path.as_path(), text.as_str()));
        let texts: Vec<_> = std::iter::once(main).chain(others).collect();
        let found = listed.iter().map(diagnostic).collect();
        let error = ReadError::of_texts(&texts, found, errors.len() - listed.len());
        ReadError { path: path.clone(), ..error }
    }

    /// A message without the name of the mesh file at its beginning, if that is the file that was read: every message
    /// is printed with the path of that file.
    fn without_file<'m>(&self, message: &'m str) -> &'m str {
        let name = self.source.path().and_then(Path::file_name).and_then(|name| name.to_str());
        let rest = name.and_then(|name| message.strip_prefix(name)?.strip_prefix(": "));
        rest.unwrap_or(message)
    }

    /// The range that a message about a node marks: the parameter, the placement, or the node.
    fn location_of(&self, node: NodeId, param: Option<&str>) -> Option<Range<usize>> {
        let placement = ["transform", "scale", "rotate", "translate"];
        let placement = placement.iter().filter(|_| matches!(self.scene.node(node), Node::Transform { .. }));
        let whole = self.source.spans.get(node.0 as usize)?.clone();
        let inner = param.iter().chain(placement).find_map(|key| self.source.find_param(&whole, key));
        Some(inner.unwrap_or(whole))
    }
}
