//! Worlds without the special cases for bodies of few leaves, as a reference for tests of those cases.

use std::sync::Arc;

use super::World;
use super::world::Body;
use crate::aabb::Aabb;
use crate::accel;

impl World {
    /// Returns the same world with every body under the accelerator `name`, with counters for every program, and
    /// with rays one by one.
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
        (self.casts_lanes, self.casts_waves) = (false, false);
        self
    }
}
