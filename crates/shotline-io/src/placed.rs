//! The meshes of a scene where they are placed, each with the object that it belongs to.

use std::sync::Arc;

use shotline::math::{Affine, ComposedTransform};
use shotline::scene::{Node, NodeId, Scene};
use shotline::solid::mesh::TriangleMesh;

use crate::error::WriteError;

/// The maximum number of nodes visited while instances are expanded: sharing can make more of them than a file can hold.
const MAX_VISITED: usize = 10_000_000;

/// The maximum depth of nested nodes; more means a cycle.
const MAX_DEPTH: usize = 100_000;

/// One placement of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedObject<'s> {
    /// Its node, which other placements share.
    pub(crate) id: NodeId,
    pub(crate) name: &'s str,
    pub(crate) material: Option<&'s str>,
    pub(crate) world_from_object: Affine,
}

/// A mesh of a placed object.
#[derive(Clone, Debug)]
pub(crate) struct PlacedMesh<'s> {
    /// The index of its object.
    pub(crate) object: usize,
    pub(crate) mesh: &'s Arc<TriangleMesh>,
    pub(crate) world_from_local: Affine,
    pub(crate) object_from_local: Affine,
}

/// What a scene consists of.
#[derive(Debug, Default)]
pub(crate) struct Placed<'s> {
    /// The placed objects, each before what it contains.
    pub(crate) objects: Vec<PlacedObject<'s>>,
    /// The meshes in the order of the scene.
    pub(crate) meshes: Vec<PlacedMesh<'s>>,
}

/// A node that waits to be visited.
struct Waiting {
    id: NodeId,
    /// To the world, and to the object.
    frames: [ComposedTransform; 2],
    depth: usize,
    object: Option<usize>,
}

impl<'s> Placed<'s> {
    /// The meshes of a scene, for a format of this name.
    ///
    /// # Errors
    /// [`WriteError::Unwritable`] if there are none, or too many, or if something else than meshes is in the scene.
    pub(crate) fn of(scene: &'s Scene, format: &str) -> Result<Placed<'s>, WriteError> {
        let refuse =
            |what: &str| Err(WriteError::Unwritable(format!("{format} holds triangles only, and {what}")));
        let mut out = Placed::default();
        let root = |id: &NodeId| Waiting {
            id: *id,
            frames: [ComposedTransform::IDENTITY; 2],
            depth: 0,
            object: None,
        };
        let mut todo: Vec<Waiting> = scene.objects.iter().rev().map(root).collect();
        let mut visited = 0;
        while let Some(Waiting { id, frames, depth, object }) = todo.pop() {
            visited += 1;
            if visited > MAX_VISITED || depth > MAX_DEPTH {
                return refuse("the scene has too many parts to write each of them out");
            }
            let below = |id, frames| Waiting { id, frames, depth: depth + 1, object };
            let name = object.map_or("", |object| out.objects[object].name);
            let node = scene.node(id);
            match node {
                Node::Solid { kind, .. } => {
                    return refuse(&format!("object '{name}' has a solid of the kind {}", kind.name));
                }
                Node::Csg { .. } => return refuse(&format!("object '{name}' has a combination of solids")),
                Node::Mesh { mesh, .. } => {
                    let [world_from_local, object_from_local] = [matrix(&frames[0])?, matrix(&frames[1])?];
                    let object = object.unwrap_or_else(|| out.add(id, "", None, Affine::IDENTITY));
                    out.meshes.push(PlacedMesh { object, mesh, world_from_local, object_from_local });
                }
                Node::Group { members } => todo.extend(members.iter().rev().map(|m| below(*m, frames))),
                Node::Lattice { lattice, .. } => {
                    if lattice.cell_count() > (MAX_VISITED / 10) as u64 {
                        return refuse("a lattice has too many cells to write each of them out");
                    }
                    let cells: Vec<_> = node.cells().collect();
                    todo.extend(cells.into_iter().rev().map(|(_, shift, element)| {
                        below(element, frames.map(|frame| frame.then(&Affine::translation(shift))))
                    }));
                }
                Node::Object { name, material, .. } => {
                    let object = Some(out.add(id, name, material.as_deref(), matrix(&frames[0])?));
                    let frames = [frames[0], ComposedTransform::IDENTITY];
                    let child = |id| Waiting { id, frames, depth: depth + 1, object };
                    todo.extend(node.children().rev().map(child));
                }
                Node::Transform { transform: local, child } => {
                    todo.push(below(*child, frames.map(|frame| local.inside(&frame))));
                }
            }
        }
        if out.meshes.iter().all(|placed| placed.mesh.faces.is_empty()) {
            return refuse("the scene has none");
        }
        Ok(out)
    }

    fn add(
        &mut self,
        id: NodeId,
        name: &'s str,
        material: Option<&'s str>,
        world_from_object: Affine,
    ) -> usize {
        self.objects.push(PlacedObject { id, name, material, world_from_object });
        self.objects.len() - 1
    }
}

fn matrix(frame: &ComposedTransform) -> Result<Affine, WriteError> {
    let pair = frame.placement().map_err(|e| WriteError::Unwritable(e.to_string()))?;
    Ok(pair.parent_from_local)
}
