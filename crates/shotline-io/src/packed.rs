//! Scenes as a text and arrays, to be kept in memory or sent somewhere: the compact form.

use std::collections::HashMap;
use std::sync::Arc;

use shotline::scene::{MeshFile, Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::document::Document;
use crate::error::{ReadError, WriteError};
use crate::format::MeshSource;
use crate::scene_json::{parse, write_scene};

/// A scene in the words of a scene file, and the meshes it names by their numbers: `"file": "0"` is the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// The text.
    pub text: String,
    /// The meshes.
    pub meshes: Vec<Arc<TriangleMesh>>,
}

/// Packs a scene. What is unpacked answers every ray as the scene does, bit for bit, and packs to the same again.
/// The names of mesh files are forgotten, and parts that are shared get names (as in a scene file), which may
/// show in the names of paths.
///
/// # Errors
/// [`WriteError::Unwritable`] for NaN and infinite numbers.
pub fn pack(scene: &Scene) -> Result<Packed, WriteError> {
    let mut scene = scene.clone();
    let mut meshes: Vec<Arc<TriangleMesh>> = Vec::new();
    let mut numbers: HashMap<*const TriangleMesh, usize> = HashMap::new();
    for node in &mut scene.nodes {
        let Node::Mesh { mesh, file } = node else { continue };
        let number = *numbers.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
            meshes.push(mesh.clone());
            meshes.len() - 1
        });
        // The mesh is kept as it is now: welding has been done.
        *file = Some(MeshFile { name: number.to_string(), weld: None });
    }
    Ok(Packed { text: write_scene(&scene)?, meshes })
}

impl Packed {
    /// The scene, with places in the text for what is wrong with it.
    ///
    /// # Errors
    /// [`ReadError`] with everything that is wrong.
    pub fn unpack(self) -> Result<Document, ReadError> {
        parse(self.text, None, None, MeshSource::Given(&self.meshes))
    }
}
