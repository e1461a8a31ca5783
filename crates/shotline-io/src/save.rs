//! Scenes to files.

use std::collections::HashMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use shotline::math::{Affine, ComposedTransform};
use shotline::scene::{MeshFile, Node, NodeId, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::error::WriteError;
use crate::format::{Content, Encoded};
use crate::scene_json::write_scene;
use crate::whole::write_whole;
use crate::{ply, registry};

/// Writes a scene in the format that the file name ends in, and answers what a user may want to know: what was lost,
/// and which other files were written. Files appear whole or not at all.
///
/// A scene file names the mesh files that lie in its folder and still hold what was read, with how they are welded;
/// all other meshes are written beside it as PLY, as they are now.
/// A mesh file takes all meshes of the scene, placed, in one.
///
/// # Errors
/// [`WriteError`] if the format cannot hold the scene or the system refuses.
pub fn save(path: impl AsRef<Path>, scene: &Scene) -> Result<Vec<String>, WriteError> {
    let path = path.as_ref();
    let format = registry::by_extension(path);
    let format = format.ok_or_else(|| WriteError::UnknownFormat {
        path: path.into(),
        known: registry::known_extensions(),
    })?;
    match format.content {
        Content::Scene { .. } => save_scene(path, scene),
        Content::Mesh { write, .. } => {
            let (mesh, mut notes) = gather(scene, format.name)?;
            let Encoded { bytes, notes: more } = write(&mesh)?;
            write_whole(path, |out| out.write_all(&bytes))?;
            notes.extend(more);
            Ok(notes)
        }
    }
}

fn save_scene(path: &Path, scene: &Scene) -> Result<Vec<String>, WriteError> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let stem = path.file_stem().map_or("scene".into(), |s| s.to_string_lossy());
    let mut scene = scene.clone();
    let mut known: HashMap<*const TriangleMesh, MeshFile> = HashMap::new();
    let mut extra: Vec<(String, Arc<TriangleMesh>)> = Vec::new();
    for node in &mut scene.nodes {
        let Node::Mesh { mesh, file } = node else { continue };
        let found = known.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
            let here = file.take().filter(|file| is_within(folder, file) && is_file_of(folder, file, mesh));
            here.unwrap_or_else(|| {
                let file = free_file(folder, &stem, &extra, mesh);
                extra.push((file.name.clone(), mesh.clone()));
                file
            })
        });
        *file = Some(found.clone());
    }
    let text = write_scene(&scene)?;
    for (name, mesh) in &extra {
        let Encoded { bytes, .. } = ply::write(mesh)?;
        write_whole(&folder.join(name), |out| out.write_all(&bytes))?;
    }
    write_whole(path, |out| out.write_all(text.as_bytes()))?;
    Ok(extra.into_iter().map(|(name, _)| format!("a mesh was written to {name}")).collect())
}

/// A file for a mesh beside a scene. What else lies in the folder is not written over.
fn free_file(
    folder: &Path,
    stem: &str,
    taken: &[(String, Arc<TriangleMesh>)],
    mesh: &TriangleMesh,
) -> MeshFile {
    let is_free = |file: &MeshFile| {
        let is_taken = taken.iter().any(|(other, _)| *other == file.name);
        !is_taken && (!folder.join(&file.name).exists() || is_file_of(folder, file, mesh))
    };
    let numbered = |number: u64| MeshFile { name: format!("{stem}-mesh{number}.ply"), weld: None };
    let mut number = 0;
    while !is_free(&numbered(number)) {
        number += 1;
    }
    numbered(number)
}

/// Whether readers of a scene may open the file: it lies in the folder of the scene, links resolved.
fn is_within(folder: &Path, file: &MeshFile) -> bool {
    let found = folder.canonicalize().and_then(|f| Ok((folder.join(&file.name).canonicalize()?, f)));
    Path::new(&file.name).is_relative() && found.is_ok_and(|(path, folder)| path.starts_with(folder))
}

/// Whether reading a file gives just this mesh, bit for bit.
fn is_file_of(folder: &Path, file: &MeshFile, mesh: &TriangleMesh) -> bool {
    let Ok(found) = registry::read_mesh_file(&folder.join(&file.name)) else { return false };
    let found = found.welded(file.weld).mesh;
    // Vertices of no face may be NaN, and the sign of zero counts.
    let bits = |mesh: &TriangleMesh| -> Vec<[u64; 3]> {
        mesh.vertices.iter().map(|v| v.to_array().map(f64::to_bits)).collect()
    };
    let polygons = |mesh: &TriangleMesh| -> Vec<u32> {
        (0..).take(mesh.faces.len()).map(|face| mesh.polygon(face)).collect()
    };
    found.faces == mesh.faces && polygons(&found) == polygons(mesh) && bits(&found) == bits(mesh)
}

/// Placements of parts that are written out, at most: sharing can make more of them than any file holds.
const MOST_PLACED: usize = 10_000_000;

/// Nodes within nodes, at most; more means a cycle.
const DEEPEST: usize = 100_000;

/// All meshes of a scene in one, with what is lost by that.
fn gather(scene: &Scene, format: &str) -> Result<(TriangleMesh, Vec<String>), WriteError> {
    let refuse =
        |what: &str| Err(WriteError::Unwritable(format!("{format} holds triangles only, and {what}")));
    let mut out = TriangleMesh::default();
    let (mut placed, mut copies, mut moved) = (0, 0, 0);
    let mut todo: Vec<(NodeId, ComposedTransform, usize, &str)> =
        scene.objects.iter().rev().map(|id| (*id, ComposedTransform::IDENTITY, 0, "")).collect();
    while let Some((id, place, depth, object)) = todo.pop() {
        placed += 1;
        if placed > MOST_PLACED || depth > DEEPEST {
            return refuse("the scene has too many parts to write each of them out");
        }
        match scene.node(id) {
            Node::Solid { kind, .. } => {
                return refuse(&format!("object '{object}' has a solid of the kind {}", kind.name));
            }
            Node::Csg { .. } => return refuse(&format!("object '{object}' has a combination of solids")),
            Node::Mesh { mesh, .. } => {
                let place = place.placement().map_err(|e| WriteError::Unwritable(e.to_string()))?;
                let place = place.parent_from_local;
                copies += 1;
                moved += if place.is_identity() { 0 } else { mesh.vertices.len() };
                append(&mut out, mesh, &place)?;
            }
            Node::Group { members } => {
                todo.extend(members.iter().rev().map(|m| (*m, place, depth + 1, object)))
            }
            Node::Object { node, name, .. } => todo.push((*node, place, depth + 1, name)),
            Node::Transform { transform, child } => {
                todo.push((*child, transform.inside(&place), depth + 1, object));
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
    }
    Ok((out, lost))
}

fn losses(scene: &Scene) -> Vec<String> {
    let objects = scene.nodes.iter().filter(|node| matches!(node, Node::Object { .. })).count();
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

fn append(out: &mut TriangleMesh, mesh: &TriangleMesh, place: &Affine) -> Result<(), WriteError> {
    let first = u32::try_from(out.vertices.len()).ok();
    let first = first.filter(|n| mesh.vertices.len() <= (u32::MAX - n) as usize);
    let first = first.ok_or_else(|| WriteError::Unwritable("more than 4294967295 vertices".into()))?;
    if place.is_identity() {
        out.vertices.extend(&mesh.vertices);
    } else {
        out.vertices.extend(mesh.vertices.iter().map(|v| place.point(*v)));
    }
    append_polygons(out, mesh);
    // A mirror turns triangles inside out.
    let mirrored = place.determinant() < 0.0;
    out.faces.extend(mesh.faces.iter().map(|[a, b, c]| {
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        [first + a, first + b, first + c]
    }));
    Ok(())
}

/// Numbers the polygons of a mesh after those that are there; does nothing where faces are the polygons.
fn append_polygons(out: &mut TriangleMesh, mesh: &TriangleMesh) {
    if out.polygons.is_empty() && mesh.polygons.is_empty() {
        return;
    }
    if out.polygons.is_empty() {
        out.polygons = (0..).take(out.faces.len()).collect();
    }
    let first = out.polygons.last().map_or(0, |last| last.saturating_add(1));
    out.polygons.extend((0..).take(mesh.faces.len()).map(|face| first.saturating_add(mesh.polygon(face))));
}
