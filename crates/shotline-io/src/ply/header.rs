//! The header of a PLY file: which elements follow, how many of each and of what they are made.

use crate::bytes::{Cursor, Word, words};
use crate::fault::Fault;

/// How the numbers are written.
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
        !matches!(self, Scalar::F32 | Scalar::F64)
    }
}

/// What a property holds.
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

/// A table of the file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    /// Where the count stands, for messages.
    pub(super) count_at: std::ops::Range<usize>,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that a row takes: its numbers, or its words with a break after each.
    pub(super) fn least_row(&self, encoding: Encoding) -> usize {
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
    /// Where the tables begin.
    pub(super) end: usize,
}

pub(super) fn read(bytes: &[u8]) -> Result<Header, Fault> {
    let mut cursor = Cursor::new(bytes, 0);
    if cursor.line().is_none_or(|(_, line)| line.trim_ascii_end() != b"ply") {
        return Err(Fault::byte(0, "a PLY file begins with the line 'ply'"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let (start, line) =
            cursor.line().ok_or_else(|| Fault::byte(bytes.len(), "the header has no end_header"))?;
        let all: Vec<Word> = words(line, start).collect();
        let whole = start..start + line.len();
        let texts: Vec<&[u8]> = all.iter().map(|w| w.bytes).collect();
        match texts[..] {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", name, _] => encoding = Some(read_encoding(name, &all[1])?),
            [b"element", name, _] => elements.push(Element {
                name: String::from_utf8_lossy(name).into_owned(),
                count: all[2].parse().ok_or_else(|| {
                    Fault::text(all[2].range(), format!("'{}' is not a number of rows", all[2].shown()))
                })?,
                count_at: all[2].range(),
                properties: Vec::new(),
            }),
            [b"property", ..] => {
                let property = read_property(&all)
                    .ok_or_else(|| Fault::text(whole.clone(), "this is no property of a known type"))?;
                let element = elements.last_mut();
                element
                    .ok_or_else(|| Fault::text(whole, "a property without an element"))?
                    .properties
                    .push(property);
            }
            [b"end_header"] => break,
            _ => return Err(Fault::text(whole, "the header has no such line")),
        }
    }
    let encoding = encoding.ok_or_else(|| Fault::byte(0, "the header has no format line"))?;
    Ok(Header { encoding, elements, end: cursor.at })
}

fn read_encoding(name: &[u8], word: &Word) -> Result<Encoding, Fault> {
    match name {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(Fault::text(word.range(), format!("there is no PLY format '{}'", word.shown()))
            .help("there is ascii, binary_little_endian, binary_big_endian")),
    }
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
