//! Worlds without the special cases for bodies of few leaves and for turned placements, as a reference for tests of those
//! cases.

use std::sync::Arc;

use super::World;
use super::world::Body;
use crate::aabb::Aabb;
use crate::accel;

impl World {
    /// Returns the same world with every body under the accelerator `name`, with counters for every program, with the boxes of
    /// each level in its own frame, and with rays one by one.
    ///
    /// # Panics
    /// If bodies are shared with another world.
    pub(crate) fn reference_world(mut self, name: &str) -> World {
        for body in &mut self.bodies {
            let Some(body) = Arc::get_mut(body) else { panic!("bodies are shared with another world") };
            if let Body::Solid(body) = body {
                let boxes: Vec<Aabb> = body.leaves.iter().map(|leaf| leaf.bounds).collect();
                body.accel = accel::build(name, &boxes);
                body.program.forget_table();
                (body.takes_lanes, body.takes_bundles, body.takes_waves) = (false, false, false);
            }
        }
        for number in 0..self.levels.len() {
            if self.levels[number].box_frame.is_some() {
                let mut level = (*self.levels[number]).clone();
                let boxes: Vec<Aabb> = level.numbers().map(|i| self.placed_bounds(&level, i)).collect();
                for (placed, bounds) in level.placements.iter_mut().zip(&boxes) {
                    placed.bounds = *bounds;
                }
                level.box_frame = None;
                level.accel = accel::build(name, &boxes);
                self.levels[number] = Arc::new(level);
            }
        }
        (self.casts_lanes, self.casts_waves) = (false, false);
        self
    }
}
