//! Triangles to STL.

use std::collections::HashSet;
use std::fmt::Write;

use shotline::math::Vec3;
use shotline::solid::mesh::TriangleMesh;

use crate::error::WriteError;
use crate::format::{lost_attributes, lost_polygons};
use crate::mesh_file::{Encoded, NamedMesh};

/// Words that a name must not have.
const RESERVED: [&str; 4] = ["solid", "facet", "endsolid", "end"];

/// Writes binary STL, as nearly all programs expect, if float32 holds every coordinate; otherwise text, which is lossless.
/// Text keeps the objects apart, each as a solid.
pub(super) fn write(named: NamedMesh) -> Result<Encoded, WriteError> {
    let mesh = named.mesh;
    let single = |x: f64| f64::from(x as f32).to_bits() == x.to_bits();
    let vertices = mesh.vertices.len();
    let moved = mesh.vertices.iter().filter(|v| !v.to_array().into_iter().all(single)).count();
    let mut notes = Vec::new();
    let bytes = if moved == 0 {
        let objects: HashSet<&str> = named.objects.iter().map(|object| object.name.as_str()).collect();
        if objects.len() > 1 {
            let count = objects.len();
            notes.push(format!(
                "{count} objects were joined into one mesh: binary STL holds one, without a name"
            ));
        }
        write_binary(mesh)?
    } else {
        notes.push(format!(
            "written as text: binary STL holds float32 only, which would move {moved} of {vertices} vertices"
        ));
        write_text(named)
    };
    let lost = vertices - distinct_corners(mesh);
    if lost > 0 {
        notes.push(format!(
            "vertices lost: {lost} of {vertices}; STL names none, so those of no face go, and those in one place \
             become one"
        ));
    }
    notes.extend(lost_polygons(mesh).into_iter().chain(lost_attributes(mesh)));
    Ok(Encoded { bytes, notes })
}

/// The number of distinct corner positions of the faces.
fn distinct_corners(mesh: &TriangleMesh) -> usize {
    // Adding zero turns -0.0 into 0.0, which is the same position.
    let key = |c: Vec3| (c + Vec3::ZERO).to_array().map(f64::to_bits);
    triangles(mesh).flatten().map(key).collect::<HashSet<_>>().len()
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

fn write_text(named: NamedMesh) -> Vec<u8> {
    let mut out = String::new();
    for (object, faces) in named.runs() {
        let name = object.map_or("shotline".into(), |object| solid_name(&object.name));
        // Writing to a string cannot fail.
        let _ = writeln!(out, "solid {name}");
        for corners in named.mesh.faces[faces].iter().map(|face| corners(named.mesh, face)) {
            let n = normal(&corners);
            let _ = writeln!(out, "facet normal {:?} {:?} {:?}\nouter loop", n.x, n.y, n.z);
            for v in &corners {
                let _ = writeln!(out, "vertex {:?} {:?} {:?}", v.x, v.y, v.z);
            }
            out.push_str("endloop\nendfacet\n");
        }
        let _ = writeln!(out, "endsolid {name}");
    }
    out.into_bytes()
}

/// A name without words that STL reserves.
fn solid_name(name: &str) -> String {
    let is_reserved = |word: &str| RESERVED.iter().any(|reserved| word.eq_ignore_ascii_case(reserved));
    let changed = |word: &str| if is_reserved(word) { format!("{word}_") } else { word.into() };
    name.split(' ').map(changed).collect::<Vec<String>>().join(" ")
}

fn triangles(mesh: &TriangleMesh) -> impl Iterator<Item = [Vec3; 3]> {
    mesh.faces.iter().map(|face| corners(mesh, face))
}

fn corners(mesh: &TriangleMesh, face: &[u32; 3]) -> [Vec3; 3] {
    face.map(|i| mesh.vertices[i as usize])
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}
