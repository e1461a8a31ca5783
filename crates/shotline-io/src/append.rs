//! Joins meshes to one.

use shotline::math::Affine;
use shotline::solid::mesh::{Attribute, NO_ROW, TriangleMesh};

use crate::error::WriteError;

/// The attribute that a transform would change.
pub(crate) const NORMAL: &str = "normal";

/// The most triangles of a mesh to which others were joined: copies of a shared mesh can be more than memory holds.
const MOST_TRIANGLES: usize = 100_000_000;

/// Refuses to join meshes to one that would be too large. `what` names the one in the message.
pub(crate) fn expect_joinable<'m>(
    meshes: impl Iterator<Item = &'m TriangleMesh>,
    what: &str,
) -> Result<(), WriteError> {
    let triangles: usize = meshes.map(|mesh| mesh.faces.len()).sum();
    if triangles <= MOST_TRIANGLES {
        return Ok(());
    }
    Err(WriteError::Unwritable(format!(
        "{what} would be one mesh of {triangles} triangles, since shared meshes are written out, and at most {MOST_TRIANGLES} are"
    )))
}

/// Appends a mesh under a transform. Normals of a mesh that is moved are left out.
pub(crate) fn append(
    out: &mut TriangleMesh,
    mesh: &TriangleMesh,
    world_from_local: &Affine,
) -> Result<(), WriteError> {
    let first = u32::try_from(out.vertices.len()).ok();
    let first = first.filter(|n| mesh.vertices.len() <= (u32::MAX - n) as usize);
    let first = first.ok_or_else(|| WriteError::Unwritable("more than 4294967295 vertices".into()))?;
    // A reflection inverts the orientation of triangles.
    let is_mirrored = world_from_local.determinant() < 0.0;
    let is_moved = !world_from_local.is_identity();
    append_polygons(out, mesh);
    append_attributes(out, mesh, is_mirrored, is_moved);
    if is_moved {
        out.vertices.extend(mesh.vertices.iter().map(|v| world_from_local.point(*v)));
    } else {
        out.vertices.extend(&mesh.vertices);
    }
    let corners = mesh.faces.iter().map(|corners| turned(*corners, is_mirrored));
    out.faces.extend(corners.map(|corners| corners.map(|vertex| first + vertex)));
    Ok(())
}

/// The corners of a triangle, in the other direction if it is mirrored.
fn turned([a, b, c]: [u32; 3], is_mirrored: bool) -> [u32; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}

/// Appends the polygon numbers of a mesh, counted on from the last; does nothing if every polygon is one triangle.
fn append_polygons(out: &mut TriangleMesh, mesh: &TriangleMesh) {
    if out.polygons.is_empty() && mesh.polygons.is_empty() {
        return;
    }
    if out.polygons.is_empty() {
        out.polygons = (0..).take(out.faces.len()).collect();
    }
    let first = out.polygons.last().map_or(0, |last| last.saturating_add(1));
    out.polygons.extend((0..).take(mesh.faces.len()).map(|face| first.saturating_add(mesh.polygon(face))));
}

/// Appends the attributes of a mesh, before its vertices and faces are. Corners of the other mesh have no value of an
/// attribute that only one mesh has.
fn append_attributes(out: &mut TriangleMesh, mesh: &TriangleMesh, is_mirrored: bool, is_moved: bool) {
    let kept = || mesh.attributes.iter().filter(|attribute| attribute.name != NORMAL || !is_moved);
    if out.faces.is_empty() && !is_mirrored {
        out.attributes = kept().cloned().collect();
        return;
    }
    let before = out.faces.len();
    for new in kept() {
        if out.attribute(&new.name).is_none() {
            let corners = Some(vec![[NO_ROW; 3]; before]);
            out.attributes.push(Attribute { corners, ..new.without_values() });
        }
    }
    let faces = &out.faces;
    for attribute in &mut out.attributes {
        let corners = attribute.corners.get_or_insert_with(|| faces.clone());
        let new = kept().find(|new| new.name == attribute.name && new.width == attribute.width);
        let Some(new) = new else {
            corners.resize(before + mesh.faces.len(), [NO_ROW; 3]);
            continue;
        };
        let first = (attribute.values.len() / attribute.width) as u32;
        let moved = |row: u32| if row == NO_ROW { NO_ROW } else { row.saturating_add(first) };
        let rows = new.corners.as_ref().unwrap_or(&mesh.faces);
        corners.extend(rows.iter().map(|rows| turned(*rows, is_mirrored).map(moved)));
        attribute.values.extend(&new.values);
    }
}

#[cfg(test)]
mod tests {
    use shotline::math::Vec3;

    use super::*;

    #[test]
    fn attributes_follow_their_triangles() {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut mesh = TriangleMesh::new(corners, vec![[0, 1, 2]]);
        let plain = mesh.clone();
        mesh.attributes.push(Attribute::of_vertices("uv", 1, vec![5.0, 6.0, 7.0]));
        mesh.attributes.push(Attribute::of_vertices(NORMAL, 1, vec![0.0; 3]));
        let mirror = Affine::scaling(Vec3::new(-1.0, 1.0, 1.0));
        let mut out = TriangleMesh::default();
        for (part, transform) in [(&plain, Affine::IDENTITY), (&mesh, mirror), (&mesh, Affine::IDENTITY)] {
            append(&mut out, part, &transform).unwrap();
        }
        out.check().unwrap();
        let value = |face, corner| out.corner_value(&out.attributes[0], face, corner).map(|value| value[0]);
        let values = [0, 1, 2].map(|face| [0, 1, 2].map(|corner| value(face, corner)));
        let some = |values: [f64; 3]| values.map(Some);
        assert_eq!(values, [[None; 3], some([5.0, 7.0, 6.0]), some([5.0, 6.0, 7.0])]);
        let normals = out.attribute(NORMAL).unwrap().corners.as_ref().unwrap();
        assert_eq!(normals[1], [NO_ROW; 3]);
    }
}
