//! Scenes to files.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use shotline::scene::{MeshFile, Node, Scene};
use shotline::solid::mesh::{Attribute, TriangleMesh};

use crate::atomic_write::atomic_write;
use crate::error::WriteError;
use crate::format::obj::{MATERIALS_MARK, write_materials};
use crate::format::{
    Content, Keeps, WriteMesh, WriteScene, WrittenScene, by_extension, known_extensions, lossless_mesh_format,
};
use crate::joined::{Joined, join};
use crate::load::read_mesh_file;
use crate::mesh_file::{Encoded, NamedMesh};
use crate::paths::folder_of;

/// Writes a scene in the format of the file name extension. Returns what was lost and which other files were written.
/// Files appear complete or not at all.
///
/// A scene file names the mesh files that lie in its folder and still hold the mesh that was read, with its welding; all
/// other meshes are written beside it as PLY, in their present state. GDML, glTF and 3MF files hold the meshes themselves. A
/// mesh file holds all meshes of the scene, with their transforms applied; OBJ keeps the objects apart and names their materials,
/// which are written beside it as MTL, and so does a text STL, without materials.
///
/// # Errors
/// [`WriteError`] if the format cannot hold the scene or the operating system refuses.
pub fn save(path: impl AsRef<Path>, scene: &Scene) -> Result<Vec<String>, WriteError> {
    let path = path.as_ref();
    let unknown = || WriteError::UnknownFormat { path: path.into(), known: known_extensions() };
    let format = by_extension(path).ok_or_else(unknown)?;
    match format.content {
        Content::Scene { write, holds_meshes: true, .. } => {
            let WrittenScene { bytes, notes } = write(path, scene)?;
            atomic_write(path, |out| out.write_all(&bytes))?;
            Ok(notes)
        }
        Content::Scene { write, .. } => save_scene(path, scene, write),
        Content::Mesh { write, keeps, .. } => save_mesh(path, scene, format.name, write, keeps),
    }
}

/// Writes all meshes of a scene as one, and a file of materials beside it if the format has such files and there is something to
/// write.
fn save_mesh(
    path: &Path,
    scene: &Scene,
    format: &str,
    write: WriteMesh,
    keeps: Keeps,
) -> Result<Vec<String>, WriteError> {
    let Joined { mesh, objects, materials, mut notes } = join(scene, format, keeps)?;
    let materials = if keeps == Keeps::NamesAndMaterials { write_materials(&materials) } else { None };
    let materials = materials.map(|text| (material_file(path, &text), text));
    let materials_file = materials.as_ref().map(|(name, _)| name.as_str());
    let named = NamedMesh { mesh: &mesh, objects: &objects, materials_file };
    let Encoded { bytes, notes: more } = write(named)?;
    if let Some((name, text)) = &materials {
        atomic_write(&folder_of(path).join(name), |out| out.write_all(text.as_bytes()))?;
    }
    atomic_write(path, |out| out.write_all(&bytes))?;
    notes.extend(more);
    notes.extend(materials.map(|(name, _)| format!("the materials were written to {name}")));
    Ok(notes)
}

/// The name of a file of materials beside a mesh: one word, as mesh files name it. Other files in the folder are not
/// overwritten, except those that a mesh of the same name had before.
fn material_file(path: &Path, text: &str) -> String {
    let stem = path.file_stem().map_or("mesh".into(), |stem| stem.to_string_lossy());
    let is_plain = |c: char| !(c.is_whitespace() || c.is_control() || matches!(c, '#' | '\\'));
    let stem: String = stem.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    let is_free = |name: &String| match std::fs::read(folder_of(path).join(name)) {
        Ok(bytes) => bytes == text.as_bytes() || bytes.starts_with(MATERIALS_MARK.as_bytes()),
        Err(error) => error.kind() == std::io::ErrorKind::NotFound,
    };
    let first = format!("{stem}.mtl");
    let mut numbered = (1..1000).map(|number| format!("{stem}-{number}.mtl"));
    if is_free(&first) { first } else { numbered.find(is_free).unwrap_or(first) }
}

/// Writes a scene file, and mesh files beside it for the meshes that have none there.
fn save_scene(path: &Path, scene: &Scene, write: WriteScene) -> Result<Vec<String>, WriteError> {
    let no_format = || WriteError::Unwritable("no mesh format keeps every bit of a mesh".into());
    let (mesh_format, write_mesh) = lossless_mesh_format().ok_or_else(no_format)?;
    let folder = folder_of(path);
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
    let WrittenScene { bytes, mut notes } = write(path, &scene)?;
    for (name, mesh) in &extra {
        let Encoded { bytes, notes: more } = write_mesh(NamedMesh::unnamed(mesh))?;
        atomic_write(&folder.join(name), |out| out.write_all(&bytes))?;
        notes.extend(more.into_iter().map(|note| format!("{name}: {note}")));
    }
    atomic_write(path, |out| out.write_all(&bytes))?;
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
