//! What a command looks at: models and rays, with messages that name the file.

use std::path::Path;

use shotline::compile::{self, World};
use shotline_io::Document;

use crate::args::{Build, Model};
use crate::failure::Failure;
use crate::rays::{OnInvalid, Rays};

/// Reads a scene, or a mesh as a scene of one object.
///
/// # Errors
/// If it cannot be read; the message lists everything that is wrong.
pub fn load(model: &Model) -> Result<Document, Failure> {
    shotline_io::load_with(&model.path, model.reach()).map_err(|e| Failure::new(e.to_string()))
}

/// Checks and builds what has been read.
///
/// # Errors
/// Everything that is wrong, with the places in the file.
pub fn compile(document: &Document, build: &Build) -> Result<World, Failure> {
    compile::compile(&document.scene, build.options())
        .map_err(|errors| Failure::new(document.explain(&errors).to_string()))
}

/// Reads and checks rays.
///
/// # Errors
/// If the file is not an array of rays, or a row is none and such rows are errors.
pub fn rays(path: &Path, on_invalid: OnInvalid) -> Result<Rays, Failure> {
    let rows = shotline_io::arrays::read_rays(path).map_err(|e| Failure::new(e.to_string()))?;
    Rays::new(&rows, on_invalid).map_err(|bad| {
        let numbers = bad.numbers.map(|x| x.to_string()).join(", ");
        let help = "mend the row, or count such rows as misses with --on-invalid miss";
        Failure::of_file(path, format!("row {} is no ray: {}: [{numbers}]\nhelp: {help}", bad.row, bad.why))
    })
}
