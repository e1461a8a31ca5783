//! STL: triangles without shared vertices, as text or binary. Corners with the same coordinates become one vertex;
//! otherwise no mesh would be closed.
//!
//! This crate has its own reader, because the maintained library, `stl_io`, reads text in float32 and gives no location
//! when a file is broken.

mod binary;
mod text;
mod write;

use std::collections::HashMap;

use shotline::math::Vec3;

use crate::bytes::{text_start, without_zeros};
use crate::diagnostic::RawDiagnostic;
use crate::format::{Content, Format, Keeps};
use crate::lines::mark_length;
use crate::location::RawLocation;
use crate::mesh_file::{MeshFile, Section};
use crate::note::Notes;
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "STL",
    extensions: &["stl"],
    detect: |bytes| binary::fits(bytes) || starts_like_text(bytes) || looks_like(bytes),
    content: Content::Mesh { read, write: write::write, keeps: Keeps::Names, is_lossless: false },
};

fn starts_like_text(bytes: &[u8]) -> bool {
    begins_with_solid(bytes) && is_text(bytes)
}

fn begins_with_solid(bytes: &[u8]) -> bool {
    let start = bytes[mark_length(bytes)..].trim_ascii_start();
    start.len() > 5 && start[..5].eq_ignore_ascii_case(b"solid")
}

/// Nearly every binary file has a zero byte near its beginning; a text has zero bytes only as padding at its end.
fn is_text(bytes: &[u8]) -> bool {
    let end = bytes.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    !bytes[..end.min(512)].contains(&0)
}

/// Whether a text contains a word of the format, ignoring case.
fn has_word(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word))
}

/// Whether a file is an STL although neither its size nor its beginning says so: a text with a facet, or a binary file
/// with extra bytes after its triangles, with attributes, or with a wrong count.
fn looks_like(bytes: &[u8]) -> bool {
    if is_text(bytes) {
        return has_word(bytes, b"endfacet") && has_word(bytes, b"vertex");
    }
    binary::looks_like(bytes)
}

/// Whether a file is a text STL: a text that begins like one or has facets, even if damaged by zero bytes.
fn text_with_facets(bytes: &[u8]) -> bool {
    if is_text(bytes) {
        return starts_like_text(bytes) || has_word(bytes, b"facet");
    }
    begins_with_solid(bytes) && has_word(bytes, b"endfacet") && has_word(bytes, b"endloop")
}

fn read(bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
    let mut triangles = Triangles::new();
    // Binary files are known by their size; many of them begin with the word "solid".
    if binary::fits(bytes) {
        binary::read(bytes, &mut triangles)?;
    } else {
        let start = text_start(bytes)?;
        if text_with_facets(bytes) {
            let text = without_zeros(bytes, triangles.notes())?;
            text::read(text, start, &mut triangles)?;
        } else if is_text(bytes) && bytes.len() > 5 && bytes.is_ascii() {
            return Err(RawDiagnostic::file(
                "is a text, but not of an STL: there is no 'solid' and no 'facet' in it",
            ));
        } else {
            binary::read(bytes, &mut triangles)?;
        }
    }
    triangles.finish(bytes)
}

/// Collects triangles, and joins corners with the same coordinates.
struct Triangles {
    vertices: Vertices,
    known: HashMap<[u64; 3], u32>,
    polygons: Polygons,
    face: Vec<Corner>,
    sections: Vec<Section>,
}

impl Triangles {
    fn new() -> Triangles {
        // Corners are numbered here, so none can be out of range.
        let polygons = Polygons::new(usize::MAX, Notes::default());
        Triangles {
            vertices: Vertices::default(),
            known: HashMap::new(),
            polygons,
            face: Vec::new(),
            sections: Vec::new(),
        }
    }

    /// Begins a solid with this name.
    fn begin_solid(&mut self, name: String) {
        self.sections.push(Section { first: self.polygons.faces(), name, material: String::new() });
    }

    /// Adds a triangle, or a polygon, as some programs write.
    fn add(&mut self, corners: &[Vec3], at: impl Fn() -> RawLocation) {
        self.face.clear();
        for corner in corners {
            let vertex = self.vertex(*corner);
            self.face.push(vertex.into());
        }
        // Cannot fail: every number is that of a vertex.
        let _ = self.polygons.add(&self.face, at);
    }

    fn vertex(&mut self, point: Vec3) -> u32 {
        // Adding zero turns -0.0 into 0.0, which is the same point.
        let key = (point + Vec3::ZERO).to_array().map(f64::to_bits);
        *self.known.entry(key).or_insert_with(|| {
            self.vertices.push(point, || RawLocation::File);
            (self.vertices.len() - 1) as u32
        })
    }

    fn notes(&mut self) -> &mut Notes {
        self.polygons.notes()
    }

    fn finish(self, bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
        if self.polygons.is_empty() {
            return Err(RawDiagnostic::file("has no triangles"));
        }
        let found = self.polygons.finish(self.vertices, 0, bytes)?;
        Ok(MeshFile { sections: self.sections, ..found })
    }
}
