//! Scenes to files.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use shotline::math::{Affine, ComposedTransform};
use shotline::scene::{MeshFile, Node, NodeId, Scene};
use shotline::solid::mesh::{Attribute, TriangleMesh};

use crate::append::{NORMAL, append};
use crate::atomic_write::atomic_write;
use crate::error::WriteError;
use crate::format::{
    Content, WriteScene, WrittenScene, by_extension, lossless_mesh_format, writable_extensions,
};
use crate::load::read_mesh_file;
use crate::mesh_file::Encoded;

/// Writes a scene in the format of the file name extension. Returns what was lost and which other files were written.
/// Files appear complete or not at all.
///
/// A scene file names the mesh files that lie in its folder and still hold the mesh that was read, with its welding; all
/// other meshes are written beside it as PLY, in their present state. A GDML file holds the meshes itself. A mesh file holds all meshes of the scene, with
/// their transforms applied, as one.
///
/// # Errors
/// [`WriteError`] if the format cannot hold the scene or the operating system refuses.
pub fn save(path: impl AsRef<Path>, scene: &Scene) -> Result<Vec<String>, WriteError> {
    let path = path.as_ref();
    let unknown = || WriteError::UnknownFormat { path: path.into(), known: writable_extensions() };
    let format = by_extension(path).ok_or_else(unknown)?;
    match format.content {
        Content::Scene { write: None, .. } => {
            let known = writable_extensions();
            Err(WriteError::ReadOnly { path: path.into(), format: format.name, known })
        }
        Content::Scene { write: Some(write), holds_meshes: true, .. } => {
            let WrittenScene { text, notes } = write(scene)?;
            atomic_write(path, |out| out.write_all(text.as_bytes()))?;
            Ok(notes)
        }
        Content::Scene { write: Some(write), .. } => save_scene(path, scene, write),
        Content::Mesh { write, .. } => {
            let (mesh, mut notes) = merge(scene, format.name)?;
            let Encoded { bytes, notes: more } = write(&mesh)?;
            atomic_write(path, |out| out.write_all(&bytes))?;
            notes.extend(more);
            Ok(notes)
        }
    }
}

/// Writes a scene file, and mesh files beside it for the meshes that have none there.
fn save_scene(path: &Path, scene: &Scene, write: WriteScene) -> Result<Vec<String>, WriteError> {
    let no_format = || WriteError::Unwritable("no mesh format keeps every bit of a mesh".into());
    let (mesh_format, write_mesh) = lossless_mesh_format().ok_or_else(no_format)?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let stem = path.file_stem().map_or("scene".into(), |s| s.to_string_lossy());
    let mut scene = scene.clone();
    let mut known: HashMap<*const TriangleMesh, MeshFile> = HashMap::new();
    let mut extra: Vec<(String, Arc<TriangleMesh>)> = Vec::new();
    for node in &mut scene.nodes {
        let Node::Mesh { mesh, file } = node else { continue };
        let found = known.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
            let present =
                file.take().filter(|file| is_within(folder, file) && is_file_of(folder, file, mesh));
            present.unwrap_or_else(|| {
                let file = free_file(folder, &stem, mesh_format.extensions[0], &extra, mesh);
                extra.push((file.name.clone(), mesh.clone()));
                file
            })
        });
        *file = Some(found.clone());
    }
    let WrittenScene { text, mut notes } = write(&scene)?;
    for (name, mesh) in &extra {
        let Encoded { bytes, .. } = write_mesh(mesh)?;
        atomic_write(&folder.join(name), |out| out.write_all(&bytes))?;
    }
    atomic_write(path, |out| out.write_all(text.as_bytes()))?;
    notes.extend(extra.into_iter().map(|(name, _)| format!("a mesh was written to {name}")));
    Ok(notes)
}

/// A file for a mesh beside a scene. Other files in the folder are not overwritten.
fn free_file(
    folder: &Path,
    stem: &str,
    extension: &str,
    taken: &[(String, Arc<TriangleMesh>)],
    mesh: &TriangleMesh,
) -> MeshFile {
    let is_free = |file: &MeshFile| {
        let is_taken = taken.iter().any(|(other, _)| *other == file.name);
        !is_taken && (!folder.join(&file.name).exists() || is_file_of(folder, file, mesh))
    };
    let numbered = |number: u64| MeshFile { name: format!("{stem}-mesh{number}.{extension}"), weld: None };
    let mut number = 0;
    while !is_free(&numbered(number)) {
        number += 1;
    }
    numbered(number)
}

/// Whether the default path policy lets readers of the scene open the file: it lies in the folder of the scene, links
/// resolved.
fn is_within(folder: &Path, file: &MeshFile) -> bool {
    let found = folder.canonicalize().and_then(|f| Ok((folder.join(&file.name).canonicalize()?, f)));
    Path::new(&file.name).is_relative() && found.is_ok_and(|(path, folder)| path.starts_with(folder))
}

/// Whether the file holds exactly this mesh, bit for bit.
fn is_file_of(folder: &Path, file: &MeshFile, mesh: &TriangleMesh) -> bool {
    let Ok(found) = read_mesh_file(&folder.join(&file.name)) else { return false };
    let found = found.welded(file.weld).mesh;
    // Vertices that no face uses may be NaN, and -0.0 differs from 0.0.
    let bits = |mesh: &TriangleMesh| -> Vec<[u64; 3]> {
        mesh.vertices.iter().map(|v| v.to_array().map(f64::to_bits)).collect()
    };
    let polygons = |mesh: &TriangleMesh| -> Vec<u32> {
        (0..).take(mesh.faces.len()).map(|face| mesh.polygon(face)).collect()
    };
    found.faces == mesh.faces
        && polygons(&found) == polygons(mesh)
        && bits(&found) == bits(mesh)
        && has_attributes_of(&found, mesh)
}

/// Whether two meshes of the same faces have the same attributes: the same values at every corner.
fn has_attributes_of(found: &TriangleMesh, mesh: &TriangleMesh) -> bool {
    let same_value = |a: Option<&[f64]>, b: Option<&[f64]>| {
        let value = |x: Option<&[f64]>| x.filter(|x| x.iter().any(|x| !x.is_nan())).map(<[f64]>::to_vec);
        value(a) == value(b)
    };
    let is_same = |a: &Attribute, b: &Attribute| {
        let corners = (0..).take(mesh.faces.len()).flat_map(|face| [0, 1, 2].map(|corner| (face, corner)));
        corners.into_iter().all(|(face, corner)| {
            same_value(found.corner_value(a, face, corner), mesh.corner_value(b, face, corner))
        })
    };
    found.attributes.len() == mesh.attributes.len()
        && mesh
            .attributes
            .iter()
            .all(|b| found.attribute(&b.name).is_some_and(|a| a.width == b.width && is_same(a, b)))
}

/// The maximum number of nodes visited while instances are expanded: sharing can make more of them than a file can hold.
const MAX_VISITED: usize = 10_000_000;

/// The maximum depth of nested nodes; more means a cycle.
const MAX_DEPTH: usize = 100_000;

/// Merges all meshes of a scene into one; also returns what that loses.
fn merge(scene: &Scene, format: &str) -> Result<(TriangleMesh, Vec<String>), WriteError> {
    let refuse =
        |what: &str| Err(WriteError::Unwritable(format!("{format} holds triangles only, and {what}")));
    let mut out = TriangleMesh::default();
    let (mut visited, mut copies, mut moved) = (0, 0, 0);
    let mut todo: Vec<(NodeId, ComposedTransform, usize, &str)> =
        scene.objects.iter().rev().map(|id| (*id, ComposedTransform::IDENTITY, 0, "")).collect();
    while let Some((id, transform, depth, object)) = todo.pop() {
        visited += 1;
        if visited > MAX_VISITED || depth > MAX_DEPTH {
            return refuse("the scene has too many parts to write each of them out");
        }
        let node = scene.node(id);
        match node {
            Node::Solid { kind, .. } => {
                return refuse(&format!("object '{object}' has a solid of the kind {}", kind.name));
            }
            Node::Csg { .. } => return refuse(&format!("object '{object}' has a combination of solids")),
            Node::Mesh { mesh, .. } => {
                let placement = transform.placement().map_err(|e| WriteError::Unwritable(e.to_string()))?;
                let world_from_local = placement.parent_from_local;
                copies += 1;
                moved += if world_from_local.is_identity() { 0 } else { mesh.vertices.len() };
                append(&mut out, mesh, &world_from_local)?;
            }
            Node::Group { members } => {
                todo.extend(members.iter().rev().map(|m| (*m, transform, depth + 1, object)))
            }
            Node::Lattice { lattice, .. } => {
                if lattice.cell_count() > (MAX_VISITED / 10) as u64 {
                    return refuse("a lattice has too many cells to write each of them out");
                }
                let cells: Vec<_> = node.cells().collect();
                todo.extend(cells.into_iter().rev().map(|(_, shift, element)| {
                    (element, transform.then(&Affine::translation(shift)), depth + 1, object)
                }));
            }
            Node::Object { name, .. } => {
                todo.extend(node.children().rev().map(|child| (child, transform, depth + 1, name.as_str())));
            }
            Node::Transform { transform: local, child } => {
                todo.push((*child, local.inside(&transform), depth + 1, object));
            }
        }
    }
    if out.faces.is_empty() {
        return refuse("the scene has none");
    }
    let mut lost = losses(scene);
    let meshes = scene.nodes.iter().filter(|node| matches!(node, Node::Mesh { .. })).count();
    if copies > meshes {
        lost.push(format!("shared meshes are written out for each of their placements, {copies} in all"));
    }
    if moved > 0 {
        lost.push(format!("vertices moved into place, and rounded to float64: {moved}"));
        let has_normals =
            |node: &Node| matches!(node, Node::Mesh { mesh, .. } if mesh.attribute(NORMAL).is_some());
        if scene.nodes.iter().any(has_normals) {
            lost.push("normals of meshes that were moved are lost".into());
        }
    }
    Ok((out, lost))
}

/// What a mesh file cannot hold of a scene.
fn losses(scene: &Scene) -> Vec<String> {
    let objects = scene.numbered_objects().len();
    let mut lost = Vec::new();
    if objects > 1 {
        lost.push(format!("{objects} objects were joined into one mesh; their names are lost"));
    }
    if let Some(units) = scene.units {
        lost.push(format!("the units, {units}, are lost"));
    }
    if !scene.materials.is_empty() {
        lost.push("materials are lost".into());
    }
    if scene.camera.is_some() || !scene.lights.is_empty() {
        lost.push("the camera and the lights are lost".into());
    }
    lost
}
