//! The winding numbers on both sides of single faces of a closed mesh.
//!
//! A face is *clear* if no other face comes near to it, except at its edges: every other triangle is farther than
//! [`CLEARANCE`] from the part of the face whose barycentric coordinates are larger than [`INSET`] / 2. Then the winding
//! number is the same all along each side of this part. Known for a face, it is that of the space that a ray comes from
//! which hits this part first. So the ray begins inside or outside, and its other hits are not needed. And such a hit is
//! an event of its own: the bounds on all `t` are smaller than the clearance. Therefore one hit shows that the ray has a
//! crossing.
//!
//! A ray of which all hits are found gives the winding numbers on both sides of the face where it enters or leaves. So
//! every face needs one such ray.

use std::sync::atomic::{AtomicI8, AtomicUsize, Ordering};

use rayon::iter::ParallelIterator;

use super::kernel::{CLEARANCE, INSET, WideIndex};
use super::mesh_line::Triangle;
use super::separation::are_apart_by;
use super::triangles::Triangles;
use crate::aabb::Aabb;

/// Meshes with smaller coordinates, other than zero, are not examined: exact signs may underflow, and the hits of a line
/// need not balance.
const SMALLEST_COORDINATE: f64 = 1e-100;

/// The state of a face that no ray has hit.
const UNKNOWN: i8 = i8::MAX;

/// The state of a face that is not clear.
const UNCLEAR: i8 = i8::MAX - 1;

/// A face that more triangles than this are near to counts as not clear.
const MAX_NEIGHBOURS: usize = 1024;

/// Examined faces after which it is known whether enough of them are clear.
const TRIAL: usize = 1 << 14;

/// What is known of the faces of a mesh.
#[derive(Debug)]
pub(crate) struct FaceSides {
    /// By face: the winding number on the front, [`UNKNOWN`] or [`UNCLEAR`].
    states: Vec<AtomicI8>,
    /// The number of examined faces, and of those that are clear.
    examined: AtomicUsize,
    clear: AtomicUsize,
}

impl FaceSides {
    /// Nothing is known yet of so many faces. Returns `None` if the coordinates of the triangles do not allow it.
    pub(super) fn of(triangles: &Triangles, faces: usize) -> Option<FaceSides> {
        let is_small = |x: &f64| *x != 0.0 && x.abs() < SMALLEST_COORDINATE;
        let has_small = |t: Triangle| t.corners.iter().any(|v| v.to_array().iter().any(is_small));
        if triangles.par_iter().any(has_small) {
            return None;
        }
        let states = (0..faces).map(|_| AtomicI8::new(UNKNOWN)).collect();
        Some(FaceSides { states, examined: 0.into(), clear: 0.into() })
    }

    /// The winding number on the front of a face, if the face is known to be clear. That on the back is one more.
    #[inline]
    pub(crate) fn front(&self, face: u32) -> Option<i32> {
        let state = self.states[face as usize].load(Ordering::Relaxed);
        (state < UNCLEAR).then_some(i32::from(state))
    }

    /// Takes the winding number on the front of a face where a ray of a block has hit it off the edges. `is_clear` finds
    /// out whether the face is clear.
    pub(super) fn learn(&self, face: u32, front: i32, is_clear: impl FnOnce() -> bool) {
        let state = &self.states[face as usize];
        // Two threads may find out the same.
        if state.load(Ordering::Relaxed) == UNKNOWN {
            let front = i8::try_from(front).ok().filter(|front| *front < UNCLEAR && is_clear());
            state.store(front.unwrap_or(UNCLEAR), Ordering::Relaxed);
            self.examined.fetch_add(1, Ordering::Relaxed);
            self.clear.fetch_add(usize::from(front.is_some()), Ordering::Relaxed);
        }
    }

    /// Bytes used.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.states.as_slice())
    }

    /// Whether at least half of the faces are clear.
    pub(crate) fn are_useful(&self) -> bool {
        let (examined, clear) = (self.examined.load(Ordering::Relaxed), self.clear.load(Ordering::Relaxed));
        examined < TRIAL || 2 * clear >= examined
    }
}

/// Whether no other triangle comes near to the inner part of a triangle.
pub(super) fn is_clear(index: &WideIndex, triangle: &Triangle) -> bool {
    let inner = inner_part(triangle);
    let around = inner.bounds();
    let around = Aabb { min: around.min - 2.0 * CLEARANCE, max: around.max + 2.0 * CLEARANCE };
    let mut left = MAX_NEIGHBOURS;
    index.tree.visit_overlapping(&around, |leaf| {
        let (others, count) = index.triangles(leaf);
        left = left.saturating_sub(count);
        let is_far = |other: &Triangle| other.face == triangle.face || are_apart_by(CLEARANCE, &inner, other);
        left > 0 && others[..count].iter().all(is_far)
    })
}

/// The triangle of the points whose barycentric coordinates are at least half of [`INSET`].
fn inner_part(triangle: &Triangle) -> Triangle {
    let [a, b, c] = triangle.corners;
    let middle = (a + b + c) * (INSET / 2.0);
    Triangle { corners: [a, b, c].map(|v| v * (1.0 - 1.5 * INSET) + middle), ..*triangle }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::{Affine, Vec3};
    use crate::solid::Solid;
    use crate::solid::mesh::shapes::{ball, cubes, ring};
    use crate::solid::mesh::{MeshSolid, TriangleMesh};

    /// Which faces are clear.
    fn clear(mesh: TriangleMesh) -> Vec<bool> {
        let solid = MeshSolid::new(Arc::new(mesh), "bvh").expect("a mesh");
        let index = solid.index.as_wide().expect("a wide tree");
        solid.triangles.iter().map(|triangle| is_clear(index, &triangle)).collect()
    }

    fn moved(mesh: TriangleMesh, by: f64) -> TriangleMesh {
        mesh.moved(&Affine::translation(Vec3::new(by, 0.0, 0.0)))
    }

    #[test]
    fn all_faces_of_sound_shells_are_clear() {
        let nested = ball(2).with(&ball(1).moved(&Affine::scaling(Vec3::splat(0.3))));
        for mesh in [ball(3), ring(9, 5), ball(2).with(&moved(ball(1), 3.0)), nested] {
            assert!(clear(mesh).iter().all(|is_clear| *is_clear));
        }
    }

    #[test]
    fn what_is_computed_for_rays_and_checks_counts_as_memory() {
        let solid = MeshSolid::new(Arc::new(ball(3)), "bvh").expect("a mesh");
        let built = solid.memory();
        assert!(solid.face_sides().is_some());
        assert_eq!(solid.memory() - built, solid.mesh.faces.len());
        let with_sides = solid.memory();
        solid.make_cells();
        let with_cells = solid.memory();
        solid.self_intersections();
        assert!(with_sides < with_cells && with_cells < solid.memory());
    }

    #[test]
    fn faces_that_others_meet_or_nearly_meet_are_not_clear() {
        let cube = cubes(&[[0; 3]]);
        for (by, count) in [(0.5, 8), (1.0, 20), (1.0 + 0.25 * CLEARANCE, 20), (1.0 + 8.0 * CLEARANCE, 24)] {
            let clear = clear(cube.clone().with(&moved(cube.clone(), by)));
            assert_eq!(clear.iter().filter(|is_clear| **is_clear).count(), count, "{by} {clear:?}");
        }
        assert!(clear(cube.clone().with(&cube)).iter().all(|is_clear| !is_clear));
    }
}
