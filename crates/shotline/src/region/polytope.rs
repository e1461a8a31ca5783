//! Convex polyhedra, cut out of a box by planes.

use std::collections::HashMap;

use crate::aabb::Aabb;
use crate::math::{HALF_ULP, Plane, Vec3, unit};

/// A corner lies in a plane if the plane's value there is at most this many half-ulps of the magnitude of its terms.
const IN_PLANE: f64 = 32.0;

/// A closed convex polyhedron, given by its faces. It is computed in plain f64: corners have rounding errors, and
/// features thinner than these may be missing.
#[derive(Clone, Debug)]
pub struct Polytope {
    /// The corners.
    pub corners: Vec<Vec3>,
    /// The indices of the corners of each face, counter-clockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
}

impl Polytope {
    /// A finite box.
    pub fn of_box(b: &Aabb) -> Polytope {
        let pick = |i: usize, k: usize| if i >> k & 1 == 1 { b.max[k] } else { b.min[k] };
        let corners = (0..8).map(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect();
        let faces: [[u32; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Polytope { corners, faces: faces.iter().map(|face| face.to_vec()).collect() }
    }

    /// Cuts off everything in front of a plane.
    pub fn cut(&mut self, plane: &Plane) {
        let sides: Vec<f64> = self.corners.iter().map(|&p| side(plane, p)).collect();
        if !sides.iter().any(|&s| s > 0.0) {
            return;
        }
        if !sides.iter().any(|&s| s < 0.0) {
            *self = Polytope { corners: Vec::new(), faces: Vec::new() };
            return;
        }
        let mut made: HashMap<(u32, u32), u32> = HashMap::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for face in &self.faces {
            let mut kept = Vec::with_capacity(face.len() + 1);
            for (k, &a) in face.iter().enumerate() {
                let b = face[(k + 1) % face.len()];
                let (of_a, of_b) = (sides[a as usize], sides[b as usize]);
                if of_a <= 0.0 {
                    kept.push(a);
                }
                if of_a * of_b < 0.0 {
                    let corners = &mut self.corners;
                    kept.push(*made.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        // Interpolated from the same end for both faces of the edge.
                        let (a, b) = (a.min(b) as usize, a.max(b) as usize);
                        let part = sides[a] / (sides[a] - sides[b]);
                        corners.push(corners[a] + (corners[b] - corners[a]) * part);
                        corners.len() as u32 - 1
                    }));
                }
            }
            if kept.iter().filter(|&&v| sides.get(v as usize).is_some_and(|&s| s < 0.0)).count() > 0 {
                faces.push(kept);
            }
        }
        let in_plane = (0..sides.len() as u32).filter(|&v| sides[v as usize] == 0.0);
        let cap: Vec<u32> = in_plane.chain(made.into_values()).collect();
        faces.push(self.around(cap, unit(plane.normal)));
        faces.retain(|face| face.len() > 2);
        self.faces = faces;
        self.drop_unused();
    }

    /// The corners of a convex face in order, counter-clockwise about a normal.
    fn around(&self, mut corners: Vec<u32>, normal: Vec3) -> Vec<u32> {
        let of = |v: u32| self.corners[v as usize];
        let middle = corners.iter().fold(Vec3::ZERO, |sum, &v| sum + of(v)) / corners.len().max(1) as f64;
        let axis = normal.abs();
        let least = (0..3).fold(0, |best, i| if axis[i] < axis[best] { i } else { best });
        let x = normal.cross(Vec3::AXES[least]);
        let y = normal.cross(x);
        let (x, y) = (x / x.length(), y / y.length());
        let angle = |v: u32| libm::atan2((of(v) - middle).dot(y), (of(v) - middle).dot(x));
        corners.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)).then(a.cmp(&b)));
        corners
    }

    fn drop_unused(&mut self) {
        let mut new = vec![u32::MAX; self.corners.len()];
        let mut corners = Vec::new();
        for v in self.faces.iter_mut().flatten() {
            let place = &mut new[*v as usize];
            if *place == u32::MAX {
                *place = corners.len() as u32;
                corners.push(self.corners[*v as usize]);
            }
            *v = *place;
        }
        self.corners = corners;
    }

    /// The faces cut into triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        let of = |v: u32| self.corners[v as usize];
        self.faces.iter().flat_map(move |face| {
            (1..face.len().saturating_sub(1)).map(move |k| [of(face[0]), of(face[k]), of(face[k + 1])])
        })
    }
}

/// The value of a plane at a point: positive in front of it, and 0 in the plane up to rounding.
pub(super) fn side(plane: &Plane, p: Vec3) -> f64 {
    let value = plane.evaluate(p);
    let size = (plane.normal * p).abs().element_sum() + plane.offset.abs();
    if value.abs() <= IN_PLANE * HALF_ULP * size { 0.0 } else { value }
}
