//! The rays of a block that wait for meshes, and how those that need the same mesh are cast at it.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::first_boundaries::FirstBoundaries;
use super::hit_lists::HitLists;
use crate::math::Affine;
use crate::ray::{Line, Span};
use crate::solid::mesh::MeshSolid;
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory, Lines, RayBlock};

/// A ray that needs a mesh of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRequest {
    pub body: u32,
    pub leaf: u32,
    pub slot: u32,
    /// The line of the ray in the frame of the mesh.
    pub line: Line,
    /// The `t` behind which hits are not needed.
    pub end: f64,
}

/// Requests, and the memory of casting their rays.
#[derive(Debug, Default)]
pub(super) struct MeshRequests {
    pub all: Vec<MeshRequest>,
    pub rows: RequestRows,
    pub kernel: KernelMemory,
    pub lists: HitLists,
    pub boundaries: FirstBoundaries,
}

/// The lines of a block of requests, row by row.
#[derive(Debug, Default)]
pub(super) struct RequestRows {
    lines: Vec<[f64; 6]>,
    errors: Vec<[f64; 6]>,
    ends: Vec<f64>,
}

impl RequestRows {
    /// The rays of requests for the same mesh as a block, in the frame of the mesh. Hits behind the ends of requests are
    /// not needed.
    pub fn block<'a>(
        &'a mut self,
        requests: &[MeshRequest],
        span: Span,
        cancel: Option<&'a AtomicBool>,
    ) -> RayBlock<'a> {
        let RequestRows { lines, errors, ends } = self;
        lines.clear();
        errors.clear();
        ends.clear();
        for MeshRequest { line: Line { o, d, o_err, d_err }, end, .. } in requests {
            lines.push([o.x, o.y, o.z, d.x, d.y, d.z]);
            errors.push([o_err.x, o_err.y, o_err.z, d_err.x, d_err.y, d_err.z]);
            ends.push(*end);
        }
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

    /// The line of a row, in the frame of the mesh.
    pub fn line(&self, row: usize) -> [f64; 6] {
        self.lines[row]
    }
}

impl MeshRequests {
    /// Sorts the requests by mesh.
    pub fn sort(&mut self) {
        self.all.sort_unstable_by_key(|request| (request.body, request.leaf, request.slot));
    }

    /// The range of the requests for the same mesh that begin at `start`, in sorted requests; `None` behind the last.
    pub fn group(&self, start: usize) -> Option<Range<usize>> {
        let first = self.all.get(start)?;
        let is_same = |request: &&MeshRequest| (request.body, request.leaf) == (first.body, first.leaf);
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
        let block = self.rows.block(&self.all[group], span, cancel);
        mesh.cast_block(&RayBlock { ends: None, ..block }, query, &mut self.kernel);
        self.lists.take(count, &mut self.kernel);
    }
}
