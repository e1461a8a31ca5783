//! The rows of a PLY table, from text or from binary, as numbers in float64 (which holds every PLY type exactly).

use super::header::{Encoding, Scalar, Shape};
use crate::bytes::{Cursor, Word, words};
use crate::fault::Fault;

/// Reads one row after another.
pub(super) trait Rows {
    /// Begins a row.
    fn begin(&mut self) -> Result<(), Fault>;

    /// Appends the numbers of a property.
    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), Fault>;

    /// Ends a row.
    fn end(&mut self) -> Result<(), Fault>;

    /// A fault of the row read last.
    fn fault(&self, message: String) -> Fault;
}

/// A row is a line.
pub(super) struct AsciiRows<'b> {
    pub(super) cursor: Cursor<'b>,
    line: Vec<Word<'b>>,
    next: usize,
    start: usize,
}

impl<'b> AsciiRows<'b> {
    pub(super) fn new(cursor: Cursor<'b>) -> AsciiRows<'b> {
        AsciiRows { cursor, line: Vec::new(), next: 0, start: 0 }
    }

    fn word(&mut self) -> Result<Word<'b>, Fault> {
        let word = self.line.get(self.next).copied();
        self.next += 1;
        word.ok_or_else(|| self.fault("numbers are missing on this line".into()))
    }

    fn number(&mut self, ty: Scalar) -> Result<f64, Fault> {
        let word = self.word()?;
        let found = match ty {
            // A float32 written as text means the float32.
            Scalar::F32 => word.parse::<f32>().map(f64::from),
            Scalar::F64 => word.parse::<f64>(),
            _ => word.parse::<i64>().map(|i| i as f64),
        };
        found.ok_or_else(|| Fault::text(word.range(), format!("'{}' is not such a number", word.shown())))
    }
}

impl Rows for AsciiRows<'_> {
    fn begin(&mut self) -> Result<(), Fault> {
        self.line.clear();
        self.next = 0;
        while self.line.is_empty() {
            let (start, line) = self
                .cursor
                .line()
                .ok_or_else(|| Fault::byte(self.cursor.at, "the file ends before its last row"))?;
            self.start = start;
            self.line.extend(words(line, start));
        }
        Ok(())
    }

    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), Fault> {
        match shape {
            Shape::One(ty) => out.push(self.number(ty)?),
            Shape::List { count, item } => {
                let count = list_length(self.number(count)?).ok_or_else(|| self.fault(BAD_LENGTH.into()))?;
                if count > self.line.len() - self.next.min(self.line.len()) {
                    return Err(self.fault("the list is longer than its line".into()));
                }
                for _ in 0..count {
                    out.push(self.number(item)?);
                }
            }
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Fault> {
        match self.line.get(self.next) {
            None => Ok(()),
            Some(word) => Err(Fault::text(word.range(), "more numbers on this line than the header says")),
        }
    }

    fn fault(&self, message: String) -> Fault {
        let end = self.line.last().map_or(self.start, |w| w.range().end);
        Fault::text(self.start..end, message)
    }
}

/// A row is so many bytes.
pub(super) struct BinaryRows<'b> {
    pub(super) cursor: Cursor<'b>,
    pub(super) encoding: Encoding,
    start: usize,
}

impl<'b> BinaryRows<'b> {
    pub(super) fn new(cursor: Cursor<'b>, encoding: Encoding) -> BinaryRows<'b> {
        BinaryRows { start: cursor.at, cursor, encoding }
    }

    fn number(&mut self, ty: Scalar) -> Result<f64, Fault> {
        let at = self.cursor.at;
        let taken =
            self.cursor.take(ty.size()).ok_or_else(|| Fault::byte(at, "the file ends within a row"))?;
        Ok(decode(taken, ty, self.encoding))
    }
}

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
    fn begin(&mut self) -> Result<(), Fault> {
        self.start = self.cursor.at;
        Ok(())
    }

    fn property(&mut self, shape: Shape, out: &mut Vec<f64>) -> Result<(), Fault> {
        match shape {
            Shape::One(ty) => out.push(self.number(ty)?),
            Shape::List { count, item } => {
                let count = list_length(self.number(count)?).ok_or_else(|| self.fault(BAD_LENGTH.into()))?;
                if count > self.cursor.left() / item.size() {
                    return Err(self.fault(format!("a list of {count} is longer than the rest of the file")));
                }
                for _ in 0..count {
                    out.push(self.number(item)?);
                }
            }
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    fn fault(&self, message: String) -> Fault {
        Fault::byte(self.start, message)
    }
}

const BAD_LENGTH: &str = "the length of a list is negative";

/// List lengths are whole numbers of at most 32 bits, or text.
fn list_length(count: f64) -> Option<usize> {
    (count >= 0.0).then_some(count as usize)
}
