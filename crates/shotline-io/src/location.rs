//! Locations in a file: as readers record them, in bytes, and as users read them, with line, column and snippet.

use std::ops::Range;

use crate::lines::{line_starts, mark_length};

/// A location as a reader records it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RawLocation {
    /// Bytes of a text.
    Text(Range<usize>),
    /// A byte of a binary file.
    Byte(usize),
    /// The file as a whole.
    File,
}

impl RawLocation {
    /// The first byte.
    pub(crate) fn start(&self) -> usize {
        match self {
            RawLocation::Text(range) => range.start,
            RawLocation::Byte(offset) => *offset,
            RawLocation::File => 0,
        }
    }
}

/// A location in a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Location {
    /// A range of a text.
    Text {
        /// The bytes, counted from 0.
        bytes: Range<usize>,
        /// The line, counted from 1.
        line: usize,
        /// The character in the line, counted from 1.
        column: usize,
        /// The line, or a section of it if it is long.
        snippet: Snippet,
    },
    /// A byte of a binary file, counted from 0.
    Byte(usize),
    /// The file as a whole.
    File,
}

/// A line of source with a marked range.
#[derive(Clone, Debug, PartialEq)]
pub struct Snippet {
    /// The text, without control characters.
    pub text: String,
    /// The number of characters before the mark.
    pub before: usize,
    /// The number of marked characters, at least one.
    pub marked: usize,
}

/// The starts of the lines of a text.
pub(crate) struct Lines<'b> {
    bytes: &'b [u8],
    starts: Vec<usize>,
}

impl Lines<'_> {
    pub(crate) fn of(bytes: &[u8]) -> Lines<'_> {
        // The column after a byte order mark is the first.
        let first = mark_length(bytes);
        Lines { bytes, starts: std::iter::once(first).chain(line_starts(bytes)).collect() }
    }

    /// Adds line, column and snippet to a location in a text.
    pub(crate) fn locate(&self, location: RawLocation) -> Location {
        match location {
            RawLocation::Text(range) => self.text(range),
            RawLocation::Byte(offset) => Location::Byte(offset),
            RawLocation::File => Location::File,
        }
    }

    fn text(&self, range: Range<usize>) -> Location {
        let start = range.start.max(self.starts[0]).min(self.bytes.len());
        let line = self.starts.partition_point(|s| *s <= start);
        let line_start = self.starts[line - 1];
        let line_end = self.starts.get(line).map_or(self.bytes.len(), |next| next - 1);
        let line_end = line_end - usize::from(self.bytes[line_start..line_end].ends_with(b"\r"));
        let marked = start.min(line_end)..range.end.clamp(start.min(line_end), line_end);
        let column = 1 + characters(&self.bytes[line_start..start]);
        let snippet = snippet(self.bytes, line_start..line_end, marked);
        Location::Text { bytes: range, line, column, snippet }
    }
}

/// The number of UTF-8 characters that begin in some bytes.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| **b & 0xC0 != 0x80).count()
}

/// Cuts a window out of a line: enough context before the mark, and at most the width of a screen.
fn snippet(bytes: &[u8], line: Range<usize>, marked: Range<usize>) -> Snippet {
    const BEFORE: usize = 60;
    const AFTER: usize = 60;
    let short = line.len() <= BEFORE + AFTER;
    let mut from = if short { line.start } else { line.start.max(marked.start.saturating_sub(BEFORE)) };
    let mut to = if short { line.end } else { line.end.min(marked.start + AFTER) };
    while from < marked.start && bytes[from] & 0xC0 == 0x80 {
        from += 1;
    }
    while to > marked.start && to < line.end && bytes[to] & 0xC0 == 0x80 {
        to -= 1;
    }
    let marked = marked.start..marked.end.min(to);
    let shown = |r: Range<usize>| plain(&String::from_utf8_lossy(&bytes[r]));
    let (lead, body, rest) = (shown(from..marked.start), shown(marked.clone()), shown(marked.end..to));
    let lead = if from > line.start { format!("...{lead}") } else { lead };
    let rest = if to < line.end { format!("{rest}...") } else { rest };
    Snippet {
        before: lead.chars().count(),
        marked: body.chars().count().max(1),
        text: format!("{lead}{body}{rest}").trim_end().to_string(),
    }
}

/// Text from a file without the control characters that a terminal would obey.
pub(crate) fn plain(text: &str) -> String {
    let printable = |c: char| match c {
        '\t' => ' ',
        c if c.is_control() => '\u{FFFD}',
        c => c,
    };
    text.chars().map(printable).collect()
}
