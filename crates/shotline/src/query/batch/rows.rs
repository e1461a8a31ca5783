//! The results of batches as columns.

use std::collections::TryReserveError;

use super::{BatchError, Fields};
use crate::compile::World;
use crate::query::row_hit::{ListsOfRows, RowHit};
use crate::query::{QueryError, Segment};

/// Closest crossings as columns, one row per ray. Columns that were not requested are empty, see [`Run::fields`](super::Run).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosestRows {
    /// Infinite for a miss.
    pub t: Vec<f64>,
    /// NaN for a miss and where there is no surface.
    pub normal: Vec<[f64; 3]>,
    /// -1 for a miss.
    pub object: Vec<i32>,
    /// -1 for a miss and where there is no surface.
    pub surface: Vec<i32>,
    /// -1 where there is no triangle.
    pub primitive: Vec<i32>,
    /// -1 for a miss.
    pub path: Vec<i64>,
    /// False for a miss.
    pub entering: Vec<bool>,
    /// A bound on the error of `t`; NaN for a miss.
    pub t_err: Vec<f64>,
}

/// All crossings as columns, one row per crossing, grouped by ray. Columns that were not requested are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossingRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Ascending within a ray.
    pub t: Vec<f64>,
    /// NaN where there is no surface.
    pub normal: Vec<[f64; 3]>,
    /// Whether the ray enters the object.
    pub entering: Vec<bool>,
    /// The object.
    pub object: Vec<i32>,
    /// -1 where there is no surface.
    pub surface: Vec<i32>,
    /// -1 where there is no triangle.
    pub primitive: Vec<i32>,
    /// The instance path.
    pub path: Vec<i64>,
    /// 0 surface, 1 start, 2 end.
    pub kind: Vec<i8>,
    /// A bound on the error of `t`.
    pub t_err: Vec<f64>,
}

/// Segments as columns, one row per segment, grouped by ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SegmentRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Where the segment begins.
    pub t_in: Vec<f64>,
    /// Where the segment ends.
    pub t_out: Vec<f64>,
    /// Its length in world units.
    pub length: Vec<f64>,
    /// -1 for an object without a material.
    pub material: Vec<i32>,
    /// The object.
    pub object: Vec<i32>,
    /// The instance path.
    pub path: Vec<i64>,
    /// The number of overlaps of equal priority.
    pub overlaps: u64,
}

/// What thickness is summed by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// A column for each of [`material_names`](World::material_names), and a last column for objects without a
    /// material.
    #[default]
    Material,
    /// A column for each of [`object_names`](World::object_names).
    Object,
}

impl By {
    /// The number of columns.
    pub fn columns(self, world: &World) -> usize {
        match self {
            By::Material => world.material_names().len() + 1,
            By::Object => world.object_names().len(),
        }
    }

    /// The column of a segment, given the number of columns.
    pub(super) fn column(self, segment: &Segment, columns: usize) -> usize {
        match self {
            By::Material => segment.material.map_or(columns - 1, |material| material as usize),
            By::Object => segment.object as usize,
        }
    }
}

/// The length of each ray in each material or object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thickness {
    /// The lengths of a ray's segments in world units, summed in their order: one row per ray, one value per
    /// column of [`By`].
    pub lengths: Vec<f64>,
    /// The number of columns.
    pub columns: usize,
    /// The number of overlaps of equal priority.
    pub overlaps: u64,
}

/// The objects that contain each point, grouped by point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectRows {
    /// The rows of point `i` are `point_splits[i]..point_splits[i + 1]`.
    pub point_splits: Vec<i64>,
    /// Ascending within a point.
    pub object: Vec<i32>,
}

/// Fields with any number of result rows per input row.
pub(super) trait Ragged: Send {
    /// Creates columns without rows.
    fn empty() -> Self;
    /// The number of result rows.
    fn len(&self) -> usize;
    /// Appends the result rows of the input rows that come next.
    fn append(&mut self, chunk: Self) -> Result<(), TryReserveError>;
}

impl From<TryReserveError> for BatchError {
    fn from(_: TryReserveError) -> BatchError {
        BatchError::OutOfMemory
    }
}

impl From<TryReserveError> for QueryError {
    fn from(_: TryReserveError) -> QueryError {
        QueryError::OutOfMemory
    }
}

/// Creates a column of `rows` copies of a value, to be overwritten.
pub(super) fn blank<T: Clone>(value: T, rows: usize) -> Result<Vec<T>, TryReserveError> {
    // `vec!` lets the operating system provide zeroed memory, but aborts if it cannot: so the allocation is
    // tried first.
    Vec::<T>::new().try_reserve_exact(rows)?;
    Ok(vec![value; rows])
}

fn extend<T>(column: &mut Vec<T>, rows: impl ExactSizeIterator<Item = T>) -> Result<(), TryReserveError> {
    column.try_reserve(rows.len())?;
    column.extend(rows);
    Ok(())
}

fn join<T>(column: &mut Vec<T>, mut rows: Vec<T>) -> Result<(), TryReserveError> {
    column.try_reserve(rows.len())?;
    column.append(&mut rows);
    Ok(())
}

fn join_splits(splits: &mut Vec<i64>, chunk: &[i64]) -> Result<(), TryReserveError> {
    let before = splits.last().copied().unwrap_or(0);
    extend(splits, chunk.iter().skip(1).map(|split| before + split))
}

fn push_split(splits: &mut Vec<i64>, rows: usize) -> Result<(), TryReserveError> {
    extend(splits, [rows as i64].into_iter())
}

fn or_minus_one(x: Option<u32>) -> i32 {
    x.map_or(-1, |x| x as i32)
}

/// The result rows of a chunk of rays, to be written in place; `None` for columns that are not requested.
pub(super) struct ClosestChunk<'a> {
    t: &'a mut [f64],
    normal: Option<&'a mut [[f64; 3]]>,
    object: Option<&'a mut [i32]>,
    surface: Option<&'a mut [i32]>,
    primitive: Option<&'a mut [i32]>,
    path: Option<&'a mut [i64]>,
    entering: Option<&'a mut [bool]>,
    t_err: Option<&'a mut [f64]>,
}

fn fill<T: Copy>(column: &mut Option<&mut [T]>, value: T) {
    if let Some(column) = column {
        column.fill(value);
    }
}

#[inline(always)]
fn put<T>(column: &mut Option<&mut [T]>, i: usize, value: T) {
    if let Some(column) = column {
        column[i] = value;
    }
}

impl ClosestChunk<'_> {
    /// Makes every row a miss.
    pub fn clear(&mut self) {
        self.t.fill(f64::INFINITY);
        fill(&mut self.normal, [f64::NAN; 3]);
        fill(&mut self.object, -1);
        fill(&mut self.surface, -1);
        fill(&mut self.primitive, -1);
        fill(&mut self.path, -1);
        fill(&mut self.entering, false);
        fill(&mut self.t_err, f64::NAN);
    }

    /// Sets a row that is a miss so far.
    #[inline(always)]
    pub fn set(&mut self, i: usize, hit: &RowHit) {
        self.t[i] = hit.t;
        put(&mut self.normal, i, hit.normal.to_array());
        put(&mut self.object, i, hit.object as i32);
        put(&mut self.surface, i, or_minus_one(hit.surface));
        put(&mut self.primitive, i, or_minus_one(hit.primitive));
        put(&mut self.path, i, hit.path as i64);
        put(&mut self.entering, i, hit.entering);
        put(&mut self.t_err, i, hit.t_err);
    }
}

/// Makes a column as long as there are rows, or empty if it is not requested. Memory that it has is kept; what its rows
/// hold is not specified.
fn resize<T: Copy>(
    column: &mut Vec<T>,
    value: T,
    rows: usize,
    is_wanted: bool,
) -> Result<(), TryReserveError> {
    let rows = if is_wanted { rows } else { 0 };
    if column.capacity() < rows {
        *column = blank(value, rows)?;
    } else {
        column.resize(rows, value);
    }
    Ok(())
}

/// Splits a column into chunks, or returns `None` for each chunk if the column is empty.
fn chunks_of<'a, T>(column: &'a mut [T], size: usize) -> impl FnMut() -> Option<Option<&'a mut [T]>> {
    let is_empty = column.is_empty();
    let mut chunks = column.chunks_mut(size);
    move || if is_empty { Some(None) } else { chunks.next().map(Some) }
}

impl ClosestRows {
    /// Makes room for `rows` rows, to be overwritten.
    pub(super) fn resize(&mut self, rows: usize, fields: Fields) -> Result<(), TryReserveError> {
        resize(&mut self.t, 0.0, rows, true)?;
        resize(&mut self.normal, [0.0; 3], rows, fields.contains(Fields::NORMAL))?;
        resize(&mut self.object, 0, rows, fields.contains(Fields::OBJECT))?;
        resize(&mut self.surface, 0, rows, fields.contains(Fields::SURFACE))?;
        resize(&mut self.primitive, 0, rows, fields.contains(Fields::PRIMITIVE))?;
        resize(&mut self.path, 0, rows, fields.contains(Fields::PATH))?;
        resize(&mut self.entering, false, rows, fields.contains(Fields::ENTERING))?;
        resize(&mut self.t_err, 0.0, rows, fields.contains(Fields::T_ERR))
    }

    /// Splits the rows into chunks of `size` rows; the last may be smaller.
    pub(super) fn chunks(&mut self, size: usize) -> impl Iterator<Item = ClosestChunk<'_>> + Send {
        let mut t = self.t.chunks_mut(size);
        let mut normal = chunks_of(&mut self.normal, size);
        let mut object = chunks_of(&mut self.object, size);
        let mut surface = chunks_of(&mut self.surface, size);
        let mut primitive = chunks_of(&mut self.primitive, size);
        let mut path = chunks_of(&mut self.path, size);
        let mut entering = chunks_of(&mut self.entering, size);
        let mut t_err = chunks_of(&mut self.t_err, size);
        std::iter::from_fn(move || {
            Some(ClosestChunk {
                t: t.next()?,
                normal: normal()?,
                object: object()?,
                surface: surface()?,
                primitive: primitive()?,
                path: path()?,
                entering: entering()?,
                t_err: t_err()?,
            })
        })
    }

    /// Appends the rows of further rays.
    pub fn append(&mut self, mut rows: ClosestRows) {
        self.t.append(&mut rows.t);
        self.normal.append(&mut rows.normal);
        self.object.append(&mut rows.object);
        self.surface.append(&mut rows.surface);
        self.primitive.append(&mut rows.primitive);
        self.path.append(&mut rows.path);
        self.entering.append(&mut rows.entering);
        self.t_err.append(&mut rows.t_err);
    }
}

impl CrossingRows {
    /// Removes all rows, and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.ray_splits.clear();
        self.ray_splits.push(0);
        self.t.clear();
        self.normal.clear();
        self.entering.clear();
        self.object.clear();
        self.surface.clear();
        self.primitive.clear();
        self.path.clear();
        self.kind.clear();
        self.t_err.clear();
    }

    /// Appends the crossings of the next rays.
    pub(super) fn push_rays(
        &mut self,
        ListsOfRows { hits, ends, before }: ListsOfRows,
        fields: Fields,
    ) -> Result<(), TryReserveError> {
        let length = self.t.len();
        fn add<T>(
            column: &mut Vec<T>,
            hits: &[RowHit],
            is_wanted: bool,
            value: impl Fn(&RowHit) -> T,
        ) -> Result<(), TryReserveError> {
            if is_wanted { extend(column, hits.iter().map(value)) } else { Ok(()) }
        }
        add(&mut self.t, hits, true, |hit| hit.t)?;
        add(&mut self.normal, hits, fields.contains(Fields::NORMAL), |hit| hit.normal.to_array())?;
        add(&mut self.entering, hits, fields.contains(Fields::ENTERING), |hit| hit.entering)?;
        add(&mut self.object, hits, fields.contains(Fields::OBJECT), |hit| hit.object as i32)?;
        add(&mut self.surface, hits, fields.contains(Fields::SURFACE), |hit| or_minus_one(hit.surface))?;
        add(&mut self.primitive, hits, fields.contains(Fields::PRIMITIVE), |hit| {
            or_minus_one(hit.primitive)
        })?;
        add(&mut self.path, hits, fields.contains(Fields::PATH), |hit| hit.path as i64)?;
        add(&mut self.kind, hits, fields.contains(Fields::KIND), |hit| hit.kind as i8)?;
        add(&mut self.t_err, hits, fields.contains(Fields::T_ERR), |hit| hit.t_err)?;
        extend(&mut self.ray_splits, ends.iter().map(|end| (length + end - before) as i64))
    }
}

impl Ragged for CrossingRows {
    fn empty() -> CrossingRows {
        CrossingRows { ray_splits: vec![0], ..CrossingRows::default() }
    }

    fn len(&self) -> usize {
        self.t.len()
    }

    fn append(&mut self, chunk: CrossingRows) -> Result<(), TryReserveError> {
        join_splits(&mut self.ray_splits, &chunk.ray_splits)?;
        join(&mut self.t, chunk.t)?;
        join(&mut self.normal, chunk.normal)?;
        join(&mut self.entering, chunk.entering)?;
        join(&mut self.object, chunk.object)?;
        join(&mut self.surface, chunk.surface)?;
        join(&mut self.primitive, chunk.primitive)?;
        join(&mut self.path, chunk.path)?;
        join(&mut self.kind, chunk.kind)?;
        join(&mut self.t_err, chunk.t_err)
    }
}

impl SegmentRows {
    /// Removes all rows, and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.ray_splits.clear();
        self.ray_splits.push(0);
        self.t_in.clear();
        self.t_out.clear();
        self.length.clear();
        self.material.clear();
        self.object.clear();
        self.path.clear();
        self.overlaps = 0;
    }

    /// Appends the segments of the next ray.
    pub(super) fn push_ray(&mut self, segments: &[Segment]) -> Result<(), TryReserveError> {
        extend(&mut self.t_in, segments.iter().map(|segment| segment.t_in))?;
        extend(&mut self.t_out, segments.iter().map(|segment| segment.t_out))?;
        extend(&mut self.length, segments.iter().map(|segment| segment.length))?;
        extend(&mut self.material, segments.iter().map(|segment| or_minus_one(segment.material)))?;
        extend(&mut self.object, segments.iter().map(|segment| segment.object as i32))?;
        extend(&mut self.path, segments.iter().map(|segment| segment.path as i64))?;
        push_split(&mut self.ray_splits, self.t_in.len())
    }
}

impl Ragged for SegmentRows {
    fn empty() -> SegmentRows {
        SegmentRows { ray_splits: vec![0], ..SegmentRows::default() }
    }

    fn len(&self) -> usize {
        self.t_in.len()
    }

    fn append(&mut self, chunk: SegmentRows) -> Result<(), TryReserveError> {
        join_splits(&mut self.ray_splits, &chunk.ray_splits)?;
        join(&mut self.t_in, chunk.t_in)?;
        join(&mut self.t_out, chunk.t_out)?;
        join(&mut self.length, chunk.length)?;
        join(&mut self.material, chunk.material)?;
        join(&mut self.object, chunk.object)?;
        join(&mut self.path, chunk.path)?;
        self.overlaps += chunk.overlaps;
        Ok(())
    }
}

impl ObjectRows {
    /// Appends the objects of the next point.
    pub(super) fn push_point(&mut self, objects: &[u32]) -> Result<(), TryReserveError> {
        extend(&mut self.object, objects.iter().map(|&object| object as i32))?;
        push_split(&mut self.point_splits, self.object.len())
    }
}

impl Ragged for ObjectRows {
    fn empty() -> ObjectRows {
        ObjectRows { point_splits: vec![0], object: Vec::new() }
    }

    fn len(&self) -> usize {
        self.object.len()
    }

    fn append(&mut self, chunk: ObjectRows) -> Result<(), TryReserveError> {
        join_splits(&mut self.point_splits, &chunk.point_splits)?;
        join(&mut self.object, chunk.object)
    }
}
