//! The paths on which bodies are reached through levels.

use super::traversal::BodyEntry;
use crate::compile::Level;
use crate::math::Vec3;

/// The path to a level.
#[derive(Clone, Copy, Debug)]
struct Step<'w> {
    level: &'w Level,
    /// The path to the level above, and the index of the placement in it; `None` for the root.
    above: Option<(u32, u32)>,
}

/// Paths to levels that some rays have entered. They stay until all of these rays have ended, so a path is only a number.
#[derive(Debug, Default)]
pub(super) struct LevelPaths<'w> {
    steps: Vec<Step<'w>>,
}

/// The path to the root.
pub(super) const ROOT: u32 = 0;

impl<'w> LevelPaths<'w> {
    /// Begins with the path to the root.
    pub fn begin(&mut self, root: &'w Level) {
        self.steps.clear();
        self.steps.push(Step { level: root, above: None });
    }

    /// Adds the path to a level.
    pub fn add(&mut self, level: &'w Level, above: u32, placement: u32) -> u32 {
        self.steps.push(Step { level, above: Some((above, placement)) });
        (self.steps.len() - 1) as u32
    }

    /// The number of paths.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Transforms a normal from the frame of a body to world coordinates, as the traversal of a single ray does.
    pub fn world_normal(&self, body_entry: &BodyEntry, normal: Vec3) -> Vec3 {
        let mut at = Some((body_entry.visit, body_entry.placement));
        let mut n = normal;
        while let Some((path, placement)) = at {
            let Step { level, above } = &self.steps[path as usize];
            n = level.placements[placement as usize].local_from_parent.covector(n);
            at = *above;
        }
        n
    }
}
