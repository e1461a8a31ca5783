//! Batches on the calling thread.

use std::sync::atomic::Ordering;

use super::rays::{RayRows, Rays, Rows};
use super::run::{Run, block_error, plan_of, row_error};
use super::worker::{Worker, empty};
use super::{BatchError, ClosestRows, block};
use crate::compile::World;
use crate::counters::Counters;
use crate::query::block_caster::{BlockCaster, BlockError, BlockMemory, BlockPlan};
use crate::query::caster::all_solid;
use crate::query::row_block::RowBlock;
use crate::query::row_hit::RowHit;
use crate::query::{Caster, CoherenceHint, Overlaps, QueryError, Scope, Segment};
use crate::ray::{Ray, Span};

/// Casts batches on the calling thread, and uses its memory again from one to the next.
///
/// It is for rays that depend on the results of others, such as those of a picture: they come in many batches of some
/// hundreds or thousands. Results have the bits of [`Caster`].
///
/// ```
/// # use shotline::{compile, math::Vec3, scene::Scene};
/// use shotline::query::batch::{BatchCaster, ClosestRows, Run};
/// use shotline::ray::{Ray, Span};
/// # let mut scene = Scene::default();
/// # let ball = scene.add_solid("sphere", &[&[2.0]]).unwrap();
/// # scene.add_object("ball", None, ball);
/// # let world = compile::compile(&scene, compile::Options::default()).unwrap();
/// let rays = [0.0, 1.0, 3.0].map(|y| Ray::new(Vec3::new(-5.0, y, 0.0), Vec3::X).unwrap());
/// let (mut caster, mut hits) = (BatchCaster::new(&world, Run::default()), ClosestRows::default());
/// caster.closest(&rays, Span::FORWARD, None, &mut hits).unwrap();
/// assert_eq!((hits.t[0], hits.t[2]), (3.0, f64::INFINITY));
/// ```
pub struct BatchCaster<'w> {
    run: Run<'w>,
    /// `None` where rays are cast one by one.
    plan: Option<BlockPlan<'w>>,
    worker: Worker<'w>,
}

impl<'w> BatchCaster<'w> {
    /// A caster for one thread. Of the [`Run`] it uses the fields, the cancel flag, the progress callback (within rays) and
    /// whether counters are requested, which [`BatchCaster::take_counters`] returns.
    pub fn new(world: &'w World, run: Run<'w>) -> BatchCaster<'w> {
        BatchCaster { run, plan: plan_of(world, &run), worker: Worker::new(world, run.watch()) }
    }

    /// Returns the work counted since the last call. Rays that are cast in blocks are not counted.
    pub fn take_counters(&mut self) -> Counters {
        self.worker.caster.take_counters()
    }

    /// The closest crossing of each ray, as [`closest_into`](super::closest_into) finds it. Rays that are cast one by one
    /// use the hint, see [`Caster::closest_with_hint`].
    ///
    /// # Errors
    /// As [`closest`](super::closest). Then the rows mean nothing.
    pub fn closest(
        &mut self,
        rays: &(impl Rays + ?Sized),
        scope: impl Into<Scope>,
        mut hint: Option<&mut CoherenceHint>,
        out: &mut ClosestRows,
    ) -> Result<(), BatchError> {
        let scope = scope.into();
        out.resize(rays.len(), self.run.fields)?;
        let Some(mut chunk) = out.chunks(rays.len().max(1)).next() else { return Ok(()) };
        chunk.clear();
        if self.plan.is_some() {
            return self.cast_block(rays, scope, |blocks, block, memory| {
                blocks.closest(block, memory, &mut |row, hit| chunk.set(row, hit))
            });
        }
        self.cast_rays(rays, |caster, row, ray| {
            let hit = match &mut hint {
                Some(hint) => caster.closest_with_hint(hint, ray, scope)?,
                None => caster.closest(ray, scope)?,
            };
            hit.iter().for_each(|hit| chunk.set(row, &RowHit::from(hit)));
            Ok(())
        })
    }

    /// Whether each ray has any crossing, as [`any`](super::any) finds it. Rays that are cast one by one use the hint, see
    /// [`Caster::any_with_hint`].
    ///
    /// # Errors
    /// As [`any`](super::any). Then the rows mean nothing.
    pub fn any(
        &mut self,
        rays: &(impl Rays + ?Sized),
        scope: impl Into<Scope>,
        mut hint: Option<&mut CoherenceHint>,
        out: &mut Vec<bool>,
    ) -> Result<(), BatchError> {
        let scope = scope.into();
        out.clear();
        out.try_reserve(rays.len())?;
        out.resize(rays.len(), false);
        if self.plan.is_some() {
            return self.cast_block(rays, scope, |blocks, block, memory| {
                blocks.any(block, memory, &mut |row| out[row] = true)
            });
        }
        self.cast_rays(rays, |caster, row, ray| {
            out[row] = match &mut hint {
                Some(hint) => caster.any_with_hint(hint, ray, scope)?,
                None => caster.any(ray, scope)?,
            };
            Ok(())
        })
    }

    /// Passes the row of each ray to `take`, with its intervals inside objects as [`segments`](super::segments) finds them.
    ///
    /// # Errors
    /// As [`segments`](super::segments). Some rays may have been passed before.
    pub fn segments(
        &mut self,
        rays: &(impl Rays + ?Sized),
        span: Span,
        overlaps: Overlaps,
        mut take: impl FnMut(usize, &[Segment]),
    ) -> Result<(), BatchError> {
        all_solid(self.worker.caster.world()).map_err(BatchError::World)?;
        if self.plan.is_some() {
            return self.cast_block(rays, span, |blocks, block, memory| {
                blocks.segments(block, overlaps, memory, &mut |row, segments, _| {
                    take(row, segments);
                    Ok(())
                })
            });
        }
        let mut segments = std::mem::take(&mut self.worker.segments);
        let outcome = self.cast_rays(rays, |caster, row, ray| {
            empty(&mut segments);
            caster.segments(ray, span, overlaps, &mut segments)?;
            take(row, &segments);
            Ok(())
        });
        self.worker.segments = segments;
        outcome
    }

    /// Passes the row of each ray to `take`, with the work that its closest crossing costs one ray alone.
    ///
    /// # Errors
    /// As [`closest`](super::closest). Some rays may have been passed before.
    pub fn cost(
        &mut self,
        rays: &(impl Rays + ?Sized),
        scope: impl Into<Scope>,
        mut take: impl FnMut(usize, Counters),
    ) -> Result<(), BatchError> {
        let scope = scope.into();
        self.cast_rays(rays, |caster, row, ray| {
            caster.take_counters();
            caster.closest(ray, scope)?;
            take(row, caster.take_counters());
            Ok(())
        })
    }

    /// Casts rays as one block.
    fn cast_block(
        &mut self,
        rays: &(impl Rays + ?Sized),
        scope: impl Into<Scope>,
        query: impl FnOnce(&mut BlockCaster<'_, 'w>, &RowBlock, &mut BlockMemory<'w>) -> Result<(), BlockError>,
    ) -> Result<(), BatchError> {
        let BatchCaster { run, plan: Some(plan), worker } = self else { return Ok(()) };
        let mut memory = std::mem::take(&mut worker.rays);
        let made = RayRows(rays).rays(0..rays.len(), &mut memory).map(|rays| {
            let (mut blocks, memory) = worker.blocks(plan);
            query(&mut blocks, &block(run, rays, scope), memory)
        });
        worker.rays = memory;
        made.and_then(|outcome| outcome.map_err(|error| block_error(0, error))).map_err(|(_, error)| error)
    }

    /// Passes the rays one by one, each with its row, to a query of single rays.
    ///
    /// # Errors
    /// [`BatchError::Cancelled`], [`BatchError::Ray`], and the first error of the query.
    pub fn cast_rays(
        &mut self,
        rays: &(impl Rays + ?Sized),
        mut query: impl FnMut(&mut Caster<'w>, usize, &Ray) -> Result<(), QueryError>,
    ) -> Result<(), BatchError> {
        for row in 0..rays.len() {
            if self.run.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return Err(BatchError::Cancelled);
            }
            let ray = rays.ray(row).map_err(|error| BatchError::Ray { row, error })?;
            query(&mut self.worker.caster, row, &ray).map_err(|error| row_error(row, error))?;
        }
        Ok(())
    }
}
