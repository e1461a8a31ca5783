//! Primitives: the triangles of a mesh that have one material.

use shotline::math::Vec3;
use shotline::solid::mesh::{Attribute, TriangleMesh, Weld};

use super::accessors::{Accessors, Values};
use super::color::srgb;
use super::fields::{Field, Read};
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

const LINES: NoteKind = NoteKind {
    name: "points_and_lines",
    effect: Effect::Changed,
    one: "1 primitive of points or lines was left out",
    many: "# primitives of points or lines were left out",
};

const EMPTY: NoteKind = NoteKind {
    name: "no_triangles",
    effect: Effect::Changed,
    one: "1 primitive without a triangle of three different corners was left out",
    many: "# primitives without a triangle of three different corners were left out",
};

const MORPHS: NoteKind = NoteKind {
    name: "morph_targets",
    effect: Effect::Changed,
    one: "1 primitive with morph targets was read without them",
    many: "# primitives with morph targets were read without them",
};

const OTHERS: NoteKind = NoteKind {
    name: "attributes_not_read",
    effect: Effect::Kept,
    one: "1 attribute of vertices besides normals, a first texture coordinate and a first colour was not read",
    many: "# attributes of vertices besides normals, a first texture coordinate and a first colour were not read",
};

/// The attributes that are kept: their names in the file and in meshes, and how many numbers they may have.
const ATTRIBUTES: [(&str, &str, &[usize]); 3] =
    [("NORMAL", "normal", &[3]), ("TEXCOORD_0", "uv", &[2]), ("COLOR_0", COLOR, &[3, 4])];

pub(super) const COLOR: &str = "color";

/// The extension whose compressed triangles some files hold beside others, and some instead of them.
const DRACO: &str = "KHR_draco_mesh_compression";

/// What the triangles of a primitive are made of, by the numbers of accessors. Equal ones are equal meshes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    mode: usize,
    indices: Option<usize>,
    positions: usize,
    attributes: [Option<usize>; 3],
}

/// A primitive.
#[derive(Clone, Debug)]
pub(super) struct Primitive<'j> {
    pub(super) field: Field<'j>,
    /// What it is called in messages.
    pub(super) what: String,
    pub(super) material: Option<usize>,
    pub(super) key: Key,
}

/// How triangles follow from a list of vertices.
const TRIANGLES: usize = 4;
const STRIP: usize = 5;
const FAN: usize = 6;

impl<'j> Primitive<'j> {
    /// The primitive that a field describes; `None` if it has no triangles.
    pub(super) fn of(
        field: Field<'j>,
        what: String,
        materials: usize,
        accessors: &Accessors,
        notes: &mut Notes,
    ) -> Read<Option<Primitive<'j>>> {
        let at = || RawLocation::Text(field.range());
        let mode = field.get("mode").map_or(Ok(TRIANGLES), |mode| mode.whole("\"mode\""))?;
        match mode {
            0..TRIANGLES => {
                notes.add(&LINES, at());
                return Ok(None);
            }
            TRIANGLES..=FAN => {}
            _ => return Err(field.error(format!("{what}: there is no mode {mode}; the last is 6"))),
        }
        if field.list("targets")?.len() > 0 {
            notes.add(&MORPHS, at());
        }
        let named = field.required("attributes", &what)?;
        let (mut positions, mut attributes) = (None, [None; 3]);
        for (name, value) in named.members("\"attributes\"")? {
            let index = accessors.index(value, &format!("{what}, {name}"))?;
            match ATTRIBUTES.iter().position(|(known, ..)| *known == name) {
                Some(known) => attributes[known] = Some(index),
                None if name == "POSITION" => positions = Some(index),
                None => notes.add(&OTHERS, RawLocation::Text(value.range())),
            }
        }
        let Some(positions) = positions else {
            return Err(named.error(format!("{what} has no attribute POSITION")));
        };
        if field.extension(DRACO).is_some() && !accessors.has_bytes(positions) {
            let message = format!("{what} is compressed by {DRACO}, which is not read");
            return Err(field.error(message).help("export it without compression"));
        }
        let indices = field.get("indices");
        let indices = indices.map(|i| accessors.index(i, &format!("{what}, indices"))).transpose()?;
        let material = match field.get("material") {
            Some(material) => Some(checked_material(material, materials, &what)?),
            None => None,
        };
        Ok(Some(Primitive { field, what, material, key: Key { mode, indices, positions, attributes } }))
    }

    /// The triangles, with vertices at one position merged; `None` if there are none.
    pub(super) fn mesh(&self, accessors: &mut Accessors, notes: &mut Notes) -> Read<Option<TriangleMesh>> {
        let positions = accessors.values(self.key.positions, &format!("{}, POSITION", self.what), &[3])?;
        let order = match self.key.indices {
            Some(indices) => accessors.indices(indices, &format!("{}, indices", self.what))?,
            None => {
                accessors.count(positions.count()).map_err(|why| self.field.error(self.said(&why)))?;
                (0..positions.count() as u32).collect()
            }
        };
        self.check_order(&order, positions.count(), accessors)?;
        let mut faces = triangles(self.key.mode, &order);
        accessors.count(3 * faces.len()).map_err(|why| self.field.error(self.said(&why)))?;
        let used = used_vertices(&mut faces, positions.count());
        let vertices = self.vertices(&positions, &used, accessors)?;
        let mut mesh = TriangleMesh::new(vertices, faces);
        for ((name, as_called, widths), index) in ATTRIBUTES.iter().zip(self.key.attributes) {
            let Some(index) = index else { continue };
            let what = format!("{}, {name}", self.what);
            let values = accessors.values(index, &what, widths)?;
            if values.count() != positions.count() {
                let message =
                    format!("{what}: there are {} values for {} vertices", values.count(), positions.count());
                return Err(accessors.error(index, message));
            }
            mesh.attributes.push(attribute(as_called, &values, &used));
        }
        // Only a mesh without a triangle of three different corners is refused here.
        if mesh.check().is_err() {
            notes.add(&EMPTY, RawLocation::Text(self.field.range()));
            return Ok(None);
        }
        Ok(Some(without_seams(mesh)))
    }

    fn said(&self, why: &str) -> String {
        format!("{}: {why}", self.what)
    }

    fn check_order(&self, order: &[u32], count: usize, accessors: &Accessors) -> Read<()> {
        let beyond = order.iter().enumerate().find(|(_, vertex)| **vertex as usize >= count);
        let Some((place, vertex)) = beyond else { return Ok(()) };
        let message = format!(
            "{}: index {place} names vertex {vertex}, but there are {count}, counted from 0",
            self.what
        );
        Err(self.key.indices.map_or_else(|| self.field.error(&message), |i| accessors.error(i, &message)))
    }

    fn vertices(&self, positions: &Values, used: &[u32], accessors: &Accessors) -> Read<Vec<Vec3>> {
        let mut vertices = Vec::with_capacity(used.len());
        for &vertex in used {
            let first = 3 * vertex as usize;
            let point = Vec3::new(
                positions.numbers[first],
                positions.numbers[first + 1],
                positions.numbers[first + 2],
            );
            if !point.is_finite() {
                let message =
                    format!("{}: vertex {vertex} has a coordinate that is NaN or infinite", self.what);
                return Err(accessors.error(self.key.positions, message));
            }
            vertices.push(point);
        }
        Ok(vertices)
    }
}

fn checked_material(material: Field, count: usize, what: &str) -> Read<usize> {
    let index = material.whole("\"material\"")?;
    if index < count {
        return Ok(index);
    }
    Err(material.error(format!("{what}: there is no material {index}; the file has {count}, counted from 0")))
}

/// The triangles of a list of vertices. A strip goes on from triangle to triangle without turning them over, and vertices
/// that are repeated in it only lead to the next ones.
fn triangles(mode: usize, order: &[u32]) -> Vec<[u32; 3]> {
    let has_corners = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    match mode {
        STRIP => {
            let turned =
                |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            order.windows(3).enumerate().map(turned).filter(has_corners).collect()
        }
        FAN => {
            let Some((first, rest)) = order.split_first() else { return Vec::new() };
            rest.windows(2).map(|w| [*first, w[0], w[1]]).filter(has_corners).collect()
        }
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}

/// Numbers the corners of faces by the vertices that they use, and returns these in ascending order.
fn used_vertices(faces: &mut [[u32; 3]], count: usize) -> Vec<u32> {
    let mut used: Vec<u32> = faces.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    if used.len() < count {
        for corner in faces.as_flattened_mut() {
            *corner = used.partition_point(|vertex| vertex < corner) as u32;
        }
    }
    used
}

/// The values of the vertices that are used. Colours are linear in the file, and sRGB in meshes, as everywhere.
fn attribute(name: &str, values: &Values, used: &[u32]) -> Attribute {
    let width = values.width;
    let mut numbers = Vec::with_capacity(used.len() * width);
    for &vertex in used {
        let first = vertex as usize * width;
        numbers.extend_from_slice(&values.numbers[first..first + width]);
    }
    if name == COLOR {
        for color in numbers.chunks_exact_mut(width) {
            color[..3].iter_mut().for_each(|x| *x = srgb(*x));
        }
    }
    Attribute::of_vertices(name, width, numbers)
}

/// The mesh with vertices at one position merged. They are split wherever an attribute has two values, and a mesh that is
/// split is not closed; the values stay at the corners of the triangles.
pub(super) fn without_seams(mesh: TriangleMesh) -> TriangleMesh {
    match mesh.welded(Weld::Within(0.0)) {
        Ok((welded, report)) if report.repeated > 0 => welded,
        _ => mesh,
    }
}
