//! The answers as columns.

use crate::compile::World;
use crate::query::{Hit, Segment};

/// Closest crossings as columns, a row a ray.
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

/// All crossings as columns, a row a crossing, grouped by ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossingRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Ascending within a ray.
    pub t: Vec<f64>,
    /// NaN where there is no surface.
    pub normal: Vec<[f64; 3]>,
    /// Whether the ray passes into the object.
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

/// Segments as columns, a row a segment, grouped by ray.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SegmentRows {
    /// The rows of ray `i` are `ray_splits[i]..ray_splits[i + 1]`.
    pub ray_splits: Vec<i64>,
    /// Where it begins.
    pub t_in: Vec<f64>,
    /// Where it ends.
    pub t_out: Vec<f64>,
    /// Its length in world units.
    pub length: Vec<f64>,
    /// -1 for an object without a material.
    pub material: Vec<i32>,
    /// The object.
    pub object: Vec<i32>,
    /// The instance path.
    pub path: Vec<i64>,
    /// How many overlaps of equal priority were met.
    pub overlaps: u64,
}

/// What thickness is counted by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// A column for each of [`material_names`](World::material_names), and a last one for objects without a material.
    #[default]
    Material,
    /// A column for each of [`object_names`](World::object_names).
    Object,
}

impl By {
    /// How many columns there are.
    pub fn columns(self, world: &World) -> usize {
        match self {
            By::Material => world.material_names().len() + 1,
            By::Object => world.object_names().len(),
        }
    }

    /// The column of a segment, where there are so many.
    pub(super) fn column(self, segment: &Segment, columns: usize) -> usize {
        match self {
            By::Material => segment.material.map_or(columns - 1, |material| material as usize),
            By::Object => segment.object as usize,
        }
    }
}

/// How far each ray goes through each material or object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Thickness {
    /// The lengths of a ray's segments in world units, added up in their order: a row a ray, in it a number for each
    /// column of [`By`].
    pub lengths: Vec<f64>,
    /// How many columns a row has.
    pub columns: usize,
    /// How many overlaps of equal priority were met.
    pub overlaps: u64,
}

/// The objects that hold each point, grouped by point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectRows {
    /// The rows of point `i` are `point_splits[i]..point_splits[i + 1]`.
    pub point_splits: Vec<i64>,
    /// Ascending within a point.
    pub object: Vec<i32>,
}

/// Columns with any number of rows for each that was asked about.
pub(super) trait Ragged: Send {
    /// Without any.
    fn empty() -> Self;
    /// How many rows there are.
    fn len(&self) -> usize;
    /// Appends the rows of those that come next.
    fn append(&mut self, part: Self);
}

fn append_splits(splits: &mut Vec<i64>, part: &[i64]) {
    let before = splits.last().copied().unwrap_or(0);
    splits.extend(part.iter().skip(1).map(|split| before + split));
}

fn or_minus_one(x: Option<u32>) -> i32 {
    x.map_or(-1, |x| x as i32)
}

/// The rows of a chunk of rays, to be written in place.
pub(super) struct ClosestPart<'a> {
    t: &'a mut [f64],
    normal: &'a mut [[f64; 3]],
    object: &'a mut [i32],
    surface: &'a mut [i32],
    primitive: &'a mut [i32],
    path: &'a mut [i64],
    entering: &'a mut [bool],
    t_err: &'a mut [f64],
}

impl ClosestPart<'_> {
    pub fn set(&mut self, i: usize, hit: Option<Hit>) {
        self.t[i] = hit.map_or(f64::INFINITY, |h| h.t);
        self.normal[i] = hit.map_or([f64::NAN; 3], |h| h.normal.to_array());
        self.object[i] = or_minus_one(hit.map(|h| h.object));
        self.surface[i] = or_minus_one(hit.and_then(|h| h.surface));
        self.primitive[i] = or_minus_one(hit.and_then(|h| h.primitive));
        self.path[i] = hit.map_or(-1, |h| h.path as i64);
        self.entering[i] = hit.is_some_and(|h| h.entering);
        self.t_err[i] = hit.map_or(f64::NAN, |h| h.t_err);
    }
}

impl ClosestRows {
    /// So many rows, to be written.
    pub(super) fn blank(rows: usize) -> ClosestRows {
        ClosestRows {
            t: vec![0.0; rows],
            normal: vec![[0.0; 3]; rows],
            object: vec![0; rows],
            surface: vec![0; rows],
            primitive: vec![0; rows],
            path: vec![0; rows],
            entering: vec![false; rows],
            t_err: vec![0.0; rows],
        }
    }

    /// The rows in parts of one size; the last may be smaller.
    pub(super) fn parts(&mut self, size: usize) -> impl Iterator<Item = ClosestPart<'_>> + Send {
        let (mut t, mut normal) = (self.t.chunks_mut(size), self.normal.chunks_mut(size));
        let (mut object, mut surface) = (self.object.chunks_mut(size), self.surface.chunks_mut(size));
        let (mut primitive, mut path) = (self.primitive.chunks_mut(size), self.path.chunks_mut(size));
        let (mut entering, mut t_err) = (self.entering.chunks_mut(size), self.t_err.chunks_mut(size));
        std::iter::from_fn(move || {
            Some(ClosestPart {
                t: t.next()?,
                normal: normal.next()?,
                object: object.next()?,
                surface: surface.next()?,
                primitive: primitive.next()?,
                path: path.next()?,
                entering: entering.next()?,
                t_err: t_err.next()?,
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
    /// Appends the crossings of the next ray.
    pub(super) fn push_ray(&mut self, hits: &[Hit]) {
        self.t.extend(hits.iter().map(|hit| hit.t));
        self.normal.extend(hits.iter().map(|hit| hit.normal.to_array()));
        self.entering.extend(hits.iter().map(|hit| hit.entering));
        self.object.extend(hits.iter().map(|hit| hit.object as i32));
        self.surface.extend(hits.iter().map(|hit| or_minus_one(hit.surface)));
        self.primitive.extend(hits.iter().map(|hit| or_minus_one(hit.primitive)));
        self.path.extend(hits.iter().map(|hit| hit.path as i64));
        self.kind.extend(hits.iter().map(|hit| hit.kind as i8));
        self.t_err.extend(hits.iter().map(|hit| hit.t_err));
        self.ray_splits.push(self.t.len() as i64);
    }
}

impl Ragged for CrossingRows {
    fn empty() -> CrossingRows {
        CrossingRows { ray_splits: vec![0], ..CrossingRows::default() }
    }

    fn len(&self) -> usize {
        self.t.len()
    }

    fn append(&mut self, mut part: CrossingRows) {
        append_splits(&mut self.ray_splits, &part.ray_splits);
        self.t.append(&mut part.t);
        self.normal.append(&mut part.normal);
        self.entering.append(&mut part.entering);
        self.object.append(&mut part.object);
        self.surface.append(&mut part.surface);
        self.primitive.append(&mut part.primitive);
        self.path.append(&mut part.path);
        self.kind.append(&mut part.kind);
        self.t_err.append(&mut part.t_err);
    }
}

impl SegmentRows {
    /// Appends the segments of the next ray.
    pub(super) fn push_ray(&mut self, segments: &[Segment]) {
        self.t_in.extend(segments.iter().map(|segment| segment.t_in));
        self.t_out.extend(segments.iter().map(|segment| segment.t_out));
        self.length.extend(segments.iter().map(|segment| segment.length));
        self.material.extend(segments.iter().map(|segment| or_minus_one(segment.material)));
        self.object.extend(segments.iter().map(|segment| segment.object as i32));
        self.path.extend(segments.iter().map(|segment| segment.path as i64));
        self.ray_splits.push(self.t_in.len() as i64);
    }
}

impl Ragged for SegmentRows {
    fn empty() -> SegmentRows {
        SegmentRows { ray_splits: vec![0], ..SegmentRows::default() }
    }

    fn len(&self) -> usize {
        self.t_in.len()
    }

    fn append(&mut self, mut part: SegmentRows) {
        append_splits(&mut self.ray_splits, &part.ray_splits);
        self.t_in.append(&mut part.t_in);
        self.t_out.append(&mut part.t_out);
        self.length.append(&mut part.length);
        self.material.append(&mut part.material);
        self.object.append(&mut part.object);
        self.path.append(&mut part.path);
        self.overlaps += part.overlaps;
    }
}

impl ObjectRows {
    /// Appends the objects of the next point.
    pub(super) fn push_point(&mut self, objects: &[u32]) {
        self.object.extend(objects.iter().map(|&object| object as i32));
        self.point_splits.push(self.object.len() as i64);
    }
}

impl Ragged for ObjectRows {
    fn empty() -> ObjectRows {
        ObjectRows { point_splits: vec![0], object: Vec::new() }
    }

    fn len(&self) -> usize {
        self.object.len()
    }

    fn append(&mut self, mut part: ObjectRows) {
        append_splits(&mut self.point_splits, &part.point_splits);
        self.object.append(&mut part.object);
    }
}
