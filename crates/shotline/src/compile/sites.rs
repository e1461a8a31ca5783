//! Where each transform of a scene counts in its world: what has to be placed anew when it changes.

use std::collections::HashMap;
use std::sync::OnceLock;

use super::world::Target;
use crate::math::Chain;
use crate::scene::{Node, NodeId, Scene};

/// Index of a [`Site`].
pub(super) type SiteId = u32;

/// A transform on the way from the root of a level to placements. One below a shared transform has several.
#[derive(Clone, Copy, Debug)]
struct Site {
    node: NodeId,
    level: u32,
    above: Option<SiteId>,
    /// The placements below it are `first..end`.
    first: u32,
    end: u32,
}

/// What was placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub node: NodeId,
    /// Whether the matrix is part of the body.
    pub baked: bool,
    /// The innermost transform above it.
    site: Option<SiteId>,
}

/// A placement: its level, and its number there.
pub(super) type Place = (u32, u32);

/// The transforms of a scene and the placements of its world.
#[derive(Debug, Default)]
pub(super) struct Sites {
    sites: Vec<Site>,
    /// By level and placement.
    origins: Vec<Vec<Origin>>,
    level: Vec<Origin>,
    of_node: HashMap<NodeId, Vec<SiteId>>,
    bodies: HashMap<u32, Vec<Place>>,
    levels: HashMap<u32, Vec<Place>>,
    /// Where nodes are used that are operands, or within operands: as found when first asked.
    operands: OnceLock<HashMap<NodeId, Vec<Place>>>,
}

impl Sites {
    /// A transform comes up in the level that is being built.
    pub(super) fn add(&mut self, node: NodeId, above: Option<SiteId>) -> SiteId {
        let id = self.sites.len() as SiteId;
        let (level, here) = (self.origins.len() as u32, self.level.len() as u32);
        self.sites.push(Site { node, level, above, first: here, end: here });
        self.of_node.entry(node).or_default().push(id);
        id
    }

    /// Something is placed in the level that is being built.
    pub(super) fn place(&mut self, site: Option<SiteId>, node: NodeId, baked: bool, target: Target) {
        let place = (self.origins.len() as u32, self.level.len() as u32);
        self.level.push(Origin { node, baked, site });
        let mut next = site;
        while let Some(id) = next {
            let site = &mut self.sites[id as usize];
            site.end = place.1 + 1;
            next = site.above;
        }
        match target {
            Target::Body(body) => self.bodies.entry(body).or_default().push(place),
            Target::Level(level) => self.levels.entry(level).or_default().push(place),
        }
    }

    /// The level that was being built is complete.
    pub(super) fn end_level(&mut self) {
        self.origins.push(std::mem::take(&mut self.level));
    }

    /// What was placed at a place.
    pub(super) fn origin(&self, (level, placement): Place) -> Origin {
        self.origins[level as usize][placement as usize]
    }

    /// The transforms between the root of the level and what was placed, together.
    pub(super) fn chain(&self, scene: &Scene, origin: Origin) -> Chain {
        let mut ways = Vec::new();
        let mut next = origin.site;
        while let Some(id) = next {
            let site = &self.sites[id as usize];
            ways.push(site.node);
            next = site.above;
        }
        ways.iter().rev().fold(Chain::IDENTITY, |chain, &node| match scene.node(node) {
            Node::Transform { transform, .. } => transform.inside(&chain),
            _ => chain,
        })
    }

    /// Every place of a level.
    pub(super) fn of_level(&self, level: u32) -> &[Place] {
        self.levels.get(&level).map_or(&[], Vec::as_slice)
    }

    /// Every place of a body.
    pub(super) fn of_body(&self, body: u32) -> &[Place] {
        self.bodies.get(&body).map_or(&[], Vec::as_slice)
    }

    /// The placements that a transform moves as a whole.
    pub(super) fn moved_by(&self, node: NodeId) -> impl Iterator<Item = Place> {
        let sites = self.of_node.get(&node).map_or(&[] as &[SiteId], Vec::as_slice);
        sites.iter().flat_map(|&id| {
            let Site { level, first, end, .. } = self.sites[id as usize];
            (first..end).map(move |placement| (level, placement))
        })
    }

    /// A place of each body in which a transform stands: above an operand.
    pub(super) fn within(&self, scene: &Scene, node: NodeId) -> Vec<Place> {
        let operands = self.operands.get_or_init(|| find_operands(scene, &self.origins, &self.bodies));
        operands.get(&node).cloned().unwrap_or_default()
    }
}

/// For each transform inside of combinations a place of each of them.
fn find_operands(
    scene: &Scene,
    origins: &[Vec<Origin>],
    bodies: &HashMap<u32, Vec<Place>>,
) -> HashMap<NodeId, Vec<Place>> {
    let mut found: HashMap<NodeId, Vec<Place>> = HashMap::new();
    for places in bodies.values() {
        let place = places[0];
        let root = origins[place.0 as usize][place.1 as usize].node;
        let mut seen = std::collections::HashSet::new();
        let mut stack = vec![root];
        while let Some(node) = stack.pop() {
            if !seen.insert(node) {
                continue;
            }
            if matches!(scene.node(node), Node::Transform { .. }) {
                found.entry(node).or_default().push(place);
            }
            stack.extend(scene.node(node).children());
        }
    }
    found
}
