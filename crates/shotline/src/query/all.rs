//! All crossings of a ray, and their number.

use super::caster::Caster;
use super::fold_query::{FoldControl, FoldQuery};
use super::hit::hit;
use super::{Hit, QueryError, Scope};
use crate::ray::Ray;
use crate::solid::Wanted;

impl Caster<'_> {
    /// Returns the number of crossings in the scope.
    ///
    /// # Errors
    /// As [`Caster::closest`].
    pub fn count(&mut self, ray: &Ray, scope: impl Into<Scope>) -> Result<u64, QueryError> {
        let mut count = 0;
        let query = FoldQuery { scope: scope.into(), wanted: Wanted::All, hint: &[] };
        self.fold(ray, &query, &mut |_, _, _| {
            count += 1;
            FoldControl::Limit(f64::INFINITY)
        })?;
        Ok(count)
    }

    /// Appends every crossing in the scope, ascending in `t`. Those of one path alternate and begin with an entry,
    /// unless only surfaces are requested. Crossings of different paths at the same `t` are in the order of the
    /// paths.
    ///
    /// # Errors
    /// As [`Caster::closest`], [`QueryError::TooMany`] and [`QueryError::OutOfMemory`].
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
        let query = FoldQuery { scope, wanted: Wanted::All, hint: &[] };
        self.fold(ray, &query, &mut |traversal, body_entry, boundary| {
            if out.len() - start >= most {
                refused = Some(QueryError::TooMany { most });
            } else if out.try_reserve(1).is_err() {
                refused = Some(QueryError::OutOfMemory);
            } else {
                out.push(hit(world, traversal, ray, body_entry, &boundary));
                return FoldControl::Limit(f64::INFINITY);
            }
            FoldControl::Stop
        })?;
        refused.map_or(Ok(()), Err)
    }
}
