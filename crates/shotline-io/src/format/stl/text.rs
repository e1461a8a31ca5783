//! Text STL: `solid ... facet normal ... outer loop, vertex x y z (three times), endloop, endfacet ... endsolid`.
//!
//! Words are read one after another, regardless of lines: some programs write a whole file on one line. A comment extends
//! from a `#` at the beginning of a word to the end of the line. In a name on the only line of a text `#` is part of the
//! name.

use shotline::math::Vec3;

use super::Triangles;
use crate::bytes::{Cursor, Word, words};
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
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

const NO_END: NoteKind = NoteKind {
    name: "no_endsolid",
    effect: Effect::Changed,
    one: "the last solid has no 'endsolid'; the file may be cut off",
    many: "the last solid has no 'endsolid'; the file may be cut off",
};

/// Reads a text that begins at a byte.
///
/// # Errors
/// The first unexpected word.
pub(super) fn read(bytes: &[u8], start: usize, out: &mut Triangles) -> Result<(), RawDiagnostic> {
    let mut reader = Reader { cursor: Cursor::new(bytes, start), line: Vec::new(), next: 0, solids: 0 };
    let mut is_open = false;
    while let Some(word) = reader.word() {
        if word.is("facet") && (is_open || !reader.is_prose()) {
            reader.facet(word, out)?;
        } else if word.is("solid") {
            is_open = true;
            reader.name(out);
        } else if word.is("endsolid") || (word.is("end") && reader.peek().is_some_and(|w| w.is("solid"))) {
            is_open = false;
            reader.end_line();
        } else if word.is("color") || word.is("colour") {
            out.notes().add(&COLOURS, RawLocation::Text(word.range()));
            reader.numbers();
        } else if reader.is_of_facet(word) {
            let message = format!("'{}' stands outside of a facet", word.shown());
            return Err(RawDiagnostic::text(word.range(), message)
                .help("there is no 'facet' before it, or an 'endfacet' too many"));
        } else {
            out.notes().add(&OUTSIDE, RawLocation::Text(word.range()));
            reader.end_line();
        }
    }
    if is_open {
        out.notes().add(&NO_END, RawLocation::Byte(bytes.len()));
    }
    Ok(())
}

/// The lookahead, in words, to distinguish a facet from a name or a sentence.
const LOOKAHEAD: usize = 8;

/// Reads the words of the next line that has any, without its comment; returns whether there is one.
fn next_line<'b>(cursor: &mut Cursor<'b>, out: &mut Vec<Word<'b>>) -> bool {
    out.clear();
    while let Some((start, line)) = cursor.line() {
        out.extend(words(line, start));
        if line.contains(&b'#')
            && let Some(comment) = out.iter().position(|w| w.bytes.starts_with(b"#"))
        {
            let is_last = || words(cursor.rest(), 0).next().is_none();
            if !(out[0].is("solid") && is_last()) {
                out.truncate(comment);
            }
        }
        if !out.is_empty() {
            return true;
        }
    }
    false
}

/// The first word after a normal.
fn after_normal<'b>(words: &[Word<'b>]) -> Option<Word<'b>> {
    words.iter().find(|w| !w.is("normal") && w.number().is_err()).copied()
}

/// The words of a text.
struct Reader<'b> {
    cursor: Cursor<'b>,
    line: Vec<Word<'b>>,
    next: usize,
    solids: usize,
}

impl<'b> Reader<'b> {
    /// The next word, without consuming it.
    fn peek(&mut self) -> Option<Word<'b>> {
        while self.next >= self.line.len() {
            self.next = 0;
            if !next_line(&mut self.cursor, &mut self.line) {
                return None;
            }
        }
        Some(self.line[self.next])
    }

    fn word(&mut self) -> Option<Word<'b>> {
        let word = self.peek();
        self.next += 1;
        word
    }

    /// The next word within a facet.
    fn word_of_facet(&mut self) -> Result<Word<'b>, RawDiagnostic> {
        let at = self.cursor.at;
        self.word()
            .ok_or_else(|| RawDiagnostic::byte(at, "the file ends within a facet").help("it is cut off"))
    }

    /// Skips the rest of a line, which is a name or text. If it contains a facet, the whole file may be on this line; then
    /// the line is skipped up to that facet, or to the solid that begins before it.
    fn end_line(&mut self) {
        let rest = self.next..self.line.len();
        let facet = rest.clone().find(|i| self.begins_facet(*i)).unwrap_or(rest.end);
        let solid = rest.skip(1).take_while(|i| *i < facet).find(|i| self.line[*i].is("solid"));
        self.next = solid.filter(|_| facet < self.line.len()).unwrap_or(facet);
    }

    /// The next [`LOOKAHEAD`] words from a word of the line, on this line and the next.
    fn following(&self, i: usize) -> Vec<Word<'b>> {
        let mut words: Vec<Word> = self.line.iter().skip(i).take(LOOKAHEAD).copied().collect();
        if words.len() < LOOKAHEAD {
            let mut next = Vec::new();
            next_line(&mut self.cursor.clone(), &mut next);
            words.extend(next.into_iter().take(LOOKAHEAD));
        }
        words
    }

    /// Whether a facet begins at a word of the line, and not a name or prose: `facet`, an optional normal, and a word that
    /// may follow, on this line or the next.
    fn begins_facet(&self, i: usize) -> bool {
        if !self.line[i].is("facet") {
            return false;
        }
        let after = after_normal(&self.following(i + 1));
        after.is_some_and(|w| ["outer", "vertex", "color", "colour"].iter().any(|word| w.is(word)))
    }

    /// Whether the word `facet`, read outside of solids, is part of a sentence: neither the rest of its line nor the next
    /// line continues a facet.
    fn is_prose(&self) -> bool {
        !self.begins_facet(self.next - 1)
            && after_normal(&self.line[self.next..(self.next + LOOKAHEAD).min(self.line.len())]).is_some()
    }

    /// Whether a word at the beginning of a statement is data of a facet.
    fn is_of_facet(&self, word: Word) -> bool {
        let next = self.following(self.next).first().copied();
        (word.is("outer") && next.is_some_and(|w| w.is("loop")))
            || (word.is("vertex") && next.is_some_and(|w| w.number().is_ok()))
    }

    /// Reads the name of a solid.
    fn name(&mut self, out: &mut Triangles) {
        self.solids += 1;
        let start = self.next;
        let empty = (start..self.line.len()).find(|i| self.line[*i].is("endsolid"));
        self.end_line();
        // A solid without facets may end on its line.
        self.next = empty.filter(|i| *i < self.next).unwrap_or(self.next);
        let words: Vec<String> = self.line[start..self.next].iter().map(Word::text).collect();
        out.begin_solid(words.join(" "));
    }

    /// Skips numbers.
    fn numbers(&mut self) {
        while self.peek().is_some_and(|w| w.number().is_ok()) {
            self.next += 1;
        }
    }

    /// Reads a facet after its first word.
    fn facet(&mut self, first: Word, out: &mut Triangles) -> Result<(), RawDiagnostic> {
        let mut corners: Vec<Vec3> = Vec::new();
        loop {
            let word = self.word_of_facet()?;
            if word.is("vertex") {
                corners.push(self.vertex(word)?);
            } else if word.is("endfacet") || (word.is("end") && self.accept("facet")) {
                if corners.len() < 3 {
                    let count = match corners.len() {
                        0 => "no corners",
                        1 => "1 corner",
                        _ => "2 corners",
                    };
                    return Err(RawDiagnostic::text(
                        word.range(),
                        format!("this facet has {count}; it needs three"),
                    ));
                }
                out.add(&corners, || RawLocation::Text(first.range()));
                return Ok(());
            } else if word.is("color") || word.is("colour") {
                out.notes().add(&COLOURS, RawLocation::Text(word.range()));
                self.numbers();
            } else if word.is("normal") {
                // Normals follow from the corners, and those in files are often wrong.
                for _ in 0..3 {
                    if self.peek().is_some_and(|w| !w.is("outer") && !w.is("vertex")) {
                        self.next += 1;
                    }
                }
            } else if word.is("facet") || word.is("solid") || word.is("endsolid") {
                return Err(self.no_endfacet(first, word));
            } else if !(word.is("outer") || word.is("loop") || word.is("endloop") || word.is("end")) {
                return Err(RawDiagnostic::text(
                    word.range(),
                    format!("'{}' is not a word of an STL file", word.shown()),
                ));
            }
        }
    }

    fn no_endfacet(&self, first: Word, word: Word) -> RawDiagnostic {
        let message = format!("'endfacet' is missing before this '{}'", word.shown());
        let diagnostic = RawDiagnostic::text(word.range(), message);
        if self.solids == 0 && word.is("solid") {
            let words = first.shown();
            return diagnostic.help(format!(
                "a '{words}' stands before the first 'solid'; delete what does not belong there"
            ));
        }
        diagnostic
    }

    /// Consumes a word if it is next.
    fn accept(&mut self, word: &str) -> bool {
        let comes = self.peek().is_some_and(|w| w.is(word));
        self.next += usize::from(comes);
        comes
    }

    fn vertex(&mut self, word: Word) -> Result<Vec3, RawDiagnostic> {
        let mut point = [0.0; 3];
        for x in &mut point {
            let is_number =
                |w: &Word| !["vertex", "endloop", "end", "endfacet"].into_iter().any(|end| w.is(end));
            let number = self.peek().filter(is_number);
            *x = number
                .ok_or_else(|| RawDiagnostic::text(word.range(), "a vertex has three coordinates"))?
                .finite()?;
            self.next += 1;
        }
        Ok(point.into())
    }
}
