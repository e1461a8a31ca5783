//! Meshes to PLY.

use std::fmt::Write;

use shotline::solid::mesh::{Attribute, TriangleMesh};

use super::POLYGON;
use super::attributes::is_set;
use super::property_names::{Named, PropertyNames};
use crate::error::WriteError;
use crate::mesh_file::{Encoded, NamedMesh};

/// The most numbers that the values of the three corners of a triangle can have in a list with a length of one byte.
const MAX_LIST: usize = 255;

/// Writes binary PLY in float64: no number is lost. Names that PLY cannot hold are changed, with a note.
pub(super) fn write(NamedMesh { mesh, .. }: NamedMesh) -> Result<Encoded, WriteError> {
    let wide = mesh.attributes.iter().find(|a| a.corners.is_some() && 3 * a.width > MAX_LIST);
    if let Some(Attribute { name, width, .. }) = wide {
        let most = MAX_LIST / 3;
        let message = format!("attribute '{name}' has {width} numbers a corner; PLY holds {most} at most");
        return Err(WriteError::Unwritable(message));
    }
    let PropertyNames { of_vertices, of_corners, note } = PropertyNames::of(&mesh.attributes);
    let types: Vec<NumberType> = of_vertices.iter().map(NumberType::of).collect();
    let mut bytes = header(mesh, &of_vertices, &types, &of_corners).into_bytes();
    bytes.reserve(mesh.vertices.len() * 24 + mesh.faces.len() * 17);
    for (number, vertex) in (0..).zip(&mesh.vertices) {
        bytes.extend(vertex.to_array().iter().flat_map(|x| x.to_le_bytes()));
        for (named, number_type) in of_vertices.iter().zip(&types) {
            for x in named.attribute.value(number).unwrap_or_default() {
                number_type.write(*x, &mut bytes);
            }
        }
    }
    for (number, face) in (0..).zip(&mesh.faces) {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| i.to_le_bytes()));
        if !mesh.polygons.is_empty() {
            bytes.extend(mesh.polygon(number).to_le_bytes());
        }
        for Named { attribute, .. } in &of_corners {
            bytes.push(3 * attribute.width as u8);
            for corner in 0..3 {
                match mesh.corner_value(attribute, number, corner) {
                    Some(value) => bytes.extend(value.iter().flat_map(|x| x.to_le_bytes())),
                    None => bytes.extend([f64::NAN.to_le_bytes()].repeat(attribute.width).as_flattened()),
                }
            }
        }
    }
    Ok(Encoded { bytes, notes: note.into_iter().collect() })
}

/// The smallest type that holds every number of an attribute: many programs read no others of colours and normals.
#[derive(Clone, Copy)]
enum NumberType {
    /// A colour of 256 steps.
    Byte,
    Float,
    Double,
}

impl NumberType {
    fn of(Named { attribute, properties, .. }: &Named) -> NumberType {
        let is_step = |x: &f64| (0.0..=1.0).contains(x) && (x * 255.0).round() / 255.0 == *x;
        let is_single = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
        let is_color = is_set("color", properties);
        if is_color && attribute.values.iter().all(is_step) {
            NumberType::Byte
        } else if attribute.values.iter().all(is_single) {
            NumberType::Float
        } else {
            NumberType::Double
        }
    }

    fn name(self) -> &'static str {
        match self {
            NumberType::Byte => "uchar",
            NumberType::Float => "float",
            NumberType::Double => "double",
        }
    }

    fn write(self, x: f64, out: &mut Vec<u8>) {
        match self {
            NumberType::Byte => out.push((x * 255.0).round() as u8),
            NumberType::Float => out.extend((x as f32).to_le_bytes()),
            NumberType::Double => out.extend(x.to_le_bytes()),
        }
    }
}

fn header(mesh: &TriangleMesh, of_vertices: &[Named], types: &[NumberType], of_corners: &[Named]) -> String {
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
        mesh.vertices.len()
    );
    // Writing to a string cannot fail.
    for (named, number_type) in of_vertices.iter().zip(types) {
        for property in &named.properties {
            let _ = writeln!(out, "property {} {property}", number_type.name());
        }
    }
    let _ = writeln!(out, "element face {}\nproperty list uchar uint vertex_indices", mesh.faces.len());
    if !mesh.polygons.is_empty() {
        let _ = writeln!(out, "property uint {POLYGON}");
    }
    for list in of_corners.iter().flat_map(|named| &named.properties) {
        let _ = writeln!(out, "property list uchar double {list}");
    }
    out + "end_header\n"
}
