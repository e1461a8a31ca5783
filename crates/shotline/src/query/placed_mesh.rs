//! A mesh that is placed at the root of a scene, and the rays of a block in its frame.

use super::Scope;
use super::row_block::RowBlock;
use super::row_hit::RowHit;
use crate::crossing::Crossing;
use crate::csg::{Boundary, HitKind};
use crate::math::{Affine, Vec3};
use crate::ray::Line;
use crate::solid::Solid;
use crate::solid::mesh::kernel::{Lines, RayBlock};
use crate::solid::mesh::{MeshHit, MeshSolid};

/// A mesh that is a body of its own, at the root of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedMesh<'w> {
    pub mesh: &'w MeshSolid,
    /// From the world to the body, and from the body to the mesh.
    pub frames: [&'w Affine; 2],
    pub object: u32,
    pub path: u64,
    pub surface: u32,
    /// Whether the mesh is closed.
    pub is_solid: bool,
    /// Whether the frames change nothing.
    pub is_at_rest: bool,
}

/// Rays in the frame of a mesh, and the bounds on their errors.
#[derive(Debug, Default)]
pub(super) struct FrameRows {
    rows: Vec<[f64; 6]>,
    errors: Vec<[f64; 6]>,
}

impl PlacedMesh<'_> {
    /// The rays of a block in the frame of the mesh. Hits of each ray behind its end are not needed.
    pub fn block<'a>(
        &'a self,
        block: &RowBlock<'a>,
        ends: Option<&'a [f64]>,
        FrameRows { rows, errors }: &'a mut FrameRows,
    ) -> RayBlock<'a> {
        let &RowBlock { rays, scope: Scope { span, .. }, wants_normals, cancel } = block;
        let lines = if self.is_at_rest {
            Lines { rows: rays, errors: None }
        } else {
            rows.clear();
            errors.clear();
            for ray in rays {
                let line = self.frames.iter().fold(line_of(ray), |line, frame| line.in_frame(frame));
                rows.push(joined(line.o, line.d));
                errors.push(joined(line.o_err, line.d_err));
            }
            Lines { rows, errors: Some(errors) }
        };
        RayBlock { rays, frames: self.frames, wants_normals, lines, span, ends, cancel }
    }

    /// The line of a ray in the frame of the mesh, without its error; `frame_rows` is from the cast.
    pub fn line<'r>(&self, rays: &'r [[f64; 6]], frame_rows: &'r FrameRows, ray: usize) -> &'r [f64; 6] {
        if self.is_at_rest { &rays[ray] } else { &frame_rows.rows[ray] }
    }

    /// A hit that is a crossing; the crossing enters or exits as for the solid.
    #[inline(always)]
    pub fn row_hit(&self, hit: &MeshHit, crossing: &Crossing) -> RowHit {
        RowHit {
            // Turns -0.0 into 0.0, as for every boundary.
            t: crossing.t + 0.0,
            t_err: crossing.t_err,
            normal: if hit.is_against == crossing.entering { hit.normal } else { -hit.normal },
            object: self.object,
            surface: Some(self.surface),
            primitive: Some(crossing.primitive),
            path: self.path,
            entering: crossing.entering,
            kind: HitKind::Surface,
        }
    }

    /// A boundary, and the hit there if there is a surface.
    #[inline(always)]
    pub fn row_boundary(&self, boundary: &Boundary, hit: Option<&MeshHit>) -> RowHit {
        let Boundary { kind, crossing, .. } = boundary;
        match hit {
            Some(hit) if *kind == HitKind::Surface => self.row_hit(hit, crossing),
            _ => self.row_of_span_end(crossing.t + 0.0, *kind),
        }
    }

    /// The start or the end of the span within the solid.
    fn row_of_span_end(&self, t: f64, kind: HitKind) -> RowHit {
        RowHit {
            t,
            t_err: 0.0,
            normal: Vec3::NAN,
            object: self.object,
            surface: None,
            primitive: None,
            path: self.path,
            entering: kind == HitKind::Start,
            kind,
        }
    }
}

/// Whether a line, in the frame of a mesh, is within its box at `t_min`, by more than any rounding. Elsewhere the plain
/// path may take the ray to begin outside, even if its hits do not balance because their tests underflow.
pub(super) fn box_holds_start(mesh: &MeshSolid, line: &[f64; 6], t_min: f64) -> bool {
    let (line, bounds) = (line_of(line), mesh.bounds());
    let way = line.d * t_min;
    let largest = line.o.abs().max(way.abs()).max(bounds.min.abs()).max(bounds.max.abs()).max_element();
    let (start, margin) = (line.o + way, 1e-12 * largest);
    ((start - bounds.min).min(bounds.max - start)).min_element() > margin
}

fn line_of(ray: &[f64; 6]) -> Line {
    Line::exact(Vec3::new(ray[0], ray[1], ray[2]), Vec3::new(ray[3], ray[4], ray[5]))
}

fn joined(a: Vec3, b: Vec3) -> [f64; 6] {
    [a.x, a.y, a.z, b.x, b.y, b.z]
}
