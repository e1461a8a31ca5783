//! PLY, the Stanford polygon format: text and both binary forms.
//!
//! Our own reader. `ply-rs-bw`, the maintained library, gives no byte offset for a broken binary file, and a
//! header that promises four thousand million rows without columns fills the memory.

mod header;
mod rows;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use self::header::{Element, Encoding, Header, Shape};
use self::rows::{AsciiRows, BinaryRows, Rows};
use crate::bytes::Cursor;
use crate::error::WriteError;
use crate::fault::Fault;
use crate::format::{Content, Encoded, Format, MeshFile};
use crate::note::Notes;
use crate::polygon::{Corner, Polygons};

pub(crate) const FORMAT: Format = Format {
    name: "PLY",
    extensions: &["ply"],
    detect: |bytes| bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r"),
    content: Content::Mesh { read, write },
};

fn read(bytes: &[u8]) -> Result<MeshFile, Fault> {
    let header = header::read(bytes)?;
    let cursor = Cursor::new(bytes, header.end);
    match header.encoding {
        Encoding::Ascii => read_tables(&header, bytes, &mut AsciiRows::new(cursor)),
        encoding => read_tables(&header, bytes, &mut BinaryRows::new(cursor, encoding)),
    }
}

fn read_tables(header: &Header, bytes: &[u8], rows: &mut impl Rows) -> Result<MeshFile, Fault> {
    let count_of = |name: &str| header.elements.iter().find(|e| e.name == name).map_or(0, |e| e.count);
    if count_of("face") == 0 {
        let help = "a mesh needs an element 'face' with its list of vertices";
        return Err(Fault::file("has no faces").help(help));
    }
    for element in &header.elements {
        check_count(element, header, bytes.len())?;
    }
    let mut vertices = Vec::new();
    let mut polygons = Polygons::new(count_of("vertex"), Notes::default());
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, rows, &mut vertices)?,
            "face" => read_faces(element, rows, &mut polygons)?,
            _ => skip(element, rows)?,
        }
    }
    Ok(polygons.finish(vertices, bytes))
}

/// Counts are believed only as far as the file has bytes for them.
fn check_count(element: &Element, header: &Header, bytes: usize) -> Result<(), Fault> {
    let left = bytes - header.end;
    // The last row of a text may lack its break.
    let most = (left + 1) / element.least_row(header.encoding).max(1);
    if element.properties.is_empty() || element.count <= most {
        return Ok(());
    }
    let message = format!(
        "the header promises {} rows of '{}', but the {left} bytes after it hold {most} at most",
        element.count, element.name
    );
    Err(Fault::text(element.count_at.clone(), message).help("the file is cut off or its header is broken"))
}

fn read_vertices(element: &Element, rows: &mut impl Rows, out: &mut Vec<Vec3>) -> Result<(), Fault> {
    let mut columns = [0; 3];
    for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
        let found =
            element.properties.iter().position(|p| p.name == name && matches!(p.shape, Shape::One(_)));
        *column = found.ok_or_else(|| Fault::file(format!("has vertices without '{name}'")))?;
    }
    let mut numbers = Vec::new();
    for i in 0..element.count {
        let mut xyz = [0.0; 3];
        rows.begin()?;
        for (p, property) in element.properties.iter().enumerate() {
            numbers.clear();
            rows.property(property.shape, &mut numbers)?;
            for (x, _) in xyz.iter_mut().zip(columns).filter(|(_, column)| *column == p) {
                *x = numbers[0];
            }
        }
        rows.end()?;
        let vertex = Vec3::from(xyz);
        if !vertex.is_finite() {
            return Err(rows.fault(format!("vertex {i} has a coordinate that is NaN or infinite")));
        }
        out.push(vertex);
    }
    Ok(())
}

fn read_faces(element: &Element, rows: &mut impl Rows, out: &mut Polygons) -> Result<(), Fault> {
    let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    let corners = element.properties.iter().position(|p| {
        is_corners(&p.name) && matches!(p.shape, Shape::List { item, .. } if item.is_integer())
    });
    let corners =
        corners.ok_or_else(|| Fault::file("has faces without a list of whole numbers 'vertex_indices'"))?;
    let (mut numbers, mut polygon) = (Vec::new(), Vec::new());
    for i in 0..element.count {
        rows.begin()?;
        for (p, property) in element.properties.iter().enumerate() {
            numbers.clear();
            rows.property(property.shape, &mut numbers)?;
            if p == corners {
                polygon.clear();
                polygon.extend(numbers.iter().map(|x| *x as Corner));
            }
        }
        rows.end()?;
        let at = rows.fault(String::new()).at;
        out.add(&polygon, at).map_err(|why| rows.fault(format!("face {i} {why}")))?;
    }
    Ok(())
}

fn skip(element: &Element, rows: &mut impl Rows) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut numbers = Vec::new();
    for _ in 0..element.count {
        rows.begin()?;
        for property in &element.properties {
            numbers.clear();
            rows.property(property.shape, &mut numbers)?;
        }
        rows.end()?;
    }
    Ok(())
}

/// Binary, in float64: nothing is lost.
pub(crate) fn write(mesh: &TriangleMesh) -> Result<Encoded, WriteError> {
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.faces.len()
    );
    let mut out = head.into_bytes();
    out.reserve(mesh.vertices.len() * 24 + mesh.faces.len() * 13);
    for vertex in &mesh.vertices {
        out.extend(vertex.to_array().iter().flat_map(|x| x.to_le_bytes()));
    }
    for face in &mesh.faces {
        out.push(3);
        out.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    Ok(out.into())
}
