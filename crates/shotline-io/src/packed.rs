//! Scenes as a text and arrays, to be kept in memory or sent to another process.

use std::collections::HashMap;
use std::sync::Arc;

use shotline::scene::{MeshFile, Node, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::document::Document;
use crate::error::{ReadError, WriteError};
use crate::format::MeshSource;
use crate::format::scene_json::{parse, write_scene};

/// A scene as the text of a scene file, and the meshes, which it names by their index: `"file": "0"` is the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// The text.
    pub text: String,
    /// The meshes.
    pub meshes: Vec<Arc<TriangleMesh>>,
}

/// Packs a scene. The unpacked scene gives the same result for every ray, bit for bit, and packs to the same again.
/// The names of mesh files are lost, and shared nodes get names (as in a scene file), which may appear in the names of
/// paths.
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
        // The mesh is kept as it is: it has been welded already.
        *file = Some(MeshFile { name: number.to_string(), weld: None });
    }
    Ok(Packed { text: write_scene(&scene)?, meshes })
}

impl Packed {
    /// The scene, with the location of each node in the text for diagnostics.
    ///
    /// # Errors
    /// [`ReadError`] with everything that is wrong.
    pub fn unpack(self) -> Result<Document, ReadError> {
        parse(self.text, None, None, MeshSource::Given(&self.meshes))
    }
}
