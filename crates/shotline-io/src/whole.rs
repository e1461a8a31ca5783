//! Output files that appear whole or not at all: written beside their place and then moved into it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::error::WriteError;

/// What a file is written through.
pub type Output<'f> = BufWriter<&'f File>;

/// Writes a file. If `fill` fails or the program ends, whatever stood at the path before stands there still.
///
/// # Errors
/// [`WriteError::Io`] if the system refuses or `fill` fails.
pub fn write_whole(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), WriteError> {
    write(path, fill).map_err(|source| WriteError::Io { path: path.into(), source })
}

fn write(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    // A link stays a link: what it points to is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    if fs::metadata(&target).is_ok_and(|m| !m.is_file()) {
        // A device or a pipe cannot be replaced, only written to.
        return through(&OpenOptions::new().write(true).open(&target)?, fill);
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".shotline-");
    #[cfg(unix)]
    {
        // Temporary files are private; an output file is as open as the user's mask says.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    through(file.as_file(), fill)?;
    file.persist(&target).map_err(|e| e.error)?;
    Ok(())
}

fn through(file: &File, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 18, file);
    fill(&mut out)?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, |out| out.write_all(b"first")).unwrap();
        let failed = write_whole(&path, |out| {
            out.write_all(b"second")?;
            Err(io::Error::other("no more"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("a.txt: cannot be written: no more"));
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let path = tempfile::tempdir().unwrap().path().join("none/a.txt");
        assert!(write_whole(&path, |_| Ok(())).is_err());
    }
}
