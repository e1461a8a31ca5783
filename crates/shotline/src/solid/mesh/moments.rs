//! Volume and moments of a mesh from its faces.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use super::MeshSolid;
use super::doubt::Doubt;
use super::patches::Patch;
use super::shells::Shells;
use super::stop::{Cancelled, Stop};
use super::tetrahedra::{determinant, exact_determinant, is_accurate};
use super::welded::first_at;
use crate::aabb::Aabb;
use crate::math::{Affine, Dd, Vec3};
use crate::pool;
use crate::solid::Moments;

/// What the faces of a closed mesh determine about its inside.
#[derive(Debug)]
pub enum Enclosed<'a> {
    /// Its moments, exact but for rounding.
    Exactly(Moments),
    /// The integrals of the winding number, which counts a doubly enclosed region twice, and the cells where it may not
    /// be 0 or 1.
    Partly(Box<Doubt<'a>>),
}

impl MeshSolid {
    /// Computes the moments of the inside from the faces. The result is exact if the mesh winds
    /// [once](super::Winding::once), or if no faces meet and all winding numbers are known. Otherwise it is the signed
    /// sum and where that may be wrong. Returns `None` for a mesh that is not closed.
    ///
    /// # Errors
    /// [`Cancelled`] within about 0.1 s after any thread has set `cancel`.
    pub fn enclosed(&self, cancel: Option<&AtomicBool>) -> Result<Option<Enclosed<'_>>, Cancelled> {
        if !self.is_closed() {
            return Ok(None);
        }
        pool::divided(|| self.find_enclosed(Stop::when(cancel))).map(Some)
    }

    fn find_enclosed(&self, stop: Stop) -> Result<Enclosed<'_>, Cancelled> {
        let patches = self.patches(stop)?;
        if !self.face_contacts().may_cross() && patches.iter().all(Patch::is_sound) {
            return Ok(Enclosed::Exactly(self.by_tetrahedra(|_| f64::from(self.inside()))));
        }
        if self.face_contacts().marks.iter().all(|marks| *marks == 0) && self.folds().is_empty() {
            // No faces meet, so the sides of each face have the winding numbers of its patch. It counts if the inside
            // ends there.
            let mut weights = vec![0.0; self.triangles.len()];
            for patch in &patches {
                let Some([front, back]) = patch.sides else { break };
                let weight = f64::from(i32::from(back != 0) - i32::from(front != 0));
                patch.items.iter().for_each(|item| weights[*item as usize] = weight);
            }
            if patches.iter().all(|patch| patch.sides.is_some()) {
                return Ok(Enclosed::Exactly(self.by_tetrahedra(|item| weights[item])));
            }
        }
        Ok(Enclosed::Partly(Box::new(Doubt::of(self, &patches, stop)?)))
    }

    /// The moments of the inside, if the faces determine them exactly.
    pub(super) fn exact_moments(&self) -> Option<Moments> {
        match self.enclosed(None).ok()?? {
            Enclosed::Exactly(moments) => Some(moments),
            Enclosed::Partly(_) => None,
        }
    }

    /// The moments of the enclosed volume by the divergence theorem, with a weight for each item.
    fn by_tetrahedra(&self, weight: impl Fn(usize) -> f64) -> Moments {
        self.scaled_moments(weight).placed(&Affine::scaling(self.size.unscale(Vec3::ONE)))
    }

    /// The moments of the weighted winding number, in the coordinates of the scaled mesh. Each shell is integrated from
    /// one of its own vertices, and the results are combined.
    pub(super) fn scaled_moments(&self, weight: impl Fn(usize) -> f64) -> Moments {
        let shells: Vec<Moments> = self
            .items_of_shells()
            .iter()
            .map(|items| {
                let (quick, is_accurate) = self.moments_of_shell(items, &weight, determinant);
                if is_accurate { quick } else { self.moments_of_shell(items, &weight, exact_determinant).0 }
            })
            .collect();
        Moments::total(&shells)
    }

    /// A box around each shell, in the frame of the mesh.
    pub(crate) fn shell_boxes(&self) -> Vec<Aabb> {
        let corners = |item: &u32| self.mesh.corners(self.triangles.face(*item));
        self.items_of_shells().iter().map(|items| Aabb::around(items.iter().flat_map(corners))).collect()
    }

    /// The items of each shell. Shells have no vertex in common.
    fn items_of_shells(&self) -> Vec<Vec<u32>> {
        let all = (0..).take(self.triangles.len());
        if self.topology.shells.count == 1 {
            return vec![all.collect()];
        }
        let first_at = first_at(&self.mesh.vertices);
        let corner = |item: u32, k: usize| {
            let face = self.mesh.faces[self.triangles.face(item) as usize];
            first_at[face[k] as usize]
        };
        let mut shells = Shells::singletons(first_at.len());
        for item in all.clone() {
            shells.join(corner(item, 0), corner(item, 1));
            shells.join(corner(item, 0), corner(item, 2));
        }
        let mut items: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        all.for_each(|item| items.entry(shells.root(corner(item, 0))).or_default().push(item));
        items.into_values().collect()
    }

    /// The moments of a shell by the given kind of determinant, and whether its volume is accurate to a double.
    fn moments_of_shell(
        &self,
        items: &[u32],
        weight: impl Fn(usize) -> f64,
        determinant: fn(Vec3, [Vec3; 3]) -> (Dd, f64),
    ) -> (Moments, bool) {
        let Some(first) = items.first() else { return (Moments::EMPTY, true) };
        let apex = self.triangles.get(*first).corners[0];
        let (mut sums, mut doubt) = ([Dd::ZERO; 10], 0.0);
        for &item in items {
            let (corners, weight) = (self.triangles.get(item).corners, weight(item as usize));
            if weight == 0.0 {
                continue;
            }
            let (six, error) = determinant(apex, corners);
            let terms = terms(six.hi / 6.0 * weight, corners.map(|corner| corner - apex));
            sums[0] = sums[0] + six * weight;
            (1..10).for_each(|i| sums[i] = sums[i] + Dd::from(terms[i]));
            doubt += error;
        }
        let is_accurate = is_accurate(sums[0], doubt, items.len());
        let mut sums = sums.map(|sum| sum.hi);
        sums[0] /= 6.0;
        let moments = Moments::from_integrals(sums);
        (Moments { centroid: moments.centroid + apex, ..moments }, is_accurate)
    }
}

/// The integrals of `1`, `x`, `y`, `z`, `x^2`, `y^2`, `z^2`, `yz`, `xz`, `xy` over the tetrahedron of the origin and a
/// triangle, negated if the origin is in front of the triangle.
pub(crate) fn tetrahedron([a, b, c]: [Vec3; 3]) -> [f64; 10] {
    terms(a.dot(b.cross(c)) / 6.0, [a, b, c])
}

/// The integrals over the tetrahedron of the origin and a triangle, given its signed volume.
fn terms(volume: f64, [a, b, c]: [Vec3; 3]) -> [f64; 10] {
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
    fn shells_in_one_another_and_turned_ones_count_once() {
        let volume = |mesh: TriangleMesh| moments(mesh).map(|m| m.volume).unwrap();
        let (one, half) = (volume(ball(2)), volume(ball(1).moved(&at(3.0, 0.5))));
        assert!((volume(ball(2).with(&ball(2).moved(&at(0.1, 0.5)))) - one).abs() < 1e-14);
        let turned = volume(ball(2).with(&ball(1).inside_out().moved(&at(3.0, 0.5))));
        assert!((turned - one - half).abs() < 1e-13);
    }

    #[test]
    fn where_the_winding_number_is_not_one_faces_do_not_tell() {
        // Balls that overlap, and a small cube in the corner of another, where no faces pass through each other.
        assert_eq!(moments(ball(2).with(&ball(2).moved(&at(0.3, 1.0)))), None);
        assert_eq!(moments(cubes(&[[0, 0, 0]]).with(&cubes(&[[0, 0, 0]]).moved(&at(0.0, 0.25)))), None);
        assert_eq!(moments(sheet(3)), None);
    }

    #[test]
    fn the_volume_of_a_long_tetrahedron_is_not_lost_to_cancellation() {
        let far = Vec3::splat(1e9);
        let vertices = vec![Vec3::ZERO, Vec3::X, Vec3::Y, far];
        let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = TriangleMesh::new(vertices, faces);
        let found = moments(mesh.clone()).unwrap();
        assert!((found.volume / (1e9 / 6.0) - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.centroid.z / 2.5e8 - 1.0).abs() < 1e-12, "{found:?}");
        // 3/80 of V h^2, as for any cone.
        assert!((found.second[2][2] / (1e9 / 6.0 * 1e18 * 3.0 / 80.0) - 1.0).abs() < 1e-12, "{found:?}");
        let solid = MeshSolid::new(Arc::new(mesh.inside_out()), "bvh").unwrap();
        assert!((solid.topology().signed_volume / (-1e9 / 6.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn small_shells_far_apart_have_the_sum_of_their_volumes() {
        for (size, away) in [(1.0, 1e8), (1.0 / 1024.0, 1e6), (1.0 / 1024.0, 1e9)] {
            let one = |place: Vec3| {
                let map = Affine::translation(place).then_after(&Affine::scaling(Vec3::splat(size)));
                cubes(&[[0, 0, 0]]).moved(&map)
            };
            let mesh = one(Vec3::ZERO).with(&one(Vec3::splat(away))).with(&one(Vec3::X * away));
            let solid = MeshSolid::new(Arc::new(mesh), "bvh").unwrap();
            let (found, volume) = (solid.moments().unwrap(), 3.0 * size.powi(3));
            assert!((found.volume / volume - 1.0).abs() < 1e-12, "{size} {away} {found:?}");
            assert!((solid.topology().signed_volume / volume - 1.0).abs() < 1e-12);
            assert!((found.centroid.x / (2.0 / 3.0 * away + 0.5 * size) - 1.0).abs() < 1e-12);
            let spread = volume * (2.0 / 9.0 * away * away + size * size / 12.0);
            assert!((found.second[0][0] / spread - 1.0).abs() < 1e-12, "{found:?}");
        }
    }
}
