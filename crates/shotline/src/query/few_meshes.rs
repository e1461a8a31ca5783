//! Worlds of a few placed meshes and nothing else: their rays need no traversal of levels.

use std::ops::ControlFlow;

use super::first_boundaries::{ClosedMesh, First, FirstBoundaries};
use super::hit_lists::HitLists;
use super::interval_ends::Interval;
use super::placed_mesh::{FrameRows, PlacedMesh};
use super::row_block::RowBlock;
use super::row_hit::RowHit;
use crate::compile::{Body, Target, World};
use crate::crossing::Crossing;
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory, RayBlock};

/// Worlds with more placements are left to the traversal of levels, which does not test every placement.
const MAX_PLACEMENTS: usize = 4;

/// The meshes of a world.
#[derive(Clone, Debug)]
pub(super) struct FewMeshes<'w> {
    placed: Vec<PlacedMesh<'w>>,
}

/// The memory of casting blocks at a few meshes; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct FewMemory {
    kernel: KernelMemory,
    frame_rows: FrameRows,
    /// By row: the best hit at the meshes so far, and the `t` behind which hits are not needed.
    best: Vec<Option<RowHit>>,
    ends: Vec<f64>,
    boundaries: FirstBoundaries,
    lists: HitLists,
}

impl<'w> FewMeshes<'w> {
    /// The meshes of a world; `None` if it has anything else, or many of them.
    pub fn of(world: &'w World) -> Option<FewMeshes<'w>> {
        let placements = &world.root().placements;
        if placements.len() > MAX_PLACEMENTS {
            return None;
        }
        let placed = placements.iter().map(|placement| {
            let Target::Body(body) = placement.target else { return None };
            let (mesh, local_from_body, surface, is_solid) = match world.body(body) {
                Body::Surface(body) => (&*body.mesh, &body.local_from_body, body.first_surface, false),
                Body::Solid(body) => match &body.leaves[..] {
                    [leaf] => (leaf.solid.as_mesh()?, &leaf.local_from_body, leaf.first_surface, true),
                    _ => return None,
                },
            };
            let frames = [&placement.local_from_parent, local_from_body];
            mesh.casts_blocks().then_some(PlacedMesh {
                mesh,
                frames,
                is_at_rest: frames.iter().all(|frame| frame.is_identity()),
                // The objects of a world without levels are all named at the root.
                object: placement.object.unwrap_or(0),
                path: placement.first_path,
                surface,
                is_solid,
            })
        });
        Some(FewMeshes { placed: placed.collect::<Option<_>>()? })
    }

    /// The mesh of a world with only one.
    pub fn only(&self) -> Option<&PlacedMesh<'w>> {
        let [only] = &self.placed[..] else { return None };
        Some(only)
    }

    /// Passes the closest crossing of each ray that has one to `set`, and marks the rays that take the plain path.
    pub fn closest(
        &self,
        block: &RowBlock,
        memory: &mut FewMemory,
        is_plain: &mut [bool],
        mut set: impl FnMut(usize, &RowHit),
    ) {
        let (rows, is_only) = (block.rays.len(), self.placed.len() == 1);
        memory.best.clear();
        memory.best.resize(if is_only { 0 } else { rows }, None);
        memory.ends.clear();
        for (i, placed) in self.placed.iter().enumerate() {
            if i > 0 {
                let end = |best: &Option<RowHit>| {
                    // As for a single ray: the limit itself counts.
                    best.map_or(f64::INFINITY, |best| best.t.next_up()).min(block.scope.span.t_max())
                };
                memory.ends.clear();
                memory.ends.extend(memory.best.iter().map(end));
            }
            memory.closest_at(placed, block, is_plain, &mut set);
        }
        for (row, hit) in memory.best.iter().enumerate().filter(|(row, _)| !is_plain[*row]) {
            hit.iter().for_each(|hit| set(row, hit));
        }
    }

    /// Passes the rows of the rays that have a crossing to `set`, and marks the rays that take the plain path.
    pub fn any(
        &self,
        block: &RowBlock,
        FewMemory { kernel, frame_rows, boundaries, .. }: &mut FewMemory,
        is_plain: &mut [bool],
        mut set: impl FnMut(usize),
    ) {
        for placed in &self.placed {
            let rays = placed.block(block, None, frame_rows);
            if placed.is_solid {
                boundaries.any(&closed(placed, &rays, block), |row, is_hit| match is_hit {
                    true => set(row),
                    false => is_plain[row] = true,
                });
            } else {
                placed.mesh.cast_block(&rays, BlockQuery::Any, kernel);
                kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
                kernel.rows_hit().for_each(&mut set);
            }
        }
    }
}

/// Rays that are cast at a closed mesh.
fn closed<'a>(placed: &PlacedMesh<'a>, rays: &'a RayBlock<'a>, of: &RowBlock) -> ClosedMesh<'a> {
    ClosedMesh { mesh: placed.mesh, block: rays, kinds: of.scope.kinds, wants_normals_later: false }
}

impl FewMemory {
    fn closest_at(
        &mut self,
        placed: &PlacedMesh,
        block: &RowBlock,
        is_plain: &mut [bool],
        mut set: impl FnMut(usize, &RowHit),
    ) {
        let FewMemory { kernel, frame_rows, best, ends, boundaries, .. } = self;
        // Paths ascend from placement to placement, so of equal hits the first one stays.
        let mut offer = |row: usize, hit: &RowHit| match best.get_mut(row) {
            None => set(row, hit),
            Some(best) if best.is_none_or(|best| hit.t < best.t) => *best = Some(*hit),
            Some(_) => {}
        };
        let rays = placed.block(block, (!ends.is_empty()).then_some(&ends[..]), frame_rows);
        if placed.is_solid {
            return boundaries.closest(&closed(placed, &rays, block), |row, first| match first {
                First::Boundary(boundary, hit) => offer(row, &placed.row_boundary(&boundary, hit)),
                First::Plain => is_plain[row] = true,
            });
        }
        placed.mesh.cast_block(&rays, BlockQuery::Nearest, kernel);
        kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
        for hit in kernel.hits() {
            offer(hit.row as usize, &placed.row_hit(hit, &hit.crossing));
        }
    }

    /// Finds all hits of a block at the only mesh of a world.
    pub fn make_lists(&mut self, placed: &PlacedMesh, block: &RowBlock) {
        let query = if placed.is_solid { BlockQuery::Within } else { BlockQuery::All };
        placed.mesh.cast_block(&placed.block(block, None, &mut self.frame_rows), query, &mut self.kernel);
        self.lists.take(block.rays.len(), &mut self.kernel);
    }

    /// Appends the intervals of a ray inside a closed mesh, after [`FewMemory::make_lists`]. Returns `false` if it takes the
    /// plain path, as with more than `most` hits.
    pub fn intervals(
        &mut self,
        placed: &PlacedMesh,
        block: &RowBlock,
        row: usize,
        most: usize,
        out: &mut Vec<Interval>,
    ) -> bool {
        let line = placed.line(block.rays, &self.frame_rows, row);
        let mut open: Option<Interval> = None;
        self.lists.count(row) <= most
            && self.lists.boundaries(placed.mesh, block.scope, row, line, |boundary, _| {
                let end = Crossing { t: boundary.crossing.t + 0.0, ..boundary.crossing };
                match open.take() {
                    None => {
                        open = Some(Interval { start: end, end, object: placed.object, path: placed.path })
                    }
                    Some(started) => out.push(Interval { end, ..started }),
                }
                ControlFlow::Continue(())
            })
    }

    /// Appends the crossings of a ray, after [`FewMemory::make_lists`]. Returns `false` if it takes the plain path, as with
    /// more than `most` hits.
    pub fn list(
        &mut self,
        placed: &PlacedMesh,
        block: &RowBlock,
        row: usize,
        most: usize,
        out: &mut Vec<RowHit>,
    ) -> bool {
        let line = placed.line(block.rays, &self.frame_rows, row);
        self.lists.count(row) <= most && self.lists.make(placed, block.scope, row, line, out)
    }
}
