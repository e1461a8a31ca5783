//! OFF, the object file format of Geomview: vertices, and faces of any number of corners. Colours, normals and texture
//! coordinates are skipped.
//!
//! Each vertex and each face has a line of its own, as all known programs write them: without lines, a colour after a vertex
//! could not be told from the next vertex.

use std::fmt::Write;
use std::ops::Range;

use shotline::math::Vec3;

use crate::bytes::{Cursor, Word, text_start, without_comment, without_zeros, words};
use crate::diagnostic::RawDiagnostic;
use crate::error::WriteError;
use crate::format::{Content, Format, Keeps, lost_attributes, lost_polygons};
use crate::lines::mark_length;
use crate::location::RawLocation;
use crate::mesh_file::{Encoded, MeshFile, NamedMesh};
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "OFF",
    extensions: &["off"],
    detect: |bytes| {
        let mut lines = Lines::new(&bytes[..bytes.len().min(4096)], mark_length(bytes));
        lines.next().is_some_and(|line| header(&line.words[0]).is_some())
    },
    content: Content::Mesh { read, write, keeps: Keeps::Nothing, is_lossless: false },
};

const BEHIND: NoteKind = NoteKind {
    name: "lines_behind",
    effect: Effect::Changed,
    one: "1 line behind the faces was not read",
    many: "# lines behind the faces were not read",
};

/// A line that has words.
struct Line<'b> {
    words: Vec<Word<'b>>,
    range: Range<usize>,
}

/// The lines that have words besides comments.
struct Lines<'b>(Cursor<'b>);

impl<'b> Lines<'b> {
    fn new(bytes: &'b [u8], start: usize) -> Lines<'b> {
        Lines(Cursor::new(bytes, start))
    }
}

impl<'b> Iterator for Lines<'b> {
    type Item = Line<'b>;

    fn next(&mut self) -> Option<Line<'b>> {
        loop {
            let (start, whole) = self.0.line()?;
            let words: Vec<Word> = words(without_comment(whole), start).collect();
            if !words.is_empty() {
                return Some(Line { words, range: start..start + whole.len() });
            }
        }
    }
}

/// The letters before `OFF` in the word that a file begins with.
fn header<'b>(word: &Word<'b>) -> Option<&'b [u8]> {
    let letters = word.bytes.strip_suffix(b"OFF")?;
    letters.iter().all(|letter| b"STCN4n".contains(letter)).then_some(letters)
}

fn read(bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
    let mut notes = Notes::default();
    let start = text_start(bytes)?;
    let bytes = without_zeros(bytes, &mut notes)?;
    let mut lines = Lines::new(bytes, start);
    let [vertex_count, face_count] = read_counts(&mut lines)?;
    let (mut vertices, mut skipped) = (Vertices::default(), 0);
    vertices.reserve(vertex_count.min(bytes.len()));
    for number in 0..vertex_count {
        let line = lines.next().ok_or_else(|| missing("vertices", vertex_count, number))?;
        let point = read_vertex(&line)?;
        skipped += usize::from(line.words.len() > 3);
        vertices.push(point, || {
            let odd = line.words[..3].iter().find(|word| word.finite().is_err());
            RawLocation::Text(odd.map_or(line.range.clone(), Word::range))
        });
    }
    let mut polygons = Polygons::new(vertex_count, notes);
    let mut corners = Vec::new();
    for number in 0..face_count {
        let line = lines.next().ok_or_else(|| missing("faces", face_count, number))?;
        skipped += usize::from(read_face(&line, &mut corners)?);
        let added = polygons.add(&corners, || RawLocation::Text(line.range.clone()));
        added.map_err(|corner| no_vertex(&line, corner, vertex_count))?;
    }
    for line in lines {
        polygons.notes().add(&BEHIND, RawLocation::Text(line.range));
    }
    if skipped > 0 {
        let lines = if skipped == 1 { "line" } else { "lines" };
        let text = format!("colours, normals and texture coordinates on {skipped} {lines} were not read");
        polygons.notes().push(Note::new("not_read", Effect::Kept, skipped, text));
    }
    polygons.finish(vertices, 0, bytes)
}

/// The numbers of vertices and faces, which a header comes before, on the same line or not.
fn read_counts(lines: &mut Lines) -> Result<[usize; 2], RawDiagnostic> {
    let no_counts = || {
        RawDiagnostic::file("has no numbers of vertices and faces")
            .help("an OFF file begins with OFF, then '8 6 12': the numbers of vertices, faces and edges")
    };
    let mut line = lines.next().ok_or_else(no_counts)?;
    if let Some(letters) = header(&line.words[0]) {
        let first = line.words[0];
        if letters.iter().any(|letter| b"4n".contains(letter)) {
            let message = format!("'{}' has vertices of another dimension than 3", first.shown());
            return Err(
                RawDiagnostic::text(first.range(), message).help("export it with three coordinates a vertex")
            );
        }
        if line.words.get(1).is_some_and(|word| word.is("BINARY")) {
            let diagnostic = RawDiagnostic::text(line.words[1].range(), "binary OFF files are not read");
            return Err(diagnostic.help("export it as text"));
        }
        line.words.remove(0);
        if line.words.is_empty() {
            line = lines.next().ok_or_else(no_counts)?;
        }
    }
    // The number of edges may be missing; nothing depends on it.
    let [vertices, faces, ..] = &line.words[..] else {
        let message = "here are the numbers of vertices and faces expected";
        return Err(RawDiagnostic::text(line.range, message).help("as in '8 6 12'"));
    };
    let count = |word: &Word| {
        let message = || format!("'{}' is not a number of vertices or faces", word.shown());
        word.parse::<u32>()
            .map(|count| count as usize)
            .ok_or_else(|| RawDiagnostic::text(word.range(), message()))
    };
    Ok([count(vertices)?, count(faces)?])
}

fn read_vertex(line: &Line) -> Result<Vec3, RawDiagnostic> {
    let [x, y, z] = line.words.get(..3).unwrap_or(&[]) else {
        let message = "a vertex has three coordinates, on one line";
        return Err(RawDiagnostic::text(line.range.clone(), message));
    };
    Ok(Vec3::new(x.number()?, y.number()?, z.number()?))
}

/// Reads the corners of a face. Returns whether more follows on its line: a colour.
fn read_face(line: &Line, corners: &mut Vec<Corner>) -> Result<bool, RawDiagnostic> {
    let (first, rest) = line.words.split_first().expect("a line has words");
    let count = first.parse::<u32>().map(|count| count as usize).ok_or_else(|| {
        let message = format!("'{}' is not the number of corners of a face", first.shown());
        RawDiagnostic::text(first.range(), message)
            .help("a face is its number of corners and then their vertices: '3 0 1 2'")
    })?;
    let Some(named) = rest.get(..count) else {
        let message = format!("a face of {count} corners has {} on its line", rest.len());
        return Err(RawDiagnostic::text(line.range.clone(), message));
    };
    corners.clear();
    for word in named {
        let corner = word.parse::<Corner>().ok_or_else(|| {
            RawDiagnostic::text(word.range(), format!("'{}' is not the number of a vertex", word.shown()))
        })?;
        corners.push(corner);
    }
    Ok(rest.len() > count)
}

fn missing(what: &str, promised: usize, found: usize) -> RawDiagnostic {
    RawDiagnostic::file(format!("promises {promised} {what}, but has {found}"))
        .help("the file may be cut off, or have several of them on one line")
}

fn no_vertex(line: &Line, corner: Corner, vertices: usize) -> RawDiagnostic {
    let message = format!("there is no vertex {corner}; the file has {vertices}, counted from 0");
    RawDiagnostic::text(line.range.clone(), message)
}

/// Writes numbers in the shortest form that reads back as the same float64: nothing is lost.
fn write(NamedMesh { mesh, .. }: NamedMesh) -> Result<Encoded, WriteError> {
    // Writing to a string cannot fail.
    let mut out = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.faces.len());
    for v in &mesh.vertices {
        let _ = writeln!(out, "{:?} {:?} {:?}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.faces {
        let _ = writeln!(out, "3 {a} {b} {c}");
    }
    let notes = lost_polygons(mesh).into_iter().chain(lost_attributes(mesh)).collect();
    Ok(Encoded { bytes: out.into_bytes(), notes })
}
