//! Whether a mesh contains many points.

use std::sync::atomic::Ordering;

use super::MeshSolid;
use super::empty_cells::EmptyCells;
use crate::math::Vec3;
use crate::solid::Solid;

impl MeshSolid {
    /// Whether the mesh contains a point, as [`Solid::contains`] finds it: that casts a line. After many points, the
    /// result for most others is looked up in the cells of space that no face meets.
    pub(crate) fn contains_one_of_many(&self, p: Vec3) -> bool {
        if !self.bounds.contains(p) {
            return false;
        }
        match self.empty_cells.get() {
            Some(cells) => {
                let winding = cells.as_ref().and_then(|cells| cells.winding_at(p));
                winding.map_or_else(|| self.contains(p), |winding| winding != 0)
            }
            None => {
                self.count_point();
                self.contains(p)
            }
        }
    }

    /// Counts a point. Once there are so many that the cells will save more time than they take, makes them.
    fn count_point(&self) {
        let enough = if cfg!(any(test, feature = "testkit")) { 64 } else { 1024 + self.triangles.len() / 4 };
        // Only one thread makes the cells. The others go on without them.
        if self.points.fetch_add(1, Ordering::Relaxed) + 1 == enough {
            self.make_cells();
        }
    }

    pub(super) fn make_cells(&self) {
        let winding = |p: Vec3| self.winding_number(p);
        // Nothing else sets them.
        let _ =
            self.empty_cells.set(EmptyCells::of(&self.triangles, self.size, &self.scaled_bounds, winding));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, cubes};
    use crate::testkit::meshes::Thin;
    use crate::testkit::random::Random;

    /// Points in and around the box of each mesh, and close to its faces.
    #[test]
    fn cells_change_no_result() {
        let mut random = Random::new(21);
        let thin: Vec<TriangleMesh> = (0..20).map(|_| Thin::any(&mut random).mesh(&mut random)).collect();
        let places = [[0, 0, 0], [1, 0, 0], [1, 1, 1], [3, 0, 2]];
        for mesh in [ball(4), ball(4).inside_out(), cubes(&places)].into_iter().chain(thin) {
            let corners = mesh.vertices.clone();
            let Ok(solid) = MeshSolid::new(Arc::new(mesh), "bvh") else { continue };
            let bounds = solid.bounds();
            for _ in 0..3000 {
                let p = match random.below(4) {
                    0 | 1 => bounds.min + bounds.size() * random.point(-0.05, 1.05),
                    2 => corners[random.below(corners.len())] + bounds.size() * random.point(-1e-3, 1e-3),
                    _ => {
                        let mut p = bounds.min + bounds.size() * random.point(0.0, 1.0);
                        p[random.below(3)] = [0.0, 5e-324, -1e-200, 1e-90][random.below(4)];
                        p
                    }
                };
                assert_eq!(solid.contains_one_of_many(p), solid.contains(p), "{p}");
            }
        }
    }
}
