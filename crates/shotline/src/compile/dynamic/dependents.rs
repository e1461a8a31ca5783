//! Where each transform of a scene takes effect in its world: what must be updated when it changes.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::super::level::{OccurrenceId, Recorder};
use super::super::placements::Target;
use crate::math::ComposedTransform;
use crate::scene::{Node, NodeId, Scene};

/// A transform on the path from the root of a level to placements. A transform below a shared one occurs several
/// times.
#[derive(Clone, Copy, Debug)]
struct Occurrence {
    node: NodeId,
    level: u32,
    above: Option<OccurrenceId>,
    /// The placements below it are `first..end`.
    first: u32,
    end: u32,
}

/// The source of a placement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub node: NodeId,
    /// Whether the matrix is baked into the body.
    pub baked: bool,
    /// The innermost transform above it.
    occurrence: Option<OccurrenceId>,
}

/// A placement: its level, and its index there.
pub(super) type PlacementRef = (u32, u32);

/// The transforms of a scene and the placements of its world.
#[derive(Debug, Default)]
pub(super) struct Dependents {
    occurrences: Vec<Occurrence>,
    /// By level and placement.
    origins: Vec<Vec<Origin>>,
    level: Vec<Origin>,
    of_node: HashMap<NodeId, Vec<OccurrenceId>>,
    bodies: HashMap<u32, Vec<PlacementRef>>,
    levels: HashMap<u32, Vec<PlacementRef>>,
    /// For each transform inside combinations, one placement of each of these combinations. Computed on first use.
    operands: OnceLock<HashMap<NodeId, Vec<PlacementRef>>>,
}

impl Dependents {
    /// The source of a placement.
    pub(super) fn origin(&self, (level, placement): PlacementRef) -> Origin {
        self.origins[level as usize][placement as usize]
    }

    /// The product of the transforms between the root of the level and a source.
    pub(super) fn composed(&self, scene: &Scene, origin: Origin) -> ComposedTransform {
        let mut path = Vec::new();
        let mut next = origin.occurrence;
        while let Some(id) = next {
            let occurrence = &self.occurrences[id as usize];
            path.push(occurrence.node);
            next = occurrence.above;
        }
        path.iter().rev().fold(ComposedTransform::IDENTITY, |composed, &node| match scene.node(node) {
            Node::Transform { transform, .. } => transform.inside(&composed),
            _ => composed,
        })
    }

    /// Every placement of a level.
    pub(super) fn of_level(&self, level: u32) -> &[PlacementRef] {
        self.levels.get(&level).map_or(&[], Vec::as_slice)
    }

    /// Every placement of a body.
    pub(super) fn of_body(&self, body: u32) -> &[PlacementRef] {
        self.bodies.get(&body).map_or(&[], Vec::as_slice)
    }

    /// The placements that a transform moves as a whole.
    pub(super) fn moved_by(&self, node: NodeId) -> impl Iterator<Item = PlacementRef> {
        let occurrences = self.of_node.get(&node).map_or(&[] as &[OccurrenceId], Vec::as_slice);
        occurrences.iter().flat_map(|&id| {
            let Occurrence { level, first, end, .. } = self.occurrences[id as usize];
            (first..end).map(move |placement| (level, placement))
        })
    }

    /// One placement of each body that contains a transform above one of its operands.
    pub(super) fn bodies_with(&self, scene: &Scene, node: NodeId) -> Vec<PlacementRef> {
        let operands = self.operands.get_or_init(|| find_operands(scene, &self.origins, &self.bodies));
        operands.get(&node).cloned().unwrap_or_default()
    }
}

impl Recorder for Dependents {
    /// Adds an occurrence of a transform to the level that is being built.
    fn add(&mut self, node: NodeId, above: Option<OccurrenceId>) -> Option<OccurrenceId> {
        let id = self.occurrences.len() as OccurrenceId;
        let (level, here) = (self.origins.len() as u32, self.level.len() as u32);
        self.occurrences.push(Occurrence { node, level, above, first: here, end: here });
        self.of_node.entry(node).or_default().push(id);
        Some(id)
    }

    /// Adds a placement to the level that is being built.
    fn place(&mut self, occurrence: Option<OccurrenceId>, node: NodeId, baked: bool, target: Target) {
        let placement = (self.origins.len() as u32, self.level.len() as u32);
        self.level.push(Origin { node, baked, occurrence });
        let mut next = occurrence;
        while let Some(id) = next {
            let occurrence = &mut self.occurrences[id as usize];
            occurrence.end = placement.1 + 1;
            next = occurrence.above;
        }
        match target {
            Target::Body(body) => self.bodies.entry(body).or_default().push(placement),
            Target::Level(level) => self.levels.entry(level).or_default().push(placement),
        }
    }

    /// The level that was being built is complete.
    fn end_level(&mut self) {
        self.origins.push(std::mem::take(&mut self.level));
    }
}

/// Finds, for each transform inside combinations, one placement of each of these combinations.
fn find_operands(
    scene: &Scene,
    origins: &[Vec<Origin>],
    bodies: &HashMap<u32, Vec<PlacementRef>>,
) -> HashMap<NodeId, Vec<PlacementRef>> {
    let mut found: HashMap<NodeId, Vec<PlacementRef>> = HashMap::new();
    for placements in bodies.values() {
        let placement = placements[0];
        let root = origins[placement.0 as usize][placement.1 as usize].node;
        let mut seen = std::collections::HashSet::new();
        let mut stack = vec![root];
        while let Some(node) = stack.pop() {
            if !seen.insert(node) {
                continue;
            }
            if matches!(scene.node(node), Node::Transform { .. }) {
                found.entry(node).or_default().push(placement);
            }
            stack.extend(scene.node(node).children());
        }
    }
    found
}
