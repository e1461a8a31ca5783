//! Scene to World: checks, and everything that is worked out once.

use crate::aabb::Aabb;
use crate::scene::{NodeId, Scene};

/// What is wrong with a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct SceneError {
    /// The node at fault; readers know where it was written.
    pub node: Option<NodeId>,
    /// The parameter at fault.
    pub param: Option<&'static str>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub hint: Option<String>,
}

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

/// Sizes of a world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Nodes of the scene.
    pub nodes: usize,
    /// Objects.
    pub objects: usize,
    /// Leaf solids, each counted once however often it is placed.
    pub leaves: usize,
    /// Leaf solids as a ray sees them, every placement counted.
    pub virtual_leaves: u64,
    /// Bytes.
    pub memory_bytes: usize,
}

/// A scene compiled for casting: immutable and shared by all threads.
#[derive(Debug)]
pub struct World {}

/// Checks a scene and builds its world.
///
/// # Errors
/// Everything that is wrong with the scene, not only the first.
pub fn compile(_scene: &Scene, _options: Options) -> Result<World, Vec<SceneError>> {
    Ok(World {})
}

impl World {
    /// The names of the objects, in the order of their numbers.
    pub fn object_names(&self) -> &[String] {
        &[]
    }

    /// The names of the materials, in the order of the scene.
    pub fn material_names(&self) -> &[String] {
        &[]
    }

    /// The number of an object's material.
    pub fn object_material(&self, _object: u32) -> Option<u32> {
        None
    }

    /// The name of a leaf surface: the leaf's place in its body and the surface, as in `box#2.side`.
    pub fn surface_name(&self, _surface: u32) -> String {
        String::new()
    }

    /// The name of an instance path, as in `world/arm[2]/bolt[0]`.
    pub fn path_name(&self, _path: u64) -> String {
        String::new()
    }

    /// A box around everything, in world coordinates; infinite where something is.
    pub fn bounds(&self) -> Aabb {
        Aabb::EMPTY
    }

    /// Sizes.
    pub fn stats(&self) -> Stats {
        Stats::default()
    }
}
