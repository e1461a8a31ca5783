//! The `.npy` header.

use crate::diagnostic::RawDiagnostic;

/// The content of a header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    /// The type, as in `<f8`.
    pub(super) descr: String,
    /// Whether the array is in Fortran order.
    pub(super) fortran: bool,
    pub(super) shape: Vec<u64>,
    /// The offset of the numbers.
    pub(super) data: usize,
}

const MAGIC: &[u8] = b"\x93NUMPY";

/// The bytes of a header, padded so that the numbers begin at a multiple of 64.
pub(super) fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}", shape.trim_end());
    let mut out = MAGIC.to_vec();
    out.extend([1, 0, 0, 0]);
    out.extend(dict.as_bytes());
    out.resize((out.len() + 1).next_multiple_of(64) - 1, b' ');
    out.push(b'\n');
    let length = (out.len() - 10) as u16;
    out[8..10].copy_from_slice(&length.to_le_bytes());
    out
}

pub(super) fn read_header(bytes: &[u8]) -> Result<Header, RawDiagnostic> {
    if !bytes.starts_with(MAGIC) {
        return Err(RawDiagnostic::byte(0, "this is not a .npy file"));
    }
    let cut = || RawDiagnostic::byte(bytes.len(), "the file ends within its header");
    let version = *bytes.get(6).ok_or_else(cut)?;
    let (length, start): (u64, usize) = match (version, bytes.get(8..10), bytes.get(8..12)) {
        (1, Some(n), _) => (u64::from(u16::from_le_bytes([n[0], n[1]])), 10),
        (2 | 3, _, Some(n)) => (u64::from(u32::from_le_bytes([n[0], n[1], n[2], n[3]])), 12),
        (1..=3, ..) => return Err(cut()),
        _ => return Err(RawDiagnostic::byte(6, format!("version {version} of .npy is not known"))),
    };
    let length = usize::try_from(length).map_err(|_| cut())?;
    let end = start.checked_add(length).ok_or_else(cut)?;
    let text = bytes.get(start..end).ok_or_else(cut)?;
    let text =
        std::str::from_utf8(text).map_err(|_| RawDiagnostic::byte(start, "the header is not a text"))?;
    let entry = |key: &str| {
        let found =
            text.split_once(&format!("'{key}'")).and_then(|(_, rest)| rest.trim_start().strip_prefix(':'));
        found
            .map(str::trim_start)
            .ok_or_else(|| RawDiagnostic::byte(start, format!("the header lacks '{key}'")))
    };
    let descr = entry("descr")?.strip_prefix('\'').and_then(|rest| rest.split_once('\''));
    let descr = descr.ok_or_else(|| {
        RawDiagnostic::byte(start, "the array holds records")
            .help("save a plain float64 array of shape (N, 6)")
    })?;
    let shape = entry("shape")?.strip_prefix('(').and_then(|rest| rest.split_once(')'));
    let shape = shape.ok_or_else(|| RawDiagnostic::byte(start, "the header has no shape"))?;
    let numbers = shape.0.split(',').map(str::trim).filter(|n| !n.is_empty());
    let shape: Option<Vec<u64>> = numbers.map(|n| n.trim_end_matches('L').parse().ok()).collect();
    Ok(Header {
        descr: descr.0.to_string(),
        fortran: entry("fortran_order")?.starts_with("True"),
        shape: shape.ok_or_else(|| RawDiagnostic::byte(start, "the header has no readable shape"))?,
        data: end,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_read_back_and_are_aligned() {
        for shape in [&[][..], &[7], &[0, 6], &[123_456_789, 3]] {
            let bytes = header("<f8", shape);
            assert_eq!(bytes.len() % 64, 0);
            let found = read_header(&bytes).unwrap();
            let shape: Vec<u64> = shape.iter().map(|n| *n as u64).collect();
            assert_eq!(found, Header { descr: "<f8".into(), fortran: false, shape, data: bytes.len() });
        }
    }
}
