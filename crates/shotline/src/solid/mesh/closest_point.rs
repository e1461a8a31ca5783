//! The points of a mesh that are nearest to given points.

use std::sync::atomic::AtomicBool;

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::index::MeshIndex;
use super::kernel::WideIndex;
use super::mesh_line::Triangle;
use super::stop::{Cancelled, Stop};
use super::{MeshSolid, triangle_point};
use crate::accel::wide::{LEAF, Node, WIDTH};
use crate::math::{Vec3, length};
use crate::pool;

/// The point of a mesh that is nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The point, in one of the triangles.
    pub point: Vec3,
    /// Its distance.
    pub distance: f64,
    /// The triangle. Of several that have the point, any may be returned, but always the same one.
    pub face: u32,
    /// The weights of the triangle's corners; their sum is 1.
    pub barycentric: [f64; 3],
}

/// How many points a thread takes at a time.
const CHUNK: usize = 256;

/// Points farther away than this, in sizes of the mesh, have no nearest point: squares of their distances would overflow.
const FAR: f64 = 1e150;

/// By how much the square of a distance to a box may be too large by rounding, beyond the padding of the box.
const SLACK: f64 = 1.0 + 1e-12;

/// Nodes and leaves to visit, and squares of distances to their boxes in the frame of the tree.
type Pending = Vec<(f64, u32)>;

/// The nearest point so far, relative to the given point.
#[derive(Clone, Copy)]
struct Best {
    square: f64,
    face: u32,
    weights: [f64; 3],
    offset: Vec3,
}

impl MeshSolid {
    /// Returns the point of the mesh that is nearest to a point; `None` for one that is not finite, or more than 1e150
    /// sizes of the mesh away.
    ///
    /// The point lies in a triangle up to rounding, and no other point of the mesh is nearer by more than a few units in
    /// the last place of the coordinates. It does not depend on the accelerator. The mesh need not be closed; faces with two
    /// equal corners have no points.
    pub fn closest_point(&self, p: Vec3) -> Option<ClosestPoint> {
        self.closest_point_by(self.closest_index(), p, &mut Pending::new())
    }

    /// As [`MeshSolid::closest_point`], for many points, on a number of threads; 0 for one per core. Calls `progress` with
    /// numbers of points that are done.
    ///
    /// # Errors
    /// [`Cancelled`] if the flag is set by any thread.
    pub fn closest_points(
        &self,
        points: &[[f64; 3]],
        threads: usize,
        cancel: Option<&AtomicBool>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Option<ClosestPoint>>, Cancelled> {
        let stop = Stop::when(cancel);
        let mut found = vec![None; points.len()];
        pool::on_threads(threads, |_| {
            let index = self.closest_index();
            let chunks = points.par_chunks(CHUNK).zip(found.par_chunks_mut(CHUNK));
            chunks.try_for_each(|(points, found)| {
                stop.check()?;
                let mut pending = Pending::new();
                for (point, to) in points.iter().zip(found) {
                    *to = self.closest_point_by(index, Vec3::from(*point), &mut pending);
                }
                progress(points.len() as u64);
                Ok(())
            })
        })?;
        Ok(found)
    }

    /// The tree of the mesh, or one that is made for this.
    fn closest_index(&self) -> &WideIndex {
        match &self.index {
            MeshIndex::Wide(index) | MeshIndex::Best { blocks: index, .. } => index,
            MeshIndex::Other(_) => {
                self.closest_index.get_or_init(|| WideIndex::of(&self.triangles, &self.scaled_bounds))
            }
        }
    }

    fn closest_point_by(&self, index: &WideIndex, p: Vec3, pending: &mut Pending) -> Option<ClosestPoint> {
        let scaled = self.size.scale(p);
        // NaN is not less.
        if !scaled.to_array().into_iter().all(|x| x.abs() < FAR) {
            return None;
        }
        let best = nearest(index, scaled, pending)?;
        let corners = self.triangles.of_face(best.face).corners;
        Some(ClosestPoint {
            point: self.size.unscale(weighted(corners, best.weights)),
            distance: length(self.size.unscale(best.offset)),
            face: best.face,
            barycentric: best.weights,
        })
    }
}

/// Visits the boxes of a tree, the nearest of each node first, as long as they are not farther than the best point.
fn nearest(index: &WideIndex, p: Vec3, pending: &mut Pending) -> Option<Best> {
    let frame = index.tree.frame;
    let (q, unit) = (frame.coordinates(p), frame.size * frame.size);
    let mut best: Option<Best> = None;
    let mut limit = f64::INFINITY;
    pending.clear();
    pending.push((0.0, 0));
    while let Some((square, child)) = pending.pop() {
        if square > limit {
            continue;
        }
        if child & LEAF == 0 {
            push_children(&index.tree.nodes[child as usize], q, limit, pending);
            continue;
        }
        let (triangles, count) = index.triangles(child & !LEAF);
        for triangle in &triangles[..count] {
            let candidate = candidate(triangle, p);
            // Of the same distance the lowest face, so that the order of the visits does not matter.
            if best.is_none_or(|best| (candidate.square, candidate.face) < (best.square, best.face)) {
                best = Some(candidate);
                limit = candidate.square / unit * SLACK;
            }
        }
    }
    best
}

/// The point of a triangle with some weights, from the corner of the largest one: in the triangle up to rounding, however far
/// away the given point is, and exact at a corner.
fn weighted(corners: [Vec3; 3], weights: [f64; 3]) -> Vec3 {
    let largest = if weights[0] >= weights[1] && weights[0] >= weights[2] {
        0
    } else if weights[1] >= weights[2] {
        1
    } else {
        2
    };
    let [base, second, third] = [0, 1, 2].map(|i| corners[(largest + i) % 3]);
    base + (second - base) * weights[(largest + 1) % 3] + (third - base) * weights[(largest + 2) % 3]
}

/// The nearest point of a triangle.
fn candidate(triangle: &Triangle, p: Vec3) -> Best {
    let (weights, offset) = triangle_point::nearest_to_origin(triangle.corners.map(|corner| corner - p));
    Best { square: offset.length_squared(), face: triangle.face, weights, offset }
}

/// Adds the children of a node whose boxes are within a limit, the nearest last.
fn push_children(node: &Node, q: Vec3, limit: f64, pending: &mut Pending) {
    let mut squares = [0.0; WIDTH];
    for axis in 0..3 {
        let [low, high] = [&node.planes[2 * axis], &node.planes[2 * axis + 1]];
        for (square, (low, high)) in squares.iter_mut().zip(low.iter().zip(high)) {
            let gap = (f64::from(*low) - q[axis]).max(q[axis] - f64::from(*high)).max(0.0);
            *square += gap * gap;
        }
    }
    let first = pending.len();
    for (square, child) in squares.into_iter().zip(node.children) {
        // An unused slot is infinitely far away.
        if square <= limit && square < f64::INFINITY {
            let at = first + pending[first..].partition_point(|(other, _)| *other > square);
            pending.insert(at, (square, child));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::accel::NAMES;
    use crate::solid::mesh::TriangleMesh;
    use crate::solid::mesh::shapes::{ball, cubes};
    use crate::testkit::meshes::Thin;
    use crate::testkit::random::Random;

    fn solid(mesh: TriangleMesh, accel: &str) -> MeshSolid {
        MeshSolid::new(Arc::new(mesh), accel).expect("a mesh")
    }

    /// Points around, in, on and far from a mesh.
    fn point(random: &mut Random, mesh: &TriangleMesh) -> Vec3 {
        let corners = mesh.corners(random.below(mesh.faces.len()) as u32);
        let size = corners[0].abs().max_element().max(1e-3);
        match random.below(5) {
            0 => random.point(-2.0, 2.0) * size,
            1 => corners[random.below(3)],
            2 => (corners[0] + corners[1]) * 0.5,
            3 => (corners[0] + corners[1] + corners[2]) / 3.0 + random.point(-1e-9, 1e-9) * size,
            _ => random.point(-1.0, 1.0) * size * 1e6,
        }
    }

    #[test]
    fn points_are_the_nearest_of_all_triangles() {
        let mut random = Random::new(5);
        let thin = (0..12).map(|_| Thin::any(&mut random).mesh(&mut random)).collect::<Vec<_>>();
        let places = [[0, 0, 0], [1, 0, 0], [1, 1, 1], [3, 0, 2]];
        for mesh in [ball(4), cubes(&places)].into_iter().chain(thin) {
            let Ok(by_name) = NAMES
                .iter()
                .map(|name| MeshSolid::new(Arc::new(mesh.clone()), name))
                .collect::<Result<Vec<_>, _>>()
            else {
                continue;
            };
            for _ in 0..200 {
                let p = point(&mut random, &mesh);
                let all = by_name[0].triangles.iter().map(|t| candidate(&t, by_name[0].size.scale(p)));
                let least =
                    all.min_by(|a, b| (a.square, a.face).partial_cmp(&(b.square, b.face)).expect("numbers"));
                let least = least.expect("a triangle");
                for solid in &by_name {
                    let found = solid.closest_point(p).expect("a near point");
                    assert_eq!((found.face, found.barycentric), (least.face, least.weights));
                }
            }
        }
    }

    /// The corners weighted give the point, which is as far away as is said.
    #[test]
    fn answers_agree_with_themselves() {
        let mut random = Random::new(6);
        let mesh = ball(5);
        let solid = solid(mesh.clone(), "bvh");
        for _ in 0..2000 {
            let p = random.point(-2.0, 2.0);
            let found = solid.closest_point(p).expect("a near point");
            let [a, b, c] = mesh.corners(found.face);
            let [u, v, w] = found.barycentric;
            assert!(u >= 0.0 && v >= 0.0 && w >= 0.0 && (u + v + w - 1.0).abs() < 1e-14);
            assert!((a * u + b * v + c * w - found.point).length() < 1e-14);
            assert!(((found.point - p).length() - found.distance).abs() < 1e-14);
            // The ball is inside the unit sphere, and not by much.
            let outside = p.length() - 1.0;
            assert!(found.distance > outside - 1e-14 && (found.distance - outside.abs()).abs() < 0.01);
        }
    }

    #[test]
    fn many_points_are_found_as_one() {
        let mut random = Random::new(7);
        let solid = solid(cubes(&[[0, 0, 0], [2, 0, 0]]), "grid");
        let mut points: Vec<[f64; 3]> = (0..3000).map(|_| random.point(-2.0, 4.0).to_array()).collect();
        points.extend([[f64::NAN, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0], [1e200, 0.0, 0.0]]);
        let one: Vec<_> = points.iter().map(|p| solid.closest_point(Vec3::from(*p))).collect();
        assert_eq!(one[3000..], [None; 3]);
        for threads in [1, 2] {
            assert_eq!(solid.closest_points(&points, threads, None, &|_| ()), Ok(one.clone()));
        }
        let cancel = AtomicBool::new(true);
        assert_eq!(solid.closest_points(&points, 1, Some(&cancel), &|_| ()), Err(Cancelled));
    }

    /// The point is as exact as the corners, not as the distance.
    #[test]
    fn points_nearest_to_far_ones_are_in_the_mesh() {
        let corners = [Vec3::new(0.3, 0.7, 0.1), Vec3::new(1.3, 0.7, 0.1), Vec3::new(0.3, 1.7, 0.1)];
        let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]);
        let solid = solid(mesh, "bvh");
        for (far, corner) in [(Vec3::new(1e8 / 3.0, -1e8 / 7.0, 3e8), 1), (Vec3::splat(-1e17), 0)] {
            let found = solid.closest_point(far).expect("a near point");
            assert_eq!(found.point, corners[corner]);
        }
    }

    #[test]
    fn sizes_do_not_matter() {
        for size in [1e-200, 1.0, 1e200] {
            let mut mesh = cubes(&[[0, 0, 0]]);
            mesh.vertices.iter_mut().for_each(|v| *v *= size);
            let found =
                solid(mesh, "bvh").closest_point(Vec3::new(0.25, 0.5, 3.0) * size).expect("a near point");
            assert_eq!((found.point, found.distance), (Vec3::new(0.25, 0.5, 1.0) * size, 2.0 * size));
        }
    }
}
