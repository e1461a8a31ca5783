//! Atomic writes: an output file appears complete or not at all. It is written beside its path and then renamed.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::error::WriteError;

/// The buffered writer of a file.
pub type Output<'f> = BufWriter<&'f File>;

/// The longest chain of symbolic links that is followed.
const MAX_LINKS: usize = 40;

/// The temporary files that are being written.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Writes a file. If `fill` fails or the program ends, the path keeps its previous contents. A symbolic link stays a
/// link, and the file keeps its permissions; a write-protected file is not changed.
///
/// # Errors
/// [`WriteError::Io`] if the operating system refuses or `fill` fails.
pub fn atomic_write(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> Result<(), WriteError> {
    write(path, fill).map_err(|source| WriteError::Io { path: path.into(), source })
}

/// Writes to a stream, such as standard output: all at once, after `fill` has succeeded.
///
/// # Errors
/// Those of `fill` and of the stream.
pub fn write_stream(
    stream: &mut impl Write,
    fill: impl FnOnce(&mut Output) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = tempfile::tempfile()?;
    fill_file(&file, fill)?;
    file.rewind()?;
    io::copy(&mut file, stream)?;
    stream.flush()
}

/// Removes the temporary files of unfinished writes, for a program that is about to end.
pub fn remove_unfinished() {
    for path in std::mem::take(&mut *UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)) {
        // A file that is already gone need not be removed.
        let _ = fs::remove_file(path);
    }
}

fn write(path: &Path, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    let target = target_of(path)?;
    let before = fs::metadata(&target).ok();
    if before.as_ref().is_some_and(|m| !m.is_file()) {
        // A device or a pipe cannot be replaced by a file.
        return write_stream(&mut OpenOptions::new().write(true).open(&target)?, fill);
    }
    if before.as_ref().is_some_and(|m| m.permissions().readonly()) {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is write-protected"));
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::NotFound,
            "there is no such folder; make the folder first",
        ));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".shotline-");
    #[cfg(unix)]
    {
        // Temporary files are private; a new output file has the permissions of the user's umask.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    let _unfinished = Unfinished::new(file.path());
    fill_file(file.as_file(), fill)?;
    if let Some(before) = before {
        file.as_file().set_permissions(before.permissions())?;
    }
    file.persist(&target).map_err(|e| e.error)?;
    Ok(())
}

/// The path with symbolic links resolved, including links to files that do not exist yet.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let Ok(link) = fs::read_link(&target) else { return Ok(target) };
        target = target.parent().unwrap_or(Path::new("")).join(link);
    }
    Err(io::Error::other("too many links to links"))
}

fn fill_file(file: &File, fill: impl FnOnce(&mut Output) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 18, file);
    fill(&mut out)?;
    out.flush()
}

/// Registers a temporary file as unfinished for as long as the value lives.
struct Unfinished(PathBuf);

impl Unfinished {
    fn new(path: &Path) -> Unfinished {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).insert(path.into());
        Unfinished(path.into())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_previous_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        atomic_write(&path, |out| out.write_all(b"first")).unwrap();
        let failed = atomic_write(&path, |out| {
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
        let error = atomic_write(&path, |_| Ok(())).unwrap_err().to_string();
        assert!(
            error.ends_with("a.txt: cannot be written: there is no such folder; make the folder first"),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_even_if_its_target_does_not_exist_yet() {
        let folder = tempfile::tempdir().unwrap();
        let (link, target) = (folder.path().join("link"), folder.path().join("target"));
        std::os::unix::fs::symlink("target", &link).unwrap();
        for text in ["first", "second"] {
            atomic_write(&link, |out| out.write_all(text.as_bytes())).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(fs::read(&target).unwrap(), text.as_bytes());
        }
        std::os::unix::fs::symlink("round", folder.path().join("round")).unwrap();
        assert!(atomic_write(&folder.path().join("round"), |_| Ok(())).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_kept_and_protected_files_not_changed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        atomic_write(&path, |out| out.write_all(b"first")).unwrap();
        let with_mode = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        with_mode(0o600);
        atomic_write(&path, |out| out.write_all(b"second")).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        with_mode(0o444);
        let error = atomic_write(&path, |out| out.write_all(b"third")).unwrap_err().to_string();
        assert!(error.contains("write-protected"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"second");
    }
}
