//! The rays of a block that wait for meshes, and how those that need the same mesh are cast at it.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

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
    /// The lines of a block.
    rows: Vec<[f64; 6]>,
    errors: Vec<[f64; 6]>,
    ends: Vec<f64>,
    pub kernel: KernelMemory,
    pub lists: HitLists,
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

    /// Casts the rays of some requests at their mesh.
    pub fn cast(
        &mut self,
        mesh: &MeshSolid,
        requests: impl Iterator<Item = usize>,
        span: Span,
        query: BlockQuery,
        cancel: Option<&AtomicBool>,
    ) {
        let MeshRequests { all, rows, errors, ends, kernel, .. } = self;
        rows.clear();
        errors.clear();
        ends.clear();
        for request in requests {
            let MeshRequest { line: Line { o, d, o_err, d_err }, end, .. } = all[request];
            rows.push([o.x, o.y, o.z, d.x, d.y, d.z]);
            errors.push([o_err.x, o_err.y, o_err.z, d_err.x, d_err.y, d_err.z]);
            ends.push(end);
        }
        let is_exact = errors.iter().flatten().all(|error| *error == 0.0);
        let is_limited = ends.iter().any(|end| *end < span.t_max());
        let has_ends = matches!(query, BlockQuery::Nearest | BlockQuery::FirstFromOutside) && is_limited;
        let block = RayBlock {
            // Normals are computed later, and only of the hits that are returned.
            rays: rows,
            frames: [&Affine::IDENTITY; 2],
            wants_normals: false,
            lines: Lines { rows, errors: (!is_exact).then_some(errors) },
            span,
            ends: has_ends.then_some(ends),
            cancel,
        };
        mesh.cast_block(&block, query, kernel);
    }

    /// Casts the rays of some requests for all hits, and sorts these by ray.
    pub fn cast_all(
        &mut self,
        mesh: &MeshSolid,
        requests: impl ExactSizeIterator<Item = usize>,
        span: Span,
        query: BlockQuery,
        cancel: Option<&AtomicBool>,
    ) {
        let count = requests.len();
        self.cast(mesh, requests, span, query, cancel);
        self.lists.sort_by_ray(count, &self.kernel);
    }

    /// The line of a row of the last cast, in the frame of the mesh.
    pub fn line(&self, row: usize) -> [f64; 6] {
        self.rows[row]
    }
}
