//! The rays of a block that wait for meshes, and how those that need the same mesh are cast at it.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::first_boundaries::FirstBoundaries;
use super::hit_lists::HitLists;
use crate::math::Affine;
use crate::ray::{Line, Span};
use crate::solid::mesh::MeshSolid;
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory, Lines, RayBlock};

/// The mesh that a ray needs, and the ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRequest {
    pub body: u32,
    pub leaf: u32,
    pub slot: u32,
}

impl MeshRequest {
    fn mesh(&self) -> (u32, u32) {
        (self.body, self.leaf)
    }
}

/// Requests, and the memory of casting their rays.
#[derive(Debug, Default)]
pub(super) struct MeshRequests {
    pub all: Vec<MeshRequest>,
    pub rows: RequestRows,
    pub kernel: KernelMemory,
    pub lists: HitLists,
    pub boundaries: FirstBoundaries,
    /// Memory for sorting.
    order: Vec<u32>,
    unsorted: (Vec<MeshRequest>, RequestRows),
}

/// The lines of requests in the frames of their meshes, row by row, and the `t` behind which hits are not needed.
#[derive(Debug, Default)]
pub(super) struct RequestRows {
    lines: Vec<[f64; 6]>,
    errors: Vec<[f64; 6]>,
    ends: Vec<f64>,
}

impl RequestRows {
    fn clear(&mut self) {
        self.lines.clear();
        self.errors.clear();
        self.ends.clear();
    }

    #[inline]
    fn push(&mut self, Line { o, d, o_err, d_err }: &Line, end: f64) {
        self.lines.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        self.errors.push([o_err.x, o_err.y, o_err.z, d_err.x, d_err.y, d_err.z]);
        self.ends.push(end);
    }

    /// Takes the rows of others in an order.
    fn reorder(&mut self, of: &RequestRows, order: &[u32]) {
        self.clear();
        self.lines.extend(order.iter().map(|&row| of.lines[row as usize]));
        self.errors.extend(order.iter().map(|&row| of.errors[row as usize]));
        self.ends.extend(order.iter().map(|&row| of.ends[row as usize]));
    }

    /// The rows of requests for the same mesh as a block, in the frame of the mesh. Hits behind the ends of requests are
    /// not needed.
    pub fn block<'a>(
        &'a self,
        group: Range<usize>,
        span: Span,
        cancel: Option<&'a AtomicBool>,
    ) -> RayBlock<'a> {
        let (lines, errors) = (&self.lines[group.clone()], &self.errors[group.clone()]);
        let ends = &self.ends[group];
        let is_exact = errors.iter().flatten().all(|error| *error == 0.0);
        let is_limited = ends.iter().any(|end| *end < span.t_max());
        RayBlock {
            // Normals are computed later, and only of the hits that are returned.
            rays: lines,
            frames: [&Affine::IDENTITY; 2],
            wants_normals: false,
            lines: Lines { rows: lines, errors: (!is_exact).then_some(errors) },
            span,
            ends: is_limited.then_some(ends),
            cancel,
        }
    }

    /// The line of a request, in the frame of the mesh.
    pub fn line(&self, request: usize) -> [f64; 6] {
        self.lines[request]
    }
}

impl MeshRequests {
    pub fn clear(&mut self) {
        self.all.clear();
        self.rows.clear();
    }

    /// Adds a request, with the line of the ray in the frame of the mesh and the `t` behind which hits are not needed.
    #[inline]
    pub fn push(&mut self, request: MeshRequest, line: &Line, end: f64) {
        self.all.push(request);
        self.rows.push(line, end);
    }

    /// Sorts the requests by mesh. Those for the same mesh keep their order.
    pub fn sort(&mut self) {
        let MeshRequests { all, rows, order, unsorted, .. } = self;
        if all.is_sorted_by_key(MeshRequest::mesh) {
            return;
        }
        order.clear();
        order.extend(0..all.len() as u32);
        order.sort_by_key(|&request| all[request as usize].mesh());
        std::mem::swap(&mut unsorted.0, all);
        std::mem::swap(&mut unsorted.1, rows);
        all.clear();
        all.extend(order.iter().map(|&request| unsorted.0[request as usize]));
        rows.reorder(&unsorted.1, order);
    }

    /// The range of the requests for the same mesh that begin at `start`, in sorted requests; `None` behind the last.
    pub fn group(&self, start: usize) -> Option<Range<usize>> {
        let first = self.all.get(start)?;
        let is_same = |request: &&MeshRequest| request.mesh() == first.mesh();
        Some(start..start + self.all[start..].iter().take_while(is_same).count())
    }

    /// Casts the rays of a range of requests for all hits, and sorts these.
    pub fn cast_all(
        &mut self,
        mesh: &MeshSolid,
        group: Range<usize>,
        span: Span,
        query: BlockQuery,
        cancel: Option<&AtomicBool>,
    ) {
        let count = group.len();
        let block = self.rows.block(group, span, cancel);
        mesh.cast_block(&RayBlock { ends: None, ..block }, query, &mut self.kernel);
        self.lists.take(count, &mut self.kernel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::testkit::random::Random;

    #[test]
    fn sorted_requests_keep_their_rows_and_their_order() {
        let mut random = Random::new(6);
        let mut requests = MeshRequests::default();
        for meshes in [1, 2, 7] {
            for count in [0, 1, 300] {
                requests.clear();
                for slot in 0..count {
                    let [body, leaf] = [0, 1].map(|_| random.below(meshes) as u32);
                    let line = Line::exact(Vec3::splat(f64::from(slot)), Vec3::X);
                    requests.push(MeshRequest { body, leaf, slot }, &line, f64::from(slot));
                }
                requests.sort();
                assert!(requests.all.is_sorted_by_key(|request| (request.mesh(), request.slot)));
                let (mut seen, mut start) = (0, 0);
                while let Some(group) = requests.group(start) {
                    start = group.end;
                    let block = requests.rows.block(group.clone(), Span::FORWARD, None);
                    for (row, request) in group.enumerate() {
                        let slot = f64::from(requests.all[request].slot);
                        assert_eq!((block.lines.rows[row][0], block.end(row)), (slot, slot));
                        assert_eq!(requests.rows.line(request)[0], slot);
                        seen += 1;
                    }
                }
                assert_eq!(seen, count);
            }
        }
    }
}
