//! The queries of blocks of rays in worlds of any kind, by the fold of blocks. Rays that are refused are marked for the
//! plain path.

use super::block_fold::{BlockFold, FoldMemory};
use super::block_visitor::{BlockVisitor, Found, InFlight, Normal};
use super::caster::Caster;
use super::fold_query::{FoldControl, FoldQuery};
use super::hit::{normal, row_hit};
use super::interval_ends::Interval;
use super::level_paths::LevelPaths;
use super::limit::search_limit_of_row;
use super::row_block::RowBlock;
use super::row_hit::{ByRow, RowHit};
use super::traversal::{BodyEntry, PlacedBody};
use crate::compile::World;
use crate::csg::{Boundary, HitKind};
use crate::math::Vec3;
use crate::solid::Wanted;

/// If the rays of a block have more boundaries than this, those that are still in flight take the plain path, which
/// needs memory for one at a time.
const MAX_BOUNDARIES: usize = if cfg!(test) { 20_000 } else { 1 << 20 };

/// The memory of the queries; reused from block to block.
#[derive(Debug, Default)]
pub(super) struct QueryMemory<'w> {
    fold: FoldMemory<'w>,
    nearest: Vec<Option<Nearest>>,
    /// The nearest boundaries whose normals are still open.
    open: Vec<(BodyEntry, Boundary)>,
    counts: Vec<u64>,
    /// The crossings of the rays, one ray after the other.
    pub crossings: ByRow<RowHit>,
    /// The crossings in the order in which they were found, and their numbers by row.
    unsorted: Unsorted<RowHit>,
    order: Vec<u32>,
    /// The intervals of the rays, one ray after the other, each ray's in the order of its traversal.
    pub intervals: ByRow<Interval>,
    /// The intervals in the order in which they were found.
    unsorted_intervals: Unsorted<Interval>,
}

/// What was found, and the row of each.
#[derive(Debug)]
struct Unsorted<T> {
    rows: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Unsorted<T> {
    fn default() -> Unsorted<T> {
        Unsorted { rows: Vec::new(), items: Vec::new() }
    }
}

impl<T> Unsorted<T> {
    fn clear(&mut self) {
        self.rows.clear();
        self.items.clear();
    }
}

/// The nearest boundary of a ray so far.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    hit: RowHit,
    has_normal: bool,
}

/// Counts that are zero.
fn zeros(counts: &mut Vec<u64>) -> &mut Vec<u64> {
    counts.clear();
    counts
}

/// Makes an array at least so long.
fn lengthen<T: Clone>(array: &mut Vec<T>, length: usize, with: T) {
    if array.len() < length {
        array.resize(length, with);
    }
}

/// The normal of a boundary in world coordinates.
fn normal_of(
    world: &World,
    paths: &LevelPaths,
    block: &RowBlock,
    row: usize,
    (body_entry, boundary): (&BodyEntry, &Boundary),
) -> Vec3 {
    let [.., x, y, z] = block.rays[row];
    let world_normal = |normal| paths.world_normal(&body_entry.placed, normal);
    normal(world, world_normal, Vec3::new(x, y, z), body_entry, boundary)
}

impl<'w> Caster<'w> {
    fn fold_block<V: BlockVisitor<'w>>(
        &mut self,
        block: &RowBlock,
        wanted: Wanted,
        memory: &mut FoldMemory<'w>,
        visitor: &mut V,
    ) {
        let query = FoldQuery { scope: block.scope, wanted, hint: &[] };
        BlockFold { caster: self, block, query }.run(memory, visitor);
    }

    /// Passes the closest crossing of each ray that has one to `set`.
    pub(super) fn fold_closest(
        &mut self,
        block: &RowBlock,
        memory: &mut QueryMemory<'w>,
        is_plain: &mut [bool],
        set: impl FnMut(usize, &RowHit),
    ) {
        let QueryMemory { fold, nearest, open, .. } = memory;
        let mut visitor = Closest { world: self.world, block, nearest, open, is_plain, set };
        self.fold_block(block, Wanted::First, fold, &mut visitor);
        if block.is_cancelled() {
            // Rays that have neither ended nor been refused may have left something behind.
            nearest.clear();
        }
    }

    /// Passes the rows of the rays that have a crossing to `set`.
    pub(super) fn fold_any(
        &mut self,
        block: &RowBlock,
        memory: &mut QueryMemory<'w>,
        is_plain: &mut [bool],
        set: impl FnMut(usize),
    ) {
        self.fold_block(block, Wanted::First, &mut memory.fold, &mut Any { is_plain, set });
    }

    /// Passes the number of crossings of each ray to `set`.
    pub(super) fn fold_count(
        &mut self,
        block: &RowBlock,
        memory: &mut QueryMemory<'w>,
        is_plain: &mut [bool],
        set: impl FnMut(usize, u64),
    ) {
        let QueryMemory { fold, counts, .. } = memory;
        self.fold_block(block, Wanted::All, fold, &mut Count { counts: zeros(counts), is_plain, set });
    }

    /// Collects the crossings of all rays, each ray's sorted as [`super::Caster::crossings`] sorts them.
    pub(super) fn fold_crossings(
        &mut self,
        block: &RowBlock,
        memory: &mut QueryMemory<'w>,
        is_plain: &mut [bool],
    ) {
        let QueryMemory { fold, counts, crossings, unsorted, order, .. } = memory;
        unsorted.clear();
        let most = self.limits.crossings as u64;
        let world = self.world;
        let mut visitor =
            Crossings { world, block, most, counts: zeros(counts), crossings: unsorted, is_plain };
        self.fold_block(block, Wanted::All, fold, &mut visitor);
        sort_by_row(block.rays.len(), unsorted, order, crossings);
        for row in 0..block.rays.len() {
            let of_row = crossings.row_mut(row);
            let order = |a: &RowHit, b: &RowHit| a.t.total_cmp(&b.t).then(a.path.cmp(&b.path));
            if !of_row.is_sorted_by(|a, b| order(a, b).is_le()) {
                // Stable: boundaries of one body keep their order.
                of_row.sort_by(order);
            }
        }
    }

    /// Collects the intervals of all rays inside bodies, each ray's in the order of its traversal.
    pub(super) fn fold_intervals(
        &mut self,
        block: &RowBlock,
        memory: &mut QueryMemory<'w>,
        is_plain: &mut [bool],
    ) {
        let QueryMemory { fold, counts, intervals, unsorted_intervals: unsorted, order, .. } = memory;
        unsorted.clear();
        let most = self.limits.crossings as u64;
        let mut visitor =
            Intervals { most, counts: zeros(counts), intervals: unsorted, open: None, is_plain };
        self.fold_block(block, Wanted::All, fold, &mut visitor);
        sort_by_row(block.rays.len(), unsorted, order, intervals);
    }
}

/// Sorts by row, by counting. What belongs to one row keeps its order.
fn sort_by_row<T: Copy>(
    rows: usize,
    unsorted: &mut Unsorted<T>,
    order: &mut Vec<u32>,
    sorted: &mut ByRow<T>,
) {
    let ByRow { items, ends } = sorted;
    ends.clear();
    ends.resize(rows, 0);
    unsorted.rows.iter().for_each(|row| ends[*row as usize] += 1);
    if unsorted.rows.is_sorted() {
        let mut sum = 0;
        for end in ends {
            sum += *end;
            *end = sum;
        }
        std::mem::swap(items, &mut unsorted.items);
        return;
    }
    // Where each row begins, and then where it ends.
    let mut begin = 0;
    for end in ends.iter_mut() {
        begin += std::mem::replace(end, begin);
    }
    order.clear();
    order.resize(unsorted.rows.len(), 0);
    for (number, row) in (0..).zip(&unsorted.rows) {
        let at = &mut ends[*row as usize];
        order[*at] = number;
        *at += 1;
    }
    items.clear();
    items.extend(order.iter().map(|number| unsorted.items[*number as usize]));
}

struct Closest<'v, S> {
    world: &'v World,
    block: &'v RowBlock<'v>,
    nearest: &'v mut Vec<Option<Nearest>>,
    open: &'v mut Vec<(BodyEntry, Boundary)>,
    is_plain: &'v mut [bool],
    set: S,
}

impl<'w, S: FnMut(usize, &RowHit)> BlockVisitor<'w> for Closest<'_, S> {
    fn make_room(&mut self, in_flight: usize) {
        lengthen(self.nearest, in_flight, None);
        let nothing = (BodyEntry::NONE, Boundary::of_span_end(HitKind::End, 0.0));
        lengthen(self.open, in_flight, nothing);
    }

    fn boundary(&mut self, ray: InFlight, found: Found<'_, 'w>) -> FoldControl {
        let Found { placed, boundary, normal, .. } = found;
        let nearest = &mut self.nearest[ray.slot];
        let (t, path) = (boundary.crossing.t, placed.path);
        if nearest.is_none_or(|Nearest { hit, .. }| t < hit.t || (t == hit.t && path < hit.path)) {
            let mut hit = row_hit(self.world, &placed, &boundary);
            let mut has_normal = true;
            match normal {
                Normal::Known(normal) => hit.normal = normal,
                Normal::Open(body_entry) => {
                    self.open[ray.slot] = (*body_entry, boundary);
                    has_normal = false;
                }
            }
            *nearest = Some(Nearest { hit, has_normal });
        }
        FoldControl::Limit(search_limit_of_row(&self.block.rays[ray.row], &boundary.crossing))
    }

    fn end(&mut self, ray: InFlight, paths: &LevelPaths<'w>) {
        if let Some(Nearest { mut hit, has_normal }) = self.nearest[ray.slot].take() {
            if !has_normal && self.block.wants_normals {
                let (body_entry, boundary) = &self.open[ray.slot];
                hit.normal = normal_of(self.world, paths, self.block, ray.row, (body_entry, boundary));
            }
            (self.set)(ray.row, &hit);
        }
    }

    fn refuse(&mut self, ray: InFlight) {
        self.nearest[ray.slot] = None;
        self.is_plain[ray.row] = true;
    }
}

struct Any<'v, S> {
    is_plain: &'v mut [bool],
    set: S,
}

impl<'w, S: FnMut(usize)> BlockVisitor<'w> for Any<'_, S> {
    const IS_ANY: bool = true;

    fn boundary(&mut self, ray: InFlight, _: Found<'_, 'w>) -> FoldControl {
        self.any(ray);
        FoldControl::Stop
    }

    fn any(&mut self, ray: InFlight) {
        (self.set)(ray.row);
    }

    fn refuse(&mut self, ray: InFlight) {
        self.is_plain[ray.row] = true;
    }
}

struct Count<'v, S> {
    counts: &'v mut Vec<u64>,
    is_plain: &'v mut [bool],
    set: S,
}

impl<'w, S: FnMut(usize, u64)> BlockVisitor<'w> for Count<'_, S> {
    fn make_room(&mut self, in_flight: usize) {
        lengthen(self.counts, in_flight, 0);
    }

    fn boundary(&mut self, ray: InFlight, _: Found<'_, 'w>) -> FoldControl {
        self.counts[ray.slot] += 1;
        FoldControl::Limit(f64::INFINITY)
    }

    fn end(&mut self, ray: InFlight, _: &LevelPaths<'w>) {
        (self.set)(ray.row, std::mem::take(&mut self.counts[ray.slot]));
    }

    fn refuse(&mut self, ray: InFlight) {
        self.counts[ray.slot] = 0;
        self.is_plain[ray.row] = true;
    }
}

struct Crossings<'v> {
    world: &'v World,
    block: &'v RowBlock<'v>,
    most: u64,
    counts: &'v mut Vec<u64>,
    crossings: &'v mut Unsorted<RowHit>,
    is_plain: &'v mut [bool],
}

impl<'w> BlockVisitor<'w> for Crossings<'_> {
    fn make_room(&mut self, in_flight: usize) {
        lengthen(self.counts, in_flight, 0);
    }

    fn boundary(&mut self, ray: InFlight, found: Found<'_, 'w>) -> FoldControl {
        let Found { paths, placed, boundary, normal } = found;
        let count = &mut self.counts[ray.slot];
        if *count >= self.most || self.crossings.rows.len() >= MAX_BOUNDARIES {
            self.is_plain[ray.row] = true;
            return FoldControl::Stop;
        }
        *count += 1;
        let mut hit = row_hit(self.world, &placed, &boundary);
        match normal {
            Normal::Known(normal) => hit.normal = normal,
            Normal::Open(body_entry) if self.block.wants_normals => {
                hit.normal = normal_of(self.world, paths, self.block, ray.row, (body_entry, &boundary));
            }
            Normal::Open(_) => {}
        }
        self.crossings.rows.push(ray.row as u32);
        self.crossings.items.push(hit);
        FoldControl::Limit(f64::INFINITY)
    }

    fn end(&mut self, ray: InFlight, _: &LevelPaths<'w>) {
        self.counts[ray.slot] = 0;
    }

    fn refuse(&mut self, ray: InFlight) {
        self.counts[ray.slot] = 0;
        self.is_plain[ray.row] = true;
    }
}

struct Intervals<'v> {
    most: u64,
    counts: &'v mut Vec<u64>,
    intervals: &'v mut Unsorted<Interval>,
    /// The interval whose end comes next.
    open: Option<Interval>,
    is_plain: &'v mut [bool],
}

impl<'w> BlockVisitor<'w> for Intervals<'_> {
    fn make_room(&mut self, in_flight: usize) {
        lengthen(self.counts, in_flight, 0);
    }

    fn boundary(&mut self, ray: InFlight, found: Found<'_, 'w>) -> FoldControl {
        let end = found.boundary.crossing;
        // The boundaries of one body arrive one after the other, in pairs of an entry and an exit.
        let Some(started) = self.open.take() else {
            let PlacedBody { object, path, .. } = found.placed;
            self.open = Some(Interval { start: end, end, object, path });
            return FoldControl::Limit(f64::INFINITY);
        };
        let count = &mut self.counts[ray.slot];
        if 2 * *count >= self.most || self.intervals.rows.len() >= MAX_BOUNDARIES {
            self.is_plain[ray.row] = true;
            return FoldControl::Stop;
        }
        *count += 1;
        self.intervals.rows.push(ray.row as u32);
        self.intervals.items.push(Interval { end, ..started });
        FoldControl::Limit(f64::INFINITY)
    }

    fn end(&mut self, ray: InFlight, _: &LevelPaths<'w>) {
        self.counts[ray.slot] = 0;
    }

    fn refuse(&mut self, ray: InFlight) {
        (self.counts[ray.slot], self.open) = (0, None);
        self.is_plain[ray.row] = true;
    }
}
