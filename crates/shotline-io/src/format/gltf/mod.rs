//! glTF 2.0 and GLB: the scenes of meshes that modelling programs and the web exchange. See `docs/gltf.md`.
//!
//! This crate has its own reader: the accessors of the library `gltf` can panic on bad files, and its errors have no
//! positions.

mod accessors;
mod appearance;
mod base64;
mod buffers;
mod color;
mod container;
mod extensions;
mod fields;
mod meshes;
mod nodes;
mod primitives;
mod transforms;
mod write;

use std::ops::Range;
use std::path::{Path, PathBuf};

use shotline::scene::{Material, Scene, Units};

use self::accessors::Accessors;
use self::appearance::Lights;
use self::buffers::Buffers;
use self::container::{Container, MAGIC, parts};
use self::fields::{Field, Read};
use self::meshes::Meshes;
use crate::bytes::as_text;
use crate::diagnostic::{Diagnostics, RawDiagnostic};
use crate::document::{Document, Included, Source};
use crate::error::ReadError;
use crate::format::{Content, Format, MeshSource};
use crate::json;
use crate::location::RawLocation;
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::options::ReadOptions;
use crate::paths::folder_of;
use crate::unique_names::UniqueNames;

pub(crate) const FORMAT: Format = Format {
    name: "glTF",
    extensions: &["gltf", "glb"],
    detect: |bytes| bytes.starts_with(MAGIC) || is_gltf_text(bytes),
    content: Content::Scene {
        read,
        write: write::write,
        holds_meshes: true,
        keeps_nesting: false,
        max_bytes: u32::MAX as u64,
        has_setups: true,
    },
};

/// Whether some bytes are JSON with the key that every glTF file has, and without the key of a scene file.
fn is_gltf_text(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let holds = |word: &[u8]| text.windows(word.len()).any(|part| part == word);
    text.starts_with(b"{") && holds(b"\"asset\"") && !holds(b"\"shotline\"")
}

const ANIMATIONS: NoteKind = NoteKind {
    name: "animations",
    effect: Effect::Kept,
    one: "1 animation was not read; everything is at rest",
    many: "# animations were not read; everything is at rest",
};

/// What is wrong that has no help of its own.
const HELP: &str = "the file may be damaged: copy it or export the scene again";

/// A file while it is read.
struct Reader<'o, 'j, 'b> {
    root: Field<'j>,
    options: &'o ReadOptions,
    accessors: Accessors<'j, 'b>,
    materials: Vec<(String, Material)>,
    meshes: Meshes,
    lights: Lights,
    names: UniqueNames,
    scene: Scene,
    /// The part of the text that each node of the scene comes from.
    spans: Vec<Range<usize>>,
    notes: Notes,
}

fn read(path: &Path, bytes: Vec<u8>, meshes: MeshSource) -> Result<Document, ReadError> {
    let options = match meshes {
        MeshSource::Files { options, .. } => options.clone(),
        MeshSource::Given(_) => ReadOptions::default(),
    };
    let mut notes = Notes::default();
    let refuse = |bytes: &[u8], diagnostic: RawDiagnostic| {
        ReadError::new(Some(path), bytes, diagnostic.or_help(HELP).into())
    };
    let Container { json, bin } = parts(&bytes, &mut notes).map_err(|error| refuse(&[], error))?;
    let text_bytes = &bytes[json];
    let text = as_text(text_bytes).map_err(|error| refuse(text_bytes, error))?;
    let mut diagnostics = Diagnostics::default();
    let tree = json::parse(text, &mut diagnostics);
    let Some((tree, root)) = tree.filter(|_| diagnostics.is_empty()) else {
        return Err(ReadError::new(Some(path), text_bytes, with_help(diagnostics)));
    };
    let bin = bin.map(|range| &bytes[range]);
    let read = read_root(Field::new(&tree, root), bin, folder_of(path), &options, text.len(), notes);
    let (scene, spans, notes, files) = read.map_err(|error| refuse(text_bytes, error))?;
    let name = path.display().to_string();
    let notes = notes.finish(text_bytes).into_iter().map(|note: Note| note.of_file(&name)).collect();
    let source = Source::including(path, text.to_owned(), spans, Included::default()).with_files(files);
    Ok(Document { scene, notes, source })
}

fn with_help(diagnostics: Diagnostics) -> Diagnostics {
    let listed = diagnostics.listed.into_iter().map(|diagnostic| diagnostic.or_help(HELP)).collect();
    Diagnostics { listed, ..diagnostics }
}

/// A scene, the bytes of each node, notes, and the files of buffers.
type RootContent = (Scene, Vec<Range<usize>>, Notes, Vec<PathBuf>);

fn read_root(
    root: Field,
    bin: Option<&[u8]>,
    folder: &Path,
    options: &ReadOptions,
    text_bytes: usize,
    mut notes: Notes,
) -> Read<RootContent> {
    check_version(root)?;
    extensions::check(root, &mut notes)?;
    let animations = root.list("animations")?;
    notes.add_many(&ANIMATIONS, animations.len(), RawLocation::File);
    let materials = appearance::materials(root.list("materials")?, &mut notes)?;
    let buffers = Buffers::read(root.list("buffers")?, bin, folder, options.paths)?;
    let files = buffers.files.clone();
    let mut reader = Reader {
        root,
        options,
        accessors: Accessors::new(root, buffers, text_bytes)?,
        materials,
        meshes: Meshes::default(),
        lights: Lights::default(),
        names: UniqueNames::default(),
        scene: Scene { units: Some(Units::Metres), ..Scene::default() },
        spans: Vec::new(),
        notes,
    };
    reader.scene()?;
    let Reader { materials, lights, mut scene, spans, mut notes, .. } = reader;
    if scene.objects.is_empty() {
        let message = "the scene has no mesh with triangles";
        return Err(RawDiagnostic::file(message).help("export it with its meshes"));
    }
    scene.materials = materials;
    scene.lights = lights.finish(&mut notes);
    Ok((scene, spans, notes, files))
}

fn check_version(root: Field) -> Read<()> {
    let asset = root.required("asset", "the file")?;
    let field = match asset.get("minVersion") {
        Some(least) => least,
        None => asset.required("version", "\"asset\"")?,
    };
    let version = field.text("the version of glTF")?;
    let is_read = match asset.get("minVersion") {
        Some(_) => version == "2.0",
        None => version.starts_with("2."),
    };
    if is_read {
        return Ok(());
    }
    Err(field
        .error(format!("this is version {version} of glTF"))
        .help("only version 2.0 is read; convert it"))
}
