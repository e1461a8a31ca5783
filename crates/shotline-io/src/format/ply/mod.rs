//! PLY, the Stanford polygon format: text and both binary forms.
//!
//! This crate has its own reader, because the maintained library, `ply-rs-bw`, gives no byte offset for a broken binary
//! file, and exhausts the memory on a header that declares four thousand million rows without columns.

mod attributes;
mod header;
mod property_names;
mod rows;
mod write;

use shotline::math::Vec3;
use shotline::solid::mesh::Attribute;

use self::attributes::{FaceAttributes, VertexAttributes};
use self::header::{Element, Encoding, Header, Shape};
use self::rows::{AsciiRows, BinaryRows, Layout, Rows};
use crate::bytes::{Cursor, without_zeros};
use crate::diagnostic::RawDiagnostic;
use crate::format::{Content, Format, Keeps};
use crate::lines::mark_length;
use crate::mesh_file::MeshFile;
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "PLY",
    extensions: &["ply"],
    detect: |bytes| {
        let text = &bytes[mark_length(bytes)..];
        text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace)
    },
    content: Content::Mesh { read, write: write::write, keeps: Keeps::Nothing, is_lossless: true },
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
    /// Of the vertices.
    attributes: Vec<Attribute>,
    of_faces: Option<FaceAttributes>,
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

const WRONG_LISTS: NoteKind = NoteKind {
    name: "wrong_lists",
    effect: Effect::Changed,
    one: "1 list of values of the corners of a face was left out, because its length is wrong",
    many: "# lists of values of the corners of faces were left out, because their lengths are wrong",
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
        Ok(Tables {
            header,
            bytes,
            vertices: Vertices::default(),
            polygons,
            attributes: Vec::new(),
            of_faces: None,
            not_read: Vec::new(),
        })
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
        self.leave_out_attributes();
        let Tables { mut attributes, of_faces, .. } = self;
        self.polygons.finish_with(self.vertices, 0, self.bytes, |corners| {
            let of_faces = of_faces.into_iter().flat_map(|of_faces| of_faces.finish(corners));
            for attribute in of_faces {
                if attributes.iter().all(|known| known.name != attribute.name) {
                    attributes.push(attribute);
                }
            }
            attributes
        })
    }

    fn read_vertices(&mut self, element: &'f Element, rows: &mut impl Rows) -> Result<(), RawDiagnostic> {
        let mut columns = [0; 3];
        for (column, name) in columns.iter_mut().zip(["x", "y", "z"]) {
            let found =
                element.properties.iter().position(|p| p.name == name && matches!(p.shape, Shape::One(_)));
            *column = found.ok_or_else(|| RawDiagnostic::file(format!("has vertices without '{name}'")))?;
        }
        // The count is known to be in proportion to the bytes of the file.
        self.vertices.reserve(element.count);
        let mut attributes = VertexAttributes::of(element, &columns);
        let read: Vec<usize> = columns.into_iter().chain(attributes.columns()).collect();
        self.leave_out(element, &read);
        let (mut numbers, mut row) = (Vec::new(), vec![0.0; element.properties.len()]);
        for _ in 0..element.count {
            rows.begin()?;
            for (x, property) in row.iter_mut().zip(&element.properties) {
                numbers.clear();
                rows.property(property.shape, &mut numbers)?;
                *x = numbers.first().copied().unwrap_or_default();
            }
            rows.end(self.polygons.notes())?;
            self.vertices.push(Vec3::from(columns.map(|column| row[column])), || rows.location());
            attributes.push(&row);
        }
        self.attributes.extend(attributes.finish());
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
        let attributes =
            (element.name == "face" && self.polygons.is_empty()).then(|| FaceAttributes::of(element));
        let mut attributes = attributes.filter(|attributes| !attributes.is_empty());
        if attributes.is_some() {
            self.polygons.number_corners();
        }
        let of_attributes = attributes.iter().flat_map(FaceAttributes::columns);
        let read: Vec<usize> = [corners].into_iter().chain(number).chain(of_attributes).collect();
        self.leave_out(element, &read);
        self.polygons.reserve(element.count);
        let (mut row, mut polygon) = (vec![Vec::new(); element.properties.len()], Vec::new());
        for i in 0..element.count {
            rows.begin()?;
            for (numbers, property) in row.iter_mut().zip(&element.properties) {
                numbers.clear();
                rows.property(property.shape, numbers)?;
            }
            if let Some(number) = number.and_then(|number| row[number].first()) {
                self.polygons.number(*number as i64).map_err(|least| {
                    let name = &element.name;
                    rows.diagnostic(format!(
                        "{name} {i} has the polygon number {number}, but numbers ascend, here from {least}"
                    ))
                })?;
            }
            rows.end(self.polygons.notes())?;
            polygon.clear();
            polygon.extend(row[corners].iter().map(|x| *x as Corner));
            let first_corner = self.polygons.corners_read();
            add(self, &polygon, rows).map_err(|corner| {
                let (name, count) = (&element.name, self.polygons.vertices());
                rows.diagnostic(format!(
                    "{name} {i} names vertex {corner}, but there are {count}, counted from 0"
                ))
            })?;
            if let Some(attributes) = &mut attributes {
                let notes = self.polygons.notes();
                attributes.push(&row, first_corner, polygon.len(), |column| {
                    notes.quote(&WRONG_LISTS, rows.location(), || element.properties[column].name.clone());
                });
            }
        }
        self.of_faces = self.of_faces.take().or(attributes);
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

    /// Leaves out the attributes of vertices that not all of them have, because a second table of vertices has other properties.
    /// Notes them, and the attributes of faces whose names are those of vertices, which are left out too.
    fn leave_out_attributes(&mut self) {
        let vertices = self.vertices.len();
        let (kept, left_out) = self.attributes.drain(..).partition(|attribute| attribute.rows() == vertices);
        self.attributes = kept;
        let left_out: Vec<Attribute> = left_out;
        let of_vertices = left_out.iter().map(|attribute| format!("{} of some vertices", attribute.name));
        let is_of_vertices = |name: &&str| self.attributes.iter().any(|known| known.name == *name);
        let of_faces = self.of_faces.iter().flat_map(FaceAttributes::names).filter(is_of_vertices);
        let of_faces = of_faces.map(|name| format!("{name} of faces, since vertices have it"));
        let names: Vec<String> = of_vertices.chain(of_faces).collect();
        if !names.is_empty() {
            let what = if names.len() == 1 { "attribute was" } else { "attributes were" };
            let text = format!("{} {what} left out: {}", names.len(), names.join(", "));
            self.polygons.notes().push(Note::new("attributes_left_out", Effect::Changed, names.len(), text));
        }
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
