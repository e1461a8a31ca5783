//! Text STL: `solid ... facet normal ... outer loop, vertex x y z (three times), endloop, endfacet ... endsolid`.
//!
//! The words are read one after another, whatever the lines: some programs write all of a file on one.

use shotline::math::Vec3;

use super::Triangles;
use crate::bytes::{Cursor, Word, words};
use crate::fault::{At, Fault};
use crate::note::{Effect, NoteKind};

const OUTSIDE: NoteKind = NoteKind {
    name: "text_outside",
    effect: Effect::Kept,
    one: "1 line outside of facets says nothing known and was passed over",
    many: "# lines outside of facets say nothing known and were passed over",
};

const COLOURS: NoteKind = NoteKind {
    name: "colours_not_read",
    effect: Effect::Kept,
    one: "1 colour was not read",
    many: "# colours were not read",
};

const JOINED: NoteKind = NoteKind {
    name: "solids_joined",
    effect: Effect::Kept,
    one: "1 solid more was joined with the first to one mesh",
    many: "# solids more were joined with the first to one mesh",
};

const NO_END: NoteKind = NoteKind {
    name: "no_endsolid",
    effect: Effect::Changed,
    one: "the last solid has no 'endsolid'; the file may be cut off",
    many: "the last solid has no 'endsolid'; the file may be cut off",
};

/// Reads a text that begins at a byte.
///
/// # Errors
/// The first word that does not belong where it stands.
pub(super) fn read(bytes: &[u8], start: usize, out: &mut Triangles) -> Result<(), Fault> {
    let mut reader = Reader { cursor: Cursor::new(bytes, start), line: Vec::new(), next: 0, solids: 0 };
    let mut is_open = false;
    while let Some(word) = reader.word() {
        if word.is("facet") {
            reader.facet(word, out)?;
        } else if word.is("solid") {
            is_open = true;
            reader.name(word, out);
        } else if word.is("endsolid") || (word.is("end") && reader.peek().is_some_and(|w| w.is("solid"))) {
            is_open = false;
            reader.end_line();
        } else if word.is("color") || word.is("colour") {
            out.notes().add(&COLOURS, At::Text(word.range()));
            reader.numbers();
        } else {
            if !word.bytes.starts_with(b"#") {
                out.notes().add(&OUTSIDE, At::Text(word.range()));
            }
            reader.end_line();
        }
    }
    if is_open {
        out.notes().add(&NO_END, At::Byte(bytes.len()));
    }
    Ok(())
}

/// The words of a text.
struct Reader<'b> {
    cursor: Cursor<'b>,
    line: Vec<Word<'b>>,
    next: usize,
    solids: usize,
}

impl<'b> Reader<'b> {
    /// The next word without taking it.
    fn peek(&mut self) -> Option<Word<'b>> {
        while self.next >= self.line.len() {
            let (start, line) = self.cursor.line()?;
            self.line.clear();
            self.line.extend(words(line, start));
            self.next = 0;
        }
        Some(self.line[self.next])
    }

    fn word(&mut self) -> Option<Word<'b>> {
        let word = self.peek();
        self.next += 1;
        word
    }

    /// The next word within a facet, behind comments.
    fn word_of_facet(&mut self) -> Result<Word<'b>, Fault> {
        loop {
            let at = self.cursor.at;
            let cut_off = || Fault::byte(at, "the file ends within a facet").help("it is cut off");
            let word = self.word().ok_or_else(cut_off)?;
            if !word.bytes.starts_with(b"#") {
                return Ok(word);
            }
            self.next = self.line.len();
        }
    }

    /// Passes over the rest of a line, which is a name or text. If there is a facet on it, all of the file may be, and
    /// the line is passed over up to that, or to the solid that begins before it.
    fn end_line(&mut self) {
        let rest = self.next..self.line.len();
        let facet = rest.clone().find(|i| self.begins_facet(*i)).unwrap_or(rest.end);
        let solid = rest.skip(1).take_while(|i| *i < facet).find(|i| self.line[*i].is("solid"));
        self.next = solid.filter(|_| facet < self.line.len()).unwrap_or(facet);
    }

    /// Whether the words of the line from here on are the beginning of a facet, and not just the word in a name.
    fn begins_facet(&self, i: usize) -> bool {
        let is = |i: usize, word: &str| self.line.get(i).is_some_and(|w| w.is(word));
        is(i, "facet") && (is(i + 1, "normal") || is(i + 1, "outer"))
    }

    /// Passes over the name of a solid.
    fn name(&mut self, word: Word, out: &mut Triangles) {
        self.solids += 1;
        if self.solids > 1 {
            out.notes().add(&JOINED, At::Text(word.range()));
        }
        let rest = self.next..self.line.len();
        let empty = rest.into_iter().find(|i| self.line[*i].is("endsolid"));
        self.end_line();
        // A solid without facets may end on its line.
        self.next = empty.filter(|i| *i < self.next).unwrap_or(self.next);
    }

    /// Passes over numbers.
    fn numbers(&mut self) {
        while self.peek().is_some_and(|w| w.number().is_ok()) {
            self.next += 1;
        }
    }

    /// Reads a facet behind its first word.
    fn facet(&mut self, first: Word, out: &mut Triangles) -> Result<(), Fault> {
        let mut corners: Vec<Vec3> = Vec::new();
        loop {
            let word = self.word_of_facet()?;
            if word.is("vertex") {
                corners.push(self.vertex(word)?);
            } else if word.is("endfacet") || (word.is("end") && self.takes("facet")) {
                if corners.len() < 3 {
                    let message = format!("this facet has {} corners; it needs three", corners.len());
                    return Err(Fault::text(word.range(), message));
                }
                out.add(&corners, || At::Text(first.range()));
                return Ok(());
            } else if word.is("color") || word.is("colour") {
                out.notes().add(&COLOURS, At::Text(word.range()));
                self.numbers();
            } else if word.is("normal") {
                // What they say follows from the corners, and often they say it wrong.
                for _ in 0..3 {
                    if self.peek().is_some_and(|w| !w.is("outer") && !w.is("vertex")) {
                        self.next += 1;
                    }
                }
            } else if !(word.is("outer") || word.is("loop") || word.is("endloop") || word.is("end")) {
                return Err(Fault::text(
                    word.range(),
                    format!("'{}' is no word of an STL file", word.shown()),
                ));
            }
        }
    }

    /// Takes a word if it comes next.
    fn takes(&mut self, word: &str) -> bool {
        let comes = self.peek().is_some_and(|w| w.is(word));
        self.next += usize::from(comes);
        comes
    }

    fn vertex(&mut self, word: Word) -> Result<Vec3, Fault> {
        let mut place = [0.0; 3];
        for x in &mut place {
            let is_number =
                |w: &Word| !["vertex", "endloop", "end", "endfacet"].into_iter().any(|end| w.is(end));
            let number = self.peek().filter(is_number);
            *x = number
                .ok_or_else(|| Fault::text(word.range(), "a vertex has three coordinates"))?
                .finite()?;
            self.next += 1;
        }
        Ok(place.into())
    }
}
