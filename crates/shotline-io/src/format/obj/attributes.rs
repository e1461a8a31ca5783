//! The attributes of an OBJ file: colours of vertices, and texture coordinates and normals of corners.

use shotline::solid::mesh::Attribute;

use crate::bytes::Word;
use crate::corner_values::CornerValues;
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

const NOT_THERE: NoteKind = NoteKind {
    name: "no_such_attribute",
    effect: Effect::Kept,
    one: "1 corner of a face names a texture or a normal that the file does not have",
    many: "# corners of faces name textures or normals that the file does not have",
};

/// The attributes of a file while it is read.
pub(super) struct Attributes {
    pub(super) uv: Named,
    pub(super) normal: Named,
    /// Three numbers for each vertex up to the last that has a colour, NaN where it has none.
    colors: Vec<f64>,
}

/// Values that corners name by numbers.
pub(super) struct Named {
    values: CornerValues,
    /// Corners that name a value beyond those so far, and their locations.
    later: Vec<(usize, RawLocation)>,
}

impl Default for Attributes {
    fn default() -> Attributes {
        let named = |name, width| Named { values: CornerValues::new(name, width), later: Vec::new() };
        Attributes { uv: named("uv", 2), normal: named("normal", 3), colors: Vec::new() }
    }
}

impl Named {
    /// Adds the value of a line. What is no number is NaN: no shape depends on it.
    pub(super) fn push(&mut self, line: &[Word]) {
        self.values.push(line[1..].iter().map(|word| word.number().unwrap_or(f64::NAN)));
    }

    /// Sets the value of a corner: its number counts from 1, or back from the newest if it is negative.
    fn set(&mut self, corner: usize, number: i64, word: &Word, notes: &mut Notes) {
        let count = self.values.len();
        let from_zero = if number < 0 { count as i64 + number } else { number - 1 };
        match u32::try_from(from_zero) {
            Ok(row) => {
                self.values.set(corner, row);
                if row as usize >= count {
                    self.later.push((corner, RawLocation::Text(word.range())));
                }
            }
            Err(_) => notes.add(&NOT_THERE, RawLocation::Text(word.range())),
        }
    }

    /// Notes the corners that still name values that the file does not have, and leaves them without.
    fn check(&mut self, notes: &mut Notes) {
        for (corner, at) in std::mem::take(&mut self.later) {
            if self.values.unset_beyond(corner) {
                notes.add(&NOT_THERE, at);
            }
        }
    }
}

impl Attributes {
    /// Sets the colour of a vertex.
    pub(super) fn color(&mut self, vertex: usize, color: [&Word; 3]) {
        self.colors.resize(vertex * 3, f64::NAN);
        self.colors.extend(color.map(|word| word.number().unwrap_or(f64::NAN)));
    }

    /// Reads the numbers of a texture and a normal in `v/vt/vn`.
    pub(super) fn corner(
        &mut self,
        word: &Word,
        corner: usize,
        notes: &mut Notes,
    ) -> Result<(), RawDiagnostic> {
        let Some(slash) = word.bytes.iter().position(|b| *b == b'/') else { return Ok(()) };
        let mut numbers = word.bytes[slash + 1..].split(|b| *b == b'/');
        for values in [&mut self.uv, &mut self.normal] {
            let Some(bytes) = numbers.next().filter(|bytes| !bytes.is_empty()) else { continue };
            match (Word { bytes, start: word.start }).parse::<i64>() {
                None | Some(0) => return Err(bad_corner(word)),
                Some(number) => values.set(corner, number, word, notes),
            }
        }
        if numbers.next().is_some() { Err(bad_corner(word)) } else { Ok(()) }
    }

    /// Notes the corners that name values that the file does not have.
    pub(super) fn check(&mut self, notes: &mut Notes) {
        self.uv.check(notes);
        self.normal.check(notes);
    }

    /// Whether corners have values.
    pub(super) fn has_corners(&self) -> bool {
        !self.uv.values.is_empty() || !self.normal.values.is_empty()
    }

    /// The attributes of a mesh with so many vertices; for each triangle its corners, numbered as they were read.
    pub(super) fn finish(mut self, vertices: usize, corners: &[[u32; 3]]) -> Vec<Attribute> {
        let color = (!self.colors.is_empty()).then(|| {
            self.colors.resize(vertices * 3, f64::NAN);
            // Some programs write colours from 0 to 255.
            if self.colors.iter().any(|x| *x > 1.0) {
                self.colors.iter_mut().for_each(|x| *x /= 255.0);
            }
            Attribute::of_vertices("color", 3, self.colors)
        });
        [color, self.uv.values.finish(corners), self.normal.values.finish(corners)]
            .into_iter()
            .flatten()
            .collect()
    }
}

fn bad_corner(word: &Word) -> RawDiagnostic {
    RawDiagnostic::text(word.range(), format!("'{}' is not a corner of a face", word.shown()))
        .help("a corner is v, v/vt, v//vn or v/vt/vn: the numbers of a vertex, a texture and a normal")
}
