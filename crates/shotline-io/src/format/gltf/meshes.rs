//! Meshes: primitives of one material each become parts, which become objects.
//!
//! The primitives of a closed mesh are often open, because the material changes on its surface; such a mesh stays whole.

use std::collections::HashMap;
use std::sync::Arc;

use shotline::scene::{Node, NodeId, Scene};
use shotline::solid::mesh::{Attribute, NO_ROW, Topology, TriangleMesh};

use super::accessors::Accessors;
use super::fields::{Field, Read};
use super::primitives::{Key, Primitive, without_seams};
use crate::location::RawLocation;
use crate::mesh_file::MeshFile;
use crate::note::{Effect, NoteKind, Notes};
use crate::options::ReadOptions;

const JOINED: NoteKind = NoteKind {
    name: "materials_joined",
    effect: Effect::Changed,
    one: "1 closed mesh of several materials, none of which encloses its part, became one object with the material of \
          most triangles",
    many: "# closed meshes of several materials, which do not enclose their parts, became one object each, with the \
           material of most triangles",
};

/// A part of a mesh that becomes an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) mesh: NodeId,
    pub(super) material: Option<usize>,
}

/// The meshes of a file, each read when a node uses it.
#[derive(Default)]
pub(super) struct Meshes {
    read: HashMap<usize, Vec<Part>>,
    /// The nodes of meshes that several meshes of the file share.
    nodes: HashMap<Vec<Key>, Option<NodeId>>,
}

/// Primitives of one material.
struct Piece<'j> {
    primitives: Vec<Primitive<'j>>,
    mesh: TriangleMesh,
    material: Option<usize>,
}

/// What meshes are added to.
pub(super) struct Target<'a> {
    pub(super) scene: &'a mut Scene,
    pub(super) spans: &'a mut Vec<std::ops::Range<usize>>,
    pub(super) notes: &'a mut Notes,
    pub(super) options: &'a ReadOptions,
    pub(super) materials: usize,
}

impl Meshes {
    /// The parts of a mesh; none if it has no triangles.
    pub(super) fn parts(
        &mut self,
        index: usize,
        field: Field,
        accessors: &mut Accessors,
        target: &mut Target,
    ) -> Read<Vec<Part>> {
        if let Some(known) = self.read.get(&index) {
            return Ok(known.clone());
        }
        let name = field.name().map_or(String::new(), |name| format!(" '{name}'"));
        let list =
            field.required("primitives", &format!("mesh {index}{name}"))?.elements("\"primitives\"")?;
        let mut pieces: Vec<(Option<usize>, Vec<Primitive>)> = Vec::new();
        let mut piece_of = HashMap::new();
        for (number, field) in list.iter().enumerate() {
            let what = format!("mesh {index}{name}, primitive {number}");
            let found = Primitive::of(field, what, target.materials, accessors, target.notes)?;
            let Some(primitive) = found else { continue };
            let piece = *piece_of.entry(primitive.material).or_insert(pieces.len());
            if piece == pieces.len() {
                pieces.push((primitive.material, Vec::new()));
            }
            pieces[piece].1.push(primitive);
        }
        let parts = match &pieces[..] {
            [] => Vec::new(),
            [(material, primitives)] => {
                let keys = keys_of(primitives);
                let node = match self.nodes.get(&keys) {
                    Some(known) => *known,
                    None => {
                        let mesh = joined_primitives(primitives, accessors, target.notes)?;
                        let node = mesh.map(|mesh| target.add(field, mesh));
                        self.nodes.insert(keys, node);
                        node
                    }
                };
                node.into_iter().map(|mesh| Part { mesh, material: *material }).collect()
            }
            _ => self.separate(pieces, field, accessors, target)?,
        };
        self.read.insert(index, parts.clone());
        Ok(parts)
    }

    /// The parts of a mesh of several materials: one each if each is closed or the whole is open, or else the whole.
    fn separate(
        &mut self,
        pieces: Vec<(Option<usize>, Vec<Primitive>)>,
        field: Field,
        accessors: &mut Accessors,
        target: &mut Target,
    ) -> Read<Vec<Part>> {
        let mut found = Vec::with_capacity(pieces.len());
        for (material, primitives) in pieces {
            if let Some(mesh) = joined_primitives(&primitives, accessors, target.notes)? {
                found.push(Piece { primitives, mesh, material });
            }
        }
        if found.len() > 1 && !found.iter().all(|piece| is_closed(&piece.mesh)) {
            let whole = joined(found.iter().map(|piece| piece.mesh.clone()).collect());
            if is_closed(&whole) {
                target.notes.add(&JOINED, RawLocation::Text(field.range()));
                let most = found.iter().rev().max_by_key(|piece| piece.mesh.faces.len());
                let material = most.and_then(|piece| piece.material);
                return Ok(vec![Part { mesh: target.add(field, whole), material }]);
            }
        }
        let mut parts = Vec::with_capacity(found.len());
        for Piece { primitives, mesh, material } in found {
            let node = self.nodes.entry(keys_of(&primitives)).or_insert(None);
            let mesh = *node.get_or_insert_with(|| target.add(field, mesh));
            parts.push(Part { mesh, material });
        }
        Ok(parts)
    }
}

impl Target<'_> {
    /// Adds a mesh, welded if the options say so.
    fn add(&mut self, field: Field, mesh: TriangleMesh) -> NodeId {
        let MeshFile { mesh, notes, .. } = MeshFile { mesh, ..MeshFile::default() }.welded(self.options.weld);
        notes.into_iter().for_each(|note| self.notes.push(note));
        self.spans.push(field.range());
        self.scene.add(Node::Mesh { mesh: Arc::new(mesh), file: None })
    }
}

fn keys_of(primitives: &[Primitive]) -> Vec<Key> {
    primitives.iter().map(|primitive| primitive.key.clone()).collect()
}

fn is_closed(mesh: &TriangleMesh) -> bool {
    Topology::of(mesh).is_ok_and(|topology| topology.is_closed())
}

fn joined_primitives(
    primitives: &[Primitive],
    accessors: &mut Accessors,
    notes: &mut Notes,
) -> Read<Option<TriangleMesh>> {
    let mut meshes = Vec::with_capacity(primitives.len());
    for primitive in primitives {
        meshes.extend(primitive.mesh(accessors, notes)?);
    }
    Ok((!meshes.is_empty()).then(|| joined(meshes)))
}

/// Meshes as one, with vertices at one position merged.
fn joined(mut meshes: Vec<TriangleMesh>) -> TriangleMesh {
    if meshes.len() == 1 {
        return meshes.swap_remove(0);
    }
    let mut whole = TriangleMesh::default();
    for mesh in &meshes {
        for attribute in &mesh.attributes {
            match whole.attributes.iter_mut().find(|known| known.name == attribute.name) {
                Some(known) => known.width = known.width.max(attribute.width),
                None => whole.attributes.push(Attribute {
                    name: attribute.name.clone(),
                    width: attribute.width,
                    values: Vec::new(),
                    corners: Some(Vec::new()),
                }),
            }
        }
    }
    for mesh in &meshes {
        for attribute in &mut whole.attributes {
            append_attribute(attribute, mesh);
        }
        let first = whole.vertices.len() as u32;
        whole.vertices.extend_from_slice(&mesh.vertices);
        whole.faces.extend(mesh.faces.iter().map(|face| face.map(|vertex| vertex + first)));
    }
    without_seams(whole)
}

/// Adds the values of a mesh to those of several. Colours without an opacity are opaque.
fn append_attribute(whole: &mut Attribute, mesh: &TriangleMesh) {
    let first = whole.rows() as u32;
    let Some(corners) = &mut whole.corners else { return };
    let Some(attribute) = mesh.attribute(&whole.name) else {
        corners.extend(std::iter::repeat_n([NO_ROW; 3], mesh.faces.len()));
        return;
    };
    let of_mesh = attribute.corners.as_deref().unwrap_or(&mesh.faces);
    corners.extend(of_mesh.iter().map(|rows| rows.map(|row| if row == NO_ROW { row } else { row + first })));
    for value in attribute.values.chunks_exact(attribute.width) {
        whole.values.extend_from_slice(value);
        whole.values.extend(std::iter::repeat_n(1.0, whole.width - attribute.width));
    }
}
