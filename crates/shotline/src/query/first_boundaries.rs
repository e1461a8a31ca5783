//! The first boundaries of rays with a closed mesh.
//!
//! The plain path takes the sum of all hits ahead for the winding number at the start of a ray that begins in the box of
//! the mesh. Here that number is the one of the side of the face from which the first hit comes, if the sides of the face
//! are known (`face_sides`). Other rays are cast for all hits.

use std::ops::ControlFlow;

use super::hit_lists::HitLists;
use super::placed_mesh::box_holds_start;
use super::{Kinds, Scope};
use crate::crossing::Crossing;
use crate::csg::{Boundary, HitKind};
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory, Lines, RayBlock};
use crate::solid::mesh::{MeshHit, MeshSolid, step};

/// A closed mesh, and a block of rays that are cast at it.
#[derive(Clone, Copy)]
pub(super) struct ClosedMesh<'a> {
    pub mesh: &'a MeshSolid,
    pub block: &'a RayBlock<'a>,
    /// The kinds of boundaries that count.
    pub kinds: Kinds,
    /// Whether the normals of hits will be computed from their triangles, one by one.
    pub wants_normals_later: bool,
}

/// What is found of a ray.
pub(super) enum First<'h> {
    /// Its first boundary, and the hit there if there is a surface.
    Boundary(Boundary, Option<&'h MeshHit>),
    /// The plain path has to cast it.
    Plain,
}

/// What is known of a ray whose hits have not been examined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// It begins outside, or has been decided.
    Outside,
    /// It begins in the box of the mesh.
    InBox,
    /// It has to be cast again.
    Open,
}

/// The memory of casts; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct FirstBoundaries {
    kernel: KernelMemory,
    lists: HitLists,
    starts: Vec<Start>,
    /// The rays of which all hits are needed.
    open: Subset,
    /// The rays of which the first hit is needed, since any hit does not show that there is a crossing.
    undecided: Subset,
}

/// Some rays of a block.
#[derive(Debug, Default)]
struct Subset {
    /// Their rows in the block.
    rows: Vec<u32>,
    rays: Vec<[f64; 6]>,
    lines: Vec<[f64; 6]>,
    errors: Vec<[f64; 6]>,
    ends: Vec<f64>,
}

impl Subset {
    /// Takes the rays of a block that are open.
    fn take(&mut self, block: &RayBlock, starts: &[Start]) {
        let Subset { rows, rays, lines, errors, ends } = self;
        rows.clear();
        rows.extend((0..).zip(starts).filter(|(_, start)| **start == Start::Open).map(|(row, _)| row));
        let copy = |from: &[[f64; 6]], into: &mut Vec<[f64; 6]>| {
            into.clear();
            into.extend(rows.iter().map(|&row| from[row as usize]));
        };
        copy(block.rays, rays);
        copy(block.lines.rows, lines);
        if let Some(of_block) = block.lines.errors {
            copy(of_block, errors);
        }
        ends.clear();
        ends.extend(rows.iter().map(|&row| block.end(row as usize)));
    }

    /// The rays as a block, each with its own end.
    fn block<'a>(&'a self, of: &RayBlock<'a>) -> RayBlock<'a> {
        RayBlock {
            rays: &self.rays,
            lines: Lines { rows: &self.lines, errors: of.lines.errors.map(|_| &self.errors[..]) },
            ends: of.ends.map(|_| &self.ends[..]),
            ..*of
        }
    }
}

impl FirstBoundaries {
    /// Passes the first boundary of each ray that has one to `take`, and the rays that take the plain path.
    pub fn closest(&mut self, of: &ClosedMesh, mut take: impl FnMut(usize, First)) {
        of.mesh.cast_block(of.block, BlockQuery::First, &mut self.kernel);
        self.begin(of.block.lines.rows.len());
        for &row in self.kernel.plain_rows() {
            match &mut self.starts[row as usize] {
                Start::Outside => take(row as usize, First::Plain),
                // The first hit may be one event with another or with an end of the span.
                start => *start = Start::Open,
            }
        }
        if of.wants_normals_later {
            of.mesh.prefetch(self.kernel.hits().iter().map(|hit| hit.crossing.primitive));
        }
        self.take_first_hits(of, &mut take);
        self.open.take(of.block, &self.starts);
        self.take_all_hits(of, take);
    }

    /// Passes the rays that have a boundary to `take`, with `true`, and those that take the plain path, with `false`.
    pub fn any(&mut self, of: &ClosedMesh, mut take: impl FnMut(usize, bool)) {
        let Some(sides) = of.mesh.face_sides() else {
            return self.closest(of, |row, first| take(row, matches!(first, First::Boundary(..))));
        };
        of.mesh.cast_block(of.block, BlockQuery::AnyOffEdges, &mut self.kernel);
        self.begin(of.block.lines.rows.len());
        for &row in self.kernel.plain_rows() {
            self.starts[row as usize] = Start::Open;
        }
        for &(row, face) in self.kernel.hit_faces() {
            let start = &mut self.starts[row as usize];
            // A hit that is an event of its own changes the winding number. If the ray begins outside, there is a
            // boundary here or before. If it begins inside, that is a boundary, unless only surfaces count.
            let is_boundary = sides.front(face).is_some_and(|front| {
                *start == Start::Outside || of.kinds == Kinds::All || front == 0 || front == -1
            });
            *start = if is_boundary { Start::Outside } else { Start::Open };
            if is_boundary {
                take(row as usize, true);
            }
        }
        self.leave_rays_without_hits(of);
        let mut undecided = std::mem::take(&mut self.undecided);
        undecided.take(of.block, &self.starts);
        let block = undecided.block(of.block);
        self.closest(&ClosedMesh { block: &block, ..*of }, |i, first| {
            if let First::Boundary(boundary, hit) = &first {
                of.learn(boundary, *hit);
            }
            take(undecided.rows[i] as usize, matches!(first, First::Boundary(..)));
        });
        self.undecided = undecided;
    }

    /// Notes which rays of the last cast begin in the box.
    fn begin(&mut self, rays: usize) {
        self.starts.clear();
        self.starts.resize(rays, Start::Outside);
        self.kernel.inside_rows().iter().for_each(|&row| self.starts[row as usize] = Start::InBox);
    }

    /// Takes the boundaries that first hits decide.
    fn take_first_hits(&mut self, of: &ClosedMesh, take: &mut impl FnMut(usize, First)) {
        let sides = of.mesh.face_sides();
        for hit in self.kernel.hits() {
            let start = &mut self.starts[hit.row as usize];
            let winding = match *start {
                Start::Open => continue,
                Start::Outside => Some(0),
                Start::InBox => {
                    let front = sides.filter(|_| hit.is_off_edges);
                    let front = front.and_then(|sides| sides.front(hit.crossing.primitive));
                    front.map(|front| if hit.crossing.entering { front } else { front + 1 })
                }
            };
            let first = winding.and_then(|winding| of.first_boundary(hit, winding));
            *start = if first.is_some() { Start::Outside } else { Start::Open };
            if let Some((boundary, hit)) = first {
                take(hit.row as usize, First::Boundary(boundary, Some(hit)));
            }
        }
        self.leave_rays_without_hits(of);
    }

    /// Decides the rays that begin in the box and have no hit in their span. Without hits ahead they begin outside.
    fn leave_rays_without_hits(&mut self, of: &ClosedMesh) {
        for &row in self.kernel.inside_rows() {
            let start = &mut self.starts[row as usize];
            if *start == Start::InBox {
                let is_known = of.kinds == Kinds::Surfaces || of.block.end(row as usize) == f64::INFINITY;
                *start = if is_known { Start::Outside } else { Start::Open };
            }
        }
    }

    /// Casts the open rays for all hits.
    fn take_all_hits(&mut self, of: &ClosedMesh, mut take: impl FnMut(usize, First)) {
        let FirstBoundaries { kernel, lists, open, .. } = self;
        if open.rows.is_empty() {
            return;
        }
        let block = RayBlock { ends: None, ..open.block(of.block) };
        of.mesh.cast_block(&block, BlockQuery::Within, kernel);
        lists.take(open.rows.len(), kernel);
        let scope = Scope { span: of.block.span, kinds: of.kinds };
        for (i, &row) in open.rows.iter().enumerate() {
            let row = row as usize;
            let mut is_first = true;
            let is_made = lists.boundaries(of.mesh, scope, i, &open.lines[i], |boundary, hit| {
                of.learn(&boundary, hit);
                if std::mem::take(&mut is_first) {
                    take(row, First::Boundary(boundary, hit));
                }
                if hit.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            if !is_made {
                take(row, First::Plain);
            }
        }
    }
}

impl ClosedMesh<'_> {
    /// Learns the sides of the face of a boundary. The winding number is zero on one of them: before an entry, behind an
    /// exit.
    fn learn(&self, boundary: &Boundary, hit: Option<&MeshHit>) {
        if let Some(hit) = hit.filter(|hit| hit.is_off_edges && boundary.kind == HitKind::Surface) {
            let front = if boundary.entering == hit.crossing.entering { 0 } else { -1 };
            self.mesh.learn_front(hit.crossing.primitive, front);
        }
    }

    /// The first boundary of a ray, given its first hit in the span, which is an event of its own within the span, and
    /// the winding number before it. If that is zero, the ray enters. If not, the span begins inside, and the ray leaves
    /// if the winding number is zero behind the hit. `None` if all hits are needed.
    fn first_boundary<'h>(&self, hit: &'h MeshHit, winding: i32) -> Option<(Boundary, &'h MeshHit)> {
        let t_min = self.block.span.t_min();
        let surface = |entering: bool| Boundary::of_leaf(Crossing { entering, ..hit.crossing });
        if winding == 0 {
            return Some((surface(true), hit));
        }
        if !box_holds_start(self.mesh, &self.block.lines.rows[hit.row as usize], t_min) {
            return None;
        }
        if self.kinds == Kinds::All {
            return Some((Boundary::of_span_end(HitKind::Start, t_min), hit));
        }
        (winding + step(&hit.crossing) == 0).then(|| (surface(false), hit))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Affine;
    use crate::ray::Span;
    use crate::solid::mesh::shapes::ball;
    use crate::testkit::random::Random;

    /// Rays that begin within a ball, or just off its surface on either side.
    fn rays_in_a_ball(random: &mut Random, count: usize) -> Vec<[f64; 6]> {
        let ray = |_| {
            let (p, d) = (random.direction(), random.direction());
            let o = p * [0.3, 0.9, 0.999, 1.001][random.below(4)];
            [o.x, o.y, o.z, d.x, d.y, d.z]
        };
        (0..count).map(ray).collect()
    }

    /// Once the faces have been hit a few times, almost no ray is cast for all hits.
    #[test]
    fn almost_all_rays_are_decided_by_one_hit() {
        let mesh = MeshSolid::new(Arc::new(ball(3)), "bvh").expect("a mesh");
        let mut random = Random::new(13);
        let mut boundaries = FirstBoundaries::default();
        let mut cast = |rays: &[[f64; 6]], kinds: Kinds, is_any: bool| {
            let block = RayBlock {
                rays,
                frames: [&Affine::IDENTITY; 2],
                wants_normals: false,
                lines: Lines { rows: rays, errors: None },
                span: Span::FORWARD,
                ends: None,
                cancel: None,
            };
            let of = ClosedMesh { mesh: &mesh, block: &block, kinds, wants_normals_later: false };
            let mut found = 0;
            if is_any {
                boundaries.any(&of, |_, is_boundary| found += usize::from(is_boundary));
            } else {
                boundaries
                    .closest(&of, |_, first| found += usize::from(matches!(first, First::Boundary(..))));
            }
            (found, boundaries.open.rows.len(), boundaries.undecided.rows.len())
        };
        cast(&rays_in_a_ball(&mut random, 20_000), Kinds::All, false);
        let rays = rays_in_a_ball(&mut random, 10_000);
        for kinds in [Kinds::All, Kinds::Surfaces] {
            let (closest, open, _) = cast(&rays, kinds, false);
            let (any, open_of_any, undecided) = cast(&rays, kinds, true);
            assert_eq!(closest, any);
            assert!(closest > 7_000, "{closest}");
            assert!(open < 200 && open_of_any < 200 && undecided < 200, "{open} {open_of_any} {undecided}");
        }
    }
}
