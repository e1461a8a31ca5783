//! From rows of pixels to their owners.

use std::ops::Range;

use rayon::prelude::*;
use shotline::compile::World;
use shotline::math::{HALF_ULP, Vec3};
use shotline::pool;
use shotline::query::batch::{BatchCaster, Run};
use shotline::query::{Caster, Overlaps};
use shotline::ray::{Ray, Span};

use super::SliceError;
use super::area::{self, Area};
use super::conflicts::{self, ConflictPart, PairInConflict, RowConflict};
use super::plane::SlicePlane;
use crate::clip_plane::MARGIN;
use crate::error::{MAX_PIXELS, MAX_SIDE};

/// The rows that a thread takes at a time.
const ROWS: usize = 16;

/// What is sliced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceSettings {
    /// The plane.
    pub plane: SlicePlane,
    /// The part of it that is shown. Default: what is around the bounded objects in the plane.
    pub area: Option<Area>,
    /// Columns and rows of pixels. Default: 800 on the longer side, and square pixels.
    pub size: Option<(u32, u32)>,
}

/// An interval of a row with one owner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Where it begins and ends, in columns from the left side.
    pub columns: [f64; 2],
    /// The object.
    pub object: u32,
    /// Its material.
    pub material: Option<u32>,
    /// The instance path.
    pub path: u64,
}

/// The owners of the pixels of a plane: rows from the top, each from the left.
///
/// The rows are beside the plane, on the side that a picture cut by it keeps, and below the middles of the pixels, by some
/// units of rounding of the largest coordinate. So a face in the plane or along a row is not run along: the plane shows what
/// begins below it, as the cut of a picture does.
#[derive(Clone, Debug)]
pub struct Slice {
    /// The plane.
    pub plane: SlicePlane,
    /// The part of the plane.
    pub area: Area,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The number of the object that owns each pixel; -1 where there is none.
    pub object: Vec<i32>,
    /// The number of its material; -1 where there is none.
    pub material: Vec<i32>,
    /// The number of its instance path; -1 where there is none.
    pub path: Vec<i64>,
    /// For each pixel, the pair of objects in conflict there, an index into `pairs`; -1 where there is none.
    pub overlap: Vec<i32>,
    /// The objects that overlap, or stick out of what contains and clips them.
    pub pairs: Vec<PairInConflict>,
    /// For each row, the intervals with one owner, in ascending order.
    pub rows: Vec<Vec<Part>>,
    /// For each row, the intervals in which objects are in conflict.
    pub conflicts: Vec<Vec<ConflictPart>>,
}

impl Slice {
    /// The width and the height of a pixel, in world units.
    pub fn pixel_size(&self) -> [f64; 2] {
        let [width, height] = self.area.size();
        [width / f64::from(self.width), height / f64::from(self.height)]
    }

    /// The world coordinates of a position in the picture: columns from the left side and rows from the top.
    pub fn point(&self, [column, row]: [f64; 2]) -> Vec3 {
        let [width, height] = self.pixel_size();
        self.plane.at(self.area.min[0] + column * width, self.area.max[1] - row * height)
    }
}

/// The owners of the pixels of a plane.
///
/// # Errors
/// [`SliceError`]: a size or an area out of range, a mesh that is not closed, a row beyond its limits, cancelled.
pub fn slice(world: &World, settings: &SliceSettings, run: Run) -> Result<Slice, SliceError> {
    let plane = settings.plane;
    let (area, (width, height)) = area::frame(world, &plane, settings.area, settings.size)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MAX_PIXELS || width.max(height) > MAX_SIDE {
        return Err(SliceError::Size { width, height });
    }
    let rays = rays(world, &plane, &area, (width, height))?;
    let span = Span::new(0.5, f64::from(width) + 0.5).map_err(|_| SliceError::Overflow)?;
    let all = || {
        let casters = || (BatchCaster::new(world, run), watched(world, run));
        let cast = |casters: &mut (BatchCaster, Caster), rays: &[Ray]| cast_rows(casters, rays, span, run);
        rays.par_chunks(ROWS).map_init(casters, cast).collect::<Vec<_>>()
    };
    let blocks = match run.pool {
        Some(pool) => pool.install(all),
        None => pool::on_threads(run.threads, |_| all()),
    };
    let (mut rows, mut conflicts) = (Vec::with_capacity(rays.len()), Vec::with_capacity(rays.len()));
    for block in blocks {
        let (parts, found) = block?;
        rows.extend(parts);
        conflicts.extend(found);
    }
    let (pairs, conflicts) = conflicts::by_pair(conflicts);
    let blank = vec![-1; pixels as usize];
    let mut slice = Slice {
        plane,
        area,
        width,
        height,
        object: blank.clone(),
        material: blank.clone(),
        path: vec![-1; pixels as usize],
        overlap: blank,
        pairs,
        rows,
        conflicts,
    };
    slice.fill();
    Ok(slice)
}

/// The rays along the rows: the middle of the first pixel is at `t` = 1, that of the next one at `t` = 2.
fn rays(
    world: &World,
    plane: &SlicePlane,
    area: &Area,
    (width, height): (u32, u32),
) -> Result<Vec<Ray>, SliceError> {
    let [column, row] = [area.size()[0] / f64::from(width), area.size()[1] / f64::from(height)];
    let bounds = world.finite_bounds();
    let corners = [plane.at(area.min[0], area.min[1]), plane.at(area.max[0], area.max[1])];
    let all = corners.into_iter().chain([bounds.min, bounds.max]);
    let largest = all.map(|p| p.abs().max_element()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let beside = MARGIN * HALF_ULP * largest;
    let ray = |i: u32| {
        let v = area.max[1] - (f64::from(i) + 0.5) * row;
        let origin = plane.at(area.min[0] - 0.5 * column, v - beside) - plane.normal() * beside;
        Ray::new(origin, plane.u() * column).map_err(|_| SliceError::Overflow)
    };
    (0..height).map(ray).collect()
}

fn watched<'w>(world: &'w World, run: Run<'w>) -> Caster<'w> {
    let mut caster = Caster::new(world);
    caster.watch(run.watch());
    caster
}

type Rows = (Vec<Vec<Part>>, Vec<Vec<RowConflict>>);

fn cast_rows(
    (casters, caster): &mut (BatchCaster, Caster),
    rays: &[Ray],
    span: Span,
    run: Run,
) -> Result<Rows, SliceError> {
    let mut parts = vec![Vec::new(); rays.len()];
    casters.segments(rays, span, Overlaps::Priority, |row, segments| {
        let part = |s: &shotline::query::Segment| Part {
            columns: [s.t_in - 0.5, s.t_out - 0.5],
            object: s.object,
            material: s.material,
            path: s.path,
        };
        parts[row] = segments.iter().map(part).collect();
    })?;
    let mut found = Vec::new();
    let conflicts: Result<_, _> =
        rays.iter().map(|ray| conflicts::on_row(caster, ray, span, &mut found)).collect();
    let conflicts = conflicts?;
    if let Some(progress) = run.progress {
        progress(rays.len() as u64);
    }
    Ok((parts, conflicts))
}

impl Slice {
    /// Writes what owns the rows into the pixels.
    fn fill(&mut self) {
        let width = self.width as usize;
        for (row, (parts, conflicts)) in self.rows.iter().zip(&self.conflicts).enumerate() {
            let first = row * width;
            for part in parts {
                let pixels = pixels(part.columns, width);
                let pixels = first + pixels.start..first + pixels.end;
                self.object[pixels.clone()].fill(part.object as i32);
                self.material[pixels.clone()].fill(part.material.map_or(-1, |m| m as i32));
                self.path[pixels].fill(part.path as i64);
            }
            for part in conflicts {
                let pixels = pixels(part.columns, width);
                self.pairs[part.pair as usize].pixels += pixels.len() as u64;
                self.overlap[first + pixels.start..first + pixels.end].fill(part.pair as i32);
            }
        }
    }
}

/// The pixels whose middles are in an interval of columns: its begin counts, its end does not.
pub(super) fn pixels([from, to]: [f64; 2], width: usize) -> Range<usize> {
    let column = |x: f64| ((x - 0.5).ceil().max(0.0) as usize).min(width);
    column(from)..column(to).max(column(from))
}
