//! Volume and moments of a mesh by its faces.

use std::sync::atomic::AtomicBool;

use super::MeshSolid;
use super::doubt::Doubt;
use super::patches::Patch;
use super::stop::{Cancelled, Stop};
use crate::math::{Affine, Dd, Vec3};
use crate::solid::Moments;

/// What the faces of a closed mesh tell of its inside.
#[derive(Debug)]
pub enum Enclosed<'a> {
    /// Its moments, exact but for rounding.
    Exactly(Moments),
    /// The integrals of the winding number, which counts what is enclosed twice twice, and where it may not be 0 or 1.
    Partly(Box<Doubt<'a>>),
}

impl MeshSolid {
    /// What the faces tell of the inside: all of it if it winds [once](super::Winding::once); else the signed sum,
    /// and where that may be wrong. `None` for a mesh that is not closed.
    ///
    /// # Errors
    /// [`Cancelled`] within some 0.1 s after any thread has set `cancel`.
    pub fn enclosed(&self, cancel: Option<&AtomicBool>) -> Result<Option<Enclosed<'_>>, Cancelled> {
        if !self.is_closed() {
            return Ok(None);
        }
        let stop = Stop::when(cancel);
        let patches = self.patches(stop)?;
        if self.meetings().crossings.count == 0 && patches.iter().all(Patch::is_sound) {
            return Ok(Some(Enclosed::Exactly(self.by_tetrahedra(|_| f64::from(self.inside())))));
        }
        if self.meetings().marks.iter().all(|marks| *marks == 0) && self.folds().is_empty() {
            // No faces meet: both sides of each are those of its patch, and it counts if the inside ends there.
            let mut weights = vec![0.0; self.triangles.len()];
            for patch in &patches {
                let Some([front, back]) = patch.sides else { break };
                let weight = f64::from(i32::from(back != 0) - i32::from(front != 0));
                patch.items.iter().for_each(|item| weights[*item as usize] = weight);
            }
            if patches.iter().all(|patch| patch.sides.is_some()) {
                return Ok(Some(Enclosed::Exactly(self.by_tetrahedra(|item| weights[item]))));
            }
        }
        Ok(Some(Enclosed::Partly(Box::new(Doubt::of(self, &patches, stop)?))))
    }

    /// The moments of the inside, where the faces tell all of it.
    pub(super) fn exact_moments(&self) -> Option<Moments> {
        match self.enclosed(None).ok()?? {
            Enclosed::Exactly(moments) => Some(moments),
            Enclosed::Partly(_) => None,
        }
    }

    /// The sums of the signed tetrahedra between the faces and a point (the divergence theorem), with the weights of items.
    fn by_tetrahedra(&self, weight: impl Fn(usize) -> f64) -> Moments {
        let tip = self.size.scale(self.bounds.centre());
        let moments = Moments::from_integrals(self.signed_integrals(|v| v - tip, weight));
        let unscaled = Moments { centroid: moments.centroid + tip, ..moments };
        unscaled.placed(&Affine::scaling(self.size.unscale(Vec3::ONE)))
    }

    /// The integrals of the weighted winding number, in the coordinates that a rotation takes the scaled mesh to.
    pub(super) fn signed_integrals(
        &self,
        rotated: impl Fn(Vec3) -> Vec3,
        weight: impl Fn(usize) -> f64,
    ) -> [f64; 10] {
        let mut sums = [Dd::ZERO; 10];
        for (item, triangle) in self.triangles.iter().enumerate() {
            let (tetrahedron, weight) = (tetrahedron(triangle.corners.map(&rotated)), weight(item));
            sums = std::array::from_fn(|i| sums[i] + Dd::from(tetrahedron[i] * weight));
        }
        sums.map(|s| s.hi)
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
    fn shells_in_one_another_and_turned_ones_count_once() {
        let volume = |mesh: TriangleMesh| moments(mesh).map(|m| m.volume).unwrap();
        let (one, half) = (volume(ball(2)), volume(ball(1).moved(&at(3.0, 0.5))));
        assert!((volume(ball(2).with(&ball(2).moved(&at(0.1, 0.5)))) - one).abs() < 1e-14);
        let turned = volume(ball(2).with(&ball(1).inside_out().moved(&at(3.0, 0.5))));
        assert!((turned - one - half).abs() < 1e-13);
    }

    #[test]
    fn where_the_winding_number_is_not_one_faces_do_not_tell() {
        // Across one another, and in one corner, where no faces pass through each other.
        assert_eq!(moments(ball(2).with(&ball(2).moved(&at(0.3, 1.0)))), None);
        assert_eq!(moments(cubes(&[[0, 0, 0]]).with(&cubes(&[[0, 0, 0]]).moved(&at(0.0, 0.25)))), None);
        assert_eq!(moments(sheet(3)), None);
    }
}
