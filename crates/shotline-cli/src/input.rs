//! The input of commands: models and rays, with messages that name the file.

use std::fmt::Display;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use shotline::accel::DEFAULT;
use shotline::compile::{self, World};
use shotline::ray::Ray;
use shotline::scene::Node;
use shotline::solid::mesh::{MeshSolid, TriangleMesh};
use shotline_io::{Document, Effect, os_error_message};
use shotline_render::view;

use crate::failure::Failure;
use crate::flags::{Build, Model};
use crate::progress::{self, Quiet};
use crate::rays::{OnInvalid, Rays, RaysError};
use crate::stream::{STDIN, is_stream};

fn read_stream() -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    match io::stdin().lock().read_to_end(&mut bytes) {
        Ok(_) => Ok(bytes),
        Err(e) => Err(Failure::new(format!("{STDIN} cannot be read: {}", os_error_message(&e)))),
    }
}

/// Reads a scene, or a mesh as a scene of one object; `-` is standard input.
///
/// # Errors
/// If it cannot be read; the message lists everything that is wrong.
pub fn load(model: &Model) -> Result<Document, Failure> {
    let document = if is_stream(&model.path) {
        shotline_io::load_bytes(Path::new(STDIN), read_stream()?, model.options())
    } else {
        shotline_io::load_with(&model.path, model.options())
    };
    document.map_err(|e| Failure::new(e.to_string()))
}

/// The paths of the files that a scene was read from, besides its own: those that it names, which are relative to the folder of
/// the scene file, and what these include.
pub fn named_files(model: &Model, document: &Document) -> Vec<PathBuf> {
    let folder = model.path.parent().unwrap_or(Path::new(""));
    let file = |node: &Node| match node {
        Node::Mesh { file, .. } => file.as_ref().map(|file| folder.join(&file.name)),
        _ => None,
    };
    let meshes = document.scene.nodes.iter().filter_map(file);
    meshes.chain(document.source.files().map(Path::to_path_buf)).collect()
}

/// Checks that at most one of two inputs is standard input.
///
/// # Errors
/// If both are.
pub fn expect_one_stream(model: &Model, rays: &Path) -> Result<(), Failure> {
    if is_stream(&model.path) && is_stream(rays) {
        let why = format!("the scene and the rays cannot both be {STDIN}\nhelp: name a file for one of them");
        return Err(Failure::new(why));
    }
    Ok(())
}

/// Reads as [`load`] does, and reports on stderr what the readers dropped or repaired.
///
/// # Errors
/// As [`load`].
pub fn load_with_notes(model: &Model, quiet: Quiet) -> Result<Document, Failure> {
    let document = load(model)?;
    for note in document.notes.iter().filter(|note| note.effect == Effect::Changed) {
        progress::note(&note.to_string(), quiet);
    }
    Ok(document)
}

/// Reports on stderr the meshes that no ray can hit, because their faces cancel: a picture of them is empty.
pub fn note_meshes_never_hit(document: &Document, quiet: Quiet) {
    for node in &document.scene.nodes {
        let Node::Mesh { mesh, file } = node else { continue };
        if !has_no_volume(mesh) {
            continue;
        }
        let winding = MeshSolid::new(mesh.clone(), DEFAULT).ok().and_then(|solid| solid.winding());
        if winding.is_some_and(|winding| !winding.can_be_hit) {
            let file = file.as_ref().map_or("mesh", |file| &file.name);
            let why = "every face cancels with coincident faces of the opposite orientation";
            progress::note(&format!("{file}: nothing of it can ever be hit: {why}"), quiet);
        }
    }
}

/// Whether the signed volume is zero within rounding: a cheap test before the winding numbers are computed.
fn has_no_volume(mesh: &TriangleMesh) -> bool {
    let count = mesh.vertices.len() as u32;
    let Some(apex) = mesh.faces.first().and_then(|face| mesh.vertices.get(face[0] as usize)) else {
        return false;
    };
    let (mut sum, mut size) = (0.0, 0.0);
    for face in mesh.faces.iter().filter(|face| face.iter().all(|v| *v < count)) {
        let [a, b, c] = face.map(|v| mesh.vertices[v as usize] - *apex);
        let volume = a.dot(b.cross(c));
        (sum, size) = (sum + volume, size + volume.abs());
    }
    f64::abs(sum) <= 1e-9 * size
}

/// Checks a document and compiles its scene.
///
/// # Errors
/// All errors, with their locations in the file.
pub fn compile(document: &Document, build: &Build) -> Result<World, Failure> {
    compile::compile(&document.scene, build.options())
        .map_err(|errors| Failure::new(document.diagnostics(&errors).to_string()))
}

/// Reads and checks rays; `-` is standard input.
///
/// # Errors
/// If the file is not an array of rays, or if a row is not a valid ray and such rows are errors.
pub fn rays(path: &Path, on_invalid: OnInvalid) -> Result<Rays, Failure> {
    checked_rays(path, on_invalid, "correct the row, or count such rows as misses with --on-invalid miss")
}

/// Reads rays that must all be valid.
///
/// # Errors
/// As [`rays`].
pub fn valid_rays(path: &Path) -> Result<Vec<Ray>, Failure> {
    checked_rays(path, OnInvalid::Error, "correct the row or remove it").map(|rays| rays.valid)
}

/// Reads rays; `help` says what to do about a row that is not a valid ray.
fn checked_rays(path: &Path, on_invalid: OnInvalid, help: &str) -> Result<Rays, Failure> {
    let rows = if is_stream(path) {
        shotline_io::arrays::parse_rays(&read_stream()?).map_err(|e| Failure::new(format!("{STDIN}: {e}")))?
    } else {
        shotline_io::arrays::read_rays(path).map_err(|e| Failure::new(e.to_string()))?
    };
    Rays::new(&rows, on_invalid).map_err(|error| match error {
        RaysError::InvalidRow(invalid) => {
            let numbers = invalid.numbers.map(|x| x.to_string()).join(", ");
            let message =
                format!("row {} is not a valid ray: {}: [{numbers}]\nhelp: {help}", invalid.row, invalid.why);
            Failure::of_input(path, message)
        }
        RaysError::OutOfMemory => {
            Failure::of_input(path, "there is not enough memory for the rays\nhelp: cast fewer at a time")
        }
    })
}

/// The size of the picture whose rays are cast if no rays are given.
pub const PICTURE: (u32, u32) = (320, 240);

/// The rays through the middles of the pixels of a picture, row by row from the top.
///
/// # Errors
/// If there is nothing to frame.
pub fn rays_of_pixels(
    model: &Model,
    document: &Document,
    world: &World,
    (width, height): (u32, u32),
) -> Result<Vec<Ray>, Failure> {
    let failure = |error: &dyn Display| Failure::of_input(&model.path, error);
    let view = view(world, &document.scene, width, height).map_err(|e| failure(&e))?;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    pixels.map(|(x, y)| view.ray(x, y)).collect::<Result<_, _>>().map_err(|e| failure(&e))
}

/// The rays of a picture of the model in scattered order, so that the first n are representative of all.
///
/// # Errors
/// If there is nothing to frame.
pub fn rays_of_picture(model: &Model, document: &Document, world: &World) -> Result<Vec<Ray>, Failure> {
    let failure = |error: &dyn Display| Failure::of_input(&model.path, error);
    let (width, height) = PICTURE;
    let view = view(world, &document.scene, width, height).map_err(|e| failure(&e))?;
    let pixels = width * height;
    (0..pixels)
        .map(|i| i * 7919 % pixels)
        .map(|i| view.ray(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5))
        .collect::<Result<_, _>>()
        .map_err(|e| failure(&e))
}
