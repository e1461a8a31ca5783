//! Wavefront OBJ: its vertices and faces; names, normals, textures and materials are passed over.
//!
//! Our own reader. `tobj`, the well-kept library, renumbers the vertices, reads NaN, and its errors say neither line
//! nor number.

use std::fmt::Write;
use std::ops::Range;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::bytes::{Cursor, Word, mark_length, text_start, without_comment, words};
use crate::error::WriteError;
use crate::fault::{At, Fault};
use crate::format::{Content, Encoded, Format, MeshFile, lost_polygons};
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "OBJ",
    extensions: &["obj"],
    // OBJ has no mark of its own: its first line that is not a comment tells the format.
    detect: |bytes| {
        let mut cursor = Cursor::new(&bytes[..bytes.len().min(4096)], mark_length(bytes));
        let lines = std::iter::from_fn(|| cursor.line());
        let first = lines.map(|(_, line)| line).find(|l| !l.trim_ascii().is_empty() && !l.starts_with(b"#"));
        first.is_some_and(|l| [&b"v "[..], b"o ", b"g ", b"mtllib "].iter().any(|word| l.starts_with(word)))
    },
    content: Content::Mesh { read, write },
};

/// The keywords that say nothing of where polygons lie: what they are for, and they.
const PASSED_OVER: &[(&str, &[&[u8]])] = &[
    ("normals", &[b"vn"]),
    ("texture coordinates", &[b"vt"]),
    ("materials", &[b"mtllib", b"usemtl", b"maplib", b"usemap"]),
    ("names and groups, which become one object", &[b"o", b"g", b"mg"]),
    ("points and lines", &[b"p", b"l"]),
    (
        "display settings",
        &[
            b"s",
            b"lod",
            b"bevel",
            b"c_interp",
            b"d_interp",
            b"shadow_obj",
            b"trace_obj",
            b"ctech",
            b"stech",
            b"call",
            b"csh",
        ],
    ),
];

/// Keywords of curves and curved surfaces.
const CURVED: &[&[u8]] = &[
    b"vp", b"cstype", b"deg", b"bmat", b"step", b"curv", b"curv2", b"surf", b"parm", b"trim", b"hole",
    b"scrv", b"sp", b"end", b"con", b"bsp", b"bzp", b"cdc", b"cdp", b"res",
];

const CURVES: NoteKind = NoteKind {
    name: "curved_surfaces",
    effect: Effect::Changed,
    one: "1 line of curves and curved surfaces was not read",
    many: "# lines of curves and curved surfaces were not read",
};

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
    let mut vertices = Vertices::default();
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    let (mut notes, mut passed_over) = (Notes::default(), [0; PASSED_OVER.len()]);
    let mut cursor = Cursor::new(bytes, text_start(bytes)?);
    let mut line = Vec::new();
    while let Some((start, end)) = next_line(&mut cursor, &mut line) {
        match line.first().map(|w: &Word| w.bytes) {
            Some(b"v") => vertices.push(read_vertex(&line, start..end)?, || {
                let odd = line[1..4].iter().find(|w| w.finite().is_err());
                At::Text(odd.map_or(start..end, Word::range))
            }),
            // The second is the outline of a face, which is a face since version 3 of the format.
            Some(b"f" | b"fo") => {
                let first = corners.len();
                for word in &line[1..] {
                    corners.push(read_corner(word, vertices.len())?);
                }
                faces.push(Face { corners: first..corners.len(), line: start..end });
            }
            None => {}
            Some(keyword) => match PASSED_OVER.iter().position(|(_, words)| words.contains(&keyword)) {
                Some(kind) => passed_over[kind] += 1,
                None if CURVED.contains(&keyword) => notes.add(&CURVES, At::Text(start..end)),
                None => notes.quote(&UNKNOWN, At::Text(start..end), || line[0].shown()),
            },
        }
    }
    if faces.is_empty() {
        return Err(Fault::file("has no faces").help("a mesh needs lines 'f 1 2 3'"));
    }
    if let Some(note) = not_read(&passed_over) {
        notes.push(note);
    }
    // Only now is it known how many vertices there are: faces may come first.
    let mut polygons = Polygons::new(vertices.len(), notes);
    for face in faces {
        let added = polygons.add(&corners[face.corners.clone()], || At::Text(face.line.clone()));
        added.map_err(|corner| no_vertex(&face, corner, vertices.len()))?;
    }
    polygons.finish(vertices, 1, bytes)
}

/// One note on everything that says nothing of the shape.
fn not_read(passed_over: &[usize]) -> Option<Note> {
    let found = PASSED_OVER.iter().zip(passed_over).filter(|(_, lines)| **lines > 0);
    let (kinds, lines): (Vec<&str>, Vec<usize>) = found.map(|((kind, _), lines)| (*kind, *lines)).unzip();
    let count = lines.iter().sum();
    let were = if count == 1 { "line was" } else { "lines were" };
    let text = format!("{count} {were} not read: {}", kinds.join("; "));
    (count > 0).then(|| Note::new("not_read", Effect::Kept, count, text))
}

fn no_vertex(face: &Face, corner: Corner, vertices: usize) -> Fault {
    let number = i128::from(corner) + 1;
    Fault::text(
        face.line.clone(),
        format!("there is no vertex {number}; the file has {vertices}, counted from 1"),
    )
}

/// Reads the words of a line that may go on after a backslash; answers where it begins and ends. A comment does not go
/// on: `# in C:\parts\` ends with its line.
fn next_line<'b>(cursor: &mut Cursor<'b>, out: &mut Vec<Word<'b>>) -> Option<(usize, usize)> {
    out.clear();
    let (start, whole) = cursor.line()?;
    let (mut at, mut whole) = (start, whole);
    loop {
        let line = without_comment(whole);
        let Some(head) = line.strip_suffix(b"\\") else {
            out.extend(words(line, at));
            return Some((start, at + whole.len()));
        };
        out.extend(words(head, at));
        match cursor.line() {
            Some((next, more)) => (at, whole) = (next, more),
            None => return Some((start, at + whole.len())),
        }
    }
}

fn read_vertex(line: &[Word], whole: Range<usize>) -> Result<Vec3, Fault> {
    // A fourth number is a weight and three more a colour; neither moves the vertex of a polygon.
    let [x, y, z] = line.get(1..4).unwrap_or(&[]) else {
        return Err(Fault::text(whole, "a vertex has three coordinates"));
    };
    Ok(Vec3::new(x.number()?, y.number()?, z.number()?))
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
    Ok(Encoded { bytes: out.into_bytes(), notes: lost_polygons(mesh).into_iter().collect() })
}
