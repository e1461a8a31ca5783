//! Volume and moments of a mesh by its faces.

use rayon::prelude::*;

use super::MeshSolid;
use super::probe::Triangle;
use super::winding::winds_once;
use crate::accel::Scratch;
use crate::math::{Affine, Dd, Vec3};
use crate::ray::{Line, Span};
use crate::solid::Moments;

impl MeshSolid {
    /// The sums of the signed tetrahedra between the faces and a point (the divergence theorem), if they are those of
    /// the inside: see [`MeshSolid::winds_once`].
    pub(super) fn by_tetrahedra(&self) -> Option<Moments> {
        if !self.winds_once() {
            return None;
        }
        let tip = self.size.scale(self.bounds.centre());
        let mut sums = [Dd::ZERO; 10];
        for triangle in &self.triangles {
            let tetrahedron = tetrahedron(triangle.corners.map(|v| v - tip));
            sums = std::array::from_fn(|i| sums[i] + Dd::from(tetrahedron[i]));
        }
        let sign = if sums[0].hi < 0.0 { -1.0 } else { 1.0 };
        let moments = Moments::from_integrals(sums.map(|s| s.hi * sign));
        let unscaled = Moments { centroid: moments.centroid + tip, ..moments };
        Some(unscaled.placed(&Affine::scaling(self.size.unscale(Vec3::ONE))))
    }

    /// Whether the winding number is 0 or one other number everywhere, 1 or -1, so that the volume it encloses is
    /// that of the inside.
    ///
    /// It changes only at faces. No two faces pass through each other, and a line through the middle of each face meets
    /// no other winding number. A face that lies in another, and is seen by none of these lines, might still be
    /// overlooked.
    fn winds_once(&self) -> bool {
        let inside = if self.topology.signed_volume < 0.0 { -1 } else { 1 };
        let sound = |triangle: &Triangle| {
            let [a, b, c] = triangle.corners;
            let normal = (b - a).cross(c - a).abs();
            let mut hits = Vec::new();
            let middle = self.size.unscale((a + b + c) / 3.0);
            // Seen as much from the front as an axis allows.
            let axis = Vec3::AXES[(0..3).fold(0, |best, i| if normal[i] > normal[best] { i } else { best })];
            let from = middle - axis * (middle.dot(axis) - self.bounds.min.dot(axis));
            let before = self.bounds.size().max_element();
            let line = Line::exact(from - axis * before, axis * before);
            self.hits(&line, Span::FORWARD, &mut hits, &mut Scratch::default());
            winds_once(&hits, inside)
        };
        self.is_closed() && self.triangles.par_iter().all(sound) && self.self_intersections().count == 0
    }
}

/// The integrals of `1`, `x`, `y`, `z`, `x^2`, `y^2`, `z^2`, `yz`, `xz`, `xy` over the tetrahedron between the origin
/// and a triangle, negative where that is seen from behind.
pub(crate) fn tetrahedron([a, b, c]: [Vec3; 3]) -> [f64; 10] {
    let volume = a.dot(b.cross(c)) / 6.0;
    let s = a + b + c;
    let first = s * (volume / 4.0);
    let product =
        |i: usize, j: usize| volume / 20.0 * (s[i] * s[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
    [
        volume,
        first.x,
        first.y,
        first.z,
        product(0, 0),
        product(1, 1),
        product(2, 2),
        product(1, 2),
        product(0, 2),
        product(0, 1),
    ]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::solid::Solid;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, cubes, ring, sheet};

    fn moments(mesh: TriangleMesh) -> Option<Moments> {
        MeshSolid::new(Arc::new(mesh), "bvh").unwrap().moments()
    }

    fn at(x: f64, size: f64) -> Affine {
        Affine::translation(Vec3::splat(x)).then_after(&Affine::scaling(Vec3::splat(size)))
    }

    #[test]
    fn cubes_have_their_moments_however_large_and_wound() {
        for size in [1.0, 1e-60, 1e60] {
            let map = Affine::scaling(Vec3::splat(size));
            for mesh in [cubes(&[[0, 0, 0]]), cubes(&[[0, 0, 0]]).inside_out()] {
                let found = moments(mesh.moved(&map)).unwrap();
                assert!((found.volume / size.powi(3) - 1.0).abs() < 1e-14, "{found:?}");
                assert!((found.centroid / size - Vec3::splat(0.5)).length() < 1e-15, "{found:?}");
                assert!((found.second[1][1] / size.powi(5) - 1.0 / 12.0).abs() < 1e-14, "{found:?}");
                assert!((found.second[0][1] / size.powi(5)).abs() < 1e-15, "{found:?}");
            }
        }
    }

    #[test]
    fn cavities_count_as_holes_and_touching_shells_as_two() {
        let volume = |mesh: TriangleMesh| moments(mesh).map(|m| m.volume);
        let one = volume(ball(2)).unwrap();
        let hollow = volume(ball(2).with(&ball(2).inside_out().moved(&at(0.0, 0.5)))).unwrap();
        assert!((hollow - one * 0.875).abs() < 1e-14);
        assert_eq!(volume(cubes(&[[0, 0, 0], [1, 0, 0], [3, 0, 0]])), Some(3.0));
        assert!(volume(ring(9, 5).unwelded()).is_some());
    }

    #[test]
    fn where_the_winding_number_is_not_one_faces_do_not_tell() {
        // Shells in one another, across one another, turned, and in one corner, where no faces pass through each other.
        for other in [
            ball(2).moved(&at(0.1, 0.5)),
            ball(2).moved(&at(0.3, 1.0)),
            ball(1).inside_out().moved(&at(3.0, 0.5)),
        ] {
            assert_eq!(moments(ball(2).with(&other)), None);
        }
        assert_eq!(moments(cubes(&[[0, 0, 0]]).with(&cubes(&[[0, 0, 0]]).moved(&at(0.0, 0.25)))), None);
        assert_eq!(moments(sheet(3)), None);
    }
}
