//! Chooses the accelerator of each level, body and mesh.

use super::{Options, SceneError};
use crate::accel;
use crate::scene::{NodeId, Scene};

/// The accelerators of a scene with some options.
#[derive(Clone, Copy, Debug)]
pub(super) struct AccelChoice<'s> {
    scene: &'s Scene,
    everywhere: Option<&'static str>,
}

impl<'s> AccelChoice<'s> {
    /// # Errors
    /// One error for each name that is not the name of an accelerator.
    pub fn new(scene: &'s Scene, options: Options) -> Result<AccelChoice<'s>, Vec<SceneError>> {
        let mut of_nodes: Vec<_> = scene.accels.iter().map(|(&node, &name)| (Some(node), name)).collect();
        of_nodes.sort_unstable();
        let all = of_nodes.into_iter().chain(scene.accel.map(|name| (None, name)));
        let all = all.chain(options.accel.map(|name| (None, name)));
        let unknown = all.filter(|(_, name)| !accel::NAMES.contains(name)).map(|(node, name)| {
            let message = format!("there is no accelerator named '{name}'");
            let error = node.map_or_else(
                || SceneError::general(message.clone()),
                |node| SceneError::at(node, message.clone()),
            );
            error.with_hint(format!("known are {}", accel::NAMES.join(", ")))
        });
        let unknown: Vec<SceneError> = unknown.collect();
        if unknown.is_empty() { Ok(AccelChoice::new_unchecked(scene, options)) } else { Err(unknown) }
    }

    /// As [`AccelChoice::new`], for a scene and options that have been checked.
    pub fn new_unchecked(scene: &'s Scene, options: Options) -> AccelChoice<'s> {
        AccelChoice { scene, everywhere: options.accel }
    }

    /// The accelerator of a node.
    pub fn of(&self, node: NodeId) -> &'static str {
        self.everywhere.or_else(|| self.scene.accels.get(&node).copied()).unwrap_or(self.general())
    }

    /// The accelerator of nodes that have none of their own, and of the scene as a whole.
    pub fn general(&self) -> &'static str {
        self.everywhere.or(self.scene.accel).unwrap_or(accel::DEFAULT)
    }
}
