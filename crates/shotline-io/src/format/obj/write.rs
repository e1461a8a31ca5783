//! Meshes to OBJ.

use std::fmt::Write;

use shotline::solid::mesh::{Attribute, TriangleMesh};

use crate::error::WriteError;
use crate::format::lost_polygons;
use crate::mesh_file::{Encoded, NamedMesh, ObjectFaces};

/// Writes numbers in the shortest form that reads back as the same float64. Colours of vertices, texture coordinates, normals, and
/// the names of objects and materials are kept.
pub(super) fn write(named: NamedMesh) -> Result<Encoded, WriteError> {
    let NamedMesh { mesh, materials_file, .. } = named;
    let of_width = |name: &str, width| mesh.attribute(name).filter(|attribute| attribute.width == width);
    let color = of_width("color", 3).filter(|attribute| attribute.corners.is_none());
    let (uv, normal) = (of_width("uv", 2), of_width("normal", 3));
    let mut out = materials_file.map_or_else(String::new, |file| format!("mtllib {file}\n"));
    for (number, v) in (0..).zip(&mesh.vertices) {
        let color = color.and_then(|color| color.value(number)).filter(|c| c.iter().all(|x| !x.is_nan()));
        write_line(&mut out, "v", v.to_array().iter().chain(color.unwrap_or_default()));
    }
    for (keyword, attribute) in [("vt", uv), ("vn", normal)] {
        let values = attribute.into_iter().flat_map(|a| a.values.chunks(a.width));
        values.for_each(|value| write_line(&mut out, keyword, value));
    }
    let mut material = None;
    for (object, faces) in named.runs() {
        if let Some(object) = object {
            write_names(&mut out, object, &mut material);
        }
        for face in faces {
            write_face(&mut out, mesh, face as u32, [uv, normal]);
        }
    }
    let written = [color, uv, normal];
    let is_lost = |a: &&Attribute| !written.iter().flatten().any(|b| std::ptr::eq(*a, *b));
    let lost: Vec<&str> = mesh.attributes.iter().filter(is_lost).map(|a| a.name.as_str()).collect();
    let note = (!lost.is_empty()).then(|| format!("attributes of corners are lost: {}", lost.join(", ")));
    Ok(Encoded { bytes: out.into_bytes(), notes: lost_polygons(mesh).into_iter().chain(note).collect() })
}

/// Writes the names of an object and of its material, where that changes.
fn write_names<'a>(out: &mut String, object: &'a ObjectFaces, material: &mut Option<&'a str>) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "o {}", object.name);
    let of_object = object.material.as_deref();
    if *material != of_object {
        // Without a name, faces have no material any more.
        let _ = writeln!(out, "{}", format!("usemtl {}", of_object.unwrap_or_default()).trim_end());
        *material = of_object;
    }
}

fn write_face(out: &mut String, mesh: &TriangleMesh, face: u32, [uv, normal]: [Option<&Attribute>; 2]) {
    out.push('f');
    for corner in 0..3 {
        let vertex = one_based(mesh.faces[face as usize][corner]);
        let number = |attribute: Option<&Attribute>| number(mesh, attribute?, face, corner);
        // Writing to a string cannot fail.
        let _ = match (number(uv), number(normal)) {
            (None, None) => write!(out, " {vertex}"),
            (Some(uv), None) => write!(out, " {vertex}/{uv}"),
            (None, Some(normal)) => write!(out, " {vertex}//{normal}"),
            (Some(uv), Some(normal)) => write!(out, " {vertex}/{uv}/{normal}"),
        };
    }
    out.push('\n');
}

fn one_based(number: u32) -> u64 {
    u64::from(number) + 1
}

/// The number of the value that a corner has.
fn number(mesh: &TriangleMesh, attribute: &Attribute, face: u32, corner: usize) -> Option<u64> {
    let corners = attribute.corners.as_deref().unwrap_or(&mesh.faces);
    let row = corners.get(face as usize)?[corner];
    attribute.value(row).map(|_| one_based(row))
}

fn write_line<'a>(out: &mut String, keyword: &str, numbers: impl IntoIterator<Item = &'a f64>) {
    out.push_str(keyword);
    for x in numbers {
        let _ = write!(out, " {x:?}");
    }
    out.push('\n');
}
