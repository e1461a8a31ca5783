//! Notes: what a reader skipped, dropped or repaired. A reader never does so silently.

use std::fmt::{self, Display, Formatter};

use crate::lines::line_at;
use crate::location::RawLocation;

/// Something that a reader, or a later step such as welding, did beyond reading the file as written. Displayed as one
/// line of text, as in "part.obj: 2 faces of fewer than three corners were dropped, the first on line 9".
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// A name for programs, as in `short_faces`. Part of the output of `--json`.
    pub kind: &'static str,
    /// What it means for the model.
    pub effect: Effect,
    /// How many times; at least 1.
    pub count: usize,
    /// What was done, with the count, as in "2 faces of fewer than three corners were dropped".
    pub text: String,
    /// The file, as the user or the scene names it.
    pub file: Option<String>,
    /// The first location in the file.
    pub first: Option<Spot>,
    /// The word at the first location, where it is informative: an unknown keyword.
    pub word: Option<String>,
}

/// What a note means for the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The geometry is that of the file: polygons were triangulated, or normals and colours were not read.
    Kept,
    /// Something was dropped or repaired, so the model may differ from what the author of the file intended.
    Changed,
}

/// A location in a file, in the file's own numbering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// A line of a text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
    /// A vertex, counted as the format does: from 1 in OBJ, from 0 in PLY.
    Vertex(usize),
}

impl Note {
    /// A note without a file and without a location.
    pub fn new(kind: &'static str, effect: Effect, count: usize, text: impl Into<String>) -> Note {
        Note { kind, effect, count, text: text.into(), file: None, first: None, word: None }
    }

    /// The same note, of this file.
    pub fn of_file(self, file: impl Into<String>) -> Note {
        Note { file: Some(file.into()), ..self }
    }
}

impl Display for Note {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{file}: ")?;
        }
        f.write_str(&self.text)?;
        let first = if self.count > 1 { " the first" } else { "" };
        let word = self.word.as_ref().map_or_else(String::new, |word| format!(" '{word}'"));
        match self.first {
            None => Ok(()),
            Some(Spot::Line(line)) => write!(f, ",{first}{word} on line {line}"),
            Some(Spot::Byte(byte)) => write!(f, ",{first}{word} at byte {byte}"),
            Some(Spot::Vertex(vertex)) => write!(f, ",{first}{word} vertex {vertex}"),
        }
    }
}

/// One kind of note: its name, its effect, and its texts for one and for several, in which `#` stands for the count.
#[derive(Debug)]
pub(crate) struct NoteKind {
    pub(crate) name: &'static str,
    pub(crate) effect: Effect,
    pub(crate) one: &'static str,
    pub(crate) many: &'static str,
}

/// The notes of a reader while it reads: each kind with its count and first location.
#[derive(Clone, Debug, Default)]
pub(crate) struct Notes {
    counted: Vec<Counted>,
    complete: Vec<Note>,
}

#[derive(Clone, Debug)]
struct Counted {
    kind: &'static NoteKind,
    count: usize,
    first: RawLocation,
    word: Option<String>,
}

impl Notes {
    /// Counts one more of a kind.
    pub(crate) fn add(&mut self, kind: &'static NoteKind, at: RawLocation) {
        self.add_many(kind, 1, at);
    }

    /// Adds to the count of a kind; `at` is the location of the first of them.
    pub(crate) fn add_many(&mut self, kind: &'static NoteKind, count: usize, at: RawLocation) {
        self.count(kind, count, at, || None);
    }

    /// Counts one more of a kind, and keeps a word of the file to quote from the first.
    pub(crate) fn quote(&mut self, kind: &'static NoteKind, at: RawLocation, word: impl FnOnce() -> String) {
        self.count(kind, 1, at, || Some(word()));
    }

    fn count(
        &mut self,
        kind: &'static NoteKind,
        count: usize,
        at: RawLocation,
        word: impl FnOnce() -> Option<String>,
    ) {
        if count == 0 {
            return;
        }
        match self.counted.iter_mut().find(|known| known.kind.name == kind.name) {
            Some(known) => known.count += count,
            None => self.counted.push(Counted { kind, count, first: at, word: word() }),
        }
    }

    /// Adds a complete note.
    pub(crate) fn push(&mut self, note: Note) {
        self.complete.push(note);
    }

    /// The notes, with line numbers in the text that these bytes hold.
    pub(crate) fn finish(self, bytes: &[u8]) -> Vec<Note> {
        self.counted.into_iter().map(|found| found.note(bytes)).chain(self.complete).collect()
    }
}

impl Counted {
    fn note(self, bytes: &[u8]) -> Note {
        let words = if self.count == 1 { self.kind.one } else { self.kind.many };
        let text = words.replace('#', &self.count.to_string());
        let first = match self.first {
            RawLocation::Text(range) => Some(Spot::Line(line_at(bytes, range.start))),
            RawLocation::Byte(byte) => Some(Spot::Byte(byte)),
            RawLocation::File => None,
        };
        Note { first, word: self.word, ..Note::new(self.kind.name, self.kind.effect, self.count, text) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ODD: NoteKind =
        NoteKind { name: "odd", effect: Effect::Changed, one: "1 odd line", many: "# odd lines" };

    #[test]
    fn notes_have_a_count_and_the_first_location() {
        let text = b"a\rb\r\nc\n\nd";
        let shown = |places: &[usize]| {
            let mut notes = Notes::default();
            places.iter().for_each(|at| notes.add(&ODD, RawLocation::Text(*at..*at + 1)));
            notes.finish(text)[0].clone().of_file("x.obj").to_string()
        };
        assert_eq!(shown(&[2]), "x.obj: 1 odd line, on line 2");
        assert_eq!(shown(&[5, 2, 8]), "x.obj: 3 odd lines, the first on line 3");
        assert_eq!(shown(&[8]), "x.obj: 1 odd line, on line 5");
        let mut notes = Notes::default();
        notes.add_many(&ODD, 7, RawLocation::Byte(84));
        assert_eq!(notes.finish(&[])[0].to_string(), "7 odd lines, the first at byte 84");
        assert_eq!(
            Note::new("weld", Effect::Changed, 2, "2 vertices merged").to_string(),
            "2 vertices merged"
        );
    }
}
