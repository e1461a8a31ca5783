//! Casts blocks of rays at worlds.
//!
//! The results have the bits of [`Caster`], which casts the rays that the kernel of a mesh leaves open.
//!
//! Results are passed to functions behind `dyn`, so that what casts is compiled once, in this crate, and not again for each caller:
//! with generic functions all other crates together took twice as long to compile as this one.

use super::block_queries::QueryMemory;
use super::few_meshes::{FewMemory, FewMeshes};
use super::row_block::RowBlock;
use super::row_hit::{ByRow, ListsOfRows, RowHit};
use super::{Caster, Hit, Overlaps, QueryError, Segment};
use crate::compile::World;
use crate::math::Vec3;
use crate::ray::{InvalidRay, Ray};

/// How blocks of rays are cast at a world.
#[derive(Clone, Debug)]
pub(super) struct BlockPlan<'w> {
    /// Set for a world of a few placed meshes and nothing else.
    few: Option<FewMeshes<'w>>,
}

impl<'w> BlockPlan<'w> {
    /// The plan for a world; `None` if its rays are cast one by one.
    pub(super) fn of(world: &'w World) -> Option<BlockPlan<'w>> {
        (world.casts_blocks() || world.casts_lanes()).then(|| BlockPlan { few: FewMeshes::of(world) })
    }
}

/// The memory with which a thread casts blocks.
#[derive(Debug, Default)]
pub(super) struct BlockMemory<'w> {
    /// By row: whether the plain path has to cast the ray.
    is_plain: Vec<bool>,
    few: FewMemory,
    queries: QueryMemory<'w>,
    lists: ByRow<RowHit>,
}

/// Crossings are passed on when there are more of them than this.
const MOST_LISTED: usize = 1 << 13;

/// So many intervals are looked for at once, by as many rays as may have them.
const MOST_INTERVALS: usize = 1 << 13;

/// The numbers of rays that are cast at once for segments: enough to fill the registers, and as many as a chunk has.
const FEWEST_ROWS: usize = 128;
const MOST_ROWS: usize = 2048;

/// Receives the row of a ray, its segments and the number of overlaps.
type TakeSegments<'t> = dyn FnMut(usize, &[Segment], u64) -> Result<(), QueryError> + 't;

/// A caster, and how it casts blocks.
pub(super) struct BlockCaster<'c, 'w> {
    pub plan: &'c BlockPlan<'w>,
    pub caster: &'c mut Caster<'w>,
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
    block: &RowBlock,
    row: usize,
    cast: impl FnOnce(&Ray) -> Result<T, QueryError>,
) -> Result<T, BlockError> {
    let [ox, oy, oz, dx, dy, dz] = block.rays[row];
    let ray = Ray::new(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    let result = ray.map_err(RayError::from).and_then(|ray| Ok(cast(&ray)?));
    result.map_err(|error| BlockError { row, error })
}

impl<'w> BlockCaster<'_, 'w> {
    /// Passes the closest crossing of each ray that has one to `set`, as [`Caster::closest`] finds it.
    pub(super) fn closest(
        &mut self,
        block: &RowBlock,
        memory: &mut BlockMemory<'w>,
        set: &mut dyn FnMut(usize, &RowHit),
    ) -> Result<(), BlockError> {
        let is_plain = begin(&mut memory.is_plain, block);
        match &self.plan.few {
            Some(few) => few.closest(block, &mut memory.few, is_plain, &mut *set),
            None => self.caster.fold_closest(block, &mut memory.queries, is_plain, &mut *set),
        }
        for row in plain_rows(is_plain) {
            let hit = plainly(block, row, |ray| self.caster.closest(ray, block.scope))?;
            hit.iter().for_each(|hit| set(row, &hit.into()));
        }
        outcome(block)
    }

    /// Passes the rows of the rays that have a crossing to `set`, as [`Caster::any`] finds it.
    pub(super) fn any(
        &mut self,
        block: &RowBlock,
        memory: &mut BlockMemory<'w>,
        set: &mut dyn FnMut(usize),
    ) -> Result<(), BlockError> {
        let block = &block.without_normals();
        let is_plain = begin(&mut memory.is_plain, block);
        match &self.plan.few {
            Some(few) => few.any(block, &mut memory.few, is_plain, &mut *set),
            None => self.caster.fold_any(block, &mut memory.queries, is_plain, &mut *set),
        }
        for row in plain_rows(is_plain) {
            if plainly(block, row, |ray| self.caster.any(ray, block.scope))? {
                set(row);
            }
        }
        outcome(block)
    }

    /// Passes the number of crossings of each ray to `set`, as [`Caster::count`] finds it.
    pub(super) fn count(
        &mut self,
        block: &RowBlock,
        memory: &mut BlockMemory<'w>,
        set: &mut dyn FnMut(usize, u64),
    ) -> Result<(), BlockError> {
        let block = &block.without_normals();
        let is_plain = begin(&mut memory.is_plain, block);
        match self.plan.few.as_ref().and_then(FewMeshes::only) {
            Some(placed) => {
                let BlockMemory { few, lists: ByRow { items: hits, .. }, .. } = memory;
                few.make_lists(placed, block);
                for (row, is_plain) in is_plain.iter_mut().enumerate() {
                    hits.clear();
                    match few.list(placed, block, row, self.caster.limits.crossings, hits) {
                        true => set(row, hits.len() as u64),
                        false => *is_plain = true,
                    }
                }
            }
            None => self.caster.fold_count(block, &mut memory.queries, is_plain, &mut *set),
        }
        for row in plain_rows(is_plain) {
            set(row, plainly(block, row, |ray| self.caster.count(ray, block.scope))?);
        }
        outcome(block)
    }

    /// Passes the crossings of rays that follow each other to `add`, in order of the rays, as [`Caster::crossings`] finds
    /// them: some rays at a time.
    pub(super) fn crossings(
        &mut self,
        block: &RowBlock,
        memory: &mut BlockMemory<'w>,
        add: &mut dyn FnMut(ListsOfRows) -> Result<(), QueryError>,
    ) -> Result<(), BlockError> {
        let BlockMemory { is_plain, few, queries, lists } = memory;
        let is_plain = begin(is_plain, block);
        let only = self.plan.few.as_ref().and_then(FewMeshes::only);
        match only {
            Some(placed) => few.make_lists(placed, block),
            None => self.caster.fold_crossings(block, queries, is_plain),
        }
        if only.is_none() && !is_plain.contains(&true) {
            pass_lists(&queries.crossings, add)?;
            return outcome(block);
        }
        lists.items.clear();
        lists.ends.clear();
        let mut found = Vec::<Hit>::new();
        for (row, &is_plain) in is_plain.iter().enumerate() {
            let is_made = match only {
                Some(placed) => few.list(placed, block, row, self.caster.limits.crossings, &mut lists.items),
                None => {
                    if !is_plain {
                        lists.items.extend_from_slice(queries.crossings.row(row));
                    }
                    !is_plain
                }
            };
            if !is_made {
                found.clear();
                plainly(block, row, |ray| self.caster.crossings(ray, block.scope, &mut found))?;
                lists.items.extend(found.iter().map(RowHit::from));
            }
            lists.ends.push(lists.items.len());
            if lists.items.len() > MOST_LISTED || row + 1 == block.rays.len() {
                let some = ListsOfRows { hits: &lists.items, ends: &lists.ends, before: 0 };
                add(some).map_err(|error| BlockError { row, error: error.into() })?;
                lists.items.clear();
                lists.items.shrink_to(2 * MOST_LISTED);
                lists.ends.clear();
            }
        }
        outcome(block)
    }

    /// Passes the segments of each ray to `set`, in order of the rays, as [`Caster::segments`] finds them, with the number
    /// of overlaps. The rays are cast some at a time: so many that their intervals stay near the CPU.
    pub(super) fn segments(
        &mut self,
        block: &RowBlock,
        overlaps: Overlaps,
        memory: &mut BlockMemory<'w>,
        set: &mut TakeSegments,
    ) -> Result<(), BlockError> {
        let (mut row, mut count) = (0, FEWEST_ROWS);
        while row < block.rays.len() {
            let end = block.rays.len().min(row + count);
            let part = RowBlock { rays: &block.rays[row..end], ..block.without_normals() };
            let found = self
                .segments_of_part(&part, overlaps, memory, &mut |at, segments, met| {
                    set(row + at, segments, met)
                })
                .map_err(|error| BlockError { row: row + error.row, ..error })?;
            count = (MOST_INTERVALS * (end - row) / found.max(1)).clamp(FEWEST_ROWS, MOST_ROWS);
            row = end;
        }
        Ok(())
    }

    /// As [`BlockCaster::segments`], of some rays. Returns the number of intervals.
    fn segments_of_part(
        &mut self,
        block: &RowBlock,
        overlaps: Overlaps,
        memory: &mut BlockMemory<'w>,
        set: &mut TakeSegments,
    ) -> Result<usize, BlockError> {
        let BlockMemory { is_plain, few, queries, .. } = memory;
        let is_plain = begin(is_plain, block);
        let only = self.plan.few.as_ref().and_then(FewMeshes::only).filter(|placed| placed.is_solid);
        match only {
            Some(placed) => few.make_lists(placed, block),
            None => self.caster.fold_intervals(block, queries, is_plain),
        }
        let (mut segments, mut of_mesh, mut found) = (Vec::new(), Vec::new(), 0);
        for (row, &is_plain) in is_plain.iter().enumerate() {
            segments.clear();
            of_mesh.clear();
            let most = self.caster.limits.crossings;
            let (intervals, is_made) = match only {
                Some(placed) => {
                    let is_made = few.intervals(placed, block, row, most, &mut of_mesh);
                    (&of_mesh[..], is_made)
                }
                None => (queries.intervals.row(row), !is_plain),
            };
            found += intervals.len();
            let count = plainly(block, row, |ray| {
                if is_made {
                    self.caster.resolve(ray, intervals, overlaps, &mut segments)
                } else {
                    self.caster.segments(ray, block.scope.span, overlaps, &mut segments)
                }
            })?;
            set(row, &segments, count).map_err(|error| BlockError { row, error: error.into() })?;
        }
        outcome(block).map(|()| found)
    }
}

/// Passes the crossings of rays, some rays at a time: so many that they stay near the CPU while columns are written.
fn pass_lists(
    lists: &ByRow<RowHit>,
    add: &mut dyn FnMut(ListsOfRows) -> Result<(), QueryError>,
) -> Result<(), BlockError> {
    let (mut row, mut before) = (0, 0);
    while row < lists.ends.len() {
        let ends = &lists.ends[row..];
        let count = ends.partition_point(|end| *end <= before + MOST_LISTED).max(1);
        let end = ends[count - 1];
        let some = ListsOfRows { hits: &lists.items[before..end], ends: &ends[..count], before };
        add(some).map_err(|error| BlockError { row, error: error.into() })?;
        (row, before) = (row + count, end);
    }
    Ok(())
}

/// Begins a block: no ray takes the plain path.
fn begin<'m>(is_plain: &'m mut Vec<bool>, block: &RowBlock) -> &'m mut [bool] {
    is_plain.clear();
    is_plain.resize(block.rays.len(), false);
    is_plain
}

fn outcome(block: &RowBlock) -> Result<(), BlockError> {
    let cancelled = BlockError { row: 0, error: QueryError::Cancelled.into() };
    if block.is_cancelled() { Err(cancelled) } else { Ok(()) }
}

fn plain_rows(is_plain: &[bool]) -> impl Iterator<Item = usize> {
    is_plain.iter().enumerate().filter(|(_, is_plain)| **is_plain).map(|(row, _)| row)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::query::Limits;
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

    fn forward(rays: &[[f64; 6]]) -> RowBlock<'_> {
        RowBlock { rays, scope: Span::FORWARD.into(), wants_normals: true, cancel: None }
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
        let plan = BlockPlan::of(&world).expect("a world of a mesh");
        let (mut caster, mut memory) = (Caster::new(&world), BlockMemory::default());
        caster.limit(limits);
        for plan in [plan, BlockPlan { few: None }] {
            let mut blocks = BlockCaster { plan: &plan, caster: &mut caster };
            let mut counts = Vec::new();
            let block = forward(&rays);
            let counted = blocks.count(&block, &mut memory, &mut |_, count| counts.push(count));
            assert!(counted.is_ok() && counts == [20; 3]);
            let listed = blocks.crossings(&block, &mut memory, &mut |_| Ok(()));
            let error = listed.err().map(|BlockError { row, error }| {
                (row, matches!(error, RayError::Query(QueryError::TooMany { most: 10 })))
            });
            assert_eq!(error, Some((0, true)));
        }
    }

    /// An array that is read in place may change under a cast: the row is then an error, not a panic.
    #[test]
    fn a_row_that_is_no_longer_a_ray_is_an_error() {
        let (world, mut rays) = stack(3, 5);
        let plan = BlockPlan::of(&world).expect("a world of a mesh");
        let (mut caster, mut memory) = (Caster::new(&world), BlockMemory::default());
        rays[3] = [f64::NAN; 6];
        for plan in [plan, BlockPlan { few: None }] {
            let mut blocks = BlockCaster { plan: &plan, caster: &mut caster };
            let failed = blocks.closest(&forward(&rays), &mut memory, &mut |_, _| ());
            assert!(matches!(failed, Err(BlockError { row: 3, error: RayError::Ray(InvalidRay::Origin) })));
        }
    }
}
