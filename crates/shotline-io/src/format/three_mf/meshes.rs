//! The mesh of an object, with the colours of its triangles.

use std::collections::HashMap;

use shotline::math::Vec3;
use shotline::solid::mesh::{Attribute, NO_ROW, TriangleMesh};

use super::elements::{Element, Found, child, elements, error, number, required_whole, tag, whole};
use super::properties::{Groups, Place, Property};
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};
use crate::xml::start_tag;

const OTHERS: NoteKind = NoteKind {
    name: "parts_of_meshes",
    effect: Effect::Changed,
    one: "1 part of a mesh besides vertices and triangles, such as a lattice of beams, was not read",
    many: "# parts of meshes besides vertices and triangles, such as lattices of beams, were not read",
};

const UNREAD: NoteKind = NoteKind {
    name: "properties_not_read",
    effect: Effect::Kept,
    one: "1 triangle has a texture or another property that was not read",
    many: "# triangles have textures or other properties that were not read",
};

/// The attributes of a triangle that name the properties of its corners.
const CORNERS: [&str; 3] = ["p1", "p2", "p3"];

/// A mesh, and the one property that all its triangles have, if they have one.
pub(super) struct Mesh {
    pub(super) mesh: TriangleMesh,
    pub(super) property: Option<Property>,
}

/// Reads a mesh. `default` is the property of triangles that name none.
pub(super) fn read(
    element: Element,
    what: &str,
    default: Option<Property>,
    groups: &Groups,
    notes: &mut Notes,
) -> Found<Mesh> {
    let no_list = |name: &str| error(element, "", format!("{what} has no <{name}>"));
    let mut vertices = Vec::new();
    for vertex in elements(child(element, "vertices").ok_or_else(|| no_list("vertices"))?) {
        vertices.push(Vec3::new(number(vertex, "x")?, number(vertex, "y")?, number(vertex, "z")?));
    }
    let mut faces = Vec::new();
    let mut colors = Colors::default();
    for triangle in elements(child(element, "triangles").ok_or_else(|| no_list("triangles"))?) {
        let corner = |name: &str| {
            let vertex = required_whole(triangle, name)?;
            let message =
                || format!("{what}: there is no vertex {vertex}; it has {}, counted from 0", vertices.len());
            let is_there = (vertex as usize) < vertices.len();
            if is_there { Ok(vertex) } else { Err(error(triangle, name, message())) }
        };
        faces.push([corner("v1")?, corner("v2")?, corner("v3")?]);
        colors.add(triangle, default, groups, notes)?;
    }
    for other in
        elements(element).filter(|part| !matches!(tag(*part), "vertices" | "triangles" | "trianglesets"))
    {
        notes.add(&OTHERS, RawLocation::Text(start_tag(other)));
    }
    let mut mesh = TriangleMesh::new(vertices, faces);
    let property = colors.single();
    if property.is_none() {
        mesh.attributes.extend(colors.attribute());
    }
    match mesh.check() {
        Ok(()) => Ok(Mesh { mesh, property: property.or(default) }),
        Err(_) => Err(error(element, "", format!("{what} has no triangle with three different corners"))),
    }
}

/// The colours at the corners of triangles while they are read.
#[derive(Debug, Default)]
struct Colors {
    rows: HashMap<Property, u32>,
    values: Vec<f64>,
    corners: Vec<[u32; 3]>,
    /// The property of all corners so far; `None` inside where they have none, or several.
    all: Option<Option<Property>>,
}

impl Colors {
    fn add(
        &mut self,
        triangle: Element,
        default: Option<Property>,
        groups: &Groups,
        notes: &mut Notes,
    ) -> Found<()> {
        let found = properties(triangle, default)?;
        let one = found.filter(|[a, b, c]| a == b && b == c).map(|[a, ..]| a);
        self.all = Some(match self.all {
            None => one,
            Some(before) => before.filter(|before| Some(*before) == one),
        });
        let mut rows = [NO_ROW; 3];
        for ((row, property), index) in rows.iter_mut().zip(found.into_iter().flatten()).zip(CORNERS) {
            if let Some(known) = self.rows.get(&property) {
                *row = *known;
                continue;
            }
            let value = groups.color(property, Place { element: triangle, index })?;
            *row = self.row(property, value);
        }
        if rows.contains(&NO_ROW) && found.is_some() {
            notes.add(&UNREAD, RawLocation::Text(start_tag(triangle)));
        }
        self.corners.push(rows);
        Ok(())
    }

    fn row(&mut self, property: Property, value: Option<[f64; 4]>) -> u32 {
        let row = match value {
            Some(value) => {
                self.values.extend(value);
                (self.values.len() / 4 - 1) as u32
            }
            None => NO_ROW,
        };
        self.rows.insert(property, row);
        row
    }

    /// The one property that all triangles have.
    fn single(&self) -> Option<Property> {
        self.all.flatten()
    }

    /// The colours as an attribute; `None` if there are none.
    fn attribute(self) -> Option<Attribute> {
        let corners = Some(self.corners);
        (!self.values.is_empty())
            .then(|| Attribute { corners, ..Attribute::of_vertices("color", 4, self.values) })
    }
}

/// The properties of the corners of a triangle: by its own group and indices, or else the default.
fn properties(triangle: Element, default: Option<Property>) -> Found<Option<[Property; 3]>> {
    let group = whole(triangle, "pid")?.or(default.map(|(group, _)| group));
    let first = whole(triangle, "p1")?;
    let (Some(group), Some(first)) = (group, first) else {
        return Ok(default.map(|default| [default; 3]));
    };
    let second = whole(triangle, "p2")?.unwrap_or(first);
    let third = whole(triangle, "p3")?.unwrap_or(first);
    Ok(Some([(group, first), (group, second), (group, third)]))
}
