//! The files of pictures: PNG or JPEG, by the extension of the name.

use std::path::Path;

use shotline_render::{Image, JpegError, encode_jpeg, encode_png};

use crate::failure::Failure;
use crate::output;
use crate::stream::is_stream;

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    Png,
    Jpeg,
}

impl PictureFormat {
    /// The format for the name of a file; PNG for standard output.
    pub fn of(path: &Path) -> PictureFormat {
        let is_jpeg = |extension: &str| ["jpg", "jpeg"].contains(&extension.to_ascii_lowercase().as_str());
        match path.extension().and_then(|extension| extension.to_str()) {
            Some(extension) if !is_stream(path) && is_jpeg(extension) => PictureFormat::Jpeg,
            _ => PictureFormat::Png,
        }
    }
}

/// Writes a picture atomically, in the format for the name of the file.
///
/// # Errors
/// If the format cannot hold the picture, or if the file cannot be written.
pub fn write(path: &Path, image: &Image) -> Result<(), Failure> {
    let bytes = match PictureFormat::of(path) {
        PictureFormat::Png => encode_png(image),
        PictureFormat::Jpeg => encode_jpeg(image).map_err(|error| failure(path, error))?,
    };
    output::write(path, &bytes)
}

/// The failure for a picture that JPEG cannot hold.
pub fn failure(path: &Path, error: JpegError) -> Failure {
    Failure::of_file(path, format!("cannot be written: {error}"))
}
