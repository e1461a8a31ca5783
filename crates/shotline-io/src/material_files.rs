//! The files of materials that a mesh file names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use shotline::scene::Material;

use crate::error::ReadError;
use crate::files::read_regular;
use crate::format::obj::read_materials;
use crate::note::{Effect, Note};
use crate::options::PathPolicy;
use crate::paths::{folder_of, resolve};

/// The largest file of materials that is read, in bytes.
const MAX_BYTES: u64 = 64 << 20;

/// What the files of materials say.
#[derive(Default)]
pub(crate) struct NamedMaterials {
    /// The materials by name.
    pub(crate) materials: HashMap<String, Material>,
    /// A note of each file that cannot be read: no shape depends on it.
    pub(crate) notes: Vec<Note>,
    /// The files that exist, also those that cannot be read.
    pub(crate) files: Vec<PathBuf>,
}

/// The materials of the files that a mesh file names.
pub(crate) fn materials_of(path: &Path, files: &[String], policy: PathPolicy) -> NamedMaterials {
    let mut named = NamedMaterials::default();
    let folder = folder_of(path);
    for file in files {
        let path = resolve(folder, folder, file, policy).map_err(|refusal| refusal.why);
        named.files.extend(path.as_ref().ok().cloned());
        match path.and_then(|path| read(&path, file)) {
            // Of two materials of one name the first counts.
            Ok(found) => found.into_iter().rev().for_each(|(name, material)| {
                named.materials.insert(name, material);
            }),
            Err(why) => {
                let text = format!("the materials of '{file}' were not read: {why}");
                named.notes.push(Note::new("materials_not_read", Effect::Kept, 1, text));
            }
        }
    }
    named
}

fn read(path: &Path, file: &str) -> Result<Vec<(String, Material)>, String> {
    let brief = |error: ReadError| error.brief(file);
    let bytes = read_regular(path, MAX_BYTES).map_err(brief)?;
    let found = read_materials(&bytes);
    found.map_err(|diagnostic| brief(ReadError::new(Some(path), &bytes, diagnostic.into())))
}
