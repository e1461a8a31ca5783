//! Solids with flat faces, built as closed meshes.

use std::collections::HashMap;
use std::sync::Arc;

use super::Solid;
use super::mesh::{MeshSolid, TriangleMesh};
use super::{ParamError, Parts};
use crate::accel;
use crate::math::Vec3;
use crate::polygon::triangulate;

/// The faces of a solid while it is built. The corners of a face are counter-clockwise seen from outside, and two faces that
/// meet in an edge share both of its vertices.
#[derive(Debug, Default)]
pub(super) struct Faces {
    mesh: TriangleMesh,
    /// The number of faces so far.
    count: u32,
}

impl Faces {
    /// Adds a vertex. Returns its index.
    pub fn vertex(&mut self, p: Vec3) -> u32 {
        self.mesh.vertices.push(p);
        self.mesh.vertices.len() as u32 - 1
    }

    /// Adds vertices of which those at one position are one. Returns their indices.
    pub fn merged(&mut self, points: &[Vec3]) -> Vec<u32> {
        let mut numbers = HashMap::new();
        // Zeros of either sign are equal.
        let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f64::to_bits);
        points.iter().map(|p| *numbers.entry(key(*p)).or_insert_with(|| self.vertex(*p))).collect()
    }

    /// Adds a face. Corners that are equal to the next count once. A face with fewer than three corners is left out.
    pub fn add(&mut self, corners: &[u32]) {
        let mut corners = corners.to_vec();
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() < 3 {
            return;
        }
        let points: Vec<Vec3> = corners.iter().map(|i| self.mesh.vertices[*i as usize]).collect();
        self.add_triangles(
            triangulate(&points).triangles.iter().map(|face| face.map(|i| corners[i as usize])),
        );
    }

    /// Adds a face that is already cut into triangles.
    pub fn add_triangles(&mut self, triangles: impl Iterator<Item = [u32; 3]>) {
        let before = self.mesh.faces.len();
        self.mesh.faces.extend(triangles);
        self.mesh.polygons.extend((before..self.mesh.faces.len()).map(|_| self.count));
        self.count += 1;
    }

    /// The solid. A parameter is named for the error that nothing is enclosed.
    pub fn finish(self, param: &'static str) -> Result<Parts, ParamError> {
        let error = |why: String| ParamError { param, why };
        let mesh = MeshSolid::new(Arc::new(self.mesh), accel::DEFAULT).map_err(|e| error(e.to_string()))?;
        if !mesh.is_closed() {
            return Err(error(format!("make no closed surface: {}", mesh.topology().why_open())));
        }
        Ok(Parts::Solid(Arc::new(mesh) as Arc<dyn Solid>, &["face"]))
    }
}
