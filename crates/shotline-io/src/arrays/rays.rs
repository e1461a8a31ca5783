//! Rays from a `.npy` or a `.csv` file: six numbers per row, origin then direction.

use std::path::Path;

use shotline::math::Vec3;
use shotline::ray::{InvalidRay, Ray};

use super::csv;
use super::npy::{self, Header};
use crate::diagnostic::RawDiagnostic;
use crate::error::ReadError;
use crate::files::read_regular;

/// A row that is not a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("ray {row}: {why}")]
pub struct InvalidRow {
    /// The row, counted from 0; the first one that is not a ray.
    pub row: usize,
    /// Why.
    pub why: InvalidRay,
}

const HELP: &str = "write the rays with numpy.save(PATH, array of shape (N, 6))";

/// Reads the rows of a file: an array of shape (N, 6), float64 or float32, in either byte and index order; or of a text with six
/// numbers a line, if its extension is `.csv`. The numbers are not checked; [`rays_of`] does that.
///
/// # Errors
/// [`ReadError`] for any other file.
pub fn read_rays(path: impl AsRef<Path>) -> Result<Vec<[f64; 6]>, ReadError> {
    let path = path.as_ref();
    let bytes = read_regular(path, u64::MAX)?;
    let is_csv = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    let read = if is_csv { csv::rows(&bytes) } else { rows(&bytes) };
    read.map_err(|diagnostic| ReadError::new(Some(path), &bytes, diagnostic.or_help(HELP).into()))
}

/// Reads the rows from the bytes of a file; see [`read_rays`].
///
/// # Errors
/// [`ReadError`] for anything else.
pub fn parse_rays(bytes: &[u8]) -> Result<Vec<[f64; 6]>, ReadError> {
    rows(bytes).map_err(|diagnostic| ReadError::new(None, bytes, diagnostic.or_help(HELP).into()))
}

/// Rows as rays.
///
/// # Errors
/// [`InvalidRow`], the first row with NaN, an infinite number or a direction of zero.
pub fn rays_of(rows: &[[f64; 6]]) -> Result<Vec<Ray>, InvalidRow> {
    let ray = |(row, r): (usize, &[f64; 6])| {
        let ray = Ray::new(Vec3::new(r[0], r[1], r[2]), Vec3::new(r[3], r[4], r[5]));
        ray.map_err(|why| InvalidRow { row, why })
    };
    rows.iter().enumerate().map(ray).collect()
}

fn rows(bytes: &[u8]) -> Result<Vec<[f64; 6]>, RawDiagnostic> {
    let header = npy::read_header(bytes)?;
    let size = item_size(&header)?;
    let [count, 6] = header.shape[..] else {
        let shape: Vec<_> = header.shape.iter().map(u64::to_string).collect();
        let comma = if shape.len() == 1 { "," } else { "" };
        let message = format!("the array has the shape ({}{comma}), but rays have (N, 6)", shape.join(", "));
        return Err(
            RawDiagnostic::byte(0, message).help("a row is the origin x, y, z and the direction x, y, z")
        );
    };
    let left = bytes.len() - header.data;
    let count =
        usize::try_from(count).ok().filter(|n| n.checked_mul(6 * size) == Some(left)).ok_or_else(|| {
            let message =
                format!("the header promises {count} rows of {} bytes, but {left} bytes follow", 6 * size);
            RawDiagnostic::byte(header.data, message).help("the file is cut off or its header is broken")
        })?;
    let big = header.descr.starts_with('>');
    let number = |index: usize| decode(&bytes[header.data + index * size..][..size], big);
    let at = |row: usize, column: usize| if header.fortran { column * count + row } else { row * 6 + column };
    Ok((0..count).map(|row| std::array::from_fn(|column| number(at(row, column)))).collect())
}

fn item_size(header: &Header) -> Result<usize, RawDiagnostic> {
    match header.descr.as_str() {
        "<f8" | ">f8" => Ok(8),
        "<f4" | ">f4" => Ok(4),
        other => Err(RawDiagnostic::byte(0, format!("the array holds '{other}', but rays are float64"))
            .help("convert it with array.astype(float)")),
    }
}

/// A float32 or a float64, by the number of bytes.
fn decode(bytes: &[u8], big: bool) -> f64 {
    let mut raw = [0; 8];
    raw[..bytes.len()].copy_from_slice(bytes);
    if big {
        raw[..bytes.len()].reverse();
    }
    match bytes.len() {
        4 => f64::from(f32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]])),
        _ => f64::from_le_bytes(raw),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(descr: &str, fortran: bool, shape: &[usize], numbers: &[u8]) -> Vec<u8> {
        let mut bytes = npy::header(descr, shape);
        if fortran {
            let text = String::from_utf8_lossy(&bytes[10..]).replace("False", "True ");
            bytes.truncate(10);
            bytes.extend(text.as_bytes());
        }
        bytes.extend(numbers);
        bytes
    }

    #[test]
    fn any_order_of_bytes_and_indices_is_read() {
        let expected: Vec<[f64; 6]> =
            (0..3).map(|r| std::array::from_fn(|c| f64::from(r * 6 + c as i32))).collect();
        let flat: Vec<f64> = expected.iter().flatten().copied().collect();
        let turned: Vec<f64> = (0..6).flat_map(|c| expected.iter().map(move |r| r[c])).collect();
        for (fortran, numbers) in [(false, &flat), (true, &turned)] {
            let each = |f: &dyn Fn(f64) -> Vec<u8>| numbers.iter().flat_map(|x| f(*x)).collect::<Vec<u8>>();
            let files = [
                ("<f8", each(&|x| x.to_le_bytes().to_vec())),
                (">f8", each(&|x| x.to_be_bytes().to_vec())),
                ("<f4", each(&|x| (x as f32).to_le_bytes().to_vec())),
                (">f4", each(&|x| (x as f32).to_be_bytes().to_vec())),
            ];
            for (descr, data) in files {
                assert_eq!(
                    parse_rays(&file(descr, fortran, &[3, 6], &data)).unwrap(),
                    expected,
                    "{descr} {fortran}"
                );
            }
        }
        assert_eq!(parse_rays(&file("<f8", false, &[0, 6], &[])).unwrap(), Vec::<[f64; 6]>::new());
    }

    #[test]
    fn errors_of_arrays_name_what_was_found() {
        let message = |bytes: &[u8]| parse_rays(bytes).unwrap_err().diagnostics[0].message.clone();
        assert!(message(&file("<f8", false, &[4, 3], &[0; 96])).contains("shape (4, 3)"));
        assert!(message(&file("<f8", false, &[6], &[0; 48])).contains("shape (6,)"));
        assert!(message(&file("<i8", false, &[1, 6], &[0; 48])).contains("'<i8'"));
        assert!(message(&file("<f8", false, &[2, 6], &[0; 48])).contains("promises 2 rows"));
        assert!(message(&file("<f8", false, &[usize::MAX, 6], &[0; 48])).contains("promises"));
        assert!(message(b"PK\x03\x04").contains("not a .npy"));
    }

    #[test]
    fn the_first_bad_row_is_named() {
        let good = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut bad = good;
        bad[1] = f64::NAN;
        assert_eq!(rays_of(&[good, bad, bad]), Err(InvalidRow { row: 1, why: InvalidRay::Origin }));
        assert_eq!(rays_of(&[good]).unwrap().len(), 1);
    }
}
