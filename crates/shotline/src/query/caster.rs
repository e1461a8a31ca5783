//! The caster: what is asked of one ray.

use super::hit::hit;
use super::membership::{Membership, line_at};
use super::quest::{Go, Quest};
use super::seed::Seed;
use super::segments::{self, Interval, Kept, resolve};
use super::stream::StreamScratch;
use super::walk::{Meeting, Walk};
use super::{Hit, Limits, Overlap, Overlaps, QueryError, Scope, Segment};
use crate::accel::{Scratch, Work};
use crate::budget::Watch;
use crate::compile::{Body, World};
use crate::crossing::Crossing;
use crate::csg::Boundary;
use crate::math::Vec3;
use crate::ray::{Line, Ray, Span};
use crate::solid::Wanted;
use crate::trace::Trace;

/// A world with one thread's scratch memory.
///
/// Every query has an end: see [`Limits`] and [`Caster::watch`]. What goes beyond is an error, and appends nothing.
///
/// ```
/// use shotline::compile::{Options, compile};
/// use shotline::math::Vec3;
/// use shotline::query::Caster;
/// use shotline::ray::{Ray, Span};
/// use shotline::scene::Scene;
///
/// let mut scene = Scene::default();
/// let ball = scene.add_solid("sphere", &[&[2.0]]).unwrap();
/// scene.add_object("ball", None, ball);
/// let world = compile(&scene, Options::default()).unwrap();
/// let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).unwrap();
/// let mut hits = Vec::new();
/// Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits).unwrap();
/// assert_eq!(hits.iter().map(|h| (h.t, h.entering)).collect::<Vec<_>>(), [(3.0, true), (7.0, false)]);
/// ```
#[derive(Debug)]
pub struct Caster<'w> {
    pub(super) world: &'w World,
    pub(super) walk: Walk<'w>,
    pub(super) stream: StreamScratch,
    pub(super) hits: Vec<Crossing>,
    pub(super) scratch: Scratch<'w>,
    pub(super) limits: Limits,
    membership: Membership,
    intervals: Vec<Interval>,
    kept: Kept,
}

/// The memory of so many intervals is kept for the next ray.
const KEPT_INTERVALS: usize = 4096;

impl<'w> Caster<'w> {
    /// A caster for one thread.
    pub fn new(world: &'w World) -> Caster<'w> {
        Caster {
            world,
            walk: Walk::default(),
            stream: StreamScratch::default(),
            hits: Vec::new(),
            scratch: Scratch::default(),
            limits: Limits::default(),
            membership: Membership::default(),
            intervals: Vec::new(),
            kept: Kept::default(),
        }
    }

    /// Lets queries be followed and cancelled while they run: also within one ray.
    pub fn watch(&mut self, watch: Watch<'w>) {
        self.scratch.budget.watch(watch);
    }

    /// Sets what one ray may cost.
    pub fn limit(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// Work counted since the caster was made, or since this was asked last.
    pub fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.scratch.work)
    }

    /// Keeps the steps of the queries that follow, so many at most, until [`Caster::take_trace`]. No answer
    /// depends on it.
    pub fn record(&mut self, most: usize) {
        self.scratch.log.start(most);
    }

    /// The steps kept since [`Caster::record`]; none are kept from here on.
    pub fn take_trace(&mut self) -> Trace {
        self.scratch.log.take()
    }

    /// The first crossing in the scope. Of several at the same `t`, that of the lowest path.
    ///
    /// # Errors
    /// [`QueryError::Cancelled`] and [`QueryError::TooLong`].
    pub fn closest(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<Option<Hit>, QueryError> {
        let nearest = self.nearest(ray, scope.into(), &[])?;
        Ok(nearest.map(|(meeting, boundary)| hit(self.world, &self.walk, ray, &meeting, &boundary)))
    }

    /// As [`Caster::closest`], asking first the body that the seed's last ray met: what lies behind that is
    /// passed over. It answers the same.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn closest_from(
        &mut self,
        seed: &mut Seed,
        ray: &Ray,
        scope: impl Into<Scope>,
    ) -> Result<Option<Hit>, QueryError> {
        let Some((meeting, boundary)) = self.nearest(ray, scope.into(), seed.way())? else { return Ok(None) };
        seed.keep(&meeting, &self.walk, &mut self.scratch.work);
        Ok(Some(hit(self.world, &self.walk, ray, &meeting, &boundary)))
    }

    fn nearest(
        &mut self,
        ray: &Ray,
        scope: Scope,
        seed: &[u32],
    ) -> Result<Option<(Meeting, Boundary)>, QueryError> {
        let mut best: Option<(Meeting, Boundary)> = None;
        let quest = Quest { scope, wanted: Wanted::First, seed };
        self.fold(ray, &quest, &mut |walk, meeting, boundary| {
            let t = boundary.crossing.t;
            let nearer =
                best.is_none_or(|(m, b)| t < b.crossing.t || (t == b.crossing.t && meeting.path < m.path));
            if nearer {
                walk.hold(meeting);
                if let Some((before, _)) = best.replace((*meeting, boundary)) {
                    walk.let_go(&before);
                }
            }
            Go::UpTo(t)
        })?;
        Ok(best)
    }

    /// Whether there is any crossing in the scope.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn any(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<bool, QueryError> {
        Ok(self.occluder(ray, scope.into(), &[])?.is_some())
    }

    /// As [`Caster::any`], asking first the body that the seed's last ray met (the shadow cache: Haines and
    /// Greenberg 1986). It answers the same.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn any_from(
        &mut self,
        seed: &mut Seed,
        ray: &Ray,
        scope: impl Into<Scope>,
    ) -> Result<bool, QueryError> {
        let found = self.occluder(ray, scope.into(), seed.way())?;
        if let Some(meeting) = &found {
            seed.keep(meeting, &self.walk, &mut self.scratch.work);
        }
        Ok(found.is_some())
    }

    fn occluder(&mut self, ray: &Ray, scope: Scope, seed: &[u32]) -> Result<Option<Meeting>, QueryError> {
        let mut found = None;
        let quest = Quest { scope, wanted: Wanted::First, seed };
        self.fold(ray, &quest, &mut |_, meeting, _| {
            found = Some(*meeting);
            Go::Stop
        })?;
        Ok(found)
    }

    /// The number of crossings in the scope.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn count(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<u64, QueryError> {
        let mut count = 0;
        let quest = Quest { scope: scope.into(), wanted: Wanted::All, seed: &[] };
        self.fold(ray, &quest, &mut |_, _, _| {
            count += 1;
            Go::UpTo(f64::INFINITY)
        })?;
        Ok(count)
    }

    /// Appends every crossing in the scope, ascending in `t`; those of one path alternate from an entry, unless only
    /// surfaces are looked for. Crossings of different paths at the same `t` come in the order of the paths.
    ///
    /// # Errors
    /// As [`Caster::closest`], and [`QueryError::TooMany`].
    pub fn crossings(
        &mut self,
        ray: &Ray,
        scope: impl Into<Scope>,
        out: &mut Vec<Hit>,
    ) -> Result<(), QueryError> {
        let start = out.len();
        let gathered = self.gather(ray, scope.into(), out);
        if gathered.is_err() {
            out.truncate(start);
        } else {
            // Stable: boundaries of one body keep their order.
            out[start..].sort_by(|a, b| a.t.total_cmp(&b.t).then(a.path.cmp(&b.path)));
        }
        gathered
    }

    fn gather(&mut self, ray: &Ray, scope: Scope, out: &mut Vec<Hit>) -> Result<(), QueryError> {
        let (world, most) = (self.world, self.limits.crossings);
        let (start, mut refused) = (out.len(), None);
        let quest = Quest { scope, wanted: Wanted::All, seed: &[] };
        self.fold(ray, &quest, &mut |walk, meeting, boundary| {
            if out.len() - start >= most {
                refused = Some(QueryError::TooMany { most });
            } else if out.try_reserve(1).is_err() {
                refused = Some(QueryError::OutOfMemory);
            } else {
                out.push(hit(world, walk, ray, meeting, &boundary));
                return Go::UpTo(f64::INFINITY);
            }
            Go::Stop
        })?;
        refused.map_or(Ok(()), Err)
    }

    /// Appends the stretches inside objects and answers how many overlaps of equal priority were met.
    /// Stretches of one object that overlap or touch are joined.
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
            let budget = &mut self.scratch.budget;
            let met = resolve(self.world, ray, &self.intervals, overlaps, &mut self.kept, budget, out)?;
            self.outcome().map(|()| met)
        });
        if met.is_err() {
            out.truncate(start);
        }
        self.intervals.clear();
        self.intervals.shrink_to(KEPT_INTERVALS);
        met
    }

    /// Appends where objects of equal priority overlap, ascending: what [`Caster::segments`] refuses, but all of it.
    ///
    /// # Errors
    /// As [`Caster::segments`].
    pub fn overlaps(&mut self, ray: &Ray, span: Span, out: &mut Vec<Overlap>) -> Result<(), QueryError> {
        let start = out.len();
        let found = self.intervals(ray, span).and_then(|()| {
            let budget = &mut self.scratch.budget;
            segments::overlaps(self.world, &self.intervals, &mut self.kept, budget, out);
            self.outcome()
        });
        if found.is_err() {
            out.truncate(start);
        }
        self.intervals.clear();
        self.intervals.shrink_to(KEPT_INTERVALS);
        found
    }

    /// The stretches inside each body, in `self.intervals`.
    fn intervals(&mut self, ray: &Ray, span: Span) -> Result<(), QueryError> {
        all_solid(self.world)?;
        let mut intervals = std::mem::take(&mut self.intervals);
        intervals.clear();
        let most = self.limits.crossings;
        let (mut open, mut refused): (Option<Interval>, _) = (None, None);
        let quest = Quest { scope: span.into(), wanted: Wanted::All, seed: &[] };
        self.fold(ray, &quest, &mut |_, meeting, boundary| {
            let end = boundary.crossing;
            // The boundaries of a body come one after the other, in pairs.
            match open.take() {
                None => open = Some(Interval { start: end, end, object: meeting.object, path: meeting.path }),
                Some(_) if 2 * intervals.len() >= most => refused = Some(QueryError::TooMany { most }),
                Some(_) if intervals.try_reserve(1).is_err() => refused = Some(QueryError::OutOfMemory),
                Some(started) => intervals.push(Interval { end, ..started }),
            }
            if refused.is_some() { Go::Stop } else { Go::UpTo(f64::INFINITY) }
        })?;
        self.intervals = intervals;
        refused.map_or(Ok(()), Err)
    }

    /// Appends the stretches inside one object, from and to which `t`, whatever else is there: ascending and apart.
    /// Answers how many steps it took; memory does not grow with them.
    ///
    /// # Errors
    /// [`QueryError`], as of [`Caster::crossings`].
    pub(crate) fn stretches(
        &mut self,
        object: u32,
        ray: &Ray,
        span: Span,
        out: &mut Vec<[f64; 2]>,
    ) -> Result<u64, QueryError> {
        let most = self.limits.crossings;
        let mut ends: Vec<f64> = Vec::new();
        let mut limit = span.t_max();
        let quest = Quest { scope: span.into(), wanted: Wanted::All, seed: &[] };
        self.scratch.budget.begin(self.limits.steps);
        self.walk.begin(self.world, Line::of(ray), span);
        self.walk.start(self.world, &mut self.scratch);
        while let Some(meeting) = self.walk.next_deep(self.world, &mut self.scratch) {
            if meeting.object == object {
                // Of one body they alternate.
                let _ = self.fold_body(&meeting, &quest, &mut limit, &mut |_, _, boundary| {
                    ends.push(boundary.crossing.t);
                    Go::UpTo(f64::INFINITY)
                });
            }
            if ends.len() > most {
                return Err(QueryError::TooMany { most });
            }
        }
        self.outcome()?;
        let mut stretches: Vec<[f64; 2]> = ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let start = out.len();
        for [from, to] in stretches {
            match out[start..].last_mut() {
                Some(last) if from <= last[1] => last[1] = last[1].max(to),
                _ => out.push([from, to]),
            }
        }
        Ok(self.scratch.budget.used())
    }

    /// Appends the objects whose interior holds a point, ascending. No promise within rounding of a surface.
    ///
    /// # Errors
    /// As [`Caster::closest`], and [`QueryError::NotASolid`] for meshes that are not closed.
    pub fn contains(&mut self, p: Vec3, out: &mut Vec<u32>) -> Result<(), QueryError> {
        all_solid(self.world)?;
        let start = out.len();
        let here = Span::new(0.0, 0.0).unwrap_or(Span::FORWARD);
        self.scratch.budget.begin(self.limits.steps);
        self.walk.begin(self.world, line_at(p), here);
        self.walk.start(self.world, &mut self.scratch);
        while let Some(meeting) = self.walk.next(self.world, 0.0, &mut self.scratch) {
            if let Body::Solid(body) = self.world.body(meeting.body)
                && self.membership.holds(body, &meeting.line, here, &mut self.scratch)
            {
                out.push(meeting.object);
            }
        }
        if let Err(error) = self.outcome() {
            out.truncate(start);
            return Err(error);
        }
        out[start..].sort_unstable();
        let mut kept = out.split_off(start);
        kept.dedup();
        out.append(&mut kept);
        Ok(())
    }
}

/// Refuses worlds in which an object has no inside.
///
/// # Errors
/// [`QueryError::NotASolid`].
pub(super) fn all_solid(world: &World) -> Result<(), QueryError> {
    match world.surface() {
        None => Ok(()),
        Some((object, body)) => Err(QueryError::NotASolid {
            object: world.object_names()[object as usize].clone(),
            why: body.mesh.topology().why_open(),
        }),
    }
}
