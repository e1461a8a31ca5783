//! Scene to World: everything that is checked and worked out once.
//!
//! The graph is checked (`graph`), leaf solids are built and placed in bodies (`body`), bodies and shared
//! groups are placed in levels (`level`). A part with several parents is compiled once and placed many
//! times; nothing here recurses, so depth is limited by memory only.

mod body;
mod error;
mod graph;
mod level;
mod live;
mod names;
mod parts;
mod sites;
mod world;

pub use error::SceneError;
pub use live::Live;
pub use world::{Stats, World};

pub(crate) use world::{Body, Leaf, Level, Placed, SolidBody, Target};

use crate::scene::Scene;

/// Choices of [`compile`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// The accelerator used at every level, by name (see [`crate::accel::NAMES`]).
    pub accel: &'static str,
}

impl Default for Options {
    fn default() -> Options {
        Options { accel: "bvh" }
    }
}

/// Checks a scene and builds its world.
///
/// # Errors
/// Everything that is wrong with the scene, not only the first.
pub fn compile(scene: &Scene, options: Options) -> Result<World, Vec<SceneError>> {
    check(options)?;
    let graph = graph::Graph::of(scene)?;
    let parts = parts::Parts::build(scene, &graph, options.accel)?;
    level::build(scene, &graph, &parts, options.accel, None)
}

fn check(options: Options) -> Result<(), Vec<SceneError>> {
    if crate::accel::NAMES.contains(&options.accel) {
        return Ok(());
    }
    let known = crate::accel::NAMES.join(", ");
    let message = format!("there is no accelerator named '{}'", options.accel);
    Err(vec![SceneError::general(message).with_hint(format!("known are {known}"))])
}

#[cfg(test)]
mod tests;
