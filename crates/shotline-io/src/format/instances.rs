//! A scene as objects of one mesh each, for formats that place and share meshes.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use shotline::math::{Affine, Vec3};
use shotline::scene::{NodeId, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::append::{append, expect_joinable};
use crate::error::WriteError;
use crate::format::{lost_attributes, lost_polygons};
use crate::losses::{self, Look};
use crate::placed::{Placed, PlacedMesh};

/// An object where it is placed.
#[derive(Clone, Debug)]
pub(crate) struct Instance<'s> {
    /// The node of the object, which other placements share.
    pub(crate) id: NodeId,
    pub(crate) name: &'s str,
    pub(crate) material: Option<&'s str>,
    pub(crate) mesh: Arc<TriangleMesh>,
    pub(crate) world_from_local: Affine,
}

/// The objects of a scene that have triangles, and notes of what is lost. Meshes are shared as in the scene; those of an object
/// that has several become one.
///
/// # Errors
/// [`WriteError::Unwritable`] if the scene has other solids than meshes, or too many.
pub(crate) fn instances<'s>(
    scene: &'s Scene,
    format: &str,
) -> Result<(Vec<Instance<'s>>, Vec<String>), WriteError> {
    let Placed { objects, meshes } = Placed::of(scene, format)?;
    let mut of_object: Vec<Vec<PlacedMesh>> = vec![Vec::new(); objects.len()];
    for placed in meshes.into_iter().filter(|placed| !placed.mesh.faces.is_empty()) {
        of_object[placed.object].push(placed);
    }
    let mut found = Vec::new();
    let mut joined: HashMap<NodeId, Arc<TriangleMesh>> = HashMap::new();
    for (object, meshes) in objects.iter().zip(of_object) {
        let (mesh, world_from_local) = match &meshes[..] {
            [] => continue,
            [only] => (only.mesh.clone(), only.world_from_local),
            several => {
                let mesh = match joined.get(&object.id) {
                    Some(mesh) => mesh.clone(),
                    None => Arc::new(whole(object.name, several)?),
                };
                joined.insert(object.id, mesh.clone());
                (mesh, object.world_from_object)
            }
        };
        let (id, name, material) = (object.id, object.name, object.material);
        found.push(Instance { id, name, material, mesh, world_from_local });
    }
    let mut notes: Vec<String> = losses::of_materials(scene, Look::Color).into_iter().collect();
    notes.extend(losses::of_nesting(scene));
    notes.extend(losses::of_view(scene));
    if !joined.is_empty() {
        notes.push(format!("objects of several meshes, which were joined into one: {}", joined.len()));
    }
    let mut known = HashSet::new();
    for instance in found.iter().filter(|instance| known.insert(Arc::as_ptr(&instance.mesh))) {
        for note in lost_polygons(&instance.mesh).into_iter().chain(lost_attributes(&instance.mesh)) {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    Ok((found, notes))
}

/// The meshes of an object as one, in its coordinates.
fn whole(name: &str, meshes: &[PlacedMesh]) -> Result<TriangleMesh, WriteError> {
    expect_joinable(meshes.iter().map(|placed| &**placed.mesh), &format!("object '{name}'"))?;
    let mut whole = TriangleMesh::default();
    for placed in meshes {
        append(&mut whole, placed.mesh, &placed.object_from_local)?;
    }
    Ok(whole)
}

/// The vertices that faces use, in their order, and the faces by the numbers of these. What no face uses may be NaN.
pub(crate) fn used_vertices(mesh: &TriangleMesh) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut numbers = vec![None; mesh.vertices.len()];
    mesh.faces.iter().flatten().for_each(|vertex| numbers[*vertex as usize] = Some(0));
    let mut vertices = Vec::new();
    for (number, vertex) in numbers.iter_mut().zip(&mesh.vertices).filter(|(number, _)| number.is_some()) {
        *number = Some(vertices.len() as u32);
        vertices.push(*vertex);
    }
    let new = |vertex: u32| numbers[vertex as usize].unwrap_or_default();
    (vertices, mesh.faces.iter().map(|face| face.map(new)).collect())
}
