//! A place in a run of bytes that never reads beyond its end.

/// Bytes with a position.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'b> {
    bytes: &'b [u8],
    pub(crate) at: usize,
}

impl<'b> Cursor<'b> {
    pub(crate) fn new(bytes: &'b [u8], at: usize) -> Cursor<'b> {
        Cursor { bytes, at: at.min(bytes.len()) }
    }

    /// How many bytes are left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next `count` bytes, if there are so many.
    pub(crate) fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    /// The next line and where it begins, without its break (`\n`, `\r\n` or `\r`); `None` at the end.
    pub(crate) fn line(&mut self) -> Option<(usize, &'b [u8])> {
        let start = self.at;
        let rest = self.bytes.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        self.at = start + length + break_at(rest, length);
        Some((start, &rest[..length]))
    }
}

/// How many bytes the line break at a place takes; 0 where there is none.
pub(crate) fn break_at(bytes: &[u8], at: usize) -> usize {
    match bytes.get(at..).unwrap_or_default() {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// The line, counted from 1, in which a byte stands. Line breaks are those of [`Cursor::line`].
pub(crate) fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + line_starts(&bytes[..at.min(bytes.len())]).count()
}

/// Where the second line and those after it begin.
pub(crate) fn line_starts(bytes: &[u8]) -> impl Iterator<Item = usize> {
    // The last byte of a break is one where a break of one byte is read.
    (0..bytes.len()).filter(|i| break_at(bytes, *i) == 1).map(|i| i + 1)
}

/// The length of a UTF-8 byte order mark at the beginning; 0 where there is none.
pub(crate) fn mark_length(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 }
}

/// The words of a line, each with the bytes at which it stands; `start` is where the line begins.
pub(crate) fn words(line: &[u8], start: usize) -> impl Iterator<Item = Word<'_>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        at += line[at..].iter().position(|b| !b.is_ascii_whitespace())?;
        let length = line[at..].iter().position(u8::is_ascii_whitespace).unwrap_or(line.len() - at);
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

    /// The word for a message: shortened, and readable whatever its bytes are.
    pub(crate) fn shown(&self) -> String {
        String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(40)]).into_owned()
    }

    pub(crate) fn parse<T: std::str::FromStr>(&self) -> Option<T> {
        std::str::from_utf8(self.bytes).ok()?.parse().ok()
    }

    /// A finite number; Rust would also read `nan` and `inf`.
    pub(crate) fn finite(&self) -> Result<f64, crate::fault::Fault> {
        match self.parse::<f64>() {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => {
                Err(crate::fault::Fault::text(self.range(), format!("{} is not finite", self.shown())))
            }
            None => {
                Err(crate::fault::Fault::text(self.range(), format!("'{}' is not a number", self.shown())))
            }
        }
    }
}
