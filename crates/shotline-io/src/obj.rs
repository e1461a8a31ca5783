//! Wavefront OBJ: its vertices and faces; names, normals, textures and materials are passed over.
//!
//! Our own reader. `tobj`, the well-kept library, renumbers the vertices, reads NaN, and its errors say neither line
//! nor number.

use std::fmt::Write;
use std::ops::Range;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::bytes::{Cursor, Word, mark_length, words};
use crate::error::WriteError;
use crate::fault::{At, Fault};
use crate::format::{Content, Encoded, Format, MeshFile};
use crate::note::{Effect, NoteKind, Notes};
use crate::polygon::{Corner, Polygons};

pub(crate) const FORMAT: Format = Format {
    name: "OBJ",
    extensions: &["obj"],
    // OBJ has no mark of its own: its first line that is no comment says what it is.
    detect: |bytes| {
        let mut cursor = Cursor::new(&bytes[..bytes.len().min(4096)], 0);
        let lines = std::iter::from_fn(|| cursor.line());
        let first = lines.map(|(_, line)| line).find(|l| !l.trim_ascii().is_empty() && !l.starts_with(b"#"));
        first.is_some_and(|l| [&b"v "[..], b"o ", b"g ", b"mtllib "].iter().any(|word| l.starts_with(word)))
    },
    content: Content::Mesh { read, write },
};

/// The keywords of the format that say nothing about where polygons lie.
const KEYWORDS: &[&[u8]] = &[
    b"vt",
    b"vn",
    b"vp",
    b"p",
    b"l",
    b"o",
    b"g",
    b"s",
    b"mg",
    b"mtllib",
    b"usemtl",
    b"maplib",
    b"usemap",
    b"lod",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"call",
    b"csh",
];

const UNKNOWN: NoteKind = NoteKind {
    name: "unknown_keyword",
    effect: Effect::Changed,
    one: "1 line with a keyword that OBJ does not have was passed over",
    many: "# lines with keywords that OBJ does not have were passed over",
};

/// A face as written, with numbers counted from 0 and its place.
struct Face {
    corners: Range<usize>,
    line: Range<usize>,
}

fn read(bytes: &[u8]) -> Result<MeshFile, Fault> {
    let mut vertices: Vec<Vec3> = Vec::new();
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    let mut notes = Notes::default();
    let mut cursor = Cursor::new(bytes, mark_length(bytes));
    let mut line = Vec::new();
    while let Some((start, end)) = next_line(&mut cursor, &mut line) {
        match line.first().map(|w: &Word| w.bytes) {
            Some(b"v") => vertices.push(read_vertex(&line, start..end)?),
            Some(b"f" | b"fo") => {
                let first = corners.len();
                for word in &line[1..] {
                    corners.push(read_corner(word, vertices.len())?);
                }
                faces.push(Face { corners: first..corners.len(), line: start..end });
            }
            None => {}
            Some(keyword) if KEYWORDS.contains(&keyword) || keyword[0] == b'#' => {}
            Some(_) => notes.quote(&UNKNOWN, At::Text(start..end), || line[0].shown()),
        }
    }
    if faces.is_empty() {
        return Err(Fault::file("has no faces").help("a mesh needs lines 'f 1 2 3'"));
    }
    // Only now is it known how many vertices there are: faces may come first.
    let mut polygons = Polygons::new(vertices.len(), notes);
    for (i, face) in faces.into_iter().enumerate() {
        let added = polygons.add(&corners[face.corners], At::Text(face.line.clone()));
        added
            .map_err(|why| Fault::text(face.line, format!("face {i} {why}; here both are counted from 0")))?;
    }
    Ok(polygons.finish(vertices, bytes))
}

/// Reads the words of a line that may go on after a backslash; answers where it begins and ends.
fn next_line<'b>(cursor: &mut Cursor<'b>, out: &mut Vec<Word<'b>>) -> Option<(usize, usize)> {
    out.clear();
    let (start, mut line) = cursor.line()?;
    let mut at = start;
    while let Some(head) = line.strip_suffix(b"\\") {
        out.extend(words(head, at));
        match cursor.line() {
            Some((next, more)) => (at, line) = (next, more),
            None => (at, line) = (at + line.len(), b""),
        }
    }
    out.extend(words(line, at));
    Some((start, at + line.len()))
}

fn read_vertex(line: &[Word], whole: Range<usize>) -> Result<Vec3, Fault> {
    // A fourth number is a weight and three more a colour; neither moves the vertex of a polygon.
    let [x, y, z] = line.get(1..4).unwrap_or(&[]) else {
        return Err(Fault::text(whole, "a vertex has three coordinates"));
    };
    Ok(Vec3::new(x.finite()?, y.finite()?, z.finite()?))
}

/// The vertex of `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative numbers count back from the newest vertex.
fn read_corner(word: &Word, vertices: usize) -> Result<Corner, Fault> {
    let length = word.bytes.iter().position(|b| *b == b'/').unwrap_or(word.bytes.len());
    let number = Word { bytes: &word.bytes[..length], start: word.start };
    match number.parse::<i64>() {
        Some(n) if n > 0 => Ok(n - 1),
        Some(n) if n < 0 && n.unsigned_abs() <= vertices as u64 => Ok(vertices as i64 + n),
        Some(0) => Err(Fault::text(word.range(), "vertices count from 1; there is no vertex 0")),
        Some(n) => Err(Fault::text(
            word.range(),
            format!("{n} counts back further than the {vertices} vertices before"),
        )),
        None => Err(Fault::text(word.range(), format!("'{}' is not a vertex of a face", word.shown()))),
    }
}

/// Numbers in their shortest form that reads back the same: nothing is lost.
fn write(mesh: &TriangleMesh) -> Result<Encoded, WriteError> {
    let mut out = String::new();
    for v in &mesh.vertices {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "v {:?} {:?} {:?}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.faces {
        let _ = writeln!(out, "f {} {} {}", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1);
    }
    Ok(out.into_bytes().into())
}
