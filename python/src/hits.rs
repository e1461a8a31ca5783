//! Where hits are on the triangles of meshes.

use std::collections::BTreeSet;

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use shotline::compile::{HitMesh, HitMeshes, World};
use shotline::math::Vec3;

/// Hits as columns, read by attribute: points (n, 3), and the surface, triangle and path of each.
#[derive(FromPyObject)]
pub struct HitRows<'py> {
    points: PyReadonlyArray2<'py, f64>,
    surfaces: PyReadonlyArray1<'py, i32>,
    primitives: PyReadonlyArray1<'py, i32>,
    paths: PyReadonlyArray1<'py, i64>,
}

impl HitRows<'_> {
    pub fn len(&self) -> usize {
        self.points.shape()[0]
    }

    /// The weights of the corners of triangles, three for each hit.
    pub fn barycentric(&self, world: &World) -> PyResult<Vec<f64>> {
        let mut weights = vec![f64::NAN; 3 * self.len()];
        let (rows, _) = weights.as_chunks_mut::<3>();
        self.visit(world, |row, mesh, primitive, point| rows[row] = mesh.barycentric(primitive, point))?;
        Ok(weights)
    }

    /// The values of an attribute, and how many numbers each has.
    pub fn interpolate(&self, world: &World, name: &str) -> PyResult<(Vec<f64>, usize)> {
        let (mut known, mut found) = (BTreeSet::new(), None);
        let mut other = None;
        self.visit(world, |row, mesh, primitive, point| {
            let Some(attribute) = mesh.mesh().attribute(name) else {
                known.extend(mesh.mesh().attributes.iter().map(|attribute| attribute.name.clone()));
                return;
            };
            let make = || (vec![f64::NAN; attribute.width * self.len()], attribute.width);
            let (values, width) = found.get_or_insert_with(make);
            if attribute.width == *width {
                mesh.interpolate(attribute, primitive, point, &mut values[row * *width..(row + 1) * *width]);
            } else {
                other = Some((*width, attribute.width));
            }
        })?;
        if let Some((width, other)) = other {
            let message = format!("'{name}' has {width} numbers in one mesh and {other} in another");
            return Err(PyValueError::new_err(message));
        }
        found.ok_or_else(|| {
            let known: Vec<String> = known.into_iter().collect();
            let names = if known.is_empty() { "no attributes".into() } else { known.join(", ") };
            PyKeyError::new_err(format!("'{name}'; the meshes that are hit have {names}"))
        })
    }

    /// Visits each hit of a mesh: its row, its mesh, the triangle and the point.
    fn visit(&self, world: &World, mut take: impl FnMut(usize, HitMesh, u32, Vec3)) -> PyResult<()> {
        let mut meshes = HitMeshes::new(world);
        let (points, _) = self.points.as_slice()?.as_chunks::<3>();
        let (surfaces, primitives) = (self.surfaces.as_slice()?, self.primitives.as_slice()?);
        let numbers = surfaces.iter().zip(primitives).zip(self.paths.as_slice()?);
        for (row, (point, ((&surface, &primitive), &path))) in points.iter().zip(numbers).enumerate() {
            let (Ok(surface), Ok(primitive), Ok(path)) =
                (u32::try_from(surface), u32::try_from(primitive), u64::try_from(path))
            else {
                continue;
            };
            let mesh =
                meshes.get(surface, path).filter(|mesh| (primitive as usize) < mesh.mesh().faces.len());
            if let Some(mesh) = mesh {
                take(row, mesh, primitive, Vec3::from(*point));
            }
        }
        Ok(())
    }
}
