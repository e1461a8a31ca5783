//! What a command leaves behind: files that appear whole or not at all, and text on stdout.

use std::io::{self, Write};
use std::path::Path;

use shotline_io::WriteError;

use crate::failure::Failure;

/// Looks whether a file may be written, before long work is done for it.
///
/// # Errors
/// If the path is a folder or lies in none.
pub fn expect_writable(path: &Path) -> Result<(), Failure> {
    let refuse = |why: &str| Err(Failure::of_file(path, format!("cannot be written: {why}")));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if path.is_dir() {
        refuse("it is a folder\nhelp: name a file in it")
    } else if folder.is_some_and(|folder| !folder.is_dir()) {
        refuse("there is no such folder\nhelp: make the folder first")
    } else {
        Ok(())
    }
}

/// Writes a file, whole or not at all.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    written(shotline_io::write_whole(path, |file| file.write_all(bytes)))
}

/// The failure of a write.
///
/// # Errors
/// If it has failed.
pub fn written(result: Result<(), WriteError>) -> Result<(), Failure> {
    result.map_err(|e| Failure::new(e.to_string()))
}

/// Prints to stdout. A reader that has seen enough and closed the pipe is no error.
///
/// # Errors
/// If stdout cannot be written for another reason.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("stdout cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}
