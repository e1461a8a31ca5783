//! Queries for the nearest crossing of a ray, and for whether there is any crossing.

use super::caster::Caster;
use super::coherence_hint::CoherenceHint;
use super::fold_query::{FoldControl, FoldQuery};
use super::hit::hit;
use super::limit::search_limit;
use super::traversal::BodyEntry;
use super::{Hit, QueryError, Scope};
use crate::csg::Boundary;
use crate::ray::Ray;
use crate::solid::Wanted;

impl Caster<'_> {
    /// Returns the first crossing in the scope. Of several crossings at the same `t`, returns the one with the
    /// lowest path.
    ///
    /// # Errors
    /// [`QueryError::Cancelled`] and [`QueryError::TooLong`].
    pub fn closest(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<Option<Hit>, QueryError> {
        let nearest = self.nearest(ray, scope.into(), &[])?;
        Ok(nearest
            .map(|(body_entry, boundary)| hit(self.world, &self.traversal, ray, &body_entry, &boundary)))
    }

    /// As [`Caster::closest`], but tests the hinted body first, and then skips what lies beyond its first
    /// crossing. The result is the same. Stores the body of the crossing in the hint.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn closest_with_hint(
        &mut self,
        hint: &mut CoherenceHint,
        ray: &Ray,
        scope: impl Into<Scope>,
    ) -> Result<Option<Hit>, QueryError> {
        let Some((body_entry, boundary)) = self.nearest(ray, scope.into(), hint.placements())? else {
            return Ok(None);
        };
        hint.keep(&body_entry, &self.traversal, &mut self.scratch.counters);
        Ok(Some(hit(self.world, &self.traversal, ray, &body_entry, &boundary)))
    }

    fn nearest(
        &mut self,
        ray: &Ray,
        scope: Scope,
        hint: &[u32],
    ) -> Result<Option<(BodyEntry, Boundary)>, QueryError> {
        let mut best: Option<(BodyEntry, Boundary)> = None;
        let (o, d) = (ray.origin(), ray.direction());
        let query = FoldQuery { scope, wanted: Wanted::First, hint };
        self.fold(ray, &query, &mut |traversal, body_entry, boundary| {
            let t = boundary.crossing.t;
            let nearer = best.is_none_or(|(m, b)| {
                t < b.crossing.t || (t == b.crossing.t && body_entry.placed.path < m.placed.path)
            });
            if nearer {
                traversal.hold(body_entry);
                if let Some((before, _)) = best.replace((*body_entry, boundary)) {
                    traversal.release_body(&before);
                }
            }
            FoldControl::Limit(search_limit(o, d, &boundary.crossing))
        })?;
        Ok(best)
    }

    /// Returns whether there is any crossing in the scope.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn any(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<bool, QueryError> {
        Ok(self.occluder(ray, scope.into(), &[])?.is_some())
    }

    /// As [`Caster::any`], but tests the hinted body first (the shadow cache of Haines and Greenberg 1986). The
    /// result is the same. Stores the occluder that was found in the hint.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn any_with_hint(
        &mut self,
        hint: &mut CoherenceHint,
        ray: &Ray,
        scope: impl Into<Scope>,
    ) -> Result<bool, QueryError> {
        let found = self.occluder(ray, scope.into(), hint.placements())?;
        if let Some(body_entry) = &found {
            hint.keep(body_entry, &self.traversal, &mut self.scratch.counters);
        }
        Ok(found.is_some())
    }

    fn occluder(&mut self, ray: &Ray, scope: Scope, hint: &[u32]) -> Result<Option<BodyEntry>, QueryError> {
        let mut found = None;
        let query = FoldQuery { scope, wanted: Wanted::First, hint };
        self.fold(ray, &query, &mut |_, body_entry, _| {
            found = Some(*body_entry);
            FoldControl::Stop
        })?;
        Ok(found)
    }
}
