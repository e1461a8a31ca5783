//! 3MF, the files of 3D printing: a zip package with models in XML. See `docs/3mf.md`.

mod build;
mod elements;
mod meshes;
mod model;
mod package;
mod properties;
mod write;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use roxmltree::Document as Tree;

use self::build::{Builder, Fault};
use self::model::Model;
use self::package::Package;
use crate::bytes::as_text;
use crate::diagnostic::RawDiagnostic;
use crate::document::{Document, Included, Source};
use crate::error::ReadError;
use crate::format::{Content, Format, MeshSource};
use crate::note::Notes;
use crate::options::ReadOptions;
use crate::xml::{offset_of, syntax_error};

pub(crate) const FORMAT: Format = Format {
    name: "3MF",
    extensions: &["3mf"],
    // The names of the parts of a zip file stand in it as they are.
    detect: |bytes| bytes.starts_with(b"PK\x03\x04") && bytes.windows(6).any(|word| word == b".model"),
    content: Content::Scene {
        read,
        write: write::write,
        holds_meshes: true,
        keeps_nesting: false,
        max_bytes: u32::MAX as u64,
        has_setups: false,
    },
};

/// What is wrong that has no help of its own.
const HELP: &str = "the file may be damaged: copy it or export the model again";

/// The most model parts that a package may have.
const MAX_PARTS: usize = 10_000;

/// The model parts of a package: their paths, texts, notes and contents.
#[derive(Default)]
struct Parts {
    paths: Vec<String>,
    /// The numbers of the parts by their paths, without a slash at the beginning.
    numbers: HashMap<String, usize>,
    texts: Vec<String>,
    notes: Vec<Notes>,
    models: Vec<Model>,
}

fn read(path: &Path, bytes: Vec<u8>, meshes: MeshSource) -> Result<Document, ReadError> {
    let options = match meshes {
        MeshSource::Files { options, .. } => options.clone(),
        MeshSource::Given(_) => ReadOptions::default(),
    };
    let refuse = |diagnostic: RawDiagnostic| ReadError::new(Some(path), &[], diagnostic.or_help(HELP).into());
    let mut package = Package::open(&bytes).map_err(refuse)?;
    let mut parts = Parts::default();
    parts.number(&package.model().map_err(refuse)?);
    while parts.texts.len() < parts.paths.len() {
        let text = package.part(&parts.paths[parts.texts.len()]).map_err(refuse)?;
        if let Err(fault) = parts.read(text) {
            return Err(parts.error(path, fault));
        }
    }
    let Parts { models, notes, .. } = &mut parts;
    let mut builder = Builder::new(models, &options);
    let built = builder.build(notes);
    let Builder { scene, spans, parts: part_of, .. } = builder;
    if let Err(fault) = built {
        return Err(parts.error(path, fault));
    }
    if scene.objects.is_empty() {
        let message = "the model builds no object";
        return Err(refuse(
            RawDiagnostic::file(message).help("add an <item> for each object to its <build>"),
        ));
    }
    let mut found = Vec::new();
    for (number, notes) in std::mem::take(&mut parts.notes).into_iter().enumerate() {
        let name = parts.shown(path, number).display().to_string();
        found
            .extend(notes.finish(parts.texts[number].as_bytes()).into_iter().map(|note| note.of_file(&name)));
    }
    // The first text is that of the file itself, which has none.
    let text_of = part_of.into_iter().map(|part| part + 1).collect();
    let paths: Vec<PathBuf> = (0..parts.paths.len()).map(|number| parts.shown(path, number)).collect();
    let texts = paths.into_iter().zip(parts.texts).collect();
    let source = Source::including(path, String::new(), spans, Included { texts, text_of });
    Ok(Document { scene, notes: found, source })
}

impl Parts {
    /// Reads the next model part.
    fn read(&mut self, bytes: Vec<u8>) -> Result<(), Fault> {
        let number = self.texts.len();
        let text = match as_text(&bytes).map(str::to_owned) {
            Ok(text) => text,
            Err(diagnostic) => {
                self.texts.push(String::from_utf8_lossy(&bytes).into_owned());
                return Err((number, diagnostic));
            }
        };
        let mut notes = Notes::default();
        let model = match Tree::parse(&text) {
            Ok(tree) => {
                let mut part = |path: &str| self.number(path);
                model::read(tree.root_element(), number, &mut part, &mut notes)
            }
            Err(error) => Err(syntax_error(offset_of(&text, &error), &error)),
        };
        self.texts.push(text);
        self.notes.push(notes);
        self.models.push(model.map_err(|diagnostic| (number, diagnostic))?);
        match self.paths.len() {
            0..=MAX_PARTS => Ok(()),
            count => Err((number, RawDiagnostic::file(format!("the package has {count} model parts")))),
        }
    }

    /// The number of the model part at a path, which is read later if it is new.
    fn number(&mut self, path: &str) -> usize {
        let path = path.trim_start_matches('/');
        *self.numbers.entry(path.to_owned()).or_insert_with(|| {
            self.paths.push(path.to_owned());
            self.paths.len() - 1
        })
    }

    /// What a part is called in messages: as a file in the package.
    fn shown(&self, path: &Path, number: usize) -> PathBuf {
        path.join(&self.paths[number])
    }

    fn error(&self, path: &Path, (number, diagnostic): Fault) -> ReadError {
        let shown = self.shown(path, number);
        let texts = [(path, ""), (shown.as_path(), self.texts[number].as_str())];
        ReadError::of_texts(&texts, vec![(1, diagnostic.or_help(HELP))], 0)
    }
}
