//! A cursor over bytes that never reads beyond their end, and the lines, words and numbers of a text.

use crate::diagnostic::RawDiagnostic;
use crate::lines::{break_at, mark_length};
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

/// A position in some bytes.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'b> {
    bytes: &'b [u8],
    pub(crate) at: usize,
}

impl<'b> Cursor<'b> {
    pub(crate) fn new(bytes: &'b [u8], at: usize) -> Cursor<'b> {
        Cursor { bytes, at: at.min(bytes.len()) }
    }

    /// The number of bytes left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The bytes that are left.
    pub(crate) fn rest(&self) -> &'b [u8] {
        &self.bytes[self.at..]
    }

    /// The next `count` bytes; `None` if there are fewer.
    pub(crate) fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    /// The next line and its offset, without its break (`\n`, `\r\n` or `\r`); `None` at the end.
    pub(crate) fn line(&mut self) -> Option<(usize, &'b [u8])> {
        let start = self.at;
        let rest = self.bytes.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at = start + length + break_at(rest, length);
        Some((start, &rest[..length]))
    }
}

/// The offset at which a text begins, after its byte order mark.
///
/// # Errors
/// If it is UTF-16 or UTF-32, which no reader accepts.
pub(crate) fn text_start(bytes: &[u8]) -> Result<usize, RawDiagnostic> {
    match wide_encoding(bytes) {
        None => Ok(mark_length(bytes)),
        Some(name) => Err(RawDiagnostic::file(format!("is {name} text; save it as UTF-8"))
            .help("editors offer the encoding when saving; `iconv -f UTF-16 -t UTF-8` converts it as well")),
    }
}

/// Bytes as text.
///
/// # Errors
/// If they are UTF-16 or UTF-32, or not UTF-8.
pub(crate) fn as_text(bytes: &[u8]) -> Result<&str, RawDiagnostic> {
    text_start(bytes)?;
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        RawDiagnostic::text(at..at + 1, "the text is not UTF-8 from here on").help("save the file as UTF-8")
    })
}

const ZEROS: NoteKind = NoteKind {
    name: "zero_bytes",
    effect: Effect::Changed,
    one: "1 zero byte after the text was dropped; the file may be cut off",
    many: "# zero bytes after the text were dropped; the file may be cut off",
};

/// A text without the zero bytes at its end with which some programs pad files; they are noted.
///
/// # Errors
/// If there is a zero byte within the text: a system crash leaves such files, in which parts of lines are lost.
pub(crate) fn without_zeros<'b>(bytes: &'b [u8], notes: &mut Notes) -> Result<&'b [u8], RawDiagnostic> {
    if !bytes.contains(&0) {
        return Ok(bytes);
    }
    let first = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    let (text, rest) = bytes.split_at(first);
    if rest.iter().all(|b| matches!(b, 0 | 0x1A) || b.is_ascii_whitespace()) {
        notes.add_many(&ZEROS, rest.iter().filter(|b| **b == 0).count(), RawLocation::Text(first..first + 1));
        return Ok(text);
    }
    Err(zero_byte(first))
}

/// The diagnostic for a zero byte within a text.
pub(crate) fn zero_byte(at: usize) -> RawDiagnostic {
    let message = "there is a zero byte (NUL) in the text, so the file is damaged";
    RawDiagnostic::text(at..at + 1, message)
        .help("copy the file again or export it again; what was lost cannot be guessed")
}

/// The name of an encoding wider than 8 bits, recognised by its byte order mark or by the zero bytes between its
/// letters.
pub(crate) fn wide_encoding(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\xFF\xFE\0\0") || bytes.starts_with(b"\0\0\xFE\xFF") {
        return Some("UTF-32");
    }
    let (pairs, _) = bytes[..bytes.len().min(64)].as_chunks::<2>();
    let is_letter = |b: u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let every = |k: usize| pairs.len() > 3 && pairs.iter().all(|p| is_letter(p[k]) && p[1 - k] == 0);
    let is_marked = bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF");
    (is_marked || every(0) || every(1)).then_some("UTF-16")
}

/// A line without its comment. A comment begins with `#`, except in the numbers `1.#IND` and `1.#INF` of old programs.
pub(crate) fn without_comment(line: &[u8]) -> &[u8] {
    let marks = line.iter().enumerate().filter(|(_, b)| **b == b'#').map(|(i, _)| i);
    &line[..marks.into_iter().find(|i| *i == 0 || line[i - 1] != b'.').unwrap_or(line.len())]
}

/// The words of a line, each with its offset; `start` is the offset of the line. The end-of-file character of DOS
/// counts as white space.
pub(crate) fn words(line: &[u8], start: usize) -> impl Iterator<Item = Word<'_>> {
    let mut at = 0;
    let is_gap = |b: &u8| b.is_ascii_whitespace() || matches!(b, 0x0B | 0x1A);
    std::iter::from_fn(move || {
        at += line[at..].iter().position(|b| !is_gap(b))?;
        let length = line[at..].iter().position(is_gap).unwrap_or(line.len() - at);
        let word = Word { bytes: &line[at..at + length], start: start + at };
        at += length;
        Some(word)
    })
}

/// A word of a text file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word<'b> {
    pub(crate) bytes: &'b [u8],
    pub(crate) start: usize,
}

impl Word<'_> {
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.bytes.len()
    }

    /// The whole word as text; what is not UTF-8 is replaced.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(self.bytes).into_owned()
    }

    /// The word for a message: shortened, and readable for any bytes.
    pub(crate) fn shown(&self) -> String {
        String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(40)]).into_owned()
    }

    /// Whether it is this keyword, ignoring case.
    pub(crate) fn is(&self, word: &str) -> bool {
        self.bytes.eq_ignore_ascii_case(word.as_bytes())
    }

    pub(crate) fn parse<T: std::str::FromStr>(&self) -> Option<T> {
        std::str::from_utf8(self.bytes).ok()?.parse().ok()
    }

    /// A number. It may be NaN or infinite, as the C libraries of Unix and Windows write these.
    ///
    /// # Errors
    /// If it is not a number, as in `1,5` or `3.1+e2`.
    pub(crate) fn number(&self) -> Result<f64, RawDiagnostic> {
        self.parse::<f64>().or_else(|| self.is_odd().then_some(f64::NAN)).ok_or_else(|| {
            let diagnostic = RawDiagnostic::text(self.range(), format!("'{}' is not a number", self.shown()));
            if self.bytes.contains(&b',') {
                diagnostic.help("write decimals with a point")
            } else {
                diagnostic
            }
        })
    }

    /// A finite number.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub(crate) fn finite(&self) -> Result<f64, RawDiagnostic> {
        let number = self.number()?;
        let diagnostic = || RawDiagnostic::text(self.range(), format!("{} is not finite", self.shown()));
        number.is_finite().then_some(number).ok_or_else(diagnostic)
    }

    /// Whether this is a spelling of NaN or infinity by old programs: `-1.#IND`, `1.#INF`, `nan(ind)`.
    pub(crate) fn is_odd(&self) -> bool {
        let sign = usize::from(matches!(self.bytes.first(), Some(b'-' | b'+')));
        let lower = self.bytes[sign..].to_ascii_lowercase();
        lower.starts_with(b"1.#") || (lower.starts_with(b"nan(") && lower.ends_with(b")"))
    }
}
