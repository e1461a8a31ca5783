//! Values at the corners of triangles: colours, normals and texture coordinates. No query depends on them.

use super::{MeshError, TriangleMesh};

/// The row of a corner that has no value.
pub const NO_ROW: u32 = u32::MAX;

/// Values at the corners of triangles, which are interpolated linearly across each triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attribute {
    /// Its name. Readers call colours `color` (red, green, blue, perhaps opacity, from 0 to 1), normals `normal` and texture
    /// coordinates `uv`.
    pub name: String,
    /// How many numbers a value has, at least 1.
    pub width: usize,
    /// The numbers, one value after another.
    pub values: Vec<f64>,
    /// For each triangle the values of its corners, by their index, or [`NO_ROW`]. `None` if value `i` is that of vertex `i`.
    pub corners: Option<Vec<[u32; 3]>>,
}

impl Attribute {
    /// Creates an attribute with one value for each vertex.
    pub fn of_vertices(name: impl Into<String>, width: usize, values: Vec<f64>) -> Attribute {
        Attribute { name: name.into(), width, values, corners: None }
    }

    /// Returns the attribute without its values, to which others can be given.
    #[must_use]
    pub fn without_values(&self) -> Attribute {
        Attribute { name: self.name.clone(), width: self.width, ..Attribute::default() }
    }

    /// Returns how many values there are.
    pub fn rows(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Returns the value with this index; `None` if there is no such value.
    pub fn value(&self, row: u32) -> Option<&[f64]> {
        let first = (row as usize).checked_mul(self.width)?;
        self.values.get(first..first.checked_add(self.width)?)
    }

    /// The bytes of its numbers.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.values.as_slice()) + self.corners.as_deref().map_or(0, size_of_val)
    }

    /// Checks the attribute against its mesh.
    pub(super) fn check(&self, mesh: &TriangleMesh) -> Result<(), MeshError> {
        let wrong = |why: String| Err(MeshError::Attribute { name: self.name.clone(), why });
        if self.width == 0 || !self.values.len().is_multiple_of(self.width) {
            return wrong(format!("{} numbers are no values of {} each", self.values.len(), self.width));
        }
        let rows = self.rows();
        let Some(corners) = &self.corners else {
            let vertices = mesh.vertices.len();
            return if rows == vertices {
                Ok(())
            } else {
                wrong(format!("it has {rows} values, but there are {vertices} vertices"))
            };
        };
        if corners.len() != mesh.faces.len() {
            return wrong(format!(
                "it has corners for {} triangles, but there are {}",
                corners.len(),
                mesh.faces.len()
            ));
        }
        let beyond = corners.iter().flatten().find(|row| **row != NO_ROW && **row as usize >= rows);
        match beyond {
            Some(row) => wrong(format!("a corner names value {row}, but there are {rows}, counted from 0")),
            None => Ok(()),
        }
    }

    /// Returns the attribute with the corners of some faces, in their order, of a mesh that has `faces`. The values are the
    /// same, so that vertices may be merged or renumbered.
    pub(super) fn of_faces(&self, faces: &[[u32; 3]], kept: &[u32]) -> Attribute {
        let corners = self.corners.as_deref().unwrap_or(faces);
        let corners = Some(kept.iter().map(|face| corners[*face as usize]).collect());
        Attribute { values: self.values.clone(), corners, ..self.without_values() }
    }
}

impl TriangleMesh {
    /// Returns the attribute with this name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Returns for a corner of a face, 0 to 2, the value of an attribute; `None` if it has none.
    pub fn corner_value<'a>(&self, attribute: &'a Attribute, face: u32, corner: usize) -> Option<&'a [f64]> {
        let corners = attribute.corners.as_deref().unwrap_or(&self.faces);
        attribute.value(*corners.get(face as usize)?.get(corner)?)
    }

    /// Writes the value of an attribute at a point of a face to `out`: the values of the corners with the weights of
    /// barycentric coordinates, NaN where a corner has no value.
    pub fn interpolate(&self, attribute: &Attribute, face: u32, barycentric: [f64; 3], out: &mut [f64]) {
        out.fill(0.0);
        for (corner, weight) in barycentric.into_iter().enumerate() {
            match self.corner_value(attribute, face, corner) {
                Some(value) => out.iter_mut().zip(value).for_each(|(sum, x)| *sum += weight * x),
                None => out.fill(f64::NAN),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::solid::mesh::Weld;

    /// Two triangles with a seam: corners 1 and 3 are in one place.
    fn seam() -> TriangleMesh {
        let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let vertices =
            [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)];
        let mut mesh = TriangleMesh::new(vertices.to_vec(), vec![[0, 1, 2], [3, 4, 2]]);
        let values = (0..10).map(f64::from).collect();
        mesh.attributes.push(Attribute::of_vertices("uv", 2, values));
        mesh
    }

    #[test]
    fn values_are_interpolated_and_missing_corners_are_nan() {
        let mut mesh = seam();
        mesh.check().unwrap();
        let uv = mesh.attribute("uv").unwrap();
        let mut value = [0.0; 2];
        mesh.interpolate(uv, 1, [0.25, 0.25, 0.5], &mut value);
        assert_eq!(value, [0.25 * 6.0 + 0.25 * 8.0 + 0.5 * 4.0, 0.25 * 7.0 + 0.25 * 9.0 + 0.5 * 5.0]);
        mesh.attributes[0].corners = Some(vec![[0, 1, 2], [3, NO_ROW, 2]]);
        mesh.check().unwrap();
        mesh.interpolate(&mesh.attributes[0], 1, [0.25, 0.25, 0.5], &mut value);
        assert!(value.iter().all(|x| x.is_nan()));
    }

    #[test]
    fn welding_keeps_the_values_on_both_sides_of_a_seam() {
        let mesh = seam();
        let (welded, _) = mesh.welded(Weld::Within(0.0)).unwrap();
        welded.check().unwrap();
        assert_eq!(welded.vertices.len(), 4);
        let value = |face, corner| welded.corner_value(&welded.attributes[0], face, corner).unwrap().to_vec();
        assert_eq!((value(0, 1), value(1, 0)), (vec![2.0, 3.0], vec![6.0, 7.0]));
    }

    #[test]
    fn an_attribute_that_does_not_fit_its_mesh_is_refused() {
        let with = |attribute: Attribute| {
            let mesh = TriangleMesh { attributes: vec![attribute], ..seam() };
            mesh.check().unwrap_err().to_string()
        };
        let few = with(Attribute::of_vertices("uv", 2, vec![0.0; 8]));
        assert_eq!(few, "attribute 'uv' does not fit the mesh: it has 4 values, but there are 5 vertices");
        let odd = with(Attribute::of_vertices("uv", 2, vec![0.0; 9]));
        assert!(odd.ends_with("9 numbers are no values of 2 each"), "{odd}");
        let beyond = Attribute {
            corners: Some(vec![[0, 1, 2], [0, 1, 3]]),
            ..Attribute::of_vertices("c", 1, vec![0.0; 3])
        };
        assert!(with(beyond).ends_with("a corner names value 3, but there are 3, counted from 0"));
    }
}
