//! Reads files from memory and checks the result.

use std::path::Path;

use shotline_io::{Document, ReadOptions, load_bytes};

/// Reads the bytes of a file of this name.
pub fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<Document, String> {
    load_bytes(Path::new(name), bytes.as_ref().to_vec(), ReadOptions::default()).map_err(|e| e.to_string())
}

/// Reads a file that must be accepted.
#[track_caller]
pub fn ok(name: &str, bytes: impl AsRef<[u8]>) -> Document {
    read(name, &bytes).unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(bytes.as_ref())))
}

/// Reads a file that must be refused with a message that contains `why`.
#[track_caller]
pub fn refused(name: &str, bytes: impl AsRef<[u8]>, why: &str) {
    match read(name, &bytes) {
        Ok(read) => panic!("read as {read:?}"),
        Err(error) => assert!(error.contains(why), "{error}"),
    }
}
