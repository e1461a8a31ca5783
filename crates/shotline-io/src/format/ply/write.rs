//! Meshes to PLY.

use std::fmt::Write;

use shotline::solid::mesh::{Attribute, TriangleMesh};

use super::POLYGON;
use super::attributes::{CORNER, SETS, TEXTURE};
use crate::error::WriteError;
use crate::mesh_file::{Encoded, NamedMesh};

/// The most numbers that the values of the three corners of a triangle can have in a list with a length of one byte.
const MAX_LIST: usize = 255;

/// Writes binary PLY in float64: nothing is lost.
pub(super) fn write(NamedMesh { mesh, .. }: NamedMesh) -> Result<Encoded, WriteError> {
    let (of_vertices, of_corners): (Vec<&Attribute>, Vec<&Attribute>) =
        mesh.attributes.iter().partition(|attribute| attribute.corners.is_none());
    let of_vertices: Vec<_> = of_vertices.into_iter().map(|a| (a, NumberType::of(a))).collect();
    let wide = of_corners.iter().find(|attribute| 3 * attribute.width > MAX_LIST);
    if let Some(Attribute { name, width, .. }) = wide {
        let most = MAX_LIST / 3;
        let message = format!("attribute '{name}' has {width} numbers a corner; PLY holds {most} at most");
        return Err(WriteError::Unwritable(message));
    }
    let mut out = header(mesh, &of_vertices, &of_corners).into_bytes();
    out.reserve(mesh.vertices.len() * 24 + mesh.faces.len() * 17);
    for (number, vertex) in (0..).zip(&mesh.vertices) {
        out.extend(vertex.to_array().iter().flat_map(|x| x.to_le_bytes()));
        for (attribute, number_type) in &of_vertices {
            for x in attribute.value(number).unwrap_or_default() {
                number_type.write(*x, &mut out);
            }
        }
    }
    for (number, face) in (0..).zip(&mesh.faces) {
        out.push(3);
        out.extend(face.iter().flat_map(|i| i.to_le_bytes()));
        if !mesh.polygons.is_empty() {
            out.extend(mesh.polygon(number).to_le_bytes());
        }
        for attribute in &of_corners {
            out.push(3 * attribute.width as u8);
            for corner in 0..3 {
                match mesh.corner_value(attribute, number, corner) {
                    Some(value) => out.extend(value.iter().flat_map(|x| x.to_le_bytes())),
                    None => out.extend([f64::NAN.to_le_bytes()].repeat(attribute.width).as_flattened()),
                }
            }
        }
    }
    Ok(out.into())
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
    fn of(attribute: &Attribute) -> NumberType {
        let is_step = |x: &f64| (0.0..=1.0).contains(x) && (x * 255.0).round() / 255.0 == *x;
        let is_single = |x: &f64| f64::from(*x as f32).to_bits() == x.to_bits();
        if attribute.name == "color" && attribute.values.iter().all(is_step) {
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

fn header(
    mesh: &TriangleMesh,
    of_vertices: &[(&Attribute, NumberType)],
    of_corners: &[&Attribute],
) -> String {
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
        mesh.vertices.len()
    );
    // Writing to a string cannot fail.
    for (attribute, number_type) in of_vertices {
        for property in properties(attribute) {
            let _ = writeln!(out, "property {} {property}", number_type.name());
        }
    }
    let _ = writeln!(out, "element face {}\nproperty list uchar uint vertex_indices", mesh.faces.len());
    if !mesh.polygons.is_empty() {
        let _ = writeln!(out, "property uint {POLYGON}");
    }
    for Attribute { name, .. } in of_corners {
        let list = if name == "uv" { TEXTURE.into() } else { format!("{CORNER}{}", word(name)) };
        let _ = writeln!(out, "property list uchar double {list}");
    }
    out + "end_header\n"
}

/// The properties of an attribute of vertices.
fn properties(attribute: &Attribute) -> Vec<String> {
    let Attribute { name, width, .. } = attribute;
    let known = SETS.iter().find(|(set, properties)| set == name && properties.len() == *width);
    match known {
        Some((_, properties)) => properties.iter().map(|property| (*property).into()).collect(),
        None if *width == 1 => vec![word(name)],
        None => (0..*width).map(|i| format!("{}_{i}", word(name))).collect(),
    }
}

/// A name as one word: PLY separates words by blanks.
fn word(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join("_")
}
