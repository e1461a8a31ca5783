//! The files of materials that a mesh file names.

use std::collections::HashMap;
use std::path::Path;

use shotline::scene::Material;

use crate::error::ReadError;
use crate::files::read_regular;
use crate::format::obj::read_materials;
use crate::note::{Effect, Note};
use crate::options::PathPolicy;
use crate::paths::{folder_of, resolve};

/// The largest file of materials that is read, in bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The materials of the files that a mesh file names, by name, and a note of each file that cannot be read: no shape depends on
/// it.
pub(crate) fn materials_of(
    path: &Path,
    files: &[String],
    policy: PathPolicy,
) -> (HashMap<String, Material>, Vec<Note>) {
    let (mut materials, mut notes) = (HashMap::new(), Vec::new());
    for file in files {
        match read(path, file, policy) {
            // Of two materials of one name the first counts.
            Ok(found) => found.into_iter().rev().for_each(|(name, material)| {
                materials.insert(name, material);
            }),
            Err(why) => {
                let text = format!("the materials of '{file}' were not read: {why}");
                notes.push(Note::new("materials_not_read", Effect::Kept, 1, text));
            }
        }
    }
    (materials, notes)
}

fn read(path: &Path, file: &str, policy: PathPolicy) -> Result<Vec<(String, Material)>, String> {
    let folder = folder_of(path);
    let path = resolve(folder, folder, file, policy).map_err(|refusal| refusal.why)?;
    let brief = |error: ReadError| error.brief(file);
    let bytes = read_regular(&path, MAX_BYTES).map_err(brief)?;
    let found = read_materials(&bytes);
    found.map_err(|diagnostic| brief(ReadError::new(Some(&path), &bytes, diagnostic.into())))
}
