//! Writes named columns to a `.npz` file, readable by `numpy.load` without pickle.

use std::io::{self, Seek, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::npy;
use crate::atomic_write::atomic_write;
use crate::error::WriteError;

/// A column, which becomes one array.
#[derive(Clone, Copy, Debug)]
pub enum Column<'a> {
    /// float64.
    F64(&'a [f64]),
    /// float64 of shape (n, 3).
    Vec3(&'a [[f64; 3]]),
    /// float64 of shape (n, width), row after row.
    Rows {
        /// Numbers per row.
        width: usize,
        /// The rows.
        values: &'a [f64],
    },
    /// int64.
    I64(&'a [i64]),
    /// int64 of shape (n, width), row after row.
    I64Rows {
        /// Numbers per row.
        width: usize,
        /// The rows.
        values: &'a [i64],
    },
    /// int32 of shape (n, width), row after row.
    I32Rows {
        /// Numbers per row.
        width: usize,
        /// The rows.
        values: &'a [i32],
    },
    /// int32.
    I32(&'a [i32]),
    /// int8.
    I8(&'a [i8]),
    /// bool.
    Bool(&'a [bool]),
    /// Text of fixed width, `<U...`.
    Text(&'a [String]),
}

/// Writes columns under their names. The file appears complete or not at all.
///
/// # Errors
/// [`WriteError`] if the operating system refuses.
pub fn write_npz(path: impl AsRef<Path>, columns: &[(&str, Column)]) -> Result<(), WriteError> {
    atomic_write(path.as_ref(), |out| fill_npz(out, columns))
}

/// Writes the bytes of an `.npz` file with columns under their names.
///
/// # Errors
/// If `out` cannot be written.
pub fn fill_npz(out: &mut (impl Write + Seek), columns: &[(&str, Column)]) -> io::Result<()> {
    let mut zip = ZipWriter::new(Deferred::new(out));
    for (name, column) in columns {
        write_column(&mut zip, name, column)?;
    }
    match zip.finish()?.failure {
        None => Ok(()),
        Some(failure) => Err(failure),
    }
}

/// Keeps the first error until the end, and from then on only counts bytes. A `ZipWriter` that gets an error prints to
/// stderr when it is dropped.
struct Deferred<W> {
    out: W,
    failure: Option<io::Error>,
    /// The offset of the next byte, and the length so far.
    position: u64,
    end: u64,
}

impl<W> Deferred<W> {
    fn new(out: W) -> Deferred<W> {
        Deferred { out, failure: None, position: 0, end: 0 }
    }
}

impl<W: Write> Write for Deferred<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failure.is_none()
            && let Err(error) = self.out.write_all(bytes)
        {
            self.failure = Some(error);
        }
        self.position += bytes.len() as u64;
        self.end = self.end.max(self.position);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.failure.is_none()
            && let Err(error) = self.out.flush()
        {
            self.failure = Some(error);
        }
        Ok(())
    }
}

impl<W: Seek> Seek for Deferred<W> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        let position = match to {
            io::SeekFrom::Start(position) => Some(position),
            io::SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
            io::SeekFrom::End(offset) => self.end.checked_add_signed(offset),
        };
        self.position = position.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        if self.failure.is_none()
            && let Err(error) = self.out.seek(io::SeekFrom::Start(self.position))
        {
            self.failure = Some(error);
        }
        Ok(self.position)
    }
}

fn write_column<W: Write + Seek>(zip: &mut ZipWriter<W>, name: &str, column: &Column) -> io::Result<()> {
    let (descr, shape) = column.layout();
    let head = npy::header(&descr, &shape);
    // Stored, as numpy.savez does: the numbers hardly compress, and compressing them would take longer than casting.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(column.bytes() + head.len() as u64 >= u64::from(u32::MAX));
    zip.start_file(format!("{name}.npy"), options)?;
    zip.write_all(&head)?;
    column.write(zip)
}

impl Column<'_> {
    /// The type and shape as NumPy writes them.
    fn layout(&self) -> (String, Vec<usize>) {
        match self {
            Column::F64(v) => ("<f8".into(), vec![v.len()]),
            Column::Vec3(v) => ("<f8".into(), vec![v.len(), 3]),
            Column::Rows { width, values } => ("<f8".into(), rows(values.len(), *width)),
            Column::I64Rows { width, values } => ("<i8".into(), rows(values.len(), *width)),
            Column::I32Rows { width, values } => ("<i4".into(), rows(values.len(), *width)),
            Column::I64(v) => ("<i8".into(), vec![v.len()]),
            Column::I32(v) => ("<i4".into(), vec![v.len()]),
            Column::I8(v) => ("|i1".into(), vec![v.len()]),
            Column::Bool(v) => ("|b1".into(), vec![v.len()]),
            Column::Text(v) => (format!("<U{}", characters(v)), vec![v.len()]),
        }
    }

    fn bytes(&self) -> u64 {
        let bytes = match self {
            Column::F64(v) => size_of_val(*v),
            Column::Vec3(v) => size_of_val(*v),
            Column::Rows { values, .. } => size_of_val(*values),
            Column::I64(v) | Column::I64Rows { values: v, .. } => size_of_val(*v),
            Column::I32(v) | Column::I32Rows { values: v, .. } => size_of_val(*v),
            Column::I8(v) => v.len(),
            Column::Bool(v) => v.len(),
            Column::Text(v) => 4 * characters(v) * v.len(),
        };
        bytes as u64
    }

    fn write(&self, out: &mut impl Write) -> io::Result<()> {
        match self {
            Column::F64(v) | Column::Rows { values: v, .. } => write_each(out, v, |x| x.to_le_bytes()),
            Column::Vec3(v) => write_each(out, v.as_flattened(), |x| x.to_le_bytes()),
            Column::I64(v) | Column::I64Rows { values: v, .. } => write_each(out, v, |x| x.to_le_bytes()),
            Column::I32(v) | Column::I32Rows { values: v, .. } => write_each(out, v, |x| x.to_le_bytes()),
            Column::I8(v) => write_each(out, v, |x| x.to_le_bytes()),
            Column::Bool(v) => write_each(out, v, |x| [u8::from(*x)]),
            Column::Text(v) => {
                let width = characters(v);
                let padded =
                    |s: &String| s.chars().chain(std::iter::repeat('\0')).take(width).collect::<Vec<_>>();
                v.iter().try_for_each(|s| write_each(out, &padded(s), |c| u32::from(*c).to_le_bytes()))
            }
        }
    }
}

/// The shape of so many numbers in rows.
fn rows(numbers: usize, width: usize) -> Vec<usize> {
    vec![numbers / width.max(1), width]
}

/// The width of a text column; NumPy has no width of 0.
fn characters(texts: &[String]) -> usize {
    texts.iter().map(|s| s.chars().count()).max().unwrap_or(0).max(1)
}

/// Writes values in chunks of some thousands, to bound both the memory and the number of calls.
fn write_each<T, const N: usize>(
    out: &mut impl Write,
    values: &[T],
    encode: fn(&T) -> [u8; N],
) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(N * values.len().min(8192));
    for chunk in values.chunks(8192) {
        buffer.clear();
        buffer.extend(chunk.iter().flat_map(encode));
        out.write_all(&buffer)?;
    }
    Ok(())
}
