//! Input files.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

use crate::diagnostic::RawDiagnostic;
use crate::error::ReadError;

/// Returns the bytes of a regular file of limited size. Pipes and devices are refused: they could block the reader
/// forever.
pub(crate) fn read_regular(path: &Path, max: u64) -> Result<Vec<u8>, ReadError> {
    let io = |e: io::Error| ReadError::io(path, &e);
    let refuse = |diagnostic: RawDiagnostic| Err(ReadError::new(Some(path), &[], diagnostic.into()));
    let irregular = |found: &Metadata| {
        if found.is_dir() {
            RawDiagnostic::file("is a folder").help("name a file in it")
        } else {
            RawDiagnostic::file("is not a regular file").help("write to a file what a pipe or a device gives")
        }
    };
    let found = std::fs::metadata(path).map_err(io)?;
    if !found.is_file() {
        return refuse(irregular(&found));
    }
    let mut file = File::open(path).map_err(io)?;
    // Checked again on the open file, in case the path was replaced in between.
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return refuse(irregular(&metadata));
    }
    if metadata.len() > max {
        return refuse(too_large(max));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

/// The diagnostic of a file that is larger than the limit.
pub(crate) fn too_large(max: u64) -> RawDiagnostic {
    let help = "put triangles into mesh files and repeated parts into \"defs\"";
    RawDiagnostic::file(format!("is larger than {} MiB", max >> 20)).help(help)
}
