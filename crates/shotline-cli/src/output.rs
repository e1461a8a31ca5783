//! The output of commands: files that are written atomically, and text on stdout.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use shotline_io::{Output, WriteError, atomic_write, os_error_message, write_stream};

use crate::failure::Failure;
use crate::stream::is_stream;

/// The file name extensions of pictures.
pub const PICTURE: &[&str] = &["png", "apng", "jpg", "jpeg"];

/// The file name extensions of arrays.
pub const ARRAYS: &[&str] = &["npz", "csv"];

/// The file name extensions of slices.
pub const SLICE: &[&str] = &["png", "jpg", "jpeg", "svg", "npz"];

/// Checks that a file can be written, before long work is done for it. `-` is standard output.
///
/// # Errors
/// If the path is a folder, if its folder does not exist, if its extension is that of another kind of file, or if it is
/// one of the inputs under any name.
pub fn expect_writable(path: &Path, extensions: &[&str], inputs: &[PathBuf]) -> Result<(), Failure> {
    let refuse = |why: &str| Err(Failure::of_file(path, format!("cannot be written: {why}")));
    if is_stream(path) {
        return if [PICTURE, ARRAYS, SLICE].contains(&extensions) { expect_no_terminal() } else { Ok(()) };
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if path.is_dir() {
        return refuse("it is a folder\nhelp: name a file in it");
    }
    if folder.is_some_and(|folder| !folder.is_dir()) {
        return refuse("there is no such folder\nhelp: make the folder first");
    }
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    if let Some(extension) =
        extension.filter(|extension| !extensions.is_empty() && !extensions.contains(&extension.as_str()))
    {
        let known: Vec<String> = extensions.iter().map(|known| format!(".{known}")).collect();
        return refuse(&format!(
            "the format is {}, not .{extension}\nhelp: use the extension {}",
            known.join(" or "),
            known.join(" or ")
        ));
    }
    expect_not_an_input(path, inputs)
}

/// Checks that a file is not one of those that are read, under any name.
///
/// # Errors
/// If it is.
pub fn expect_not_an_input(path: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    match inputs.iter().find(|input| !is_stream(path) && is_same_file(path, input)) {
        None => Ok(()),
        Some(input) => {
            let why = format!("it is the input {}\nhelp: write to another file", input.display());
            Err(Failure::of_file(path, format!("cannot be written: {why}")))
        }
    }
}

/// Whether two paths lead to one regular file, also by hard or symbolic links. A file that does not exist is not the same.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let (Ok(of_a), Ok(of_b)) = (a.metadata(), b.metadata()) else { return false };
    #[cfg(unix)]
    let same = {
        use std::os::unix::fs::MetadataExt;
        (of_a.dev(), of_a.ino()) == (of_b.dev(), of_b.ino())
    };
    #[cfg(not(unix))]
    let same = matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    same && of_a.is_file() && of_b.is_file()
}

fn expect_no_terminal() -> Result<(), Failure> {
    if io::stdout().is_terminal() {
        let why = "stdout is a terminal, which cannot show this\nhelp: name a file with -o, or use a pipe";
        return Err(Failure::new(why));
    }
    Ok(())
}

/// Writes a file atomically; `-` is standard output.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    fill(path, |file| file.write_all(bytes))
}

/// Writes a file as [`write()`] does, but lets a function write it piece by piece.
///
/// # Errors
/// If it cannot be written.
pub fn fill(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), Failure> {
    if !is_stream(path) {
        return written(atomic_write(path, fill));
    }
    match write_stream(&mut io::stdout().lock(), fill) {
        // A reader that stops early is not an error.
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("stdout cannot be written: {}", os_error_message(&e))))
        }
        _ => Ok(()),
    }
}

/// Converts the error of a write.
///
/// # Errors
/// If the write has failed.
pub fn written(result: Result<(), WriteError>) -> Result<(), Failure> {
    result.map_err(|e| Failure::new(e.to_string()))
}

/// Prints text that accompanies an output: to stdout, or to stderr if the output itself goes to stdout.
///
/// # Errors
/// As [`print()`].
pub fn print_with(output: &Path, text: &str) -> Result<(), Failure> {
    if is_stream(output) {
        eprint!("{text}");
        return Ok(());
    }
    print(text)
}

/// Prints to stdout. A reader that closes the pipe early is not an error. Names can come from any file: control characters, which
/// a terminal would execute, are replaced.
///
/// # Errors
/// If stdout cannot be written for another reason.
pub fn print(text: &str) -> Result<(), Failure> {
    let is_control = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    let text = text.replace(is_control, "\u{FFFD}");
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("stdout cannot be written: {}", os_error_message(&e))))
        }
        _ => Ok(()),
    }
}
