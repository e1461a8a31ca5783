//! What is seen first along a ray where some objects are hidden: the first point from which on its owner is visible.
//!
//! Hidden objects still displace what is around them, so a hidden object leaves a hole through which the walls around it are
//! seen. Who owns the ray is decided by the same sweep as for segments. It runs over the bodies whose boxes have begun, nearest
//! first; what it finds is final if all other boxes begin behind it. So the rest of a deep scene is not traversed.

use std::ops::ControlFlow;

use super::caster::Caster;
use super::fold_query::{FoldControl, FoldQuery};
use super::hit::hit;
use super::limit::search_limit;
use super::met_bodies::MetBodies;
use super::owned_parts::{OwnedPart, sweep};
use super::traversal::BodyEntry;
use super::{Hit, Kinds, Overlaps, QueryError, Scope};
use crate::compile::Body;
use crate::csg::{Boundary, HitKind};
use crate::ray::{Line, Ray};
use crate::solid::Wanted;

/// What is seen first of the bodies that have been met.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// The body whose surface is crossed, and where.
    body: u32,
    boundary: Boundary,
    /// The interval that is seen; `None` for a surface that has no inside.
    owner: Option<usize>,
    /// Whether the owner begins; otherwise it is seen from within, where it ends.
    begins: bool,
}

/// When the sweep has to run again.
struct Schedule {
    /// Nothing is seen before this `t`.
    after: f64,
    /// The number of intervals from which on it pays: each sweep has one and a half times the intervals of the last one.
    intervals: usize,
}

impl Caster<'_> {
    /// Returns the first crossing in the scope from which on the object that owns the ray is visible. `hidden` tells by the number
    /// of an object whether it is hidden; objects beyond its end are visible. Where objects of equal priority overlap, the one
    /// that is placed later owns the ray.
    ///
    /// The object, the path and the direction of the hit are those of the visible owner, and the normal points out of it. The
    /// surface is the one that is crossed: that of the owner, or that of a hidden object that the ray leaves. A ray that begins in
    /// a visible owner has a hit of kind [`HitKind::Start`]; with [`Kinds::Surfaces`] it sees that owner from within, where it
    /// ends, unless another one begins there. Meshes that are not closed own nothing and are seen unless they are hidden.
    ///
    /// # Errors
    /// As [`Caster::crossings`].
    pub fn first_visible(
        &mut self,
        ray: &Ray,
        scope: impl Into<Scope>,
        hidden: &[bool],
    ) -> Result<Option<Hit>, QueryError> {
        let mut met = std::mem::take(&mut self.met);
        met.begin();
        let seen = self.search(ray, scope.into(), hidden, &mut met);
        let hit = seen.map(|seen| seen.map(|seen| self.seen_hit(ray, &met, &seen)));
        self.met = met;
        hit
    }

    fn search(
        &mut self,
        ray: &Ray,
        scope: Scope,
        hidden: &[bool],
        met: &mut MetBodies,
    ) -> Result<Option<Seen>, QueryError> {
        let is_hidden = |object: u32| hidden.get(object as usize).copied().unwrap_or(false);
        let (o, d) = (ray.origin(), ray.direction());
        let mut schedule = Schedule { after: f64::INFINITY, intervals: 0 };
        self.scratch.budget.begin(self.limits.steps);
        self.traversal.begin(self.world, Line::of(ray), scope.span);
        self.traversal.enter_root(self.world, &mut self.scratch);
        while let Some(body_entry) = self.traversal.next(self.world, scope.span.t_max(), &mut self.scratch) {
            if body_entry.enter > schedule.after && met.intervals.len() >= schedule.intervals {
                let seen = self.first_of(scope.kinds, &is_hidden, met)?;
                let limit = seen.map(|seen| search_limit(o, d, &seen.boundary.crossing));
                if limit.is_some_and(|limit| body_entry.enter > limit) {
                    return Ok(seen);
                }
                schedule.after = limit.unwrap_or(body_entry.enter);
                schedule.intervals = met.intervals.len() * 3 / 2 + 1;
            }
            let first = met.intervals.len();
            self.meet(&body_entry, scope, !is_hidden(body_entry.placed.object), met)?;
            if !is_hidden(body_entry.placed.object) {
                let starts = met.intervals[first..].iter().map(|interval| interval.start.t);
                let surface = met.surface.map(|(_, boundary)| boundary.crossing.t);
                schedule.after = starts.chain(surface).fold(schedule.after, f64::min);
            }
        }
        self.outcome()?;
        self.first_of(scope.kinds, &is_hidden, met)
    }

    /// Adds the intervals of a body.
    fn meet(
        &mut self,
        body_entry: &BodyEntry,
        scope: Scope,
        is_visible: bool,
        met: &mut MetBodies,
    ) -> Result<(), QueryError> {
        let is_solid = matches!(self.world.body(body_entry.placed.body), Body::Solid(_));
        if !is_solid && !is_visible {
            return Ok(());
        }
        let most = self.limits.crossings;
        let number = met.bodies.len() as u32;
        met.bodies.push(*body_entry);
        self.traversal.hold(body_entry);
        let wanted = if is_solid { Wanted::All } else { Wanted::First };
        let query = FoldQuery { scope: scope.span.into(), wanted, hint: &[] };
        let (mut open, mut refused): (Option<Boundary>, _) = (None, None);
        let mut limit = f64::INFINITY;
        let _ = self.fold_body(body_entry, &query, &mut limit, &mut |_, _, boundary| {
            if !is_solid {
                met.add_surface(number, boundary);
            } else if let Some(start) = open.take() {
                if 2 * met.intervals.len() >= most {
                    refused = Some(QueryError::TooMany { most });
                } else if met.intervals.try_reserve(1).is_err() || met.of_intervals.try_reserve(1).is_err() {
                    refused = Some(QueryError::OutOfMemory);
                } else {
                    met.add(number, body_entry, [start, boundary]);
                }
            } else {
                // The boundaries of a body come in pairs of an entry and an exit.
                open = Some(boundary);
            }
            if refused.is_some() { FoldControl::Stop } else { FoldControl::Limit(f64::INFINITY) }
        });
        refused.map_or(Ok(()), Err)
    }

    /// What is seen first of the bodies that have been met.
    fn first_of(
        &mut self,
        kinds: Kinds,
        is_hidden: &impl Fn(u32) -> bool,
        met: &MetBodies,
    ) -> Result<Option<Seen>, QueryError> {
        let mut view = View { kinds, met, around: None, seen: None };
        let (world, budget) = (self.world, &mut self.scratch.budget);
        sweep(world, &met.intervals, Overlaps::Priority, &mut self.ownership, budget, |part| {
            view.take(part, is_hidden(met.intervals[part.interval].object))
        })?;
        self.outcome()?;
        let owner = view.finish();
        let t = owner.map_or(f64::INFINITY, |seen| seen.boundary.crossing.t);
        let surface = met.surface.filter(|(_, boundary)| boundary.crossing.t < t);
        let of_surface = |(body, boundary)| Seen { body, boundary, owner: None, begins: true };
        Ok(surface.map(of_surface).or(owner))
    }

    /// The hit of what is seen.
    fn seen_hit(&self, ray: &Ray, met: &MetBodies, seen: &Seen) -> Hit {
        let body = &met.bodies[seen.body as usize];
        let crossed = hit(self.world, &self.traversal, ray, body, &seen.boundary);
        let Some(owner) = seen.owner.map(|interval| &met.intervals[interval]) else { return crossed };
        // The surface of a hidden object is turned over where the ray leaves it for the owner, or the other way round.
        let normal = if crossed.entering == seen.begins { crossed.normal } else { -crossed.normal };
        Hit { entering: seen.begins, normal, object: owner.object, path: owner.path, ..crossed }
    }
}

/// Looks at the parts of a ray, from the first on.
struct View<'m> {
    kinds: Kinds,
    met: &'m MetBodies,
    /// The visible owner in which the ray begins, if only surfaces are looked for.
    around: Option<OwnedPart>,
    seen: Option<Seen>,
}

impl View<'_> {
    fn take(&mut self, part: &OwnedPart, is_hidden: bool) -> ControlFlow<()> {
        if let Some(around) = self.around
            && (is_hidden || around.events[1] != part.events[0])
        {
            return ControlFlow::Break(());
        }
        if is_hidden {
            return ControlFlow::Continue(());
        }
        let seen = self.seen_at(part, true);
        if self.kinds == Kinds::Surfaces && seen.boundary.kind == HitKind::Start {
            self.around = Some(*part);
            return ControlFlow::Continue(());
        }
        self.seen = Some(seen);
        ControlFlow::Break(())
    }

    fn finish(self) -> Option<Seen> {
        let within = self.around.map(|around| self.seen_at(&around, false));
        self.seen.or(within.filter(|seen| seen.boundary.kind == HitKind::Surface))
    }

    /// One of the ends of a part.
    fn seen_at(&self, part: &OwnedPart, begins: bool) -> Seen {
        let end = if begins { part.start } else { part.end };
        let (body, ends) = self.met.of_intervals[end.interval];
        let boundary = ends[usize::from(!end.crossing.entering)];
        Seen { body, boundary, owner: Some(part.interval), begins }
    }
}
