//! Casts blocks of rays at worlds of a few placed meshes, without the traversal of levels.
//!
//! The results have the bits of [`Caster`], which casts the rays that the kernel of the mesh leaves open.

use std::sync::atomic::{AtomicBool, Ordering};

use super::hit_lists::HitLists;
use super::placed_mesh::{FrameRows, PlacedMesh};
use super::row_hit::RowHit;
use super::{Caster, Hit, Limits, QueryError, Scope};
use crate::compile::{Body, Target, World};
use crate::math::Vec3;
use crate::ray::Ray;
use crate::solid::mesh::kernel::{KernelMemory, Want};

/// Worlds with more placements are left to the traversal of levels, which does not test every placement.
const MAX_PLACEMENTS: usize = 4;

/// A world of few placed meshes.
#[derive(Clone, Debug)]
pub(super) struct MeshWorld<'w> {
    placed: Vec<PlacedMesh<'w>>,
}

impl<'w> MeshWorld<'w> {
    /// The meshes of a world; `None` if it has anything else.
    pub(super) fn of(world: &'w World, limits: Limits) -> Option<MeshWorld<'w>> {
        let placements = &world.root().placements;
        if placements.is_empty() || placements.len() > MAX_PLACEMENTS {
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
            let steps = limits.steps.saturating_sub(limits.crossings as u64);
            mesh.casts_blocks(steps).then_some(PlacedMesh {
                mesh,
                frames: [&placement.local_from_parent, local_from_body],
                // The objects of a world without levels are all named at the root.
                object: placement.object.unwrap_or(0),
                path: placement.first_path,
                surface,
                is_solid,
            })
        });
        Some(MeshWorld { placed: placed.collect::<Option<_>>()? })
    }
}

/// The memory with which a thread casts blocks.
#[derive(Debug, Default)]
pub(super) struct BlockMemory {
    kernel: KernelMemory,
    frame_rows: FrameRows,
    /// By row: the best hit, and whether the plain path has to cast the ray.
    best: Vec<Option<RowHit>>,
    is_plain: Vec<bool>,
    inside: Inside,
    lists: HitLists,
}

/// The rays that may begin inside a solid.
#[derive(Debug, Default)]
struct Inside {
    rows: Vec<u32>,
    rays: Vec<[f64; 6]>,
}

impl Inside {
    fn of(&mut self, rays: &[[f64; 6]], rows: &[u32]) {
        self.rows.clear();
        self.rows.extend_from_slice(rows);
        self.rays.clear();
        self.rays.extend(rows.iter().map(|&row| rays[row as usize]));
    }
}

/// A caster with the meshes of its world.
pub(super) struct BlockCaster<'c, 'w> {
    pub meshes: &'c MeshWorld<'w>,
    pub caster: &'c mut Caster<'w>,
    pub memory: &'c mut BlockMemory,
    pub cancel: Option<&'c AtomicBool>,
}

/// The row of a block at which a query failed, and why.
pub(super) type BlockError = (usize, QueryError);

impl BlockCaster<'_, '_> {
    /// Passes the closest crossing of each ray that has one to `set`, as [`Caster::closest`] finds it.
    pub(super) fn closest(
        &mut self,
        rays: &[[f64; 6]],
        scope: Scope,
        wants_normals: bool,
        mut set: impl FnMut(usize, &RowHit),
    ) -> Result<(), BlockError> {
        let BlockMemory { kernel, frame_rows, best, is_plain, inside, lists } = &mut *self.memory;
        is_plain.clear();
        is_plain.resize(rays.len(), false);
        let is_only = self.meshes.placed.len() == 1;
        best.clear();
        best.resize(if is_only { 0 } else { rays.len() }, None);
        // Paths ascend from placement to placement, so of equal hits the first one stays.
        let mut offer = |row: usize, hit: &RowHit| match best.get_mut(row) {
            None => set(row, hit),
            Some(best) if best.is_none_or(|best| hit.t < best.t) => *best = Some(*hit),
            Some(_) => {}
        };
        for placed in &self.meshes.placed {
            let want = if placed.is_solid { Want::First } else { Want::Nearest };
            placed.cast(rays, scope, (want, wants_normals), self.cancel, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            for hit in kernel.hits() {
                offer(hit.row as usize, &placed.row_hit(hit, &hit.crossing));
            }
            if kernel.inside_rows().is_empty() {
                continue;
            }
            inside.of(rays, kernel.inside_rows());
            placed.cast(&inside.rays, scope, (Want::Within, wants_normals), self.cancel, frame_rows, kernel);
            lists.sort_by_ray(inside.rays.len(), kernel);
            for (i, &row) in inside.rows.iter().enumerate() {
                let line = || placed.line(&inside.rays, frame_rows, i);
                if lists.make(placed, scope, i, line) {
                    lists.found.first().into_iter().for_each(|hit| offer(row as usize, hit));
                } else {
                    is_plain[row as usize] = true;
                }
            }
        }
        for (row, hit) in best.iter().enumerate().filter(|(row, _)| !is_plain[*row]) {
            hit.iter().for_each(|hit| set(row, hit));
        }
        for row in (0..rays.len()).filter(|&row| is_plain[row]) {
            let hit = self.caster.closest(&ray_of(&rays[row]), scope).map_err(|error| (row, error))?;
            hit.iter().for_each(|hit| set(row, &hit.into()));
        }
        self.outcome()
    }

    /// Passes the rows of the rays that have a crossing to `set`, as [`Caster::any`] finds it.
    pub(super) fn any(
        &mut self,
        rays: &[[f64; 6]],
        scope: Scope,
        mut set: impl FnMut(usize),
    ) -> Result<(), BlockError> {
        if self.meshes.placed.iter().any(|placed| placed.is_solid) {
            // One hit of a solid does not tell whether there is a crossing: another may be one event with it.
            return self.closest(rays, scope, false, |row, _| set(row));
        }
        let BlockMemory { kernel, frame_rows, is_plain, .. } = &mut *self.memory;
        is_plain.clear();
        is_plain.resize(rays.len(), false);
        for placed in &self.meshes.placed {
            placed.cast(rays, scope, (Want::Any, false), self.cancel, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            kernel.rows_hit().for_each(&mut set);
        }
        for row in (0..rays.len()).filter(|&row| is_plain[row]) {
            if self.caster.any(&ray_of(&rays[row]), scope).map_err(|error| (row, error))? {
                set(row);
            }
        }
        self.outcome()
    }

    /// Passes the crossings of each ray to `set`, in order of the rays, as [`Caster::crossings`] finds them.
    pub(super) fn crossings(
        &mut self,
        rays: &[[f64; 6]],
        scope: Scope,
        wants_normals: bool,
        mut set: impl FnMut(usize, &[RowHit]) -> Result<(), QueryError>,
    ) -> Result<(), BlockError> {
        let [placed] = &self.meshes.placed[..] else {
            return self.crossings_one_by_one(rays, scope, set);
        };
        let BlockMemory { kernel, frame_rows, lists, .. } = &mut *self.memory;
        let want = if placed.is_solid { Want::Within } else { Want::All };
        placed.cast(rays, scope, (want, wants_normals), self.cancel, frame_rows, kernel);
        lists.sort_by_ray(rays.len(), kernel);
        let mut hits = Vec::new();
        for (row, ray) in rays.iter().enumerate() {
            let line = || placed.line(rays, frame_rows, row);
            if lists.count(row) > self.caster.limits.crossings || !lists.make(placed, scope, row, line) {
                hits.clear();
                self.caster.crossings(&ray_of(ray), scope, &mut hits).map_err(|error| (row, error))?;
                lists.found.clear();
                lists.found.extend(hits.iter().map(RowHit::from));
            }
            set(row, &lists.found).map_err(|error| (row, error))?;
        }
        self.outcome()
    }

    fn crossings_one_by_one(
        &mut self,
        rays: &[[f64; 6]],
        scope: Scope,
        mut set: impl FnMut(usize, &[RowHit]) -> Result<(), QueryError>,
    ) -> Result<(), BlockError> {
        let (mut hits, mut found) = (Vec::<Hit>::new(), Vec::new());
        for (row, ray) in rays.iter().enumerate() {
            hits.clear();
            found.clear();
            self.caster.crossings(&ray_of(ray), scope, &mut hits).map_err(|error| (row, error))?;
            found.extend(hits.iter().map(RowHit::from));
            set(row, &found).map_err(|error| (row, error))?;
        }
        Ok(())
    }

    fn outcome(&self) -> Result<(), BlockError> {
        let cancelled = self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err((0, QueryError::Cancelled)) } else { Ok(()) }
    }
}

/// The ray of a row that has been validated.
fn ray_of(row: &[f64; 6]) -> Ray {
    let [ox, oy, oz, dx, dy, dz] = *row;
    Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz))
        .unwrap_or_else(|error| unreachable!("the row was validated: {error}"))
}
