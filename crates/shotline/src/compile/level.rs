//! Levels: the placements of a group, under one accelerator. A group with several parents becomes a level of its own,
//! which is placed like a body. Other groups are flattened into the level that contains them. An object with contents is
//! a group of its shape and its contents.

use std::sync::Arc;

use std::collections::HashMap;
use std::ops::Range;

use super::accel_choice::AccelChoice;
use super::body::{BodyBuilder, is_body};
use super::box_frame::turn_boxes;
use super::built_leaves::BuiltLeaves;
use super::graph::Graph;
use super::lane_groups::lane_groups;
use super::lattice_cells::{Element, LatticeCells};
use super::names::{Labels, NO_NAME, NameId};
use super::placements::{Level, ObjectScope, Placement, Target};
use super::world::{ObjectInfo, World};
use super::{SceneError, Stats};
use crate::aabb::Aabb;
use crate::accel::{self, Items, LatticeIndex};
use crate::math::{Affine, ComposedTransform, Lattice, TransformPair};
use crate::scene::{EMPTY_CELL, Node, NodeId, Scene};

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

/// A node on the path down from a level's root.
struct Visit {
    node: NodeId,
    composed: ComposedTransform,
    object: Option<u32>,
    /// The innermost scope around it in the level.
    scope: Option<u32>,
    name: NameId,
    /// The innermost transform above, if the recorder keeps it.
    occurrence: Option<OccurrenceId>,
}

/// Members that are being visited: those of the level itself, or those of a group that is flattened into it. They are
/// visited one by one, so a group of a million members needs no room for a million visits.
struct Members<'s> {
    list: MemberList<'s>,
    /// The group; `None` for the level itself.
    group: Option<Group>,
    /// The object that they are in; `None` where it is named above the level.
    object: Option<u32>,
    /// The scope that they are in, and whether it ends with them.
    scope: Option<u32>,
    ends_scope: bool,
}

/// The members of a group, or the roots of a scene. An object with contents is a group of its shape and its contents.
#[derive(Clone, Copy)]
struct MemberList<'s> {
    /// The shape, which comes first and has the name of the object.
    shape: Option<NodeId>,
    nodes: &'s [NodeId],
    /// Whether the names of `nodes` contain their index.
    indexed: bool,
    /// How many have been visited, the shape among them.
    visited: usize,
}

impl<'s> MemberList<'s> {
    /// The members of a node that is a group.
    fn of(node: &'s Node) -> Option<MemberList<'s>> {
        match node {
            Node::Group { members } => {
                Some(MemberList { shape: None, nodes: members, indexed: true, visited: 0 })
            }
            Node::Object { node, contents, .. } if !contents.is_empty() => {
                Some(MemberList { shape: Some(*node), nodes: contents, indexed: true, visited: 0 })
            }
            _ => None,
        }
    }

    /// The next member, with its index; the shape has none.
    fn next(&mut self) -> Option<(NodeId, Option<usize>)> {
        let number = self.visited;
        self.visited += 1;
        match self.shape {
            Some(shape) if number == 0 => Some((shape, None)),
            _ => {
                let index = number - usize::from(self.shape.is_some());
                self.nodes.get(index).map(|&node| (node, Some(index)))
            }
        }
    }
}

/// A group that is flattened into a level.
struct Group {
    visit: Visit,
    /// The index of its range among those of all groups of the level.
    range: usize,
}

impl<'s> Builder<'s> {
    fn run(&mut self) -> Result<(), SceneError> {
        let (graph, scene) = (self.graph, self.bodies.scene);
        self.number_objects();
        // Children come before parents, so the targets of a level's placements exist already.
        for &id in graph.postorder.iter().filter(|&&id| graph.is_shared(id)) {
            let node = scene.node(id);
            let target = match (node, MemberList::of(node)) {
                (Node::Lattice { lattice, elements, table }, _) => {
                    self.lattice(id, *lattice, elements, table.as_deref())?
                }
                (_, Some(members)) => {
                    let object = self.objects.get(&id).copied();
                    let (mut level, groups) = self.level(members, object)?;
                    turn_boxes(&mut level, &self.world);
                    Some(Target::Level(self.add_level(level, &groups, self.bodies.choice.of(id))))
                }
                _ if is_body(node) => self.body(id, &ComposedTransform::IDENTITY)?,
                _ => None,
            };
            let Some(target) = target else { continue };
            self.targets.insert(id, target);
        }
        let roots = MemberList { shape: None, nodes: &scene.objects, indexed: false, visited: 0 };
        let (root, groups) = self.level(roots, None)?;
        self.world.root = self.add_level(root, &groups, self.bodies.choice.general());
        Arc::make_mut(&mut self.world.names).shrink();
        Ok(())
    }

    /// Numbers the objects.
    fn number_objects(&mut self) {
        let scene = self.bodies.scene;
        for id in scene.numbered_objects() {
            if let Node::Object { name, material, priority, clip, .. } = scene.node(id) {
                let material = material
                    .as_ref()
                    .and_then(|m| scene.materials.iter().position(|(known, _)| known == m).map(|i| i as u32));
                self.objects.insert(id, self.world.objects.len() as u32);
                self.world.objects.push(ObjectInfo { material, priority: *priority, clip: *clip });
                self.world.object_names.push(name.clone());
            }
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

    /// Builds the level of some members, but for its accelerator; those of an object with contents are in its scope. Also
    /// returns the ranges of placements that are groups.
    fn level(
        &mut self,
        members: MemberList<'s>,
        object: Option<u32>,
    ) -> Result<(Level, Vec<Range<u32>>), SceneError> {
        let mut level = Level::default();
        let scope = object.map(|object| add_scope(&mut level, object, None));
        // The placements of each group. They are a contiguous range because members are visited depth first.
        let mut ranges: Vec<Range<u32>> = Vec::new();
        let mut open = vec![Members { list: members, group: None, object, scope, ends_scope: true }];
        while let Some(members) = open.last_mut() {
            let placed = level.placements.len() as u32;
            let Some(visit) = self.next_visit(members) else {
                if let Some(group) = &members.group {
                    ranges[group.range].end = placed;
                }
                if let (Some(scope), true) = (members.scope, members.ends_scope) {
                    level.scopes[scope as usize].paths.end = level.path_count;
                }
                open.pop();
                continue;
            };
            let visit = self.pass_transforms(visit);
            match MemberList::of(self.bodies.scene.node(visit.node)) {
                Some(list) if !self.graph.is_shared(visit.node) => {
                    let object = self.objects.get(&visit.node).copied().or(visit.object);
                    let (scope, ends_scope) = scope_of_group(&mut level, object, visit.scope);
                    let group = Some(Group { visit, range: ranges.len() });
                    ranges.push(placed..placed);
                    open.push(Members { list, group, object, scope, ends_scope });
                }
                _ => self.place(&mut level, visit)?,
            }
        }
        self.recorder.end_level();
        level.placements.shrink_to_fit();
        level.bounds = level.placements.iter().fold(Aabb::EMPTY, |all, placed| all.union(&placed.bounds));
        Ok((level, ranges))
    }

    /// Adds a level with an accelerator over the boxes of its placements.
    fn add_level(&mut self, mut level: Level, groups: &[Range<u32>], accel: &'static str) -> u32 {
        let boxes: Vec<Aabb> = level.placements.iter().map(|p| p.bounds).collect();
        level.accel_name = accel;
        level.accel = accel::build(accel, Items { boxes: &boxes, groups: Some(groups) });
        self.world.levels.push(Arc::new(level));
        (self.world.levels.len() - 1) as u32
    }

    /// Builds the level of a lattice. Returns `None` if no cell holds anything.
    fn lattice(
        &mut self,
        id: NodeId,
        lattice: Lattice,
        elements: &[NodeId],
        table: Option<&[u32]>,
    ) -> Result<Option<Target>, SceneError> {
        let mut level = Level { accel_name: "lattice", ..Level::default() };
        let (mut of_cells, mut numbers) = (Vec::new(), Vec::new());
        let uses = self.bodies.scene.node(id).element_uses().unwrap_or_default();
        for (&node, uses) in elements.iter().zip(uses) {
            // What no cell holds is not in the world.
            let placed = if uses > 0 { self.element(node)? } else { None };
            numbers.push(placed.as_ref().map_or(EMPTY_CELL, |_| of_cells.len() as u32));
            if let Some((element, placement)) = placed {
                of_cells.push(element);
                level.placements.push(placement);
            }
        }
        if of_cells.is_empty() {
            return Ok(None);
        }
        let number = |&element: &u32| numbers.get(element as usize).copied().unwrap_or(EMPTY_CELL);
        let table: Option<Arc<[u32]>> = table.map(|table| table.iter().map(number).collect());
        let count = |of: fn(&Element) -> u64| match &table {
            None => of(&of_cells[0]).checked_mul(lattice.cell_count()),
            Some(table) => table
                .iter()
                .filter_map(|&element| of_cells.get(element as usize))
                .try_fold(0u64, |sum, element| sum.checked_add(of(element))),
        };
        level.leaf_count = count(|element| element.leaf_count).unwrap_or(u64::MAX);
        level.path_count = count(|element| element.path_count)
            .filter(|&n| n <= i64::MAX as u64)
            .ok_or_else(|| SceneError::at(id, "more than 2^63 instances cannot be numbered".into()))?;
        let cells = LatticeCells::new(lattice, of_cells, table);
        level.bounds = cells.all_bounds();
        if cells.element_bounds().is_finite() && !level.bounds.is_finite() {
            return Err(SceneError::at(id, "the cells of this lattice are too far away".into())
                .with_hint("use smaller numbers, or another unit of length"));
        }
        for (element, placed) in (0..).zip(&mut level.placements) {
            placed.bounds = cells.bounds(0, element);
        }
        let index = LatticeIndex::new(lattice, cells.element_bounds(), cells.table().cloned());
        level.accel = Some(Box::new(index));
        level.lattice = Some(Box::new(cells));
        self.recorder.end_level();
        self.world.levels.push(Arc::new(level));
        Ok(Some(Target::Level((self.world.levels.len() - 1) as u32)))
    }

    /// An element of a lattice, and the placement from which those of its cells are made. Returns `None` if there is nothing
    /// to place.
    fn element(&mut self, node: NodeId) -> Result<Option<(Element, Placement)>, SceneError> {
        let (label, _) = self.labels.of(node);
        let name = Arc::make_mut(&mut self.world.names).add(NO_NAME, label, None);
        let (mut at, mut object, mut chain) = (node, None, Vec::new());
        loop {
            match self.bodies.scene.node(at) {
                Node::Transform { transform, child } => {
                    chain.extend(transform.matrices());
                    at = *child;
                }
                Node::Object { node, contents, .. } if contents.is_empty() => {
                    object = self.objects.get(&at).copied();
                    at = *node;
                }
                _ => break,
            }
        }
        let Some(&target) = self.targets.get(&at) else { return Ok(None) };
        let transform = self.bodies.shifted(at, &chain)?;
        let element = Element {
            transform,
            bounds: self.world.bounds_of(target),
            path_count: self.world.paths_of(target),
            leaf_count: self.world.leaves_of(target),
        };
        let placement = Placement {
            local_from_parent: Affine::IDENTITY,
            bounds: Aabb::EMPTY,
            target,
            object,
            scope: None,
            first_path: 0,
            name,
        };
        Ok(Some((element, placement)))
    }

    /// The visit of the next member, if there is one left.
    fn next_visit(&mut self, members: &mut Members) -> Option<Visit> {
        let (node, index) = members.list.next()?;
        let group = members.group.as_ref().map(|group| &group.visit);
        let above = group.map_or(NO_NAME, |group| group.name);
        let names = Arc::make_mut(&mut self.world.names);
        let name = match index {
            None => above,
            Some(index) => {
                let (label, is_given) = self.labels.of(node);
                names.add(above, label, Some(index).filter(|_| members.list.indexed && !is_given))
            }
        };
        Some(Visit {
            node,
            composed: group.map_or(ComposedTransform::IDENTITY, |group| group.composed),
            object: members.object,
            scope: members.scope,
            name,
            occurrence: group.and_then(|group| group.occurrence),
        })
    }

    /// Goes on to the first node below that is no transform and no object without contents.
    fn pass_transforms(&mut self, mut visit: Visit) -> Visit {
        let scene = self.bodies.scene;
        loop {
            match scene.node(visit.node) {
                Node::Transform { transform, child } => {
                    visit.composed = transform.inside(&visit.composed);
                    visit.occurrence = self.recorder.add(visit.node, visit.occurrence);
                    visit.node = *child;
                }
                Node::Object { node, contents, .. } if contents.is_empty() => {
                    visit.object = self.objects.get(&visit.node).copied();
                    visit.node = *node;
                }
                _ => return visit,
            }
        }
    }

    /// Places a body or a shared group. A body that is not shared has its transforms baked in, so that rays are
    /// transformed only once, by the matrix of each leaf.
    fn place(&mut self, level: &mut Level, visit: Visit) -> Result<(), SceneError> {
        let shared = self.graph.is_shared(visit.node).then(|| self.targets.get(&visit.node)).flatten();
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
            scope: visit.scope,
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
        world.lane_groups = lane_groups(&world.bodies);
        world.stats.memory_bytes = world.memory();
        world.clips = world.objects.iter().any(|object| object.clip);
        world.surface = world.find_surface();
        world.casts_blocks = world.bodies.iter().any(|body| body.block_meshes().next().is_some());
        let takes_beams = world.root().accel.as_ref().is_some_and(|accel| accel.takes_beams());
        let is_walked = |level: &Arc<Level>| level.accel.as_ref().is_none_or(|accel| accel.takes_beams());
        world.casts_waves = !world.casts_blocks && world.levels.iter().all(is_walked);
        world.casts_lanes = takes_beams && world.bodies.iter().any(|body| body.takes_bundles());
        world
    }
}

/// The scope of the members of a group, and whether it ends with them: a new one if their object begins with the group.
fn scope_of_group(level: &mut Level, object: Option<u32>, around: Option<u32>) -> (Option<u32>, bool) {
    match object {
        Some(object) if around.is_none_or(|scope| level.scopes[scope as usize].object != object) => {
            (Some(add_scope(level, object, around)), true)
        }
        _ => (around, false),
    }
}

/// Adds a scope that begins with the next placement of a level.
fn add_scope(level: &mut Level, object: u32, parent: Option<u32>) -> u32 {
    level.scopes.push(ObjectScope { object, parent, paths: level.path_count..level.path_count });
    (level.scopes.len() - 1) as u32
}

impl World {
    fn empty(scene: &Scene) -> World {
        World {
            levels: Vec::new(),
            root: 0,
            bodies: Vec::new(),
            lane_groups: Vec::new(),
            objects: Vec::new(),
            clips: false,
            object_names: Vec::new(),
            material_names: scene.materials.iter().map(|(name, _)| name.clone()).collect(),
            names: Arc::default(),
            surface: None,
            casts_blocks: false,
            casts_lanes: false,
            casts_waves: false,
            stats: Stats::default(),
        }
    }
}
