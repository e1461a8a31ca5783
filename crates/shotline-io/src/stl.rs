//! STL: triangles without shared vertices, as text or binary. Corners with the same coordinates become one vertex,
//! or no mesh would be closed.
//!
//! Our own reader. `stl_io`, the well-kept library, reads text in float32 and says no place when a file is broken.

use std::collections::HashMap;
use std::fmt::Write;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::bytes::{Cursor, Word, words};
use crate::error::WriteError;
use crate::fault::Fault;
use crate::format::{Content, Encoded, Format, MeshFile};

pub(crate) const FORMAT: Format = Format {
    name: "STL",
    extensions: &["stl"],
    detect: |bytes| is_binary(bytes) || starts_like_text(bytes),
    content: Content::Mesh { read, write },
};

/// Bytes before the first triangle of a binary file, the last four of which count the triangles.
const HEAD: usize = 84;

/// Bytes of a triangle: a normal, three corners, and two bytes that mean nothing.
const TRIANGLE: usize = 50;

/// How many triangles the head of a binary file promises.
fn promised(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEAD)?;
    Some(u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// Binary files are known by their size; many of them begin with the word "solid".
fn is_binary(bytes: &[u8]) -> bool {
    promised(bytes)
        .is_some_and(|n| n.checked_mul(TRIANGLE).and_then(|n| n.checked_add(HEAD)) == Some(bytes.len()))
}

fn starts_like_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    // A zero byte is in the head of nearly every binary file and in no text.
    start.len() > 5
        && start[..5].eq_ignore_ascii_case(b"solid")
        && !bytes[..bytes.len().min(HEAD)].contains(&0)
}

fn read(bytes: &[u8]) -> Result<MeshFile, Fault> {
    let mut welder = Welder::default();
    if is_binary(bytes) {
        read_binary(bytes, &mut welder)?;
    } else if starts_like_text(bytes) {
        read_text(bytes, &mut welder)?;
    } else {
        return Err(wrong_size(bytes));
    }
    if welder.mesh.faces.is_empty() {
        return Err(Fault::file("has no triangles"));
    }
    Ok(MeshFile { mesh: welder.mesh, notes: Vec::new() })
}

fn wrong_size(bytes: &[u8]) -> Fault {
    let Some(count) = promised(bytes) else {
        return Fault::byte(
            bytes.len(),
            "the file ends within the head of a binary STL, and is no text STL either",
        );
    };
    let held = (bytes.len() - HEAD) / TRIANGLE;
    let message = format!("the file promises {count} triangles at byte 80, but its size fits {held}");
    Fault::byte((HEAD + held * TRIANGLE).min(bytes.len()), message)
        .help("the file is cut off, or it is no STL")
}

fn read_binary(bytes: &[u8], out: &mut Welder) -> Result<(), Fault> {
    for (i, triangle) in bytes[HEAD..].chunks_exact(TRIANGLE).enumerate() {
        let number = |k: usize| {
            let at = 12 + 4 * k;
            f64::from(f32::from_le_bytes([
                triangle[at],
                triangle[at + 1],
                triangle[at + 2],
                triangle[at + 3],
            ]))
        };
        let corner = |k: usize| Vec3::new(number(3 * k), number(3 * k + 1), number(3 * k + 2));
        let corners = [corner(0), corner(1), corner(2)];
        if !corners.iter().all(|c| c.is_finite()) {
            let message = format!("triangle {i} has a coordinate that is NaN or infinite");
            return Err(Fault::byte(HEAD + i * TRIANGLE, message));
        }
        out.add(corners);
    }
    Ok(())
}

/// Reads `facet ... vertex x y z (three times) ... endfacet` and passes over the other words, which say nothing.
fn read_text(bytes: &[u8], out: &mut Welder) -> Result<(), Fault> {
    let mut cursor = Cursor::new(bytes, 0);
    let mut corners: Vec<Vec3> = Vec::new();
    let mut closed = true;
    while let Some((start, line)) = cursor.line() {
        let line: Vec<Word> = words(line, start).collect();
        let Some(first) = line.first() else { continue };
        let is = |word: &str| first.bytes.eq_ignore_ascii_case(word.as_bytes());
        if is("vertex") {
            corners.push(read_corner(&line)?);
        } else if is("facet") {
            closed = false;
        } else if is("endfacet") {
            let count = corners.len();
            let triangle = <[Vec3; 3]>::try_from(std::mem::take(&mut corners));
            let message = format!("triangle {} has {count} corners", out.mesh.faces.len());
            out.add(triangle.map_err(|_| Fault::text(first.range(), message))?);
            closed = true;
        } else if !["solid", "outer", "endloop", "endsolid"].into_iter().any(is) {
            return Err(Fault::text(first.range(), format!("'{}' is no word of an STL file", first.shown())));
        }
    }
    if closed {
        Ok(())
    } else {
        Err(Fault::byte(bytes.len(), "the file ends within a facet").help("it is cut off"))
    }
}

fn read_corner(line: &[Word]) -> Result<Vec3, Fault> {
    match line {
        [_, x, y, z] => Ok(Vec3::new(x.finite()?, y.finite()?, z.finite()?)),
        [first, ..] => Err(Fault::text(first.range(), "a vertex has three coordinates")),
        [] => Ok(Vec3::ZERO),
    }
}

/// Joins corners with the same coordinates.
#[derive(Default)]
struct Welder {
    mesh: TriangleMesh,
    known: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn add(&mut self, corners: [Vec3; 3]) {
        let face = corners.map(|c| {
            // Adding zero turns -0.0 into 0.0, which is the same place.
            let key = (c + Vec3::ZERO).to_array().map(f64::to_bits);
            *self.known.entry(key).or_insert_with(|| {
                self.mesh.vertices.push(c);
                (self.mesh.vertices.len() - 1) as u32
            })
        });
        self.mesh.faces.push(face);
    }
}

/// Binary where float32 holds every coordinate, as nearly all programs expect; otherwise text, which loses nothing.
fn write(mesh: &TriangleMesh) -> Result<Encoded, WriteError> {
    let single = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
    let vertices = mesh.vertices.len();
    let moved = mesh.vertices.iter().filter(|v| !v.to_array().into_iter().all(single)).count();
    let mut notes = Vec::new();
    let bytes = if moved == 0 {
        write_binary(mesh)?
    } else {
        notes.push(format!(
            "written as text: binary STL holds float32 only, which would move {moved} of {vertices} vertices"
        ));
        write_text(mesh)
    };
    let lost = vertices - places(mesh);
    if lost > 0 {
        notes.push(format!(
            "vertices lost: {lost} of {vertices}; STL names none, so those of no face go, and those in one place \
             become one"
        ));
    }
    Ok(Encoded { bytes, notes })
}

/// In how many places the faces have corners.
fn places(mesh: &TriangleMesh) -> usize {
    let mut welder = Welder::default();
    triangles(mesh).for_each(|corners| welder.add(corners));
    welder.mesh.vertices.len()
}

fn write_binary(mesh: &TriangleMesh) -> Result<Vec<u8>, WriteError> {
    let count = u32::try_from(mesh.faces.len());
    let count = count.map_err(|_| WriteError::Unwritable("STL holds at most 4294967295 triangles".into()))?;
    let mut out = vec![0; 80];
    out[..15].copy_from_slice(b"shotline binary");
    out.extend(count.to_le_bytes());
    for corners in triangles(mesh) {
        for v in [normal(&corners)].iter().chain(&corners) {
            out.extend(v.to_array().iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        out.extend([0, 0]);
    }
    Ok(out)
}

fn write_text(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = String::from("solid shotline\n");
    for corners in triangles(mesh) {
        let n = normal(&corners);
        // Writing to a string cannot fail.
        let _ = writeln!(out, "facet normal {:?} {:?} {:?}\nouter loop", n.x, n.y, n.z);
        for v in &corners {
            let _ = writeln!(out, "vertex {:?} {:?} {:?}", v.x, v.y, v.z);
        }
        out.push_str("endloop\nendfacet\n");
    }
    out.push_str("endsolid shotline\n");
    out.into_bytes()
}

fn triangles(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    mesh.faces.iter().map(|face| face.map(|i| mesh.vertices[i as usize]))
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}
