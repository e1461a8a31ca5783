//! Compiles a scene to a world: everything that is checked and computed once.
//!
//! The graph is checked (`graph`), leaf solids are built and placed in bodies (`body`), bodies and shared groups are
//! placed in levels (`level`). A node with several parents is compiled once and placed many times. Nothing here
//! recurses, so depth is limited by memory only.

mod accel_choice;
mod body;
mod box_frame;
mod box_join;
mod built_leaves;
mod conflict_candidates;
mod dynamic;
mod error;
mod graph;
mod hit_meshes;
mod lane_groups;
mod lattice_cells;
mod lattices;
mod level;
mod materials;
mod names;
mod placements;
#[cfg(any(test, feature = "testkit"))]
mod reference_world;
mod world;

pub use conflict_candidates::{ConflictCandidate, ConflictCandidates, ConflictKind};
pub use dynamic::DynamicWorld;
pub use error::{InvalidScene, SceneError};
pub use hit_meshes::{HitMesh, HitMeshes};
pub use world::{Stats, World};

pub(crate) use lattice_cells::LatticeCells;
pub(crate) use placements::{Level, Placement, Target};
pub(crate) use world::{Body, Leaf, SolidBody, SurfaceBody};

use accel_choice::AccelChoice;
use built_leaves::BuiltLeaves;

use crate::scene::Scene;

/// Options of [`compile`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The accelerator used everywhere, by name (see [`crate::accel::NAMES`]), regardless of the scene. With `None`,
    /// the scene's own [choices](Scene::accels) apply, and [`crate::accel::DEFAULT`] where it has none.
    pub accel: Option<&'static str>,
}

/// Checks a scene and builds its world.
///
/// # Errors
/// Everything that is wrong with the scene, not only the first error.
pub fn compile(scene: &Scene, options: Options) -> Result<World, Vec<SceneError>> {
    build(scene, options, &mut ()).map(|(world, _)| world)
}

/// Checks a scene and builds its world, and returns its leaves too. Reports to the recorder what depends on each
/// transform.
fn build(
    scene: &Scene,
    options: Options,
    recorder: &mut dyn level::Recorder,
) -> Result<(World, BuiltLeaves), Vec<SceneError>> {
    let choice = AccelChoice::new(scene, options)?;
    let graph = graph::Graph::of(scene)?;
    let mut errors = materials::check(scene);
    errors.extend(lattices::check(scene));
    let leaves = match BuiltLeaves::build(scene, &graph, choice) {
        Ok(leaves) if errors.is_empty() => leaves,
        Ok(_) => return Err(errors),
        Err(more) => {
            errors.extend(more);
            return Err(errors);
        }
    };
    let world = level::build(scene, &graph, &leaves, choice, recorder)?;
    Ok((world, leaves))
}

impl Scene {
    /// Builds the world of the scene, with the accelerators that it names: [`compile`], with all errors as one.
    ///
    /// # Errors
    /// [`InvalidScene`] holds everything that is wrong with the scene, not only the first error.
    pub fn compile(&self) -> Result<World, InvalidScene> {
        compile(self, Options::default()).map_err(|errors| InvalidScene::new(self, errors))
    }
}

#[cfg(test)]
mod tests;
