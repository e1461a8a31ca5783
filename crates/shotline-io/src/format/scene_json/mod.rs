//! Scene files: JSON with comments. See `docs/scene-format.md`.

mod appearance;
mod duplicates;
mod keys;
mod lattices;
mod mesh_files;
mod motions;
mod names;
mod nodes;
mod placement;
mod schema;
mod values;
mod write;

use std::path::Path;

use shotline::scene::{Scene, Units};

use self::keys::{TOP, names};
use self::mesh_files::Meshes;
use self::nodes::Graph;
pub use self::schema::scene_schema;

use self::values::Values;
pub use self::write::write_scene;
use crate::bytes::{text_start, zero_byte};
use crate::diagnostic::{Diagnostics, RawDiagnostic};
use crate::document::{Document, Source};
use crate::error::{ReadError, WriteError};
use crate::files::too_large;
use crate::format::{Content, Format, MeshSource, WrittenScene};
use crate::json::{self, ValueId};
use crate::note::Note;
use crate::paths::folder_of;

pub(crate) const FORMAT: Format = Format {
    name: "scene",
    extensions: &["json", "jsonc"],
    detect: |bytes| {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
        text.starts_with(b"{") || text.starts_with(b"//") || text.starts_with(b"/*")
    },
    content: Content::Scene {
        read,
        write,
        holds_meshes: false,
        keeps_nesting: true,
        max_bytes: MAX_BYTES,
        has_setups: false,
    },
};

/// The largest scene file that is read, in bytes.
const MAX_BYTES: u64 = 256 << 20;

fn write(_: &Path, scene: &Scene) -> Result<WrittenScene, WriteError> {
    Ok(WrittenScene { bytes: write_scene(scene)?.into_bytes(), notes: Vec::new() })
}

/// Reads the bytes of a scene file.
fn read(path: &Path, bytes: Vec<u8>, meshes: MeshSource) -> Result<Document, ReadError> {
    if let Err(diagnostic) = text_start(&bytes) {
        return Err(ReadError::new(Some(path), &bytes, diagnostic.into()));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let diagnostic = RawDiagnostic::text(at..at + 1, "the text is not UTF-8 from here on")
                .help("save the file as UTF-8");
            return Err(ReadError::new(Some(path), error.as_bytes(), diagnostic.into()));
        }
    };
    parse(text, Some(path), Some(folder_of(path)), meshes)
}

/// Reads the text of a scene; mesh files are looked up in the folder, if there is one.
pub(crate) fn parse(
    text: String,
    path: Option<&Path>,
    folder: Option<&Path>,
    meshes: MeshSource,
) -> Result<Document, ReadError> {
    let mut diagnostics = Diagnostics::default();
    let document = document(&text, Meshes::of(folder, meshes), &mut diagnostics);
    match document {
        Some((scene, spans, mut notes)) if diagnostics.is_empty() => {
            let file = path.map(|path| path.display().to_string());
            let duplicates = duplicates::duplicate_names(&scene, &spans, &text).into_iter();
            notes.extend(duplicates.map(|note| Note { file: file.clone(), ..note }));
            Ok(Document { scene, notes, source: Source::text_of(path, text, spans, find_param) })
        }
        _ => Err(ReadError::new(path, text.as_bytes(), diagnostics)),
    }
}

/// A scene, the bytes of each node, and notes.
type Parsed = (Scene, Vec<std::ops::Range<usize>>, Vec<Note>);

fn document(text: &str, meshes: Meshes, diagnostics: &mut Diagnostics) -> Option<Parsed> {
    // The limit applies to files only; offsets in the text have 32 bits.
    let max = if let Meshes::Given(_) = meshes { u32::MAX.into() } else { MAX_BYTES };
    if text.len() as u64 > max {
        diagnostics.push(too_large(max));
        return None;
    }
    if let Some(at) = text.find('\0') {
        diagnostics.push(zero_byte(at));
        return None;
    }
    let (tree, root) = json::parse(text, diagnostics)?;
    let mut values = Values { tree: &tree, diagnostics };
    values.object(root, "a scene")?;
    values.only(root, "a scene", &names(TOP).collect::<Vec<_>>());
    check_version(&mut values, root);
    let get = |key: &str| tree.get(root, key);
    let units = get("units").and_then(|at| read_units(&mut values, at));
    let materials =
        get("materials").map(|at| appearance::read_materials(&mut values, at)).unwrap_or_default();
    let camera = get("camera").and_then(|at| appearance::read_camera(&mut values, at));
    let lights = get("lights").map(|at| appearance::read_lights(&mut values, at)).unwrap_or_default();
    let motions = get("motions").map(|at| motions::read(&mut values, at)).unwrap_or_default();
    let accel = values.accel(root);
    let mut graph = Graph::new(values, meshes, materials);
    graph.read(get("defs"), get("objects"));
    let Graph { mut scene, spans, meshes, mut values, .. } = graph;
    motions::check(&mut values, &motions, &scene);
    (scene.units, scene.camera, scene.lights) = (units, camera, lights);
    scene.accel = accel;
    scene.motions = motions.into_iter().map(|(motion, _)| motion).collect();
    Some((scene, spans, meshes.into_notes()))
}

/// The unit of length; `None` for a scene without one.
fn read_units(values: &mut Values, at: ValueId) -> Option<Units> {
    let written = values.text(at, "\"units\"")?;
    let known = Units::ALL.iter().find(|(name, _)| name == written);
    if known.is_none() && written != Units::NONE {
        let names = Units::ALL.iter().map(|(name, _)| *name).chain([Units::NONE]);
        let help = values.hint(written, names);
        values.report(at, format!("'{written}' is not a unit of length"), help);
    }
    known.map(|(_, units)| *units)
}

fn check_version(values: &mut Values, root: ValueId) {
    let Some(at) = values.tree.get(root, "shotline") else {
        values.report_at_start(
            root,
            "the scene lacks \"shotline\": 1",
            "add \"shotline\": 1, the version of the format",
        );
        return;
    };
    if let Some(version) = values.number(at, "\"shotline\"").filter(|v| *v != 1.0) {
        let help = "this program reads version 1; a newer one may read this file";
        values.report(at, format!("the file is written for version {version} of the format"), help);
    }
}

/// The bytes of a parameter of a node, found by parsing the text of the node again: errors are rare, and storing the
/// range of every parameter would take more memory than the scene.
fn find_param(node: &str, param: &str) -> Option<std::ops::Range<usize>> {
    let mut ignored = Diagnostics::default();
    let (tree, root) = json::parse(node, &mut ignored)?;
    tree.get(root, param).map(|at| tree.range(at))
}
