//! PLY, the Stanford polygon format: text and both binary forms.
//!
//! This crate has its own reader, because the maintained library, `ply-rs-bw`, gives no byte offset for a broken binary
//! file, and exhausts the memory on a header that declares four thousand million rows without columns.

mod header;
mod rows;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use self::header::{Element, Encoding, Header, Shape};
use self::rows::{AsciiRows, BinaryRows, Layout, Rows};
use crate::bytes::{Cursor, without_zeros};
use crate::diagnostic::RawDiagnostic;
use crate::error::WriteError;
use crate::format::{Content, Format};
use crate::lines::mark_length;
use crate::mesh_file::{Encoded, MeshFile};
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "PLY",
    extensions: &["ply"],
    detect: |bytes| {
        let text = &bytes[mark_length(bytes)..];
        text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace)
    },
    content: Content::Mesh { read, write, is_lossless: true },
};

fn read(bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
    let mut notes = Notes::default();
    let header = header::read(bytes, &mut notes)?;
    if header.encoding != Encoding::Ascii {
        let cursor = Cursor::new(bytes, header.end);
        return Tables::new(&header, bytes, notes)?.read(&mut BinaryRows::new(cursor, header.encoding));
    }
    let bytes = without_zeros(bytes, &mut notes)?;
    let cursor = || Cursor::new(bytes, header.end);
    let read_as =
        |layout| Tables::new(&header, bytes, notes.clone())?.read(&mut AsciiRows::new(cursor(), layout));
    // If neither layout fits, the error of the one by lines is reported.
    read_as(Layout::Lines).or_else(|diagnostic| read_as(Layout::Loose).map_err(|_| diagnostic))
}

/// Refuses counts for which the file has too few bytes.
fn check_count(element: &Element, header: &Header, bytes: usize) -> Result<(), RawDiagnostic> {
    let left = bytes - header.end;
    // The last row of a text may have no line break.
    let most = (left + 1) / element.min_row_bytes(header.encoding).max(1);
    if element.properties.is_empty() || element.count <= most {
        return Ok(());
    }
    let message = format!(
        "the header promises {} rows of '{}', but the {left} bytes after it hold {most} at most",
        element.count, element.name
    );
    Err(RawDiagnostic::text(element.count_at.clone(), message)
        .help("the file is cut off or its header is broken"))
}

/// Reads the tables to a mesh.
struct Tables<'f> {
    header: &'f Header,
    bytes: &'f [u8],
    vertices: Vertices,
    polygons: Polygons,
    not_read: Vec<&'f str>,
}

/// Ends a strip of triangles within a list, which continues with another strip.
const END_OF_STRIP: Corner = -1;

/// The property of a face that holds the number of the polygon it was cut from. Written if triangles and polygons are
/// numbered differently.
const POLYGON: &str = "shotline_polygon";

const STRIPS: NoteKind = NoteKind {
    name: "strips_cut",
    effect: Effect::Kept,
    one: "1 strip of triangles was cut into these",
    many: "# strips of triangles were cut into these",
};

const SEAMS: NoteKind = NoteKind {
    name: "strip_seams",
    effect: Effect::Kept,
    one: "1 triangle with two corners at one vertex, a seam of a strip, was left out",
    many: "# triangles with two corners at one vertex, seams of strips, were left out",
};

impl<'f> Tables<'f> {
    fn new(header: &'f Header, bytes: &'f [u8], notes: Notes) -> Result<Tables<'f>, RawDiagnostic> {
        let count_of = |name: &str| header.elements.iter().find(|e| e.name == name).map_or(0, |e| e.count);
        if count_of("face") == 0 && count_of("tristrips") == 0 {
            let help = "a mesh needs an element 'face' with its list of vertices";
            return Err(RawDiagnostic::file("has no faces").help(help));
        }
        for element in &header.elements {
            check_count(element, header, bytes.len())?;
        }
        let polygons = Polygons::new(count_of("vertex"), notes);
        Ok(Tables { header, bytes, vertices: Vertices::default(), polygons, not_read: Vec::new() })
    }

    fn read(mut self, rows: &mut impl Rows) -> Result<MeshFile, RawDiagnostic> {
        for element in &self.header.elements {
            match element.name.as_str() {
                "vertex" => self.read_vertices(element, rows)?,
                "face" => self.read_lists(element, rows, Tables::add_face)?,
                "tristrips" => self.read_lists(element, rows, Tables::add_strips)?,
                name => {
                    self.not_read.push(name);
                    self.skip(element, rows)?;
                }
            }
        }
        rows.end_all(self.polygons.notes())?;
        let count = self.not_read.len();
        if count > 0 {
            let what = if count == 1 { "property or element was" } else { "properties and elements were" };
            let text = format!("{count} {what} not read: {}", self.not_read.join(", "));
            self.polygons.notes().push(Note::new("not_read", Effect::Kept, count, text));
        }
        self.polygons.finish(self.vertices, 0, self.bytes)
    }

    fn read_vertices(&mut self, element: &'f Element, rows: &mut impl Rows) -> Result<(), RawDiagnostic> {
        let mut columns = [0; 3];
        for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
            let found =
                element.properties.iter().position(|p| p.name == name && matches!(p.shape, Shape::One(_)));
            *column = found.ok_or_else(|| RawDiagnostic::file(format!("has vertices without '{name}'")))?;
        }
        self.leave_out(element, &columns);
        // The count is known to be in proportion to the bytes of the file.
        self.vertices.reserve(element.count);
        let mut numbers = Vec::new();
        for _ in 0..element.count {
            let mut xyz = [0.0; 3];
            rows.begin()?;
            for (p, property) in element.properties.iter().enumerate() {
                numbers.clear();
                rows.property(property.shape, &mut numbers)?;
                for (x, _) in xyz.iter_mut().zip(columns).filter(|(_, column)| *column == p) {
                    *x = numbers[0];
                }
            }
            rows.end(self.polygons.notes())?;
            self.vertices.push(Vec3::from(xyz), || rows.location());
        }
        Ok(())
    }

    /// Reads a list of vertices from each row.
    fn read_lists<R: Rows>(
        &mut self,
        element: &'f Element,
        rows: &mut R,
        add: fn(&mut Tables<'f>, &[Corner], &R) -> Result<(), Corner>,
    ) -> Result<(), RawDiagnostic> {
        let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
        let corners = element.properties.iter().position(|p| {
            is_corners(&p.name) && matches!(p.shape, Shape::List { item, .. } if item.is_integer())
        });
        let missing = || {
            RawDiagnostic::file(format!(
                "has an element '{}' without a list of whole numbers 'vertex_indices'",
                element.name
            ))
        };
        let corners = corners.ok_or_else(missing)?;
        let number = element
            .properties
            .iter()
            .position(|p| p.name == POLYGON && matches!(p.shape, Shape::One(item) if item.is_integer()));
        let read: Vec<usize> = [corners].into_iter().chain(number).collect();
        self.leave_out(element, &read);
        self.polygons.reserve(element.count);
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
                if Some(p) == number {
                    self.polygons.number(numbers[0] as i64).map_err(|least| {
                        let (name, given) = (&element.name, numbers[0]);
                        rows.diagnostic(format!(
                            "{name} {i} has the polygon number {given}, but numbers ascend, here from {least}"
                        ))
                    })?;
                }
            }
            rows.end(self.polygons.notes())?;
            add(self, &polygon, rows).map_err(|corner| {
                let (name, count) = (&element.name, self.polygons.vertices());
                rows.diagnostic(format!(
                    "{name} {i} names vertex {corner}, but there are {count}, counted from 0"
                ))
            })?;
        }
        Ok(())
    }

    fn add_face(&mut self, corners: &[Corner], rows: &impl Rows) -> Result<(), Corner> {
        self.polygons.add(corners, || rows.location())
    }

    /// Every three consecutive corners are a triangle; every second triangle has its orientation reversed.
    fn add_strips(&mut self, corners: &[Corner], rows: &impl Rows) -> Result<(), Corner> {
        for strip in corners.split(|corner| *corner == END_OF_STRIP).filter(|strip| !strip.is_empty()) {
            if strip.len() < 3 {
                self.polygons.add(strip, || rows.location())?;
                continue;
            }
            self.polygons.notes().add(&STRIPS, rows.location());
            for (i, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = *corners else { continue };
                if a == b || b == c || c == a {
                    self.polygons.notes().add(&SEAMS, rows.location());
                } else {
                    self.polygons.add(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] }, || rows.location())?;
                }
            }
        }
        Ok(())
    }

    /// Notes the properties that do not affect the shape.
    fn leave_out(&mut self, element: &'f Element, read: &[usize]) {
        let others = element.properties.iter().enumerate().filter(|(p, _)| !read.contains(p));
        self.not_read.extend(others.map(|(_, property)| property.name.as_str()));
    }

    fn skip(&mut self, element: &Element, rows: &mut impl Rows) -> Result<(), RawDiagnostic> {
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
            rows.end(self.polygons.notes())?;
        }
        Ok(())
    }
}

/// Writes binary PLY in float64: nothing is lost.
fn write(mesh: &TriangleMesh) -> Result<Encoded, WriteError> {
    let numbered =
        if mesh.polygons.is_empty() { String::new() } else { format!("property uint {POLYGON}\n") };
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_indices\n{numbered}end_header\n",
        mesh.vertices.len(),
        mesh.faces.len()
    );
    let mut out = head.into_bytes();
    out.reserve(mesh.vertices.len() * 24 + mesh.faces.len() * 17);
    for vertex in &mesh.vertices {
        out.extend(vertex.to_array().iter().flat_map(|x| x.to_le_bytes()));
    }
    for (number, face) in (0..).zip(&mesh.faces) {
        out.push(3);
        out.extend(face.iter().flat_map(|i| i.to_le_bytes()));
        if !mesh.polygons.is_empty() {
            out.extend(mesh.polygon(number).to_le_bytes());
        }
    }
    Ok(out.into())
}
