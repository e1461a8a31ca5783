//! The objects that contain a point.

use super::QueryError;
use super::caster::{Caster, all_solid};
use super::membership::line_at;
use super::ownership::at_point;
use crate::compile::Body;
use crate::math::Vec3;
use crate::ray::Span;

impl Caster<'_> {
    /// Appends the objects whose interior contains a point, ascending. What is outside an object that contains it and clips
    /// does not count. Nothing is promised for a point within rounding error of a surface.
    ///
    /// # Errors
    /// As [`Caster::closest`], and [`QueryError::NotASolid`] for meshes that are not closed.
    pub fn contains(&mut self, p: Vec3, out: &mut Vec<u32>) -> Result<(), QueryError> {
        let mut bodies = self.bodies_at(p)?;
        if self.world.clips() {
            bodies = at_point(self.world, &bodies, &mut self.ownership);
        }
        let mut objects: Vec<u32> = bodies.into_iter().map(|(_, object)| object).collect();
        objects.sort_unstable();
        objects.dedup();
        out.append(&mut objects);
        Ok(())
    }

    /// The object that owns a point, and the instance path of its body, as [`Caster::segments`] with
    /// [`Overlaps::Priority`](super::Overlaps::Priority) finds them on a ray through it.
    ///
    /// # Errors
    /// As [`Caster::contains`].
    pub fn owner_at(&mut self, p: Vec3) -> Result<Option<(u32, u64)>, QueryError> {
        let bodies = self.bodies_at(p)?;
        let owner = at_point(self.world, &bodies, &mut self.ownership).first().copied();
        Ok(owner.map(|(path, object)| (object, path)))
    }

    /// The bodies that contain a point, as paths with their objects.
    fn bodies_at(&mut self, p: Vec3) -> Result<Vec<(u64, u32)>, QueryError> {
        all_solid(self.world)?;
        let mut bodies = Vec::new();
        let here = Span::new(0.0, 0.0).unwrap_or(Span::FORWARD);
        self.scratch.budget.begin(self.limits.steps);
        self.traversal.begin(self.world, line_at(p), here);
        self.traversal.enter_root(self.world, &mut self.scratch);
        while let Some(body_entry) = self.traversal.next(self.world, 0.0, &mut self.scratch) {
            if let Body::Solid(body) = self.world.body(body_entry.placed.body)
                && self.membership.holds(body, &body_entry.line, here, &mut self.scratch)
            {
                bodies.push((body_entry.placed.path, body_entry.placed.object));
            }
        }
        self.outcome().map(|()| bodies)
    }
}
