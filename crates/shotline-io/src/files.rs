//! Input files.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

use crate::error::ReadError;
use crate::fault::Fault;

/// The bytes of a regular file of limited size: a pipe or a device could keep the reader waiting for ever.
pub(crate) fn read_regular(path: &Path, most: u64) -> Result<Vec<u8>, ReadError> {
    let io = |e: io::Error| ReadError::io(path, &e);
    let refuse = |fault: Fault| Err(ReadError::new(Some(path), &[], fault.into()));
    let irregular = |found: &Metadata| {
        if found.is_dir() {
            Fault::file("is a folder").help("name a file in it")
        } else {
            Fault::file("is not a regular file").help("write to a file what a pipe or a device gives")
        }
    };
    let found = std::fs::metadata(path).map_err(io)?;
    if !found.is_file() {
        return refuse(irregular(&found));
    }
    let mut file = File::open(path).map_err(io)?;
    // Asked again of what was opened, in case it was exchanged in between.
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return refuse(irregular(&metadata));
    }
    if metadata.len() > most {
        return refuse(too_large(most));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

/// What is wrong with a file of more bytes than are read.
pub(crate) fn too_large(most: u64) -> Fault {
    let help = "put triangles into mesh files and repeated parts into \"defs\"";
    Fault::file(format!("is larger than {} MiB", most >> 20)).help(help)
}
