//! Wavefront OBJ: vertices and faces; names, normals, textures and materials are skipped.
//!
//! This crate has its own reader, because the maintained library, `tobj`, renumbers the vertices, accepts NaN, and its
//! errors have neither line nor number.

use std::fmt::Write;
use std::ops::Range;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::bytes::{Cursor, Word, text_start, without_comment, without_zeros, words};
use crate::diagnostic::RawDiagnostic;
use crate::error::WriteError;
use crate::format::{Content, Format, lost_polygons};
use crate::lines::mark_length;
use crate::location::RawLocation;
use crate::mesh_file::{Encoded, MeshFile};
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

pub(crate) const FORMAT: Format = Format {
    name: "OBJ",
    extensions: &["obj"],
    // OBJ has no signature; the first line that is not a comment identifies it.
    detect: |bytes| {
        let mut cursor = Cursor::new(&bytes[..bytes.len().min(4096)], mark_length(bytes));
        let lines = std::iter::from_fn(|| cursor.line());
        let first = lines.map(|(_, line)| line).find(|l| !l.trim_ascii().is_empty() && !l.starts_with(b"#"));
        first.is_some_and(|l| [&b"v "[..], b"o ", b"g ", b"mtllib "].iter().any(|word| l.starts_with(word)))
    },
    content: Content::Mesh { read, write, is_lossless: false },
};

/// What is skipped because it does not affect the shape, with its keywords.
const SKIPPED: &[(&str, &[&[u8]])] = &[
    ("normals", &[b"vn"]),
    ("texture coordinates", &[b"vt"]),
    ("colours of vertices", &[]),
    ("weights of vertices, which polygons do not have", &[]),
    ("materials", &[b"mtllib", b"usemtl", b"maplib", b"usemap"]),
    ("names and groups, which become one object", &[b"o", b"g", b"mg"]),
    ("points and lines", &[b"p", b"l"]),
    (
        "display settings",
        &[b"s", b"lod", b"bevel", b"c_interp", b"d_interp", b"shadow_obj", b"trace_obj", b"ctech", b"stech"],
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

/// Keywords that run commands, which may add to the model.
const COMMANDS: &[&[u8]] = &[b"call", b"csh"];

const NOT_RUN: NoteKind = NoteKind {
    name: "commands",
    effect: Effect::Changed,
    one: "1 line that takes in another file or runs a command was not followed",
    many: "# lines that take in other files or run commands were not followed",
};

const UNKNOWN: NoteKind = NoteKind {
    name: "unknown_keyword",
    effect: Effect::Changed,
    one: "1 line with a keyword that OBJ does not have was passed over",
    many: "# lines with keywords that OBJ does not have were passed over",
};

const NOT_THERE: NoteKind = NoteKind {
    name: "no_such_attribute",
    effect: Effect::Kept,
    one: "1 corner of a face names a texture or a normal that the file does not have",
    many: "# corners of faces name textures or normals that the file does not have",
};

/// The indices in [`SKIPPED`] of what corners of faces refer to.
const NORMALS: usize = 0;
const TEXTURES: usize = 1;

/// The indices in [`SKIPPED`] of what a line `v` may have besides a position.
const COLOURS: usize = 2;
const WEIGHTS: usize = 3;

const SURPLUS: NoteKind = NoteKind {
    name: "extra_numbers",
    effect: Effect::Changed,
    one: "1 vertex has words behind its coordinates that are neither a weight nor a colour; they were dropped",
    many: "# vertices have words behind their coordinates that are neither a weight nor a colour; they were dropped",
};

/// A face as written: the range of its corners, counted from 0, and its line.
struct Face {
    corners: Range<usize>,
    line: Range<usize>,
}

fn read(bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
    let mut vertices = Vertices::default();
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    let (mut notes, mut skipped) = (Notes::default(), [0; SKIPPED.len()]);
    let start = text_start(bytes)?;
    let bytes = without_zeros(bytes, &mut notes)?;
    let mut cursor = Cursor::new(bytes, start);
    let (mut line, mut attributes) = (Vec::new(), AttributeNumbers::default());
    while let Some((start, end)) = next_line(&mut cursor, &mut line) {
        match line.first().map(|w: &Word| w.bytes) {
            Some(b"v") => {
                let point = read_vertex(&line, start..end)?;
                vertices.push(point, || {
                    let odd = line[1..4].iter().find(|w| w.finite().is_err());
                    RawLocation::Text(odd.map_or(start..end, Word::range))
                });
                if line.len() > 4 {
                    count_extra_numbers(&line, &mut skipped, &mut notes);
                }
            }
            // "fo" is the outline of a face, which is a face since version 3 of the format.
            Some(b"f" | b"fo") => {
                let first = corners.len();
                for word in &line[1..] {
                    corners.push(read_corner(word, vertices.len())?);
                    attributes.check(word, &skipped, &mut notes)?;
                }
                faces.push(Face { corners: first..corners.len(), line: start..end });
            }
            None => {}
            Some(keyword) => match SKIPPED.iter().position(|(_, words)| words.contains(&keyword)) {
                Some(kind) => skipped[kind] += 1,
                None if CURVED.contains(&keyword) => notes.add(&CURVES, RawLocation::Text(start..end)),
                None if COMMANDS.contains(&keyword) => notes.add(&NOT_RUN, RawLocation::Text(start..end)),
                None => notes.quote(&UNKNOWN, RawLocation::Text(start..end), || line[0].shown()),
            },
        }
    }
    if faces.is_empty() {
        return Err(RawDiagnostic::file("has no faces").help("a mesh needs lines 'f 1 2 3'"));
    }
    attributes.finish(&skipped, &mut notes);
    if let Some(note) = not_read(&skipped) {
        notes.push(note);
    }
    // Faces may precede vertices, so the number of vertices is known only now.
    let mut polygons = Polygons::new(vertices.len(), notes);
    for face in faces {
        let added = polygons.add(&corners[face.corners.clone()], || RawLocation::Text(face.line.clone()));
        added.map_err(|corner| no_vertex(&face, corner, vertices.len()))?;
    }
    polygons.finish(vertices, 1, bytes)
}

/// One note of everything that does not affect the shape.
fn not_read(skipped: &[usize]) -> Option<Note> {
    let found = SKIPPED.iter().zip(skipped).filter(|(_, lines)| **lines > 0);
    let (kinds, lines): (Vec<&str>, Vec<usize>) = found.map(|((kind, _), lines)| (*kind, *lines)).unzip();
    let count = lines.iter().sum();
    let were = if count == 1 { "line was" } else { "lines were" };
    let text = format!("{count} {were} not read: {}", kinds.join("; "));
    (count > 0).then(|| Note::new("not_read", Effect::Kept, count, text))
}

fn no_vertex(face: &Face, corner: Corner, vertices: usize) -> RawDiagnostic {
    let number = i128::from(corner) + 1;
    RawDiagnostic::text(
        face.line.clone(),
        format!("there is no vertex {number}; the file has {vertices}, counted from 1"),
    )
}

/// Reads the words of a line, which a backslash continues on the next; returns where it begins and ends. A comment is
/// not continued: `# in C:\parts\` ends with its line.
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

/// Counts what a vertex has beyond three coordinates. A fourth number is a weight and three more a colour, with or
/// without opacity; neither moves the vertex of a polygon. A weight of 1 says nothing.
fn count_extra_numbers(line: &[Word], skipped: &mut [usize], notes: &mut Notes) {
    let words = &line[4..];
    if words.iter().any(|w| w.number().is_err()) {
        return notes.quote(&SURPLUS, RawLocation::Text(words[0].range()), || words[0].shown());
    }
    match words {
        [weight] if weight.number().is_ok_and(|w| w != 1.0) => skipped[WEIGHTS] += 1,
        [_] => {}
        [_, _, _] | [_, _, _, _] => skipped[COLOURS] += 1,
        _ => notes.quote(&SURPLUS, RawLocation::Text(words[0].range()), || words[0].shown()),
    }
}

fn read_vertex(line: &[Word], whole: Range<usize>) -> Result<Vec3, RawDiagnostic> {
    let [x, y, z] = line.get(1..4).unwrap_or(&[]) else {
        return Err(RawDiagnostic::text(whole, "a vertex has three coordinates"));
    };
    Ok(Vec3::new(x.number()?, y.number()?, z.number()?))
}

/// The vertex of `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative numbers count back from the newest vertex.
fn read_corner(word: &Word, vertices: usize) -> Result<Corner, RawDiagnostic> {
    let length = word.bytes.iter().position(|b| *b == b'/').unwrap_or(word.bytes.len());
    let number = Word { bytes: &word.bytes[..length], start: word.start };
    match number.parse::<i64>() {
        Some(n) if n > 0 => Ok(n - 1),
        Some(n) if n < 0 && n.unsigned_abs() <= vertices as u64 => Ok(vertices as i64 + n),
        Some(0) => Err(RawDiagnostic::text(word.range(), "vertices count from 1; there is no vertex 0")),
        Some(n) => Err(RawDiagnostic::text(
            word.range(),
            format!("{n} counts back further than the {vertices} vertices before"),
        )),
        None => {
            Err(RawDiagnostic::text(word.range(), format!("'{}' is not a vertex of a face", word.shown())))
        }
    }
}

/// Checks the numbers of textures and normals in corners against how many the file has.
#[derive(Default)]
struct AttributeNumbers {
    /// Numbers beyond the count so far: the index in [`SKIPPED`], the number and its location.
    later: Vec<(usize, u64, RawLocation)>,
}

impl AttributeNumbers {
    /// Checks `v/vt/vn` after the number of the vertex.
    fn check(&mut self, word: &Word, skipped: &[usize], notes: &mut Notes) -> Result<(), RawDiagnostic> {
        let Some(slash) = word.bytes.iter().position(|b| *b == b'/') else { return Ok(()) };
        let mut numbers = word.bytes[slash + 1..].split(|b| *b == b'/');
        for kind in [TEXTURES, NORMALS] {
            let Some(bytes) = numbers.next().filter(|bytes| !bytes.is_empty()) else { continue };
            match (Word { bytes, start: word.start }).parse::<i64>() {
                None | Some(0) => return Err(bad_corner(word)),
                Some(n) if n < 0 && n.unsigned_abs() > skipped[kind] as u64 => {
                    notes.add(&NOT_THERE, RawLocation::Text(word.range()));
                }
                Some(n) if n > 0 && n as u64 > skipped[kind] as u64 => {
                    self.later.push((kind, n as u64, RawLocation::Text(word.range())));
                }
                Some(_) => {}
            }
        }
        if numbers.next().is_some() { Err(bad_corner(word)) } else { Ok(()) }
    }

    /// Notes the numbers that are still beyond the count at the end.
    fn finish(self, skipped: &[usize], notes: &mut Notes) {
        for (kind, number, at) in self.later {
            if number > skipped[kind] as u64 {
                notes.add(&NOT_THERE, at);
            }
        }
    }
}

fn bad_corner(word: &Word) -> RawDiagnostic {
    RawDiagnostic::text(word.range(), format!("'{}' is not a corner of a face", word.shown()))
        .help("a corner is v, v/vt, v//vn or v/vt/vn: the numbers of a vertex, a texture and a normal")
}

/// Writes numbers in the shortest form that reads back as the same float64: nothing is lost.
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
