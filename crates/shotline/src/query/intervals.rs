//! The intervals of a ray inside bodies and objects. Segments, overlaps and measures are computed from them.

use super::caster::{Caster, all_solid};
use super::fold_query::{FoldControl, FoldQuery};
use super::interval_ends::Interval;
use super::owned_parts::resolve;
use super::ownership;
use super::{Conflict, Overlaps, QueryError, Segment};
use crate::ray::{Line, Ray, Span};
use crate::solid::Wanted;

/// The memory of up to this many intervals is kept for the next ray.
const RETAINED_INTERVALS: usize = 4096;

impl Caster<'_> {
    /// Appends the intervals inside objects, each up to where another instance owns the ray, and returns the number of
    /// overlaps of equal priority.
    ///
    /// # Errors
    /// As [`Caster::crossings`], [`QueryError::NotASolid`] for meshes that are not closed and, with
    /// [`Overlaps::Error`], [`QueryError::Overlap`].
    pub fn segments(
        &mut self,
        ray: &Ray,
        span: Span,
        overlaps: Overlaps,
        out: &mut Vec<Segment>,
    ) -> Result<u64, QueryError> {
        let start = out.len();
        let met = self.intervals(ray, span).and_then(|()| {
            let intervals = std::mem::take(&mut self.intervals);
            let met = self.resolve_within_budget(ray, &intervals, overlaps, out);
            self.intervals = intervals;
            met
        });
        if met.is_err() {
            out.truncate(start);
        }
        self.intervals.clear();
        self.intervals.shrink_to(RETAINED_INTERVALS);
        met
    }

    /// As [`Caster::segments`], of a ray whose intervals are known.
    pub(super) fn resolve(
        &mut self,
        ray: &Ray,
        intervals: &[Interval],
        overlaps: Overlaps,
        out: &mut Vec<Segment>,
    ) -> Result<u64, QueryError> {
        self.scratch.budget.begin(self.limits.steps);
        self.resolve_within_budget(ray, intervals, overlaps, out)
    }

    fn resolve_within_budget(
        &mut self,
        ray: &Ray,
        intervals: &[Interval],
        overlaps: Overlaps,
        out: &mut Vec<Segment>,
    ) -> Result<u64, QueryError> {
        let budget = &mut self.scratch.budget;
        let met = resolve(self.world, ray, intervals, overlaps, &mut self.ownership, budget, out)?;
        self.outcome().map(|()| met)
    }

    /// Appends the overlaps of objects of equal priority, ascending, and where contents stick out of an object that clips
    /// them. [`Caster::segments`] may refuse at the first overlap; this returns them all. Returns the number of intervals
    /// inside bodies, which does not depend on the accelerator.
    ///
    /// # Errors
    /// As [`Caster::segments`].
    pub fn conflicts(&mut self, ray: &Ray, span: Span, out: &mut Vec<Conflict>) -> Result<usize, QueryError> {
        let start = out.len();
        let found = self.intervals(ray, span).and_then(|()| {
            let budget = &mut self.scratch.budget;
            ownership::conflicts(self.world, &self.intervals, &mut self.ownership, budget, out);
            self.outcome().map(|()| self.intervals.len())
        });
        if found.is_err() {
            out.truncate(start);
        }
        self.intervals.clear();
        self.intervals.shrink_to(RETAINED_INTERVALS);
        found
    }

    /// Computes the intervals inside each body and stores them in `self.intervals`.
    fn intervals(&mut self, ray: &Ray, span: Span) -> Result<(), QueryError> {
        all_solid(self.world)?;
        let mut intervals = std::mem::take(&mut self.intervals);
        intervals.clear();
        let most = self.limits.crossings;
        let (mut open, mut refused): (Option<Interval>, _) = (None, None);
        let query = FoldQuery { scope: span.into(), wanted: Wanted::All, hint: &[] };
        self.fold(ray, &query, &mut |_, body_entry, boundary| {
            let end = boundary.crossing;
            // The boundaries of one body arrive one after the other, in pairs of an entry and an exit.
            match open.take() {
                None => {
                    open = Some(Interval {
                        start: end,
                        end,
                        object: body_entry.placed.object,
                        path: body_entry.placed.path,
                    })
                }
                Some(_) if 2 * intervals.len() >= most => refused = Some(QueryError::TooMany { most }),
                Some(_) if intervals.try_reserve(1).is_err() => refused = Some(QueryError::OutOfMemory),
                Some(started) => intervals.push(Interval { end, ..started }),
            }
            if refused.is_some() { FoldControl::Stop } else { FoldControl::Limit(f64::INFINITY) }
        })?;
        self.intervals = intervals;
        refused.map_or(Ok(()), Err)
    }

    /// Appends the intervals `[t_in, t_out]` inside one object, regardless of other objects. They are ascending
    /// and disjoint. Returns the number of steps taken. Memory does not grow with the number of steps.
    ///
    /// # Errors
    /// As [`Caster::crossings`].
    pub(crate) fn object_intervals(
        &mut self,
        object: u32,
        ray: &Ray,
        span: Span,
        out: &mut Vec<[f64; 2]>,
    ) -> Result<u64, QueryError> {
        let most = self.limits.crossings;
        let mut ends: Vec<f64> = Vec::new();
        let mut limit = span.t_max();
        let query = FoldQuery { scope: span.into(), wanted: Wanted::All, hint: &[] };
        self.scratch.budget.begin(self.limits.steps);
        self.traversal.begin(self.world, Line::of(ray), span);
        self.traversal.enter_root(self.world, &mut self.scratch);
        while let Some(body_entry) = self.traversal.next_unordered(self.world, &mut self.scratch) {
            if body_entry.placed.object == object {
                // The boundaries of one body alternate, so they can be paired.
                let _ = self.fold_body(&body_entry, &query, &mut limit, &mut |_, _, boundary| {
                    ends.push(boundary.crossing.t);
                    FoldControl::Limit(f64::INFINITY)
                });
            }
            if ends.len() > most {
                return Err(QueryError::TooMany { most });
            }
        }
        self.outcome()?;
        let mut intervals: Vec<[f64; 2]> = ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let start = out.len();
        for [from, to] in intervals {
            match out[start..].last_mut() {
                Some(last) if from <= last[1] => last[1] = last[1].max(to),
                _ => out.push([from, to]),
            }
        }
        Ok(self.scratch.budget.used())
    }
}
