//! The objects that contain a point.

use super::QueryError;
use super::caster::{Caster, all_solid};
use super::membership::line_at;
use crate::compile::Body;
use crate::math::Vec3;
use crate::ray::Span;

impl Caster<'_> {
    /// Appends the objects whose interior contains a point, ascending. Nothing is promised for a point within
    /// rounding error of a surface.
    ///
    /// # Errors
    /// As [`Caster::closest`], and [`QueryError::NotASolid`] for meshes that are not closed.
    pub fn contains(&mut self, p: Vec3, out: &mut Vec<u32>) -> Result<(), QueryError> {
        all_solid(self.world)?;
        let start = out.len();
        let here = Span::new(0.0, 0.0).unwrap_or(Span::FORWARD);
        self.scratch.budget.begin(self.limits.steps);
        self.traversal.begin(self.world, line_at(p), here);
        self.traversal.enter_root(self.world, &mut self.scratch);
        while let Some(body_entry) = self.traversal.next(self.world, 0.0, &mut self.scratch) {
            if let Body::Solid(body) = self.world.body(body_entry.placed.body)
                && self.membership.holds(body, &body_entry.line, here, &mut self.scratch)
            {
                out.push(body_entry.placed.object);
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
