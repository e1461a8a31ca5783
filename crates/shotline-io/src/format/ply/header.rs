//! The header of a PLY file: the elements, their counts and their properties.

use std::collections::VecDeque;

use crate::bytes::{Cursor, Word, text_start, words};
use crate::diagnostic::RawDiagnostic;
use crate::lines::break_at;
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind, Notes};

/// The encoding of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        self.range().is_some()
    }

    /// The least and the largest number of an integer type.
    pub(super) fn range(self) -> Option<(i64, i64)> {
        match self {
            Scalar::I8 => Some((i8::MIN.into(), i8::MAX.into())),
            Scalar::U8 => Some((0, u8::MAX.into())),
            Scalar::I16 => Some((i16::MIN.into(), i16::MAX.into())),
            Scalar::U16 => Some((0, u16::MAX.into())),
            Scalar::I32 => Some((i32::MIN.into(), i32::MAX.into())),
            Scalar::U32 => Some((0, u32::MAX.into())),
            Scalar::F32 | Scalar::F64 => None,
        }
    }
}

/// The type of a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) shape: Shape,
}

/// An element: a table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    /// The location of the count, for messages.
    pub(super) count_at: std::ops::Range<usize>,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The minimum number of bytes of a row: its numbers, or its words with a separator after each.
    pub(super) fn min_row_bytes(&self, encoding: Encoding) -> usize {
        let least = |p: &Property| match (p.shape, encoding) {
            (_, Encoding::Ascii) => 2,
            (Shape::One(scalar), _) | (Shape::List { count: scalar, .. }, _) => scalar.size(),
        };
        self.properties.iter().map(least).sum()
    }
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The offset of the tables.
    pub(super) end: usize,
}

const STRAY_LINE: NoteKind = NoteKind {
    name: "header_lines",
    effect: Effect::Changed,
    one: "1 line of the header that says nothing known was passed over",
    many: "# lines of the header that say nothing known were passed over",
};

/// Reads the header. Lines that are not part of the format are noted.
pub(super) fn read(bytes: &[u8], notes: &mut Notes) -> Result<Header, RawDiagnostic> {
    let mut cursor = Cursor::new(bytes, text_start(bytes)?);
    let begin = cursor.at;
    // Some programs write all of a header on one line, so a line may hold several statements.
    let mut line: VecDeque<Word> =
        cursor.line().map(|(start, l)| words(l, start).collect()).unwrap_or_default();
    if line.pop_front().is_none_or(|w| w.bytes != b"ply" || w.start != begin) {
        return Err(RawDiagnostic::byte(0, "a PLY file begins with the line 'ply'"));
    }
    let breaks_with_cr = break_at(bytes, begin + 3) == 1 && bytes[begin + 3] == b'\r';
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        while line.is_empty() {
            let Some((start, words_of)) = cursor.line().map(|(start, l)| (start, words(l, start))) else {
                return Err(RawDiagnostic::byte(bytes.len(), "the header has no end_header"));
            };
            line.extend(words_of);
            // Before the first element an unknown line cannot be a part of one: old versions of Blender write their name there.
            if elements.is_empty() && line.front().is_some_and(|w| !KEYWORDS.contains(&w.bytes)) {
                notes.add(&STRAY_LINE, RawLocation::Text(start..cursor.at));
                line.clear();
            }
        }
        let first = line[0];
        match first.bytes {
            b"comment" | b"obj_info" => line.clear(),
            b"end_header" => {
                let end = first.range().end;
                return finish(bytes, encoding, elements, end, breaks_with_cr);
            }
            b"format" => encoding = Some(read_encoding(&take(&mut line, 3)?)?),
            b"element" => elements.push(read_element(&take(&mut line, 3)?)?),
            b"property" => {
                let is_list = line.get(1).is_some_and(|w| w.bytes == b"list");
                let words = take(&mut line, if is_list { 5 } else { 3 })?;
                let range = first.start..words.last().map_or(first.start, |w| w.range().end);
                let property = read_property(&words).ok_or_else(|| {
                    RawDiagnostic::text(range.clone(), "this is not a property of a known type")
                })?;
                let element = elements.last_mut();
                element
                    .ok_or_else(|| RawDiagnostic::text(range, "a property without an element"))?
                    .properties
                    .push(property);
            }
            _ => {
                let end = line.back().map_or(first.start, |w| w.range().end);
                return Err(RawDiagnostic::text(first.start..end, "the header has no such line"));
            }
        }
    }
}

/// The first words of the statements of a header.
const KEYWORDS: &[&[u8]] = &[b"format", b"element", b"property", b"comment", b"obj_info", b"end_header"];

/// Takes the words of a statement off a line.
fn take<'b>(line: &mut VecDeque<Word<'b>>, count: usize) -> Result<Vec<Word<'b>>, RawDiagnostic> {
    if line.len() < count {
        let end = line.back().map_or(0, |w| w.range().end);
        let start = line.front().map_or(0, |w| w.start);
        return Err(RawDiagnostic::text(start..end, "this line of the header is not complete"));
    }
    Ok(line.drain(..count).collect())
}

/// The header ends with one line break after its last word, of the kind that the header uses: the first byte of a table
/// may look like the second half of one. If the tables follow on the same line, the header ends with the word.
fn finish(
    bytes: &[u8],
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    end: usize,
    breaks_with_cr: bool,
) -> Result<Header, RawDiagnostic> {
    let encoding = encoding.ok_or_else(|| RawDiagnostic::byte(0, "the header has no format line"))?;
    let blanks = bytes[end..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    let length = match break_at(bytes, end + blanks) {
        2 if breaks_with_cr => 1,
        length => length,
    };
    let end = if length > 0 { end + blanks + length } else { end };
    Ok(Header { encoding, elements, end })
}

fn read_encoding(words: &[Word]) -> Result<Encoding, RawDiagnostic> {
    let (word, version) = (words[1], words[2]);
    if version.number() != Ok(1.0) {
        let message = format!("there is no version {} of PLY", version.shown());
        return Err(RawDiagnostic::text(version.range(), message).help("the only version is 1.0"));
    }
    match word.bytes {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(RawDiagnostic::text(word.range(), format!("there is no PLY format '{}'", word.shown()))
            .help("there is ascii, binary_little_endian, binary_big_endian")),
    }
}

fn read_element(words: &[Word]) -> Result<Element, RawDiagnostic> {
    let diagnostic =
        || RawDiagnostic::text(words[2].range(), format!("'{}' is not a number of rows", words[2].shown()));
    Ok(Element {
        name: String::from_utf8_lossy(words[1].bytes).into_owned(),
        count: words[2].parse().ok_or_else(diagnostic)?,
        count_at: words[2].range(),
        properties: Vec::new(),
    })
}

fn read_property(words: &[Word]) -> Option<Property> {
    let name = |w: &Word| String::from_utf8_lossy(w.bytes).into_owned();
    match words {
        [_, list, count, item, n] if list.bytes == b"list" => {
            let (count, item) = (Scalar::of(count.bytes)?, Scalar::of(item.bytes)?);
            count.is_integer().then(|| Property { name: name(n), shape: Shape::List { count, item } })
        }
        [_, ty, n] => Some(Property { name: name(n), shape: Shape::One(Scalar::of(ty.bytes)?) }),
        _ => None,
    }
}
