//! The paths on which bodies are reached through levels.

use super::traversal::PlacedBody;
use crate::compile::Level;
use crate::math::{Affine, Vec3};

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

    /// The transforms into the frame of a placed body that several rays meet together, innermost first. Rays go through
    /// lattices one by one.
    pub fn frames(&self, placed: &PlacedBody) -> impl Iterator<Item = &'w Affine> {
        let mut at = Some((placed.visit, placed.placement));
        std::iter::from_fn(move || {
            let (path, placement) = at?;
            let Step { level, above } = &self.steps[path as usize];
            at = *above;
            Some(&level.placements[placement as usize].local_from_parent)
        })
    }

    /// Transforms a normal from the frame of a body to world coordinates, as the traversal of a single ray does.
    pub fn world_normal(&self, placed: &PlacedBody, normal: Vec3) -> Vec3 {
        let mut at = Some((placed.visit, placed.placement));
        let mut n = normal;
        while let Some((path, placement)) = at {
            let Step { level, above } = &self.steps[path as usize];
            n = level.placement(placement).local_from_parent.covector(n);
            at = *above;
        }
        n
    }
}
