//! Line breaks of a text, and the byte order mark before its first line.

/// The number of bytes of the line break at an offset; 0 where there is none.
pub(crate) fn break_at(bytes: &[u8], at: usize) -> usize {
    match bytes.get(at..).unwrap_or_default() {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// The line, counted from 1, that contains a byte.
pub(crate) fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + line_starts(&bytes[..at.min(bytes.len())]).count()
}

/// The offsets at which the second line and those after it begin.
pub(crate) fn line_starts(bytes: &[u8]) -> impl Iterator<Item = usize> {
    // At the last byte of a break of two bytes, `break_at` sees a break of one byte.
    (0..bytes.len()).filter(|i| break_at(bytes, *i) == 1).map(|i| i + 1)
}

/// The length of a UTF-8 byte order mark at the beginning; 0 where there is none.
pub(crate) fn mark_length(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 }
}
