//! The rows of a PLY table, from text or from binary, as numbers in float64 (which holds every PLY type exactly).

use super::header::{Encoding, Scalar, Shape};
use crate::bytes::{Cursor, Word, without_comment, words};
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

/// Reads one row after another.
pub(super) trait Rows {
    /// Begins a row.
    fn begin(&mut self) -> Result<(), RawDiagnostic>;

    /// Appends the numbers of a property.
    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), RawDiagnostic>;

    /// Ends a row.
    fn end(&mut self, notes: &mut Notes) -> Result<(), RawDiagnostic>;

    /// Ends the last row.
    fn end_all(&mut self, notes: &mut Notes) -> Result<(), RawDiagnostic>;

    /// The location of the row read last.
    fn location(&self) -> RawLocation;

    /// A diagnostic of the row read last.
    fn diagnostic(&self, message: String) -> RawDiagnostic {
        RawDiagnostic { location: self.location(), message, help: None, file: None }
    }
}

const EXTRA_NUMBERS: NoteKind = NoteKind {
    name: "extra_numbers",
    effect: Effect::Changed,
    one: "1 row has more numbers than the header says; they were dropped",
    many: "# rows have more numbers than the header says; they were dropped",
};

const EXTRA_LINES: NoteKind = NoteKind {
    name: "extra_lines",
    effect: Effect::Changed,
    one: "1 line behind the last row was dropped",
    many: "# lines behind the last row were dropped",
};

const EXTRA_BYTES: NoteKind = NoteKind {
    name: "extra_bytes",
    effect: Effect::Changed,
    one: "1 byte behind the last row was dropped",
    many: "# bytes behind the last row were dropped",
};

const BEYOND: NoteKind = NoteKind {
    name: "beyond_type",
    effect: Effect::Changed,
    one: "1 whole number is beyond the type that the header gives it; it was read as written",
    many: "# whole numbers are beyond the types that the header gives them; they were read as written",
};

const LOOSE_ROWS: NoteKind = NoteKind {
    name: "loose_rows",
    effect: Effect::Kept,
    one: "rows do not stand on lines of their own; the numbers were read one after another",
    many: "rows do not stand on lines of their own; the numbers were read one after another",
};

/// How the rows of a text relate to its lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Layout {
    /// A row is a line, as the format says.
    Lines,
    /// Rows follow each other regardless of lines, and must fill the file exactly.
    Loose,
}

/// The rows of a text.
pub(super) struct AsciiRows<'b> {
    cursor: Cursor<'b>,
    layout: Layout,
    line: Vec<Word<'b>>,
    next: usize,
    start: usize,
    /// The range of the number read last, if it is out of the range of its type.
    beyond: Option<std::ops::Range<usize>>,
    /// The count of numbers outside of lists that are out of range, and the location of the first.
    all_beyond: usize,
    first_beyond: Option<RawLocation>,
}

impl<'b> AsciiRows<'b> {
    pub(super) fn new(cursor: Cursor<'b>, layout: Layout) -> AsciiRows<'b> {
        AsciiRows {
            start: cursor.at,
            cursor,
            layout,
            line: Vec::new(),
            next: 0,
            beyond: None,
            all_beyond: 0,
            first_beyond: None,
        }
    }

    /// Moves to the next line that has words; returns whether there is one.
    fn next_line(&mut self) -> bool {
        self.line.clear();
        self.next = 0;
        while self.line.is_empty() {
            let Some((start, line)) = self.cursor.line() else { return false };
            self.start = start;
            self.line.extend(words(without_comment(line), start));
            if self.line.first().is_some_and(|w| w.bytes == b"comment") {
                self.line.clear();
            }
        }
        true
    }

    fn word(&mut self) -> Result<Word<'b>, RawDiagnostic> {
        while self.layout == Layout::Loose && self.next >= self.line.len() && self.next_line() {}
        let word = self.line.get(self.next).copied();
        self.next += 1;
        word.ok_or_else(|| self.diagnostic("numbers are missing on this line".into()))
    }

    fn number(&mut self, ty: Scalar) -> Result<f64, RawDiagnostic> {
        let word = self.word()?;
        let Some((least, most)) = ty.range() else {
            // Reads all digits, also those beyond the precision of a float32.
            let odd = || word.is_odd().then_some(f64::NAN);
            let diagnostic =
                || RawDiagnostic::text(word.range(), format!("'{}' is not such a number", word.shown()));
            return word.parse::<f64>().or_else(odd).ok_or_else(diagnostic);
        };
        let number = word.parse::<i64>().ok_or_else(|| {
            RawDiagnostic::text(
                word.range(),
                format!("'{}' is not a whole number, as the header says", word.shown()),
            )
        })?;
        self.beyond = (number < least || number > most).then(|| word.range());
        Ok(number as f64)
    }

    /// The length of a list or a number in one. It must be in range: vertex indices must not be guessed.
    fn number_of_list(&mut self, ty: Scalar) -> Result<f64, RawDiagnostic> {
        let number = self.number(ty)?;
        match self.beyond.take() {
            None => Ok(number),
            Some(range) => {
                let (least, most) = ty.range().unwrap_or_default();
                let message =
                    format!("{number} is not within {least} and {most}, as its type in the header says");
                Err(RawDiagnostic::text(range, message))
            }
        }
    }

    /// An upper bound on the number of words that follow.
    fn words_left(&self) -> usize {
        let on_line = self.line.len().saturating_sub(self.next);
        if self.layout == Layout::Lines { on_line } else { on_line + self.cursor.left() / 2 + 1 }
    }
}

impl Rows for AsciiRows<'_> {
    fn begin(&mut self) -> Result<(), RawDiagnostic> {
        if self.layout == Layout::Loose && self.next < self.line.len() || self.next_line() {
            return Ok(());
        }
        Err(RawDiagnostic::byte(self.cursor.at, "the file ends before its last row"))
    }

    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), RawDiagnostic> {
        match shape {
            Shape::One(ty) => {
                out.push(self.number(ty)?);
                if let Some(range) = self.beyond.take() {
                    self.all_beyond += 1;
                    self.first_beyond.get_or_insert(RawLocation::Text(range));
                }
            }
            Shape::List { count, item } => {
                let length = self.number_of_list(count)?;
                let length = list_length(length).ok_or_else(|| self.diagnostic(BAD_LENGTH.into()))?;
                if length > self.words_left() {
                    return Err(self.diagnostic("the list is longer than its line".into()));
                }
                for _ in 0..length {
                    out.push(self.number_of_list(item)?);
                }
            }
        }
        Ok(())
    }

    fn end(&mut self, notes: &mut Notes) -> Result<(), RawDiagnostic> {
        if let (Layout::Lines, Some(word)) = (self.layout, self.line.get(self.next)) {
            notes.add(&EXTRA_NUMBERS, RawLocation::Text(word.range()));
        }
        Ok(())
    }

    fn end_all(&mut self, notes: &mut Notes) -> Result<(), RawDiagnostic> {
        notes.add_many(&BEYOND, self.all_beyond, self.first_beyond.take().unwrap_or(RawLocation::File));
        if self.layout == Layout::Lines {
            while self.next_line() {
                notes.add(&EXTRA_LINES, self.location());
            }
        } else if self.next < self.line.len() || self.next_line() {
            return Err(self.diagnostic("more numbers than the header says".into()));
        } else {
            notes.add(&LOOSE_ROWS, RawLocation::File);
        }
        Ok(())
    }

    fn location(&self) -> RawLocation {
        let end = self.line.last().map_or(self.start, |w| w.range().end);
        RawLocation::Text(self.start..end)
    }
}

/// The rows of a binary file.
pub(super) struct BinaryRows<'b> {
    pub(super) cursor: Cursor<'b>,
    pub(super) encoding: Encoding,
    start: usize,
}

impl<'b> BinaryRows<'b> {
    pub(super) fn new(cursor: Cursor<'b>, encoding: Encoding) -> BinaryRows<'b> {
        BinaryRows { start: cursor.at, cursor, encoding }
    }

    fn number(&mut self, ty: Scalar) -> Result<f64, RawDiagnostic> {
        let at = self.cursor.at;
        let taken = self
            .cursor
            .take(ty.size())
            .ok_or_else(|| RawDiagnostic::byte(at, "the file ends within a row"))?;
        Ok(decode(taken, ty, self.encoding))
    }
}

#[inline(always)]
fn decode(bytes: &[u8], ty: Scalar, encoding: Encoding) -> f64 {
    fn array<const N: usize>(bytes: &[u8], encoding: Encoding) -> [u8; N] {
        let mut out = [0; N];
        out.copy_from_slice(bytes);
        if encoding == Encoding::BigEndian {
            out.reverse();
        }
        out
    }
    match ty {
        Scalar::I8 => f64::from(i8::from_le_bytes(array(bytes, encoding))),
        Scalar::U8 => f64::from(u8::from_le_bytes(array(bytes, encoding))),
        Scalar::I16 => f64::from(i16::from_le_bytes(array(bytes, encoding))),
        Scalar::U16 => f64::from(u16::from_le_bytes(array(bytes, encoding))),
        Scalar::I32 => f64::from(i32::from_le_bytes(array(bytes, encoding))),
        Scalar::U32 => f64::from(u32::from_le_bytes(array(bytes, encoding))),
        Scalar::F32 => f64::from(f32::from_le_bytes(array(bytes, encoding))),
        Scalar::F64 => f64::from_le_bytes(array(bytes, encoding)),
    }
}

impl Rows for BinaryRows<'_> {
    fn begin(&mut self) -> Result<(), RawDiagnostic> {
        self.start = self.cursor.at;
        Ok(())
    }

    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), RawDiagnostic> {
        match shape {
            Shape::One(ty) => out.push(self.number(ty)?),
            Shape::List { count, item } => {
                let count =
                    list_length(self.number(count)?).ok_or_else(|| self.diagnostic(BAD_LENGTH.into()))?;
                if count > self.cursor.left() / item.size() {
                    return Err(
                        self.diagnostic(format!("a list of {count} is longer than the rest of the file"))
                    );
                }
                let bytes = self.cursor.take(count * item.size()).unwrap_or_default();
                out.extend(bytes.chunks_exact(item.size()).map(|number| decode(number, item, self.encoding)));
            }
        }
        Ok(())
    }

    fn end(&mut self, _: &mut Notes) -> Result<(), RawDiagnostic> {
        Ok(())
    }

    fn end_all(&mut self, notes: &mut Notes) -> Result<(), RawDiagnostic> {
        notes.add_many(&EXTRA_BYTES, self.cursor.left(), RawLocation::Byte(self.cursor.at));
        Ok(())
    }

    fn location(&self) -> RawLocation {
        RawLocation::Byte(self.start)
    }
}

const BAD_LENGTH: &str = "the length of a list is negative";

/// The length of a list; `None` if negative.
fn list_length(count: f64) -> Option<usize> {
    (count >= 0.0).then_some(count as usize)
}
