//! The compiled form of a scene.

use std::borrow::Cow;
use std::sync::Arc;

use super::names::PathNames;
use super::placements::{Level, Placement, Target};
use crate::aabb::Aabb;
use crate::accel::Accelerator;
use crate::csg::Program;
use crate::math::{Affine, ComposedTransform};
use crate::solid::Solid;
use crate::solid::mesh::MeshSolid;

/// Sizes of a world, and the condition of its matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Nodes of the scene.
    pub nodes: usize,
    /// Objects.
    pub objects: usize,
    /// Leaf solids in memory, each counted once however often it is placed.
    pub leaves: usize,
    /// Leaf solids in the scene as rays see it: each counted once for every placement.
    pub virtual_leaves: u64,
    /// Memory in bytes.
    pub memory_bytes: usize,
    /// The largest condition number of a matrix that transforms rays; 0 if there is none.
    pub condition: f64,
}

/// A scene compiled for ray queries: immutable, and shared by all threads.
#[derive(Clone, Debug)]
pub struct World {
    /// Levels and bodies may be shared with worlds that differ from this one elsewhere: see [`super::DynamicWorld`].
    pub(super) levels: Vec<Arc<Level>>,
    pub(super) root: u32,
    pub(super) bodies: Vec<Arc<Body>>,
    /// For each body a number: rays can be cast in lanes together at bodies with the same. Apart from the bodies, so that
    /// these are not fetched only for it.
    pub(super) lane_groups: Vec<u32>,
    pub(super) objects: Vec<ObjectInfo>,
    /// Whether there is an object whose contents count only inside it.
    pub(super) clips: bool,
    pub(super) object_names: Vec<String>,
    pub(super) material_names: Vec<String>,
    pub(super) names: Arc<PathNames>,
    /// The number of an object with a body that is not a solid, and the number of that body.
    pub(super) surface: Option<(u32, u32)>,
    /// Whether there is a mesh at which blocks of rays can be cast.
    pub(super) casts_blocks: bool,
    /// Whether rays that run close together can be cast at bodies in lanes.
    pub(super) casts_lanes: bool,
    /// Whether rays can be cast in waves: there are no meshes, and all levels can be walked.
    pub(super) casts_waves: bool,
    pub(super) stats: Stats,
}

#[derive(Clone, Debug)]
pub(super) struct ObjectInfo {
    pub material: Option<u32>,
    pub priority: i32,
    /// Whether what it contains counts only inside it.
    pub clip: bool,
}

/// Anything that rays can hit, in a frame of its own.
#[derive(Debug)]
pub(crate) enum Body {
    Solid(SolidBody),
    /// A mesh that is not closed: it has hits but no inside.
    Surface(SurfaceBody),
}

/// A combination of leaves.
#[derive(Debug)]
pub(crate) struct SolidBody {
    pub leaves: Vec<Leaf>,
    pub program: Program,
    /// Over the effective bounds of the leaves; `None` where they are few.
    pub accel: Option<Box<dyn Accelerator>>,
    pub bounds: Aabb,
    pub first_surface: u32,
    /// Whether rays can be cast at it in lanes: it has few leaves, and no meshes.
    pub takes_lanes: bool,
    /// Whether the rays of a bundle can share a traversal of its accelerator: it has no meshes.
    pub takes_bundles: bool,
    /// Whether rays of a wave can be cast at it together: all its leaves take lanes, and its program is one chain of
    /// operations.
    pub takes_waves: bool,
}

/// A placed solid.
#[derive(Debug)]
pub(crate) struct Leaf {
    pub solid: Arc<dyn Solid>,
    pub kind: &'static str,
    /// The number of the solid that it is, or is part of, among those of the body.
    pub number: u32,
    /// The names of its surfaces.
    pub surfaces: &'static [&'static str],
    pub local_from_body: Affine,
    /// Where the leaf can affect the result, in the frame of the body.
    pub bounds: Aabb,
    pub first_surface: u32,
}

#[derive(Debug)]
pub(crate) struct SurfaceBody {
    pub mesh: Arc<MeshSolid>,
    pub local_from_body: Affine,
    pub bounds: Aabb,
    pub first_surface: u32,
}

impl World {
    /// The names of the objects, in the order of their numbers.
    pub fn object_names(&self) -> &[String] {
        &self.object_names
    }

    /// The names of the materials, in the order of the scene.
    pub fn material_names(&self) -> &[String] {
        &self.material_names
    }

    /// The number of an object's material.
    pub fn object_material(&self, object: u32) -> Option<u32> {
        self.objects[object as usize].material
    }

    /// An object's priority.
    pub fn object_priority(&self, object: u32) -> i32 {
        self.objects[object as usize].priority
    }

    /// Whether there is an object whose contents count only inside it.
    pub(crate) fn clips(&self) -> bool {
        self.clips
    }

    /// Whether what an object contains counts only inside it.
    pub fn object_clips(&self, object: u32) -> bool {
        self.objects[object as usize].clip
    }

    /// Sizes.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// A box around everything, in world coordinates; infinite if anything is unbounded.
    pub fn bounds(&self) -> Aabb {
        self.root().bounds
    }

    /// A box around everything bounded, in world coordinates. Of an unbounded placement, only the bounded bodies
    /// inside it count. Empty if nothing is bounded.
    pub fn finite_bounds(&self) -> Aabb {
        // Levels come after those that they place.
        let mut finite: Vec<Aabb> = Vec::with_capacity(self.levels.len());
        for level in &self.levels {
            let boxes = level.placements.iter().map(|placed| match placed.target {
                _ if placed.bounds.is_finite() || placed.bounds.is_empty() => placed.bounds,
                Target::Body(_) => Aabb::EMPTY,
                // This matrix is itself an inverse, so it can be inverted, except for rounding.
                Target::Level(below) => match placed.local_from_parent.inverse() {
                    Ok(map) if !finite[below as usize].is_empty() => finite[below as usize].transformed(&map),
                    _ => Aabb::EMPTY,
                },
            });
            // The cells of a lattice are all bounded or all unbounded. Boxes in a frame of their own are bounded.
            let listed = boxes.fold(Aabb::EMPTY, |all, b| all.union(&b));
            finite.push(match &level.lattice {
                _ if level.bounds.is_finite() => level.bounds,
                Some(_) => Aabb::EMPTY,
                None => listed,
            });
        }
        finite.get(self.root as usize).copied().unwrap_or_default()
    }

    /// The number of instance paths: paths are numbered from 0.
    pub fn path_count(&self) -> u64 {
        self.root().path_count
    }

    /// The name of an instance path, as in `world/arm[2]/bolt[0]`; empty for a number not in use.
    pub fn path_name(&self, path: u64) -> String {
        let mut name = String::new();
        self.steps_of_path(path).for_each(|(level, number)| self.write_name(level, number, &mut name));
        name
    }

    /// The matrix of an instance path, the product of all transforms on it: world coordinates from local coordinates.
    /// The local frame of a solid or a mesh alone is its own. That of a combination is the frame it is written in if
    /// it is shared, otherwise that of the group around it. `None` for a number that is not in use.
    pub fn path_transform(&self, path: u64) -> Option<Affine> {
        let local_from_world = self.frame_from_world(path, |body| match body {
            Body::Surface(b) => &b.local_from_body,
            Body::Solid(b) if b.leaves.len() == 1 => &b.leaves[0].local_from_body,
            Body::Solid(_) => &Affine::IDENTITY,
        })?;
        local_from_world.placement().ok().map(|placement| placement.local_from_parent)
    }

    /// The transform from world coordinates to a frame of the body at the end of a path, which is given from its body. `None` for
    /// a path that is not in use.
    pub(super) fn frame_from_world<'a>(
        &'a self,
        path: u64,
        frame_from_body: impl FnOnce(&'a Body) -> &'a Affine,
    ) -> Option<ComposedTransform> {
        let steps = self.steps_of_path(path);
        let placements: Vec<Cow<Placement>> = steps.map(|(level, number)| level.placement(number)).collect();
        let Target::Body(body) = placements.last()?.target else { return None };
        let frame = ComposedTransform::IDENTITY.then(frame_from_body(self.body(body)));
        let down = placements.iter().rev().map(|placed| &placed.local_from_parent);
        Some(down.fold(frame, |composed, step| composed.then(step)))
    }

    /// The levels on an instance path, outermost first, each with the number of its placement; none for a number not in use.
    fn steps_of_path(&self, path: u64) -> impl Iterator<Item = (&Level, u32)> {
        let (mut level, mut rest) = (Some(self.root()), path);
        std::iter::from_fn(move || {
            let here = level.take().filter(|level| rest < level.path_count)?;
            let number = here.placement_of_path(rest);
            let placed = here.placement(number);
            rest -= placed.first_path;
            if let Target::Level(next) = placed.target {
                level = Some(self.level(next));
            }
            Some((here, number))
        })
    }

    /// The name of a leaf surface: the kind of the leaf, its number in its body if there are several, and the surface
    /// of the leaf, as in `cylinder#2.side`. Empty for a number that is not in use.
    pub fn surface_name(&self, surface: u32) -> String {
        let Some(body) = self.body_of_surface(surface) else { return String::new() };
        let (kind, leaf, within, names) = match body {
            Body::Surface(b) => ("mesh", "mesh".into(), surface - b.first_surface, b.mesh.surfaces()),
            Body::Solid(b) => {
                let leaf = b.leaves.partition_point(|l| l.first_surface <= surface).checked_sub(1);
                let Some((leaf, l)) = leaf.and_then(|leaf| Some((leaf, b.leaves.get(leaf)?))) else {
                    return String::new();
                };
                (l.kind, b.leaf_name(leaf), surface - l.first_surface, l.surfaces)
            }
        };
        match names.get(within as usize) {
            Some(name) if *name == kind => leaf,
            Some(name) => format!("{leaf}.{name}"),
            None => String::new(),
        }
    }

    /// The last body whose surfaces do not begin behind a surface.
    pub(super) fn body_of_surface(&self, surface: u32) -> Option<&Body> {
        let i = self.bodies.partition_point(|b| b.first_surface() <= surface);
        i.checked_sub(1).map(|i| &*self.bodies[i])
    }

    /// The name of a placement of a level: the end of the paths that lead to it.
    pub(crate) fn placed_name(&self, level: &Level, number: u32) -> String {
        let mut name = String::new();
        self.write_name(level, number, &mut name);
        name
    }

    fn write_name(&self, level: &Level, number: u32, out: &mut String) {
        self.names.write(level.placement(number).name, out);
        if let Some(cells) = &level.lattice {
            out.push_str(&format!("[{}]", cells.lattice.cell_name(number)));
        }
    }

    /// An object that has no inside, with its mesh, if there is one. A world with such an object has no segments.
    pub(crate) fn surface(&self) -> Option<(u32, &SurfaceBody)> {
        let (object, body) = self.surface?;
        match self.body(body) {
            Body::Surface(surface) => Some((object, surface)),
            Body::Solid(_) => None,
        }
    }

    /// Searches the levels for [`World::surface`], each level once.
    pub(super) fn find_surface(&self) -> Option<(u32, u32)> {
        let mut seen = vec![false; self.levels.len()];
        let mut pending = vec![(self.root, 0)];
        while let Some((level, object)) = pending.pop() {
            if std::mem::replace(&mut seen[level as usize], true) {
                continue;
            }
            for placed in &self.level(level).placements {
                let object = placed.object.unwrap_or(object);
                match placed.target {
                    Target::Level(next) => pending.push((next, object)),
                    Target::Body(body) if matches!(self.body(body), Body::Surface(_)) => {
                        return Some((object, body));
                    }
                    Target::Body(_) => {}
                }
            }
        }
        None
    }

    /// Whether there is a mesh at which blocks of rays can be cast.
    pub(crate) fn casts_blocks(&self) -> bool {
        self.casts_blocks
    }

    /// Whether rays that run close together can be cast at bodies in lanes.
    pub(crate) fn casts_lanes(&self) -> bool {
        self.casts_lanes
    }

    /// A number of a body: rays can be cast in lanes together at bodies with the same.
    pub(crate) fn lane_group(&self, body: u32) -> u32 {
        self.lane_groups[body as usize]
    }

    /// Whether rays can be cast in waves.
    pub(crate) fn casts_waves(&self) -> bool {
        self.casts_waves
    }

    /// All levels. A level comes after the levels that it places; the root is the last.
    pub(crate) fn levels(&self) -> &[Arc<Level>] {
        &self.levels
    }

    pub(crate) fn root(&self) -> &Level {
        self.level(self.root)
    }

    pub(crate) fn level(&self, index: u32) -> &Level {
        &self.levels[index as usize]
    }

    pub(crate) fn body(&self, index: u32) -> &Body {
        &self.bodies[index as usize]
    }

    pub(super) fn bounds_of(&self, target: Target) -> Aabb {
        match target {
            Target::Body(b) => self.body(b).bounds(),
            Target::Level(l) => self.level(l).bounds,
        }
    }

    pub(super) fn paths_of(&self, target: Target) -> u64 {
        match target {
            Target::Body(_) => 1,
            Target::Level(l) => self.level(l).path_count,
        }
    }

    pub(super) fn leaves_of(&self, target: Target) -> u64 {
        match target {
            Target::Body(b) => self.body(b).leaf_count(),
            Target::Level(l) => self.level(l).leaf_count,
        }
    }

    /// Bytes used; a solid shared by several leaves is counted with each.
    pub(super) fn memory(&self) -> usize {
        let accel = |a: &Option<Box<dyn Accelerator>>| a.as_ref().map_or(0, |a| a.memory());
        let levels: usize = self
            .levels
            .iter()
            .map(|l| {
                let placements = size_of_val(l.placements.as_slice()) + size_of_val(l.scopes.as_slice());
                let cells = l.lattice.as_ref().map_or(0, |cells| cells.memory());
                size_of::<Level>() + placements + cells + accel(&l.accel)
            })
            .sum();
        let leaf = |l: &Leaf| size_of::<Leaf>() + size_of_val(&*l.solid) + l.solid.memory();
        let bodies: usize = self
            .bodies
            .iter()
            .map(|b| match &**b {
                Body::Solid(b) => {
                    b.leaves.iter().map(leaf).sum::<usize>() + b.program.memory() + accel(&b.accel)
                }
                Body::Surface(b) => b.mesh.memory(),
            })
            .sum();
        size_of::<World>()
            + levels
            + bodies
            + size_of_val(self.bodies.as_slice())
            + size_of_val(self.lane_groups.as_slice())
            + self.names.memory()
    }
}

impl SolidBody {
    /// The name of the solid of a leaf: its kind, followed by its number if there are several.
    pub(crate) fn leaf_name(&self, leaf: usize) -> String {
        let Leaf { kind, number, .. } = self.leaves[leaf];
        let is_only = self.leaves.last().is_none_or(|last| last.number == 0);
        if is_only { kind.to_owned() } else { format!("{kind}#{number}") }
    }
}

/// A mesh of a body, at which blocks of rays can be cast.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyMesh<'w> {
    pub mesh: &'w MeshSolid,
    pub leaf: u32,
    pub local_from_body: &'w Affine,
    /// Where the mesh can affect the result, in the frame of the body.
    pub bounds: &'w Aabb,
}

impl Body {
    /// The meshes at which blocks of rays can be cast. Those of combinations of many leaves are left out: which of them a
    /// ray needs is not known before.
    pub(crate) fn block_meshes(&self) -> impl Iterator<Item = BodyMesh<'_>> {
        let (surface, leaves) = match self {
            Body::Surface(body) => (Some(body), &[][..]),
            Body::Solid(body) => (None, if body.accel.is_none() { &body.leaves[..] } else { &[] }),
        };
        let of_surface = surface.map(|SurfaceBody { mesh, local_from_body, bounds, .. }| BodyMesh {
            mesh,
            leaf: 0,
            local_from_body,
            bounds,
        });
        let of_leaves =
            (0..).zip(leaves).filter_map(|(leaf, Leaf { solid, local_from_body, bounds, .. })| {
                Some(BodyMesh { mesh: solid.as_mesh()?, leaf, local_from_body, bounds })
            });
        of_surface.into_iter().chain(of_leaves).filter(|body_mesh| body_mesh.mesh.casts_blocks())
    }

    /// Whether the rays of a bundle are cast at it together.
    #[inline]
    pub(crate) fn takes_bundles(&self) -> bool {
        matches!(self, Body::Solid(body) if body.takes_lanes || body.takes_bundles)
    }

    /// Whether rays are cast at it in lanes.
    pub(crate) fn takes_lanes(&self) -> bool {
        matches!(self, Body::Solid(SolidBody { takes_lanes: true, .. }))
    }

    pub(super) fn first_surface(&self) -> u32 {
        match self {
            Body::Solid(b) => b.first_surface,
            Body::Surface(b) => b.first_surface,
        }
    }

    fn bounds(&self) -> Aabb {
        match self {
            Body::Solid(b) => b.bounds,
            Body::Surface(b) => b.bounds,
        }
    }

    pub(crate) fn leaf_count(&self) -> u64 {
        match self {
            Body::Solid(b) => b.leaves.len() as u64,
            Body::Surface(_) => 1,
        }
    }
}
