//! Binary STL: a head of 84 bytes, the last four of which count the triangles, and 50 bytes for each.

use shotline::math::Vec3;

use super::Triangles;
use crate::diagnostic::RawDiagnostic;
use crate::location::RawLocation;
use crate::note::{Effect, NoteKind};

/// Bytes before the first triangle.
const HEAD: usize = 84;

/// Bytes of a triangle: a normal, three corners, and two bytes without meaning or with the number of bytes that follow.
const TRIANGLE: usize = 50;

const SPARE: NoteKind = NoteKind {
    name: "extra_bytes",
    effect: Effect::Changed,
    one: "1 byte behind the last triangle was dropped",
    many: "# bytes behind the last triangle were dropped",
};

const ATTRIBUTES: NoteKind = NoteKind {
    name: "attribute_bytes",
    effect: Effect::Kept,
    one: "1 byte of attributes between triangles was not read",
    many: "# bytes of attributes between triangles were not read",
};

const WORDS: NoteKind = NoteKind {
    name: "not_read",
    effect: Effect::Kept,
    one: "1 attribute or colour of a triangle was not read",
    many: "# attributes or colours of triangles were not read",
};

const COLOUR: NoteKind = NoteKind {
    name: "colours_not_read",
    effect: Effect::Kept,
    one: "1 colour of the whole was not read",
    many: "# colours of the whole were not read",
};

const UNCOUNTED: NoteKind = NoteKind {
    name: "wrong_count",
    effect: Effect::Changed,
    one: "the file holds 1 triangle more than the count at byte 80 says; it was read",
    many: "the file holds # triangles more than the count at byte 80 says; they were read",
};

/// The number of triangles that the header declares.
fn declared(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEAD)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// Whether the size is exactly that of the declared number of triangles.
pub(super) fn fits(bytes: &[u8]) -> bool {
    declared(bytes)
        .is_some_and(|n| n.checked_mul(TRIANGLE).and_then(|n| n.checked_add(HEAD)) == Some(bytes.len()))
}

/// Whether bytes of a size that does not fit are probably still an STL: the declared or present triangles look valid.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let Some(count) = declared(bytes) else { return false };
    let held = (bytes.len() - HEAD) / TRIANGLE;
    let most = if count == 0 || count > held { held } else { count };
    // Four random bytes are often a number, but seldom one of an ordinary size.
    let is_ordinary = |x: f64| x == 0.0 || (1e-12..1e12).contains(&x.abs());
    let is_plausible =
        |t: &[u8]| is_triangle(t) && corners(t).iter().all(|c| c.to_array().into_iter().all(is_ordinary));
    let plain =
        most > 0 && bytes[HEAD..].chunks_exact(TRIANGLE).take(most.min(MAX_EXAMINED)).all(is_plausible);
    plain || (count > 0 && attributes(bytes, count) == Some(bytes.len()))
}

/// The maximum number of triangles that are examined to detect an STL.
const MAX_EXAMINED: usize = 1000;

/// Reads the triangles.
///
/// # Errors
/// If there are fewer triangles than declared, or a corner is not finite.
pub(super) fn read(bytes: &[u8], out: &mut Triangles) -> Result<(), RawDiagnostic> {
    let Some(count) = declared(bytes) else {
        let message = "the file ends within the head of a binary STL, and is not a text STL either";
        return Err(RawDiagnostic::byte(bytes.len(), message));
    };
    let held = (bytes.len() - HEAD) / TRIANGLE;
    let rest = (bytes.len() - HEAD) % TRIANGLE;
    if count > held {
        return Err(cut_off(bytes, count, held));
    }
    if count < held || rest > 0 {
        if attributes(bytes, count).is_some_and(|end| end == bytes.len()) {
            return read_with_attributes(bytes, count, out);
        }
        let more = &bytes[HEAD + count * TRIANGLE..];
        if rest == 0 && more.chunks_exact(TRIANGLE).all(is_triangle) {
            out.notes().add_many(&UNCOUNTED, held - count, RawLocation::Byte(80));
            return read_many(bytes, held, out);
        }
        if count == 0 {
            let message = format!(
                "the count at byte 80 says that there are no triangles, and the {} bytes behind it are no whole \
                 number of triangles",
                bytes.len() - HEAD
            );
            return Err(RawDiagnostic::byte(80, message).help("the file is damaged, or it is not an STL"));
        }
        out.notes().add_many(&SPARE, more.len(), RawLocation::Byte(HEAD + count * TRIANGLE));
    }
    read_many(bytes, count, out)
}

fn cut_off(bytes: &[u8], count: usize, held: usize) -> RawDiagnostic {
    let (rest, end) = ((bytes.len() - HEAD) % TRIANGLE, HEAD + held * TRIANGLE);
    let part = if rest == 0 { String::new() } else { format!(" and {rest} bytes of another") };
    let message =
        format!("the count at byte 80 says {count} triangles, but the file ends after {held}{part}");
    RawDiagnostic::byte(end, message).help("the file is cut off, its count is wrong, or it is not an STL")
}

/// The end of the triangles if the last two bytes of each are the number of bytes that follow it.
fn attributes(bytes: &[u8], count: usize) -> Option<usize> {
    let mut end = HEAD;
    for _ in 0..count {
        let length = bytes.get(end + TRIANGLE - 2..end + TRIANGLE)?;
        end += TRIANGLE + usize::from(u16::from_le_bytes([length[0], length[1]]));
    }
    Some(end)
}

fn read_with_attributes(bytes: &[u8], count: usize, out: &mut Triangles) -> Result<(), RawDiagnostic> {
    let mut at = HEAD;
    for i in 0..count {
        let triangle = &bytes[at..at + TRIANGLE];
        let length = usize::from(u16::from_le_bytes([triangle[TRIANGLE - 2], triangle[TRIANGLE - 1]]));
        read_triangle(triangle, i, at, out)?;
        out.notes().add_many(&ATTRIBUTES, length, RawLocation::Byte(at + TRIANGLE));
        at += TRIANGLE + length;
    }
    Ok(())
}

fn read_many(bytes: &[u8], count: usize, out: &mut Triangles) -> Result<(), RawDiagnostic> {
    if let Some(at) = bytes[..80].windows(6).position(|w| w == b"COLOR=") {
        out.notes().add(&COLOUR, RawLocation::Byte(at));
    }
    let (mut words, mut first) = (0, 0);
    for (i, triangle) in bytes[HEAD..].chunks_exact(TRIANGLE).take(count).enumerate() {
        let at = HEAD + i * TRIANGLE;
        read_triangle(triangle, i, at, out)?;
        if triangle[TRIANGLE - 2..] != [0, 0] {
            first = if words == 0 { at + TRIANGLE - 2 } else { first };
            words += 1;
        }
    }
    out.notes().add_many(&WORDS, words, RawLocation::Byte(first));
    Ok(())
}

fn read_triangle(
    triangle: &[u8],
    number: usize,
    at: usize,
    out: &mut Triangles,
) -> Result<(), RawDiagnostic> {
    let corners = corners(triangle);
    if !corners.iter().all(|c| c.is_finite()) {
        return Err(RawDiagnostic::byte(
            at,
            format!("triangle {number} has a coordinate that is NaN or infinite"),
        ));
    }
    out.add(&corners, || RawLocation::Byte(at));
    Ok(())
}

/// The corners of a triangle of 50 bytes.
fn corners(triangle: &[u8]) -> [Vec3; 3] {
    let number = |k: usize| {
        let at = 12 + 4 * k;
        f64::from(f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]))
    };
    [0, 3, 6].map(|k| Vec3::new(number(k), number(k + 1), number(k + 2)))
}

/// Whether 50 bytes look like a triangle: its corners are three different points.
fn is_triangle(bytes: &[u8]) -> bool {
    let [a, b, c] = corners(bytes);
    a.is_finite() && b.is_finite() && c.is_finite() && a != b && b != c && c != a
}
