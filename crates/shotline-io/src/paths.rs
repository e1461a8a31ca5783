//! The paths of the files that another file names.

use std::path::{Path, PathBuf};

use crate::error::os_error_message;
use crate::options::PathPolicy;

/// Why a file that another file names is refused.
#[derive(Clone, Debug)]
pub(crate) struct Refusal {
    pub(crate) why: String,
    pub(crate) help: String,
}

impl Refusal {
    pub(crate) fn new(why: impl Into<String>, help: impl Into<String>) -> Refusal {
        Refusal { why: why.into(), help: help.into() }
    }
}

/// The path of a file that a file in a folder names, links resolved, if the path policy allows it: it must lie in the folder
/// of the whole scene.
pub(crate) fn resolve(
    folder: &Path,
    scene_folder: &Path,
    file: &str,
    policy: PathPolicy,
) -> Result<PathBuf, Refusal> {
    const INSIDE: &str = "copy it into the folder of the scene and name it relative to that; \
                          or, if you trust the scene, allow it with --allow-outside (in Python allow_outside=True)";
    let confined = policy == PathPolicy::SceneFolder;
    let drive = file.as_bytes().get(1) == Some(&b':') && file.as_bytes()[0].is_ascii_alphabetic();
    if confined && (drive || file.starts_with(['/', '\\']) || Path::new(file).is_absolute()) {
        return Err(Refusal::new("the path of this file is absolute", INSIDE));
    }
    match scene_folder.canonicalize().and_then(|f| Ok((folder.join(file).canonicalize()?, f))) {
        Err(error) => {
            let why = format!("'{file}' cannot be opened: {}", os_error_message(&error));
            Err(Refusal::new(why, "paths are relative to the file that names them"))
        }
        Ok((path, scene_folder)) if confined && !path.starts_with(&scene_folder) => {
            Err(Refusal::new("this file lies outside of the scene's folder", INSIDE))
        }
        Ok((path, _)) => Ok(path),
    }
}

/// The folder of a file. `Path::parent` of a bare file name is the empty path, which cannot be opened.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
