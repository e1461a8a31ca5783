//! What a command leaves behind: files that appear whole or not at all, and text on stdout.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A file in the making. It is written beside its final place under another name and renamed when it is
/// complete; dropped before that it leaves nothing.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    part: Option<PathBuf>,
    file: File,
}

impl OutputFile {
    /// Opens a file for writing. To be called before long work, so that a bad path costs no time.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn create(path: &Path) -> Result<OutputFile, Failure> {
        let failure = |e: io::Error| Failure::of_file(path, format!("cannot be written: {e}"));
        if path.is_dir() {
            return Err(Failure::of_file(path, "cannot be written: it is a folder; name a file in it"));
        }
        // A device or a pipe cannot be replaced by renaming: write into it.
        if path.exists() && !path.is_file() {
            let file = OpenOptions::new().write(true).open(path).map_err(failure)?;
            return Ok(OutputFile { path: path.into(), part: None, file });
        }
        // Through a link the file it points to is replaced, not the link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let name = path.file_name().ok_or_else(|| Failure::of_file(&path, "is not the name of a file"))?;
        let mut part_name = std::ffi::OsString::from(".");
        part_name.push(name);
        part_name.push(format!(".{}.part", std::process::id()));
        let part = path.with_file_name(part_name);
        let file = File::create(&part).map_err(failure)?;
        Ok(OutputFile { path, part: Some(part), file })
    }

    /// Writes the contents and puts the file in its place.
    ///
    /// # Errors
    /// If the contents cannot be written; nothing is left then.
    pub fn finish(mut self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
        let failure = |path: &Path, e: io::Error| Failure::of_file(path, format!("cannot be written: {e}"));
        let mut buffered = BufWriter::new(&self.file);
        write(&mut buffered).and_then(|()| buffered.flush()).map_err(|e| failure(&self.path, e))?;
        drop(buffered);
        if let Some(part) = self.part.take() {
            fs::rename(&part, &self.path).map_err(|e| {
                let _ = fs::remove_file(&part);
                failure(&self.path, e)
            })?;
        }
        Ok(())
    }
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            let _ = fs::remove_file(part);
        }
    }
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
