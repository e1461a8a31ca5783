//! Wavefront OBJ: vertices and faces, their colours, normals and texture coordinates, names and materials.
//!
//! This crate has its own reader, because the maintained library, `tobj`, renumbers the vertices, accepts NaN, and its
//! errors have neither line nor number.

mod attributes;
mod materials;
mod sections;
mod write;

use std::ops::Range;

use shotline::math::Vec3;

use crate::bytes::{Cursor, Word, text_start, without_comment, without_zeros, words};
use crate::diagnostic::RawDiagnostic;
use crate::format::{Content, Format, Keeps};
use crate::lines::mark_length;
use crate::location::RawLocation;
use crate::mesh_file::MeshFile;
use crate::note::{Effect, Note, NoteKind, Notes};
use crate::polygon::{Corner, Polygons, Vertices};

use self::attributes::Attributes;
pub(crate) use self::materials::{MATERIALS_MARK, read_materials, write_materials};
use self::sections::Sections;

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
    content: Content::Mesh { read, write: write::write, keeps: Keeps::NamesAndMaterials, is_lossless: false },
};

/// What is skipped because it does not affect the shape, with its keywords.
const SKIPPED: &[(&str, &[&[u8]])] = &[
    ("weights of vertices, which polygons do not have", &[]),
    ("texture maps", &[b"maplib", b"usemap"]),
    ("points and lines", &[b"p", b"l"]),
    (
        "display settings",
        &[
            b"s",
            b"mg",
            b"lod",
            b"bevel",
            b"c_interp",
            b"d_interp",
            b"shadow_obj",
            b"trace_obj",
            b"ctech",
            b"stech",
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

/// The index in [`SKIPPED`] of the weights of vertices.
const WEIGHTS: usize = 0;

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
    let mut notes = Notes::default();
    let start = text_start(bytes)?;
    let bytes = without_zeros(bytes, &mut notes)?;
    let mut cursor = Cursor::new(bytes, start);
    let (mut reader, mut line) = (Reader { notes, ..Reader::default() }, Vec::new());
    while let Some((start, end)) = next_line(&mut cursor, &mut line) {
        reader.line(&line, start..end)?;
    }
    reader.finish(bytes)
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    vertices: Vertices,
    /// The corners of all faces.
    corners: Vec<Corner>,
    faces: Vec<Face>,
    attributes: Attributes,
    sections: Sections,
    /// How many lines of each kind in [`SKIPPED`] there are.
    skipped: [usize; SKIPPED.len()],
    notes: Notes,
}

impl Reader {
    fn line(&mut self, line: &[Word], range: Range<usize>) -> Result<(), RawDiagnostic> {
        let Some(first) = line.first() else { return Ok(()) };
        let notes = &mut self.notes;
        match first.bytes {
            b"v" => self.vertex(line, range)?,
            b"vt" => self.attributes.uv.push(line),
            b"vn" => self.attributes.normal.push(line),
            // "fo" is the outline of a face, which is a face since version 3 of the format.
            b"f" | b"fo" => self.face(line, range)?,
            b"o" => self.sections.object(line, self.faces.len()),
            b"g" => self.sections.group(line, self.faces.len()),
            b"usemtl" => self.sections.material(line, self.faces.len()),
            b"mtllib" => self.sections.files.extend(line[1..].iter().map(Word::text)),
            keyword => match SKIPPED.iter().position(|(_, words)| words.contains(&keyword)) {
                Some(kind) => self.skipped[kind] += 1,
                None if CURVED.contains(&keyword) => notes.add(&CURVES, RawLocation::Text(range)),
                None if COMMANDS.contains(&keyword) => notes.add(&NOT_RUN, RawLocation::Text(range)),
                None => notes.quote(&UNKNOWN, RawLocation::Text(range), || first.shown()),
            },
        }
        Ok(())
    }

    fn vertex(&mut self, line: &[Word], range: Range<usize>) -> Result<(), RawDiagnostic> {
        let point = read_vertex(line, range.clone())?;
        self.vertices.push(point, || {
            let odd = line[1..4].iter().find(|w| w.finite().is_err());
            RawLocation::Text(odd.map_or(range, Word::range))
        });
        if line.len() > 4 {
            self.extra_numbers(&line[4..]);
        }
        Ok(())
    }

    /// Reads what a vertex has beyond three coordinates. A fourth number is a weight and three more a colour, with or
    /// without opacity; neither moves the vertex of a polygon. A weight of 1 says nothing.
    fn extra_numbers(&mut self, words: &[Word]) {
        let is_known = words.iter().all(|w| w.number().is_ok());
        match words {
            [weight] if is_known => self.skipped[WEIGHTS] += usize::from(weight.number() != Ok(1.0)),
            [red, green, blue] | [red, green, blue, _] if is_known => {
                self.attributes.color(self.vertices.len() - 1, [red, green, blue]);
            }
            _ => self.notes.quote(&SURPLUS, RawLocation::Text(words[0].range()), || words[0].shown()),
        }
    }

    fn face(&mut self, line: &[Word], range: Range<usize>) -> Result<(), RawDiagnostic> {
        let first = self.corners.len();
        for word in &line[1..] {
            self.corners.push(read_corner(word, self.vertices.len())?);
            self.attributes.corner(word, self.corners.len() - 1, &mut self.notes)?;
        }
        self.faces.push(Face { corners: first..self.corners.len(), line: range });
        Ok(())
    }

    fn finish(mut self, bytes: &[u8]) -> Result<MeshFile, RawDiagnostic> {
        if self.faces.is_empty() {
            return Err(RawDiagnostic::file("has no faces").help("a mesh needs lines 'f 1 2 3'"));
        }
        self.attributes.check(&mut self.notes);
        if let Some(note) = not_read(&self.skipped) {
            self.notes.push(note);
        }
        // Faces may precede vertices, so the number of vertices is known only now.
        let count = self.vertices.len();
        let mut polygons = Polygons::new(count, self.notes);
        if self.attributes.has_corners() {
            polygons.number_corners();
        }
        for face in self.faces {
            let corners = &self.corners[face.corners.clone()];
            let added = polygons.add(corners, || RawLocation::Text(face.line.clone()));
            added.map_err(|corner| no_vertex(&face, corner, count))?;
        }
        let attributes = self.attributes;
        let found =
            polygons.finish_with(self.vertices, 1, bytes, |corners| attributes.finish(count, corners))?;
        Ok(self.sections.give(found))
    }
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
