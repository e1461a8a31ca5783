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
use crate::ray::{InvalidRay, Ray};
use crate::solid::mesh::kernel::{BlockQuery, KernelMemory};

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
pub(super) struct BlockError {
    pub row: usize,
    pub error: RayError,
}

/// Why a ray has no result.
pub(super) enum RayError {
    Query(QueryError),
    /// Its numbers have changed since they were validated: a caller's array is read in place.
    Ray(InvalidRay),
}

impl From<QueryError> for RayError {
    fn from(error: QueryError) -> RayError {
        RayError::Query(error)
    }
}

impl From<InvalidRay> for RayError {
    fn from(error: InvalidRay) -> RayError {
        RayError::Ray(error)
    }
}

/// Casts one ray of a block by the plain path.
fn plainly<T>(
    rays: &[[f64; 6]],
    row: usize,
    cast: impl FnOnce(&Ray) -> Result<T, QueryError>,
) -> Result<T, BlockError> {
    let [ox, oy, oz, dx, dy, dz] = rays[row];
    let ray = Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    let result = ray.map_err(RayError::from).and_then(|ray| Ok(cast(&ray)?));
    result.map_err(|error| BlockError { row, error })
}

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
            let query = if placed.is_solid { BlockQuery::First } else { BlockQuery::Nearest };
            placed.cast(rays, scope, (query, wants_normals), self.cancel, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            for hit in kernel.hits() {
                offer(hit.row as usize, &placed.row_hit(hit, &hit.crossing));
            }
            if kernel.inside_rows().is_empty() {
                continue;
            }
            inside.of(rays, kernel.inside_rows());
            placed.cast(
                &inside.rays,
                scope,
                (BlockQuery::Within, wants_normals),
                self.cancel,
                frame_rows,
                kernel,
            );
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
            let hit = plainly(rays, row, |ray| self.caster.closest(ray, scope))?;
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
            placed.cast(rays, scope, (BlockQuery::Any, false), self.cancel, frame_rows, kernel);
            kernel.plain_rows().iter().for_each(|&row| is_plain[row as usize] = true);
            kernel.rows_hit().for_each(&mut set);
        }
        for row in (0..rays.len()).filter(|&row| is_plain[row]) {
            if plainly(rays, row, |ray| self.caster.any(ray, scope))? {
                set(row);
            }
        }
        self.outcome()
    }

    /// Passes the number of crossings of each ray to `set`, as [`Caster::count`] finds it.
    pub(super) fn count(
        &mut self,
        rays: &[[f64; 6]],
        scope: Scope,
        mut set: impl FnMut(usize, u64),
    ) -> Result<(), BlockError> {
        let made = self.make_lists(rays, scope, false);
        for row in 0..rays.len() {
            let count = match self.list(made, rays, scope, row) {
                Some(list) => list.len() as u64,
                None => plainly(rays, row, |ray| self.caster.count(ray, scope))?,
            };
            set(row, count);
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
        let made = self.make_lists(rays, scope, wants_normals);
        let (mut hits, mut of_plain) = (Vec::<Hit>::new(), Vec::new());
        for row in 0..rays.len() {
            let list = match self.list(made, rays, scope, row) {
                Some(list) => list,
                None => {
                    hits.clear();
                    plainly(rays, row, |ray| self.caster.crossings(ray, scope, &mut hits))?;
                    of_plain.clear();
                    of_plain.extend(hits.iter().map(RowHit::from));
                    &of_plain
                }
            };
            set(row, list).map_err(|error| BlockError { row, error: error.into() })?;
        }
        self.outcome()
    }

    /// Finds all hits of the rays at the only mesh. Returns whether there is only one: lists of several placements take
    /// the plain path.
    fn make_lists(&mut self, rays: &[[f64; 6]], scope: Scope, wants_normals: bool) -> bool {
        let [placed] = &self.meshes.placed[..] else { return false };
        let BlockMemory { kernel, frame_rows, lists, .. } = &mut *self.memory;
        let query = if placed.is_solid { BlockQuery::Within } else { BlockQuery::All };
        placed.cast(rays, scope, (query, wants_normals), self.cancel, frame_rows, kernel);
        lists.sort_by_ray(rays.len(), kernel);
        true
    }

    /// The list of a ray, if lists were made; `None` if it takes the plain path.
    fn list(&mut self, made: bool, rays: &[[f64; 6]], scope: Scope, row: usize) -> Option<&[RowHit]> {
        let placed = self.meshes.placed.first().filter(|_| made)?;
        let BlockMemory { frame_rows, lists, .. } = &mut *self.memory;
        let is_short = lists.count(row) <= self.caster.limits.crossings;
        let line = || placed.line(rays, frame_rows, row);
        (is_short && lists.make(placed, scope, row, line)).then_some(&lists.found[..])
    }

    fn outcome(&self) -> Result<(), BlockError> {
        let cancelled = self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed));
        if cancelled { Err(BlockError { row: 0, error: QueryError::Cancelled.into() }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::query::batch::{self, Run};
    use crate::ray::Span;
    use crate::shape::{Object, Shape};
    use crate::solid::mesh::TriangleMesh;

    /// Sheets one above the other, and rays through all of them.
    fn stack(sheets: u32, rays: usize) -> (World, Vec<[f64; 6]>) {
        let mut mesh = TriangleMesh::default();
        for i in 0..sheets {
            let corner = |x: f64, y: f64| Vec3::new(x, y, f64::from(i));
            mesh.vertices.extend([corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)]);
            mesh.faces.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let shape = Shape::triangles(Arc::new(mesh)).expect("a mesh");
        let world = crate::scene::Scene::of([Object::new("stack", shape)]).compile().expect("a world");
        let ray = |i: usize| [0.3, 0.2 + 1e-3 * (i % 100) as f64, -1.0, 0.0, 1e-3, 1.0];
        (world, (0..rays).map(ray).collect())
    }

    #[test]
    fn rays_with_too_many_hits_for_a_chunk_are_cast_one_by_one() {
        let (world, rays) = stack(100, 500);
        let rays = batch::RowsOfSix(&rays);
        let counters = Default::default();
        let run = Run { threads: 1, ..Run::default() };
        let plain = Run { counters: Some(&counters), ..run };
        let [found, expected] = [run, plain].map(|run| batch::crossings(&world, &rays, Span::FORWARD, run));
        assert_eq!(found, expected);
        assert_eq!(found.expect("within limits").t.len(), 500 * 100);
        let [found, expected] = [run, plain].map(|run| batch::count(&world, &rays, Span::FORWARD, run));
        assert_eq!(found, expected);
    }

    /// The limit is for crossings that are listed. They can be counted beyond it.
    #[test]
    fn the_limit_of_crossings_is_not_one_of_their_number() {
        let (world, rays) = stack(20, 3);
        let limits = Limits { crossings: 10, ..Limits::default() };
        let meshes = MeshWorld::of(&world, limits).expect("a world of a mesh");
        let (mut caster, mut memory) = (Caster::new(&world), BlockMemory::default());
        caster.limit(limits);
        let mut blocks =
            BlockCaster { meshes: &meshes, caster: &mut caster, memory: &mut memory, cancel: None };
        let mut counts = Vec::new();
        let counted = blocks.count(&rays, Span::FORWARD.into(), |_, count| counts.push(count));
        assert!(counted.is_ok() && counts == [20; 3]);
        let listed = blocks.crossings(&rays, Span::FORWARD.into(), true, |_, _| Ok(()));
        let error = listed.err().map(|BlockError { row, error }| {
            (row, matches!(error, RayError::Query(QueryError::TooMany { most: 10 })))
        });
        assert_eq!(error, Some((0, true)));
    }

    /// An array that is read in place may change under a cast: the row is then an error, not a panic.
    #[test]
    fn a_row_that_is_no_longer_a_ray_is_an_error() {
        let (world, mut rays) = stack(3, 5);
        let meshes = MeshWorld::of(&world, Limits::default()).expect("a world of a mesh");
        let (mut caster, mut memory) = (Caster::new(&world), BlockMemory::default());
        let mut blocks =
            BlockCaster { meshes: &meshes, caster: &mut caster, memory: &mut memory, cancel: None };
        rays[3] = [f64::NAN; 6];
        let failed = blocks.closest(&rays, Span::FORWARD.into(), true, |_, _| ());
        assert!(matches!(failed, Err(BlockError { row: 3, error: RayError::Ray(InvalidRay::Origin) })));
    }
}
