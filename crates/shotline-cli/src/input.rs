//! What a command looks at: models and rays, with messages that name the file.

use std::fmt::Display;
use std::path::Path;

use shotline::compile::{self, World};
use shotline::ray::Ray;
use shotline_io::Document;
use shotline_render::view;

use crate::args::{Build, Model};
use crate::failure::Failure;
use crate::rays::{NoRays, OnInvalid, Rays};

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
    Rays::new(&rows, on_invalid).map_err(|error| match error {
        NoRays::BadRow(bad) => {
            let numbers = bad.numbers.map(|x| x.to_string()).join(", ");
            let help = "mend the row, or count such rows as misses with --on-invalid miss";
            let message = format!("row {} is no ray: {}: [{numbers}]\nhelp: {help}", bad.row, bad.why);
            Failure::of_file(path, message)
        }
        NoRays::OutOfMemory => {
            Failure::of_file(path, "there is not enough memory for the rays\nhelp: cast fewer at a time")
        }
    })
}

/// Reads rays that must all be valid.
///
/// # Errors
/// As [`rays`].
pub fn valid_rays(path: &Path) -> Result<Vec<Ray>, Failure> {
    rays(path, OnInvalid::Error).map(|rays| rays.valid)
}

/// The size of the picture whose rays are cast where none are given.
pub const PICTURE: (u32, u32) = (320, 240);

/// The rays of a picture of the model, scattered over it, so that the first of them are like all of them.
///
/// # Errors
/// If there is nothing to look at.
pub fn rays_of_picture(model: &Model, document: &Document, world: &World) -> Result<Vec<Ray>, Failure> {
    let failure = |error: &dyn Display| Failure::of_file(&model.path, error);
    let (width, height) = PICTURE;
    let view = view(world, &document.scene, width, height).map_err(|e| failure(&e))?;
    let pixels = width * height;
    (0..pixels)
        .map(|i| i * 7919 % pixels)
        .map(|i| view.ray(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5))
        .collect::<Result<_, _>>()
        .map_err(|e| failure(&e))
}
