//! Worlds of a few placed meshes and nothing else: their rays need no traversal of levels.

use super::hit_lists::HitLists;
use super::inside::{FirstHits, Inside};
use super::placed_mesh::{FrameRows, PlacedMesh};
use super::row_block::RowBlock;
use super::row_hit::RowHit;
use crate::compile::{Body, Target, World};
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory};

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
    inside: Inside,
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
            mesh.casts_blocks().then_some(PlacedMesh {
                mesh,
                frames: [&placement.local_from_parent, local_from_body],
                // The objects of a world without levels are all named at the root.
                object: placement.object.unwrap_or(0),
                path: placement.first_path,
                surface,
                is_solid,
            })
        });
        Some(FewMeshes { placed: placed.collect::<Option<_>>()? })
    }

    /// The lookups in the cells of the first mesh, and how many of them succeeded.
    #[cfg(test)]
    pub fn lookups(&self) -> Option<[usize; 2]> {
        self.placed.first()?.mesh.empty_cells().map(|cells| cells.lookups())
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
        memory: &mut FewMemory,
        is_plain: &mut [bool],
        mut set: impl FnMut(usize),
    ) {
        if self.placed.iter().any(|placed| placed.is_solid) {
            // One hit of a solid does not show that there is a crossing: another may be one event with it.
            return self.closest(block, memory, is_plain, |row, _| set(row));
        }
        let FewMemory { kernel, frame_rows, .. } = memory;
        for placed in &self.placed {
            placed.cast(block, BlockQuery::Any, None, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            kernel.rows_hit().for_each(&mut set);
        }
    }
}

impl FewMemory {
    fn closest_at(
        &mut self,
        placed: &PlacedMesh,
        block: &RowBlock,
        is_plain: &mut [bool],
        mut set: impl FnMut(usize, &RowHit),
    ) {
        let FewMemory { kernel, frame_rows, best, ends, inside, lists } = self;
        // Paths ascend from placement to placement, so of equal hits the first one stays.
        let mut offer = |row: usize, hit: &RowHit| match best.get_mut(row) {
            None => set(row, hit),
            Some(best) if best.is_none_or(|best| hit.t < best.t) => *best = Some(*hit),
            Some(_) => {}
        };
        let ends = (!ends.is_empty()).then_some(&ends[..]);
        if !placed.is_solid {
            placed.cast(block, BlockQuery::Nearest, ends, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            for hit in kernel.hits() {
                offer(hit.row as usize, &placed.row_hit(hit, &hit.crossing));
            }
            return;
        }
        let cells = placed.mesh.empty_cells();
        let query = if cells.is_some() { BlockQuery::First } else { BlockQuery::FirstFromOutside };
        placed.cast(block, query, ends, frame_rows, kernel);
        placed.mesh.count_starts_in_box(kernel.inside_rows().len());
        inside.decide(FirstHits { placed, cells, block, ends, frame_rows }, kernel, is_plain, &mut offer);
        if inside.rows.is_empty() {
            return;
        }
        let of_inside = RowBlock { rays: &inside.rays, ..*block };
        placed.cast(&of_inside, BlockQuery::Within, None, frame_rows, kernel);
        lists.sort_by_ray(inside.rays.len(), kernel);
        for (i, &row) in inside.rows.iter().enumerate() {
            let line = placed.line(&inside.rays, frame_rows, i);
            if lists.make(placed, block.scope, i, line) {
                lists.found.first().into_iter().for_each(|hit| offer(row as usize, hit));
            } else {
                is_plain[row as usize] = true;
            }
        }
    }

    /// Finds all hits of a block at the only mesh of a world.
    pub fn make_lists(&mut self, placed: &PlacedMesh, block: &RowBlock) {
        let query = if placed.is_solid { BlockQuery::Within } else { BlockQuery::All };
        placed.cast(block, query, None, &mut self.frame_rows, &mut self.kernel);
        self.lists.sort_by_ray(block.rays.len(), &self.kernel);
    }

    /// The crossings of a ray, after [`FewMemory::make_lists`]; `None` if it takes the plain path, as with more than `most`
    /// hits.
    pub fn list(
        &mut self,
        placed: &PlacedMesh,
        block: &RowBlock,
        row: usize,
        most: usize,
    ) -> Option<&[RowHit]> {
        let line = placed.line(block.rays, &self.frame_rows, row);
        let is_made = self.lists.count(row) <= most && self.lists.make(placed, block.scope, row, line);
        is_made.then_some(&self.lists.found[..])
    }
}
