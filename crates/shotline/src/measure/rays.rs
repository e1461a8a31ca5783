//! Measures objects by rays along the axes.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::cells::Cells;
use super::estimate::{COUNT, Estimate, SHIFTS, by_shifts_and_axes, numbers};
use super::extent::Extent;
use super::known::{KnownMoments, Sampled};
use super::leaves::LeafBox;
use super::{Measure, MeasureError, Range, Settings};
use crate::aabb::Aabb;
use crate::compile::{Body, World};
use crate::math::{Affine, Dd, HALF_ULP, Vec3, split_mix64};
use crate::query::batch::Run;
use crate::query::{Caster, Limits, Overlaps, QueryError};
use crate::ray::{Ray, Span};
use crate::scene::{Scene, Units};
use crate::solid::Moments;

/// The strata of a sample: one per axis and shift.
pub(super) const STRATA: usize = 3 * SHIFTS;

/// The number of steps that a ray is always granted on average.
const STEPS_OF_A_RAY: u64 = 1000;

/// The number of rays along each axis from which the cost of all rays is estimated.
const PILOT: usize = 64;

/// If rays meet fewer intervals than this, the samples are too few to show how much they miss.
pub(super) const MIN_INTERVALS: u64 = 16 * SHIFTS as u64;

/// If at least this many rays meet a leaf, their spread shows the error of its volume.
const MIN_RAYS_PER_LEAF: f64 = 16.0;

/// The error of an end of an interval, and of an edge of a cell, in half-ulps of the coordinates.
const ROUNDING: f64 = 32.0;

/// Rays summed by one thread between checks of the cancel flag.
const CHUNK: usize = 1024;

/// Steps that a thread takes before it adds them to the shared count.
const STEP_BATCH: u64 = 1 << 16;

/// The errors of centroid and inertia grow at most by this factor.
const MOST_GROWTH: f64 = 4.0;

/// The number of leaves by which cells are chosen is at most this.
const MOST_LEAVES: usize = 2048;

/// Chunks processed in parallel before their sums are added.
const ROUND: usize = 256;

/// The two steps of the additive sequence, as fractions of 2^64: one over the plastic number, and over its square.
const STEPS: [u64; 2] = [0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1d];

/// Running sums of integrals in the order of [`Moments::from_integrals`].
type Sums = [Dd; 10];

/// The result of casting rays.
struct Samples {
    /// Integrals per shift, over all axes.
    shifts: [[f64; 10]; SHIFTS],
    /// Integrals per axis, over all shifts.
    axes: [[f64; 10]; 3],
    /// The largest difference between the contributions of two rays of one cell. A contribution is the weighted length
    /// inside the object, as a fraction of the length of the box.
    spread: f64,
    /// The sum of the weights of all intervals.
    interval_weight: f64,
}

/// The smallest and largest contribution of a ray in the current cell, and the largest difference in any cell.
#[derive(Default)]
struct Spread {
    cell: Option<usize>,
    low: f64,
    high: f64,
    most: f64,
}

impl Spread {
    fn add(&mut self, cell: usize, ray: f64) {
        let is_new = self.cell.replace(cell) != Some(cell);
        (self.low, self.high) = if is_new { (ray, ray) } else { (self.low.min(ray), self.high.max(ray)) };
        self.most = self.most.max(self.high - self.low);
    }
}

/// The inputs that are the same for all objects.
pub(super) struct Rays<'a> {
    pub world: &'a World,
    pub settings: &'a Settings,
    pub run: Run<'a>,
    /// For each object that may need rays, by index, the boxes of its leaves.
    pub leaves: Vec<Vec<LeafBox>>,
}

/// An object to be sampled, with the work done so far.
struct Task {
    object: u32,
    centre: Vec3,
    half: Vec3,
    /// Rays per shift and axis.
    rays: usize,
    /// How these rays are distributed over the square across each axis.
    cells: [Cells; 3],
    /// Intervals found.
    intervals: AtomicU64,
    /// Boxes and bodies visited to find them.
    steps: AtomicU64,
    most_steps: u64,
}

impl Task {
    /// Estimates how many rays along an axis meet a leaf. The leaf is approximated by the ellipsoid of the same
    /// moments.
    fn rays_through(&self, leaf: &LeafBox, moments: &Moments, axis: usize) -> f64 {
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let sample_point = |v: Vec3| across.map(|k| ((v - self.centre) / self.half)[k]);
        let (low, high) = (sample_point(leaf.bounds.min), sample_point(leaf.bounds.max));
        let shadow = (high[0] - low[0]) * (high[1] - low[1]);
        // In the coordinates of the square. The semi-axes of an ellipsoid are those of its covariance times the square
        // root of 5.
        let [i, j] = across;
        let entry =
            |i: usize, j: usize| 5.0 * moments.second[i][j] / moments.volume / self.half[i] / self.half[j];
        let area =
            std::f64::consts::PI * (entry(i, i) * entry(j, j) - entry(i, j) * entry(j, i)).max(0.0).sqrt();
        let rays = self.cells[axis].rays_in(low, high, self.rays) * SHIFTS as f64;
        // A leaf without volume cannot be missed.
        if shadow > 0.0 && area >= 0.0 { rays * (area / shadow).min(1.0) } else { f64::INFINITY }
    }
}

impl Rays<'_> {
    /// Checks that an object has an inside.
    ///
    /// # Errors
    /// [`MeasureError`] if it has none.
    pub(super) fn check(&self, object: u32, extent: &Extent) -> Result<(), MeasureError> {
        if let Some(Body::Surface(surface)) = extent.open.map(|body| self.world.body(body)) {
            let why = surface.mesh.topology().why_open();
            return Err(MeasureError::Query(QueryError::NotASolid { object: self.name(object), why }));
        }
        Ok(())
    }

    /// Measures an object that has passed [`Rays::check`].
    ///
    /// # Errors
    /// [`MeasureError`].
    pub(super) fn measure(
        &self,
        scene: &Scene,
        object: u32,
        extent: &Extent,
    ) -> Result<Measure, MeasureError> {
        let (numbers, rays) = self.numbers(object, extent)?;
        if let Some(range) = Range::of_volume(numbers[0].value, &extent.bounds) {
            return Err(MeasureError::OutOfRange { object: self.name(object), range });
        }
        let material = self.world.object_material(object).and_then(|m| scene.materials.get(m as usize));
        let density = material.and_then(|(_, material)| material.density);
        let mass_of_one = scene.units.map_or(1.0, Units::cubic_centimetres);
        Ok(Measure {
            object,
            volume: numbers[0],
            mass: density.map(|density| numbers[0].times(density * mass_of_one)),
            centroid: [numbers[1], numbers[2], numbers[3]],
            inertia: std::array::from_fn(|i| std::array::from_fn(|j| numbers[4 + 3 * i + j])),
            exact: rays == 0 && !extent.is_unbounded(),
            bounds: extent.bounds,
            rays,
        })
    }

    /// Returns volume, centroid and inertia, and the number of rays that were cast for them.
    fn numbers(&self, object: u32, extent: &Extent) -> Result<([Estimate; COUNT], usize), MeasureError> {
        let bounds = extent.bounds;
        let skipped = || {
            if let Some(progress) = self.run.progress {
                progress(self.settings.rays as u64);
            }
        };
        if extent.is_unbounded() {
            skipped();
            return Ok(([Estimate { value: f64::NAN, std_error: f64::NAN }; COUNT], 0));
        }
        // Boxes are conservative: an object with a flat box has no volume.
        let flat = !bounds.min.cmplt(bounds.max).all();
        let nothing = || flat.then_some(KnownMoments::Exactly(Moments::EMPTY));
        match extent.moments.clone().or_else(nothing) {
            Some(KnownMoments::Exactly(moments)) => {
                skipped();
                Ok((numbers(&moments).map(|value| Estimate { value, std_error: 0.0 }), 0))
            }
            Some(KnownMoments::Sampled(sampled)) => Ok(self.partly(&sampled, &bounds)),
            None => self.by_rays(object, &bounds),
        }
    }

    /// The estimates for an object of which a part has been sampled.
    fn partly(&self, sampled: &Sampled, bounds: &Aabb) -> ([Estimate; COUNT], usize) {
        let centre = bounds.centre();
        let shifts = sampled.moments.map(|moments| moments.integrals_from(centre));
        let axes = sampled.axes.map(|moments| moments.integrals_from(centre));
        let mut numbers = by_shifts_and_axes(&shifts, &axes, &Affine::translation(centre));
        add_missed_volume(&mut numbers, sampled.unseen, bounds);
        let rays = self.settings.rays.div_ceil(STRATA).max(1).saturating_mul(STRATA);
        (numbers, rays.saturating_mul(sampled.solids.len()))
    }

    fn by_rays(&self, object: u32, bounds: &Aabb) -> Result<([Estimate; COUNT], usize), MeasureError> {
        let rays = self.settings.rays.div_ceil(STRATA).max(1);
        let all_rays = rays.saturating_mul(STRATA);
        let (centre, half) = (bounds.centre(), bounds.size() * 0.5);
        let most_steps = self.run.most_rows.max((all_rays as u64).saturating_mul(STEPS_OF_A_RAY));
        let cells = self.cells(object, bounds, rays);
        let (intervals, steps) = (AtomicU64::new(0), AtomicU64::new(0));
        let task = Task { object, centre, half, rays, cells, intervals, steps, most_steps };
        self.expect_affordable(&task)?;
        let Samples { shifts, axes, spread, interval_weight } = self.samples(&task)?;
        let world_from_box = Affine::translation(centre).then_after(&Affine::scaling(half));
        let mut numbers = by_shifts_and_axes(&shifts, &axes, &world_from_box);
        let rare = self.rarely_met(&task);
        let (met, share) = (task.intervals.into_inner(), bounds.size().element_product() / all_rays as f64);
        add_largest_contribution(&mut numbers, spread * share);
        if met < MIN_INTERVALS {
            let weight = task.cells.iter().map(Cells::most_weight).fold(0.0, f64::max);
            add_missed_volume(&mut numbers, weight * share, bounds);
        }
        add_missed_volume(&mut numbers, rare, bounds);
        // The error of both ends of an interval, as a fraction of the length of the box.
        let off = ROUNDING * HALF_ULP * (Vec3::ONE + (centre / half).abs()).max_element();
        add_missed_volume(&mut numbers, off * share * interval_weight, bounds);
        Ok((numbers, all_rays))
    }

    /// Returns the error of leaves that too few rays meet for their spread to show it. All leaves that are expected to
    /// meet no ray may be missed at once, so their volumes add up; the errors of the others are independent.
    fn rarely_met(&self, task: &Task) -> f64 {
        let (mut missing, mut squares) = (0.0, 0.0);
        for leaf in self.leaves.get(task.object as usize).into_iter().flatten() {
            let Some(moments) = leaf.moments else { continue };
            let rays: f64 = (0..3).map(|axis| task.rays_through(leaf, &moments, axis)).sum();
            let volume = moments.volume.abs();
            match rays {
                0.0..1.0 => missing += volume,
                1.0..MIN_RAYS_PER_LEAF => squares += volume * volume / rays,
                _ => {}
            }
        }
        missing + squares.sqrt()
    }

    /// Computes the cells across each axis from the leaves in the box of an object.
    fn cells(&self, object: u32, bounds: &Aabb, rays: usize) -> [Cells; 3] {
        // Where other objects may own a part, their edges count too.
        let alone = self.settings.overlaps == Overlaps::All;
        let others = if alone { &[] } else { &self.leaves[..] };
        let leaves = self.leaves.get(object as usize).into_iter().chain(others).flatten();
        let met = leaves.filter(|leaf| !leaf.bounds.intersection(bounds).is_empty());
        let leaves: Vec<Aabb> = met.take(MOST_LEAVES).map(|leaf| leaf.bounds).collect();
        [0, 1, 2].map(|axis| Cells::new(bounds, &leaves, axis, rays))
    }

    /// Checks, by a few rays of a task, that all of them together will not take too many steps.
    ///
    /// # Errors
    /// [`MeasureError::TooMany`], and those of rays.
    fn expect_affordable(&self, task: &Task) -> Result<(), MeasureError> {
        let mut caster = Caster::new(self.world);
        caster.watch(self.run.watch());
        let (mut steps, mut cast, mut intervals) = (0u64, 0u64, Vec::new());
        for axis in 0..3 {
            for i in (0..task.rays).step_by(task.rays.div_ceil(PILOT)) {
                let (_, cell) = task.cells[axis].of(i);
                let mut at = Vec3::ZERO;
                // Any index but 0, which is the corner of the cell.
                [at[(axis + 1) % 3], at[(axis + 2) % 3]] = cell.sample_point(sample_point(i + 1, [0; 2]));
                intervals.clear();
                steps += self.intervals(&mut caster, task, at, axis, &mut intervals)?;
                cast += 1;
            }
        }
        let each = steps.div_ceil(cast.max(1));
        if each.saturating_mul((task.rays * STRATA) as u64) <= task.most_steps {
            return Ok(());
        }
        let rays = (self.run.most_rows / each) as usize / STRATA * STRATA;
        Err(MeasureError::TooMany { object: self.name(task.object), rays })
    }

    /// Computes the integrals over the object for each shift and for each axis, in coordinates in which its box reaches
    /// from -1 to 1.
    fn samples(&self, task: &Task) -> Result<Samples, MeasureError> {
        let (mut shifts, mut axes) = ([[Dd::ZERO; 10]; SHIFTS], [[Dd::ZERO; 10]; 3]);
        let (mut spread, mut interval_weight) = (0.0f64, 0.0);
        let chunks = task.rays.div_ceil(CHUNK);
        let mut round = 0..0;
        while round.end < chunks * STRATA {
            round = round.end..(round.end + ROUND).min(chunks * STRATA);
            let one = |caster: &mut Caster, job: usize| self.chunk(caster, task, job / chunks, job % chunks);
            let caster = || {
                let mut caster = Caster::new(self.world);
                caster.watch(self.run.watch());
                caster
            };
            let parts: Vec<_> = round.clone().into_par_iter().map_init(caster, one).collect();
            // In order, so that sums have the same bits for any number of threads.
            for (job, part) in round.clone().zip(parts) {
                let (stratum, (part, own, intervals)) = (job / chunks, part?);
                (spread, interval_weight) = (spread.max(own), interval_weight + intervals);
                for sum in [&mut shifts[stratum / 3], &mut axes[stratum % 3]] {
                    *sum = std::array::from_fn(|i| sum[i] + part[i]);
                }
            }
        }
        // The rays of each axis alone estimate the whole. Each ray represents a part of the square [-1, 1] x [-1, 1].
        let mean =
            |sums: Sums, strata: usize| sums.map(|sum| sum.hi * (4.0 / (strata as f64 * task.rays as f64)));
        let (shifts, axes) = (shifts.map(|sums| mean(sums, 3)), axes.map(|sums| mean(sums, SHIFTS)));
        Ok(Samples { shifts, axes, spread, interval_weight })
    }

    /// Casts the rays of one chunk of a stratum (an axis and a shift). Returns their sums for the integrals, the
    /// largest difference between two of them, and the sum of the weights of their intervals.
    fn chunk(
        &self,
        caster: &mut Caster,
        task: &Task,
        stratum: usize,
        chunk: usize,
    ) -> Result<(Sums, f64, f64), MeasureError> {
        if self.run.cancel.is_some_and(|c| c.load(Ordering::Relaxed)) {
            return Err(MeasureError::Cancelled);
        }
        let axis = stratum % 3;
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let key = split_mix64(split_mix64(self.settings.seed) ^ u64::from(task.object)) ^ stratum as u64;
        let (mut sums, mut spread) = ([Dd::ZERO; 10], Spread::default());
        let (mut intervals, mut met, mut taken, mut interval_weight) = (Vec::new(), 0, 0, 0.0);
        let rays = chunk * CHUNK..((chunk + 1) * CHUNK).min(task.rays);
        let cast = rays.len() as u64;
        for i in rays {
            let (number, cell) = task.cells[axis].of(i);
            // Each cell has its own sequence.
            let key = key ^ (number as u64) << 32;
            let point = sample_point(i - cell.first, [split_mix64(key), split_mix64(key ^ (1 << 63))]);
            let mut sample_point = Vec3::ZERO;
            [sample_point[across[0]], sample_point[across[1]]] = cell.sample_point(point);
            intervals.clear();
            let steps = self.intervals(caster, task, sample_point, axis, &mut intervals)?;
            (met, taken) = (met + intervals.len() as u64, taken + steps);
            interval_weight += cell.weight * intervals.len() as f64;
            if taken > STEP_BATCH {
                self.count(task, std::mem::take(&mut taken))?;
            }
            let length: f64 = intervals.iter().map(|[from, to]| to - from).sum();
            spread.add(number, 0.5 * length * cell.weight);
            for &interval in &intervals {
                let terms = integrals(sample_point, axis, interval);
                sums = std::array::from_fn(|k| sums[k] + Dd::from(terms[k] * cell.weight));
            }
        }
        task.intervals.fetch_add(met, Ordering::Relaxed);
        self.count(task, taken)?;
        let done = caster.take_counters();
        if let Some(mut counters) = self.run.counters.and_then(|counters| counters.lock().ok()) {
            *counters += done;
        }
        if let Some(progress) = self.run.progress {
            progress(cast);
        }
        Ok((sums, spread.most, interval_weight))
    }

    /// Appends the intervals inside the object, from -1 to 1, of the ray along an axis through a point of its box.
    /// Returns the number of boxes and bodies visited.
    fn intervals(
        &self,
        caster: &mut Caster,
        task: &Task,
        sample_point: Vec3,
        axis: usize,
        out: &mut Vec<[f64; 2]>,
    ) -> Result<u64, MeasureError> {
        let ray = Ray::new(task.centre + sample_point * task.half, Vec3::AXES[axis] * task.half[axis]);
        // Ray creation fails only if the box is too far from the origin; there are no intervals then.
        let (Ok(ray), Ok(span)) = (ray, Span::new(-1.0, 1.0)) else { return Ok(0) };
        let result = match self.settings.overlaps {
            Overlaps::All => {
                let left = task.most_steps.saturating_sub(task.steps.load(Ordering::Relaxed));
                let limits = Limits::default();
                caster.limit(Limits { steps: left.min(limits.steps), ..limits });
                caster.object_intervals(task.object, &ray, span, out)
            }
            overlaps => {
                let mut segments = Vec::new();
                let result = caster.segments(&ray, span, overlaps, &mut segments);
                let own = segments.iter().filter(|segment| segment.object == task.object);
                out.extend(own.map(|segment| [segment.t_in, segment.t_out]));
                result.map(|_| segments.len() as u64)
            }
        };
        result.map_err(|error| match error {
            QueryError::Cancelled => MeasureError::Cancelled,
            QueryError::TooMany { .. } | QueryError::TooLong { .. } => {
                // Stop the other threads too.
                task.steps.fetch_max(task.most_steps, Ordering::Relaxed);
                MeasureError::TooMany { object: self.name(task.object), rays: 0 }
            }
            error => MeasureError::Query(error),
        })
    }

    fn count(&self, task: &Task, steps: u64) -> Result<(), MeasureError> {
        let too_many = task.steps.fetch_add(steps, Ordering::Relaxed) + steps > task.most_steps;
        if too_many {
            return Err(MeasureError::TooMany { object: self.name(task.object), rays: 0 });
        }
        Ok(())
    }

    fn name(&self, object: u32) -> String {
        self.world.object_names()[object as usize].clone()
    }
}

/// Adds to the errors the effect of one ray more or less among those that contribute most. This matters where few rays
/// contribute most of the volume: at the rim of a thin shell. The other errors grow in proportion to that of the
/// volume, at most by [`MOST_GROWTH`].
fn add_largest_contribution(numbers: &mut [Estimate; COUNT], volume: f64) {
    let before = numbers[0].std_error;
    let after = before.hypot(volume);
    let growth = if before > 0.0 { (after / before).min(MOST_GROWTH) } else { 1.0 };
    numbers.iter_mut().for_each(|number| number.std_error *= growth);
    numbers[0].std_error = after;
}

/// Adds to the errors the effect of having missed such a volume in a corner of the box.
fn add_missed_volume(numbers: &mut [Estimate; COUNT], unseen: f64, bounds: &Aabb) {
    if unseen == 0.0 {
        return;
    }
    let size = bounds.size();
    let shift = size * (unseen / (numbers[0].value + unseen));
    let change = [unseen, shift.x, shift.y, shift.z].into_iter();
    let change = change.chain(std::iter::repeat(unseen * size.length_squared()));
    let add = |(number, change): (&mut Estimate, f64)| number.std_error = number.std_error.hypot(change);
    numbers.iter_mut().zip(change).for_each(add);
}

/// The integrals of all terms over an interval of a ray along an axis.
fn integrals(sample_point: Vec3, axis: usize, [from, to]: [f64; 2]) -> [f64; 10] {
    let length = to - from;
    // Along the axis the means of the coordinate and of its square, across the axis the coordinates themselves.
    let (mut mean, mut square) = (sample_point, sample_point * sample_point);
    mean[axis] = from.midpoint(to);
    square[axis] = (from * from + from * to + to * to) / 3.0;
    let Vec3 { x, y, z } = mean;
    [1.0, x, y, z, square.x, square.y, square.z, y * z, x * z, x * y].map(|mean| mean * length)
}

/// Returns point `i` of the shifted sequence in the square from -1 to 1.
pub(super) fn sample_point(i: usize, shift: [u64; 2]) -> [f64; 2] {
    std::array::from_fn(|k| {
        let step = STEPS[k].wrapping_mul(i as u64).wrapping_add(shift[k]);
        // The middle of one of 2^53 equal cells, up to rounding.
        ((step >> 11) as f64 + 0.5) / (1u64 << 52) as f64 - 1.0
    })
}
