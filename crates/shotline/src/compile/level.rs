//! Levels: the placements of a group, under one accelerator. A group with several parents becomes a level of its own,
//! which is placed like a body. Other groups are flattened into the level that contains them.

use std::sync::Arc;

use std::collections::HashMap;
use std::ops::Range;

use super::accel_choice::AccelChoice;
use super::body::{BodyBuilder, is_body};
use super::built_leaves::BuiltLeaves;
use super::graph::Graph;
use super::names::{Labels, NameId};
use super::world::{Level, ObjectInfo, Placement, Target, World};
use super::{SceneError, Stats};
use crate::aabb::Aabb;
use crate::accel::{self, Items};
use crate::math::{ComposedTransform, TransformPair};
use crate::scene::{Node, NodeId, Scene};

/// Index of one occurrence of a transform on the path from the root of a level to its placements.
pub(super) type OccurrenceId = u32;

/// Receives, in order, the transforms that the levels are built from and the placements below them.
pub(super) trait Recorder {
    /// Records a transform of the level that is being built, below the occurrence `above`. Returns its own occurrence
    /// if it is kept.
    fn add(&mut self, node: NodeId, above: Option<OccurrenceId>) -> Option<OccurrenceId>;

    /// Records that a node is placed in the level that is being built. `baked`: its transforms are part of the body.
    fn place(&mut self, occurrence: Option<OccurrenceId>, node: NodeId, baked: bool, target: Target);

    /// Records that the level that was being built is complete.
    fn end_level(&mut self);
}

/// Records nothing.
impl Recorder for () {
    fn add(&mut self, _node: NodeId, _above: Option<OccurrenceId>) -> Option<OccurrenceId> {
        None
    }
    fn place(&mut self, _: Option<OccurrenceId>, _node: NodeId, _baked: bool, _target: Target) {}
    fn end_level(&mut self) {}
}

/// Builds the world of a scene. The recorder receives the points where each transform of the scene has an effect.
pub(super) fn build(
    scene: &Scene,
    graph: &Graph,
    leaves: &BuiltLeaves,
    choice: AccelChoice,
    recorder: &mut dyn Recorder,
) -> Result<World, Vec<SceneError>> {
    let mut builder = Builder {
        graph,
        labels: Labels::new(scene),
        bodies: BodyBuilder { scene, leaves, choice, surfaces: 0, stats: Stats::default() },
        world: World::empty(scene),
        targets: HashMap::new(),
        objects: HashMap::new(),
        recorder,
    };
    builder.run().map_err(|error| vec![error])?;
    Ok(builder.finish())
}

struct Builder<'s> {
    graph: &'s Graph,
    labels: Labels<'s>,
    bodies: BodyBuilder<'s>,
    world: World,
    /// Shared bodies and groups that have been compiled.
    targets: HashMap<NodeId, Target>,
    objects: HashMap<NodeId, u32>,
    recorder: &'s mut dyn Recorder,
}

/// A pending node on the path down from a level's root.
struct Visit {
    node: NodeId,
    composed: ComposedTransform,
    object: Option<u32>,
    name: NameId,
    /// The innermost transform above, if the recorder keeps it.
    occurrence: Option<OccurrenceId>,
}

/// The placements of each group that is flattened into a level. They are a contiguous range because members are
/// visited depth first.
#[derive(Default)]
struct Groups {
    ranges: Vec<Range<u32>>,
    /// Groups that are being visited: the index of the range, and the height of the stack at which the group ends.
    open: Vec<(usize, usize)>,
}

impl Groups {
    /// Begins a group. It ends when the stack of pending visits has shrunk back to `height`.
    fn begin(&mut self, height: usize, placed: usize) {
        self.open.push((self.ranges.len(), height));
        self.ranges.push(placed as u32..placed as u32);
    }

    fn end(&mut self, height: usize, placed: usize) {
        while let Some((range, _)) = self.open.pop_if(|(_, end)| *end == height) {
            self.ranges[range].end = placed as u32;
        }
    }
}

impl<'s> Builder<'s> {
    fn run(&mut self) -> Result<(), SceneError> {
        let (graph, scene) = (self.graph, self.bodies.scene);
        self.number_objects();
        // Children come before parents, so the targets of a level's placements exist already.
        for &id in graph.postorder.iter().filter(|&&id| graph.is_shared(id)) {
            let node = scene.node(id);
            let target = match node {
                Node::Group { members } => {
                    Target::Level(self.level(members, true, self.bodies.choice.of(id))?)
                }
                _ if is_body(node) => match self.body(id, &ComposedTransform::IDENTITY)? {
                    Some(target) => target,
                    None => continue,
                },
                _ => continue,
            };
            self.targets.insert(id, target);
        }
        self.world.root = self.level(&scene.objects, false, self.bodies.choice.general())?;
        Ok(())
    }

    /// Numbers the objects depth first: each root, in the order of the file, followed by the objects inside it.
    fn number_objects(&mut self) {
        let scene = self.bodies.scene;
        let mut stack: Vec<NodeId> = scene.objects.iter().rev().copied().collect();
        let mut seen = vec![false; scene.nodes.len()];
        while let Some(id) = stack.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            if let Node::Object { name, material, priority, .. } = scene.node(id) {
                let material = material
                    .as_ref()
                    .and_then(|m| scene.materials.iter().position(|(known, _)| known == m).map(|i| i as u32));
                self.objects.insert(id, self.world.objects.len() as u32);
                self.world.objects.push(ObjectInfo { material, priority: *priority });
                self.world.object_names.push(name.clone());
            }
            stack.extend(scene.node(id).children().iter().rev());
        }
    }

    /// Builds a body. Returns `None` for a combination of empty groups, which has nothing to place.
    fn body(&mut self, node: NodeId, composed: &ComposedTransform) -> Result<Option<Target>, SceneError> {
        let body = self.bodies.build(node, composed)?;
        if body.leaf_count() == 0 {
            return Ok(None);
        }
        self.world.bodies.push(Arc::new(body));
        Ok(Some(Target::Body((self.world.bodies.len() - 1) as u32)))
    }

    /// Builds the level of some members. If `indexed`, their names contain their index in the group.
    fn level(&mut self, members: &[NodeId], indexed: bool, accel: &'static str) -> Result<u32, SceneError> {
        let mut level = Level { accel_name: accel, ..Level::default() };
        let mut stack = Vec::new();
        self.push_members(&mut stack, members, None, indexed);
        let mut groups = Groups::default();
        loop {
            groups.end(stack.len(), level.placements.len());
            let Some(visit) = stack.pop() else { break };
            let scene = self.bodies.scene;
            match scene.node(visit.node) {
                Node::Transform { transform, child } => {
                    let composed = transform.inside(&visit.composed);
                    let occurrence = self.recorder.add(visit.node, visit.occurrence);
                    stack.push(Visit { node: *child, composed, occurrence, ..visit });
                }
                Node::Object { node, .. } => {
                    let object = self.objects.get(&visit.node).copied();
                    stack.push(Visit { node: *node, object, ..visit });
                }
                Node::Group { members } if !self.graph.is_shared(visit.node) => {
                    groups.begin(stack.len(), level.placements.len());
                    self.push_members(&mut stack, members, Some(&visit), true);
                }
                _ => self.place(&mut level, visit)?,
            }
        }
        self.recorder.end_level();
        let boxes: Vec<Aabb> = level.placements.iter().map(|p| p.bounds).collect();
        level.bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
        level.accel = accel::build(accel, Items { boxes: &boxes, groups: Some(&groups.ranges) });
        self.world.levels.push(Arc::new(level));
        Ok((self.world.levels.len() - 1) as u32)
    }

    /// Pushes members that are to be visited: those of the level itself, or those of a group that is flattened into
    /// it.
    fn push_members(
        &mut self,
        stack: &mut Vec<Visit>,
        members: &[NodeId],
        group: Option<&Visit>,
        indexed: bool,
    ) {
        let start = stack.len();
        let composed = group.map_or(ComposedTransform::IDENTITY, |g| g.composed);
        let object = group.and_then(|g| g.object);
        let occurrence = group.and_then(|g| g.occurrence);
        for (i, &node) in members.iter().enumerate() {
            let parent = group.map(|g| g.name);
            let name =
                Arc::make_mut(&mut self.world.names).add(parent, self.labels.of(node), indexed.then_some(i));
            stack.push(Visit { node, composed, object, name, occurrence });
        }
        stack[start..].reverse();
    }

    /// Places a body or a shared group. A body that is not shared has its transforms baked in, so that rays are
    /// transformed only once, by the matrix of each leaf.
    fn place(&mut self, level: &mut Level, visit: Visit) -> Result<(), SceneError> {
        let shared = self.targets.get(&visit.node);
        let baked = shared.is_none();
        let (target, placement) = match shared {
            Some(&target) => (target, self.bodies.placed(visit.node, &visit.composed)?),
            None => match self.body(visit.node, &visit.composed)? {
                Some(target) => (target, TransformPair::IDENTITY),
                None => return Ok(()),
            },
        };
        self.recorder.place(visit.occurrence, visit.node, baked, target);
        let first_path = level.path_count;
        level.path_count = level
            .path_count
            .checked_add(self.world.paths_of(target))
            .filter(|&n| n <= i64::MAX as u64)
            .ok_or_else(|| {
                SceneError::at(visit.node, "more than 2^63 instances cannot be numbered".into())
            })?;
        level.leaf_count = level.leaf_count.saturating_add(self.world.leaves_of(target));
        level.placements.push(Placement {
            local_from_parent: placement.local_from_parent,
            bounds: self.world.bounds_of(target).transformed(&placement.parent_from_local),
            target,
            object: visit.object,
            first_path,
            name: visit.name,
        });
        Ok(())
    }

    fn finish(self) -> World {
        let mut world = self.world;
        let root = &world.levels[world.root as usize];
        world.stats = Stats {
            nodes: self.bodies.scene.nodes.len(),
            objects: world.objects.len(),
            leaves: self.bodies.stats.leaves,
            virtual_leaves: root.leaf_count,
            memory_bytes: 0,
            condition: self.bodies.stats.condition,
        };
        world.stats.memory_bytes = world.memory();
        world.surface = world.find_surface();
        world.casts_blocks = world.bodies.iter().any(|body| body.block_meshes().next().is_some());
        let takes_beams = world.root().accel.as_ref().is_some_and(|accel| accel.takes_beams());
        world.casts_lanes = takes_beams && world.bodies.iter().any(|body| body.takes_bundles());
        world
    }
}

impl World {
    fn empty(scene: &Scene) -> World {
        World {
            levels: Vec::new(),
            root: 0,
            bodies: Vec::new(),
            objects: Vec::new(),
            object_names: Vec::new(),
            material_names: scene.materials.iter().map(|(name, _)| name.clone()).collect(),
            names: Arc::default(),
            surface: None,
            casts_blocks: false,
            casts_lanes: false,
            stats: Stats::default(),
        }
    }
}
