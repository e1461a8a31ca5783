//! Extensions: those that a file requires must be known, others are noted.

use super::fields::{Field, Read};
use crate::note::{Effect, Note, Notes};

/// The extensions that are read.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";
const QUANTIZED: &str = "KHR_mesh_quantization";

/// The beginnings of the names of extensions that concern only how surfaces look, of which nothing but a colour is read.
const OF_SURFACES: [&str; 5] = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_xmp"];

/// The extension that places a mesh many times by a list.
const INSTANCES: &str = "EXT_mesh_gpu_instancing";

fn is_read(name: &str) -> bool {
    name == LIGHTS || name == QUANTIZED
}

fn is_of_surfaces(name: &str) -> bool {
    OF_SURFACES.iter().any(|start| name.starts_with(start))
}

/// Refuses a file that requires what is not known, and notes what it uses besides.
pub(super) fn check(root: Field, notes: &mut Notes) -> Read<()> {
    for required in root.list("extensionsRequired")?.iter() {
        let name = required.text("each of \"extensionsRequired\"")?;
        if !is_read(name) && !is_of_surfaces(name) {
            let message = format!("the file requires the extension {name}, which is not known");
            return Err(required.error(message).help("export the scene without it"));
        }
    }
    let mut unread = Vec::new();
    for used in root.list("extensionsUsed")?.iter() {
        let name = used.text("each of \"extensionsUsed\"")?;
        if !is_read(name) && !unread.contains(&name) && unread.len() < MAX_NAMED {
            unread.push(name);
        }
    }
    if !unread.is_empty() {
        let text = format!("extensions that were not read: {}", unread.join(", "));
        let effect = if unread.contains(&INSTANCES) { Effect::Changed } else { Effect::Kept };
        notes.push(Note::new("extensions_not_read", effect, unread.len(), text));
    }
    Ok(())
}

/// How many extensions are named.
const MAX_NAMED: usize = 50;
