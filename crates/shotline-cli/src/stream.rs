//! Standard input and output as paths: `-` on the command line.

use std::path::Path;

/// The name of standard input in messages and in paths that name an object.
pub const STDIN: &str = "stdin";

/// The name of an input in messages.
pub fn name_of(path: &Path) -> String {
    if is_stream(path) { STDIN.into() } else { path.display().to_string() }
}

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}
