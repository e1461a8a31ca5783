//! Rays that begin in the box of a closed mesh: whether they begin inside the mesh, and what their first boundary is.
//!
//! The plain path takes the sum of all hits ahead for the winding number at the start. Here the winding number is that
//! of an empty cell that the ray passes through before its first hit. Without such a cell, it is that of an empty cell near
//! the start, less the sum of the hits between the two. Rays that neither decides are cast for all hits.

use std::sync::atomic::AtomicBool;

use super::Kinds;
use super::placed_mesh::{FrameRows, PlacedMesh, box_holds_start};
use super::row_block::RowBlock;
use super::row_hit::RowHit;
use crate::crossing::Crossing;
use crate::csg::HitKind;
use crate::math::Vec3;
use crate::ray::Span;
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory, Lines, RayBlock};
use crate::solid::mesh::{EmptyCells, MeshHit, step};

/// A block of rays that was cast at a closed mesh for first hits.
#[derive(Clone, Copy)]
pub(super) struct FirstHits<'a, 'w> {
    pub placed: &'a PlacedMesh<'w>,
    /// If there are none, the rays that begin in the box were not cast.
    pub cells: Option<&'a EmptyCells>,
    pub block: &'a RowBlock<'a>,
    /// The `t` behind which hits of each ray were not looked for, if that is before the end of the span.
    pub ends: Option<&'a [f64]>,
    pub frame_rows: &'a FrameRows,
}

/// What the first hit of a ray says about its first boundary.
enum First {
    Is(RowHit),
    None,
    /// All hits are needed.
    Open,
}

/// Whether a ray of a block is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// It begins outside, or has been decided.
    Outside,
    /// It begins in the box of the mesh.
    InBox,
    /// All its hits are needed.
    Open,
}

/// The rays of a block that begin in the box of a mesh.
#[derive(Debug, Default)]
pub(super) struct Inside {
    starts: Vec<Start>,
    /// The rays that no empty cell decides, with their first hits.
    undecided: Vec<(u32, Option<MeshHit>)>,
    ways: Ways,
    /// The rays of which all hits are needed.
    pub rows: Vec<u32>,
    pub rays: Vec<[f64; 6]>,
}

/// Lines from the starts of rays to empty cells. Rays in a row that start at the same point share one.
#[derive(Debug, Default)]
struct Ways {
    lines: Vec<[f64; 6]>,
    /// The winding numbers at the ends and, after the cast, at the starts; `None` where it is unknown.
    winding: Vec<Option<i32>>,
    /// The line of each ray.
    line_of: Vec<u32>,
}

impl Inside {
    /// Passes the first boundaries that first hits decide to `offer`, marks the rays that take the plain path, and
    /// gathers the rays of which all hits are needed. `kernel` holds the first hits.
    pub fn decide(
        &mut self,
        first: FirstHits,
        kernel: &mut KernelMemory,
        is_plain: &mut [bool],
        mut offer: impl FnMut(usize, &RowHit),
    ) {
        self.begin(first, kernel, is_plain);
        let in_box = self.look_up(first, kernel, &mut offer);
        let Inside { starts, undecided, ways, rows, rays } = self;
        if let Some(cells) = first.cells {
            ways.find(undecided.iter().map(|(row, _)| first.line(*row)), cells, first.block.scope.span);
            ways.cast(first.placed, first.block.cancel, kernel);
            let mut open = 0;
            for ((row, hit), way) in undecided.iter().zip(&ways.line_of) {
                match ways.winding[*way as usize]
                    .map_or(First::Open, |winding| first.boundary(*row, hit.as_ref(), winding))
                {
                    First::Is(boundary) => offer(*row as usize, &boundary),
                    First::None => {}
                    First::Open => {
                        starts[*row as usize] = Start::Open;
                        open += 1;
                    }
                }
            }
            cells.count(in_box, in_box - open);
        }
        rows.clear();
        rows.extend((0..).zip(&*starts).filter(|(_, start)| **start == Start::Open).map(|(row, _)| row));
        rays.clear();
        rays.extend(rows.iter().map(|&row| first.block.rays[row as usize]));
    }

    /// Finds the rays that begin in the box, and those of them of which all hits are needed in any case.
    fn begin(&mut self, first: FirstHits, kernel: &KernelMemory, is_plain: &mut [bool]) {
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(first.block.rays.len(), Start::Outside);
        let start = if first.cells.is_some() { Start::InBox } else { Start::Open };
        kernel.inside_rows().iter().for_each(|&row| starts[row as usize] = start);
        for &row in kernel.plain_rows() {
            match &mut starts[row as usize] {
                Start::Outside => is_plain[row as usize] = true,
                // The first hit may be one event with another or with an end of the span.
                start => *start = Start::Open,
            }
        }
    }

    /// Decides the rays that begin outside of the box, and those that pass through an empty cell before their first hit.
    /// Returns how many rays with a certain first hit, or with none, begin in the box.
    fn look_up(
        &mut self,
        first: FirstHits,
        kernel: &KernelMemory,
        mut offer: impl FnMut(usize, &RowHit),
    ) -> usize {
        let Inside { starts, undecided, .. } = self;
        undecided.clear();
        let mut in_box = 0;
        let mut by_cells = |row: u32, hit: Option<&MeshHit>| {
            in_box += 1;
            let boundary = first.boundary_by_cells(row, hit);
            if matches!(boundary, First::Open) {
                undecided.push((row, hit.copied()));
            }
            boundary
        };
        for hit in kernel.hits() {
            let start = &mut starts[hit.row as usize];
            let boundary = match *start {
                Start::Open => continue,
                Start::Outside => First::Is(first.placed.entry(hit)),
                Start::InBox => by_cells(hit.row, Some(hit)),
            };
            *start = Start::Outside;
            if let First::Is(boundary) = boundary {
                offer(hit.row as usize, &boundary);
            }
        }
        for &row in kernel.inside_rows() {
            let start = &mut starts[row as usize];
            if *start == Start::InBox {
                *start = Start::Outside;
                if let First::Is(boundary) = by_cells(row, None) {
                    offer(row as usize, &boundary);
                }
            }
        }
        in_box
    }
}

impl Ways {
    /// Finds the ways from the starts of rays. There are none from a start that is rounded.
    fn find<'l>(&mut self, lines: impl Iterator<Item = &'l [f64; 6]>, cells: &EmptyCells, span: Span) {
        self.lines.clear();
        self.winding.clear();
        self.line_of.clear();
        for line in lines {
            let o = Vec3::new(line[0], line[1], line[2]);
            if self.lines.last().is_some_and(|last| last[..3] == line[..3]) {
                self.line_of.push(self.lines.len() as u32 - 1);
                continue;
            }
            self.line_of.push(self.lines.len() as u32);
            let near = if span.t_min() == 0.0 { cells.near(o) } else { None };
            // Without an end, the way is no line, and is not cast.
            let (end, winding) = near.map_or((o, None), |(end, winding)| (end, Some(winding)));
            let d = end - o;
            self.lines.push([o.x, o.y, o.z, d.x, d.y, d.z]);
            self.winding.push(winding);
        }
    }

    /// Follows the ways back to the starts of the rays.
    ///
    /// A way begins exactly at the start. It ends where its direction is rounded to, which is within the padding of the
    /// empty cell. A `t` is positive if and only if the hit is ahead of the start (`plane`), unless it underflows. So the
    /// sum of the hits is exact if all of them are certainly between the start and the end, and the start is not on the
    /// surface: there the way and the ray may begin on different sides of it, because ties are broken for each line. A
    /// start on a face is a hit with a `t` of zero; on an edge or a corner, the way is near an edge.
    fn cast(&mut self, placed: &PlacedMesh, cancel: Option<&AtomicBool>, kernel: &mut KernelMemory) {
        let Ways { lines, winding, .. } = self;
        let block = RayBlock {
            rays: lines,
            frames: placed.frames,
            wants_normals: false,
            lines: Lines { rows: lines, errors: None },
            span: Span::new(0.0, 1.0).unwrap_or(Span::FORWARD),
            ends: None,
            cancel,
        };
        placed.mesh.cast_block(&block, BlockQuery::AllOffEdges, kernel);
        kernel.plain_rows().iter().for_each(|&row| winding[row as usize] = None);
        for MeshHit { row, crossing, .. } in kernel.hits() {
            let winding = &mut winding[*row as usize];
            let is_between = crossing.low() > 0.0 && crossing.high() < 1.0;
            *winding = winding.filter(|_| is_between).map(|winding| winding - step(crossing));
        }
    }
}

impl<'a> FirstHits<'a, '_> {
    fn line(&self, row: u32) -> &'a [f64; 6] {
        self.placed.line(self.block.rays, self.frame_rows, row as usize)
    }

    /// The first boundary of a ray that begins in the box, given its first hit in the span, which is an event of its own
    /// within the span; `None` if there is no hit.
    fn boundary_by_cells(&self, row: u32, hit: Option<&MeshHit>) -> First {
        let (span, line) = (self.block.scope.span, self.line(row));
        let end = match hit {
            Some(hit) => hit.crossing.low(),
            // Without hits ahead their sum is zero, and there is no boundary.
            None => match self.ends.map_or(span.t_max(), |ends| ends[row as usize]) {
                f64::INFINITY => return First::None,
                end => end,
            },
        };
        let winding = self.cells.and_then(|cells| cells.winding_between(line, span.t_min(), end));
        winding.map_or(First::Open, |winding| self.boundary(row, hit, winding))
    }

    /// The same, given the winding number at the start. If it is zero, the first hit enters. If not, the span begins
    /// inside, and the first hit leaves if the winding number is zero behind it.
    fn boundary(&self, row: u32, hit: Option<&MeshHit>, winding: i32) -> First {
        let (t_min, placed) = (self.block.scope.span.t_min(), self.placed);
        if winding == 0 {
            return hit.map_or(First::None, |hit| First::Is(placed.entry(hit)));
        }
        if !box_holds_start(placed.mesh, self.line(row), t_min) {
            return First::Open;
        }
        if self.block.scope.kinds == Kinds::All {
            return First::Is(placed.row_of_span_end(t_min + 0.0, HitKind::Start));
        }
        match hit {
            None => First::None,
            Some(hit) if winding + step(&hit.crossing) == 0 => {
                First::Is(placed.row_hit(hit, &Crossing { entering: false, ..hit.crossing }))
            }
            Some(_) => First::Open,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use crate::query::batch::{self, Run};
    use crate::query::{Scope, few_meshes::FewMeshes};
    use crate::ray::Span;
    use crate::shape::{Object, Shape};
    use crate::solid::mesh::shapes::ball;
    use crate::testkit::random::Random;

    /// Rays that begin within a ball, or just off its surface on either side.
    #[test]
    fn almost_all_rays_from_within_the_box_are_decided_without_all_hits() {
        let shape = Shape::triangles(Arc::new(ball(4))).expect("a mesh");
        let world = crate::scene::Scene::of([Object::new("ball", shape)]).compile().expect("a world");
        let mut random = Random::new(13);
        let ray = |_| {
            let (p, d) = (random.direction(), random.direction());
            let o = p * [0.3, 0.9, 0.999, 1.001][random.below(4)];
            [o.x, o.y, o.z, d.x, d.y, d.z]
        };
        let rays: Vec<[f64; 6]> = (0..10_000).map(ray).collect();
        let rays = batch::RowsOfSix(&rays);
        let counters = Mutex::default();
        let run = Run { threads: 1, ..Run::default() };
        let plain = Run { counters: Some(&counters), ..run };
        for scope in [Span::FORWARD.into(), Scope::surfaces(Span::FORWARD)] {
            let [found, expected] =
                [run, plain].map(|run| batch::closest(&world, &rays, scope, run).unwrap());
            assert_eq!(found.t, expected.t);
            assert_eq!(found.entering, expected.entering);
        }
        let meshes = FewMeshes::of(&world).expect("a world of a mesh");
        let [lookups, found] = meshes.lookups().expect("cells");
        assert!(lookups > 10_000 && found as f64 > 0.99 * lookups as f64, "{found} of {lookups}");
    }
}
