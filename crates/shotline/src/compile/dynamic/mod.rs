//! A world that is kept up to date while transforms change.

mod dependents;
mod resolve_path;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

use crate::aabb::Aabb;
use crate::accel::{self, Accelerator};
use crate::compile::accel_choice::AccelChoice;
use crate::compile::body::BodyBuilder;
use crate::compile::built_leaves::BuiltLeaves;
use crate::compile::placements::Target;
use crate::compile::world::{Body, World};
use crate::compile::{Options, SceneError, Stats, build};
use crate::math::{Affine, ComposedTransform, TransformPair};
use crate::scene::{LocalTransform, Node, NodeId, Scene};
use dependents::{Dependents, PlacementRef};
use resolve_path::{insert_transform_above, namesakes, resolve, transforms};

/// A scene with its world, in which transforms may change. Only what depends on a change is computed again: the
/// placements below the transform, the combinations with the transform above one of their operands, and the boxes of
/// all levels above. The world is the same as a newly compiled one, except for the shape of its accelerators, which
/// no result depends on.
///
/// A clone shares everything until one of the two changes. Then it still shares the levels and bodies that do not
/// change.
///
/// ```
/// use shotline::compile::{DynamicWorld, Options};
/// use shotline::math::{Affine, Vec3};
/// use shotline::query::Caster;
/// use shotline::ray::{Ray, Span};
/// use shotline::scene::{LocalTransform, Scene};
///
/// let mut scene = Scene::default();
/// let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
/// let place = scene.add_transform(Affine::IDENTITY, ball);
/// scene.add_object("ball", None, place);
/// let mut live = DynamicWorld::new(scene, Options::default()).unwrap();
/// let up = Affine::translation(Vec3::new(0.0, 0.0, 3.0));
/// live.set(&[(place, LocalTransform::Matrix(up))]).unwrap();
/// let ray = Ray::new(Vec3::ZERO, Vec3::Z).unwrap();
/// assert_eq!(Caster::new(live.world()).closest(&ray, Span::FORWARD).unwrap().unwrap().t, 2.0);
/// ```
#[derive(Clone, Debug)]
pub struct DynamicWorld {
    scene: Arc<Scene>,
    world: Arc<World>,
    leaves: Arc<BuiltLeaves>,
    dependents: Arc<Dependents>,
    /// The nodes below lattices. When one of them changes, the whole scene is compiled again.
    in_lattices: Arc<HashSet<NodeId>>,
    options: Options,
}

impl DynamicWorld {
    /// Compiles a scene, and records what depends on each of its transforms.
    ///
    /// # Errors
    /// As [`compile`](super::compile).
    pub fn new(scene: Scene, options: Options) -> Result<DynamicWorld, Vec<SceneError>> {
        let mut dependents = Dependents::default();
        let (world, leaves) = build(&scene, options, &mut dependents)?;
        let (leaves, dependents) = (Arc::new(leaves), Arc::new(dependents));
        let in_lattices = Arc::new(below_lattices(&scene));
        let (scene, world) = (Arc::new(scene), Arc::new(world));
        Ok(DynamicWorld { scene, world, leaves, dependents, in_lattices, options })
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The current world. Of its [`Stats`], the memory is that of the first compilation, and the condition is the
    /// worst so far.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// Changes transforms, given by their nodes, all at once. A shared node moves in all of its placements.
    ///
    /// # Errors
    /// The first [`SceneError`]: a node that is not a transform, or a matrix that cannot be inverted. Then nothing is
    /// changed.
    pub fn set(&mut self, transforms: &[(NodeId, LocalTransform)]) -> Result<(), SceneError> {
        for (id, _) in transforms {
            if !matches!(self.scene.nodes.get(id.0 as usize), Some(Node::Transform { .. })) {
                return Err(SceneError::at(
                    *id,
                    "only a transform can be set, and this node is not one".into(),
                ));
            }
        }
        let old = self.write(transforms);
        if transforms.iter().any(|(id, _)| self.in_lattices.contains(id)) {
            return self.rebuild(&old);
        }
        let done = self.update(transforms.iter().map(|(id, _)| *id));
        if done.is_err() {
            self.write(&old);
        }
        done
    }

    /// Replaces all transforms between the member that a path names and its group by one matrix: parent from local.
    /// The path may also be the beginning of one, as in `robot/arm[2]`. A shared node moves in all of its placements. An
    /// object with contents moves as a whole: transforms below it stay.
    /// A member without a transform gets one; then the whole scene is compiled again.
    ///
    /// # Errors
    /// [`SceneError`]s: there is no such path, or several, or the matrix cannot be inverted. Then nothing is changed.
    pub fn place(&mut self, path: &str, matrix: Affine) -> Result<(), Vec<SceneError>> {
        let member = resolve(&self.scene, path).ok_or_else(|| {
            let error = SceneError::general(format!("no path begins with '{path}'"));
            vec![error.with_hint(
                "paths are named as the answers name them, as in robot/arm[2]/bolt[0]; cells of a lattice do not move alone",
            )]
        })?;
        let namesakes = namesakes(&self.scene, path);
        if namesakes > 1 {
            let error = SceneError::general(format!(
                "'{path}' stands for several things, as {namesakes} objects have one name"
            ));
            return Err(vec![error.with_hint("give the objects different names")]);
        }
        let matrix = LocalTransform::Matrix(matrix);
        let identity = LocalTransform::Matrix(Affine::IDENTITY);
        let nodes = transforms(&self.scene, member);
        if nodes.is_empty() {
            let mut scene = (*self.scene).clone();
            insert_transform_above(&mut scene, member, matrix);
            *self = DynamicWorld::new(scene, self.options)?;
            return Ok(());
        }
        let changes: Vec<_> = nodes
            .iter()
            .enumerate()
            .map(|(i, &node)| (node, if i == 0 { matrix } else { identity }))
            .collect();
        self.set(&changes).map_err(|error| vec![error])
    }

    /// A box, in world coordinates, around everything that a transform moves. Infinite if some of it is an operand,
    /// or is in a shared node and so has several placements.
    pub fn moved_bounds(&self, node: NodeId) -> Aabb {
        let is_copied = self.in_lattices.contains(&node);
        if is_copied || !self.dependents.bodies_with(&self.scene, node).is_empty() {
            return Aabb::EVERYTHING;
        }
        self.dependents.moved_by(node).fold(Aabb::EMPTY, |all, (level, placement)| {
            let placed = &self.world.level(level).placements[placement as usize];
            // The boxes of the root are in the frame of the world.
            all.union(if level == self.world.root { &placed.bounds } else { &Aabb::EVERYTHING })
        })
    }

    /// Compiles the whole scene again; writes the old transforms if it cannot be compiled.
    fn rebuild(&mut self, old: &[(NodeId, LocalTransform)]) -> Result<(), SceneError> {
        match DynamicWorld::new((*self.scene).clone(), self.options) {
            Ok(new) => {
                *self = new;
                Ok(())
            }
            Err(errors) => {
                self.write(old);
                let unknown = || SceneError::general("the scene cannot be compiled".into());
                Err(errors.into_iter().next().unwrap_or_else(unknown))
            }
        }
    }

    /// Writes transforms into the scene and returns the previous ones, in an order such that writing them undoes the
    /// change.
    fn write(&mut self, transforms: &[(NodeId, LocalTransform)]) -> Vec<(NodeId, LocalTransform)> {
        let (mut old, scene) = (Vec::new(), Arc::make_mut(&mut self.scene));
        for (id, new) in transforms {
            if let Node::Transform { transform, .. } = &mut scene.nodes[id.0 as usize] {
                old.push((*id, std::mem::replace(transform, *new)));
            }
        }
        old.reverse();
        old
    }

    /// Updates the world. Everything that can fail is done before anything is changed.
    fn update(&mut self, nodes: impl Iterator<Item = NodeId>) -> Result<(), SceneError> {
        let (mut dirty, mut bodies) = (DirtyPlacements::default(), BTreeMap::new());
        for node in nodes {
            for at in self.dependents.moved_by(node) {
                self.placement(at)?;
                dirty.add(at);
                // A body that is not shared contains its matrix.
                if self.dependents.origin(at).baked {
                    bodies.extend(self.body(at).map(|body| (body, at)));
                }
            }
            for at in self.dependents.bodies_with(&self.scene, node) {
                bodies.extend(self.body(at).map(|body| (body, at)));
            }
        }
        let rebuilt = bodies.iter().map(|(&body, &at)| Ok((body, self.rebuilt(body, at)?)));
        for (body, new) in rebuilt.collect::<Result<Vec<_>, SceneError>>()? {
            Arc::make_mut(&mut self.world).bodies[body as usize] = Arc::new(new);
            self.dependents.of_body(body).iter().for_each(|&at| dirty.add(at));
        }
        // Levels come after those that they place.
        while let Some((level, placements)) = dirty.0.pop_first() {
            if self.update_level(level, &placements)? {
                self.dependents.of_level(level).iter().for_each(|&at| dirty.add(at));
            }
        }
        Ok(())
    }

    fn body(&self, (level, placement): PlacementRef) -> Option<u32> {
        match self.world.level(level).placements[placement as usize].target {
            Target::Body(body) => Some(body),
            Target::Level(_) => None,
        }
    }

    /// The matrix of a placement.
    fn placement(&self, at: PlacementRef) -> Result<TransformPair, SceneError> {
        let origin = self.dependents.origin(at);
        let composed = self.dependents.composed(&self.scene, origin);
        let placement = self.builder(0).placed(origin.node, &composed)?;
        let condition = placement.condition;
        Ok(if origin.baked { TransformPair { condition, ..TransformPair::IDENTITY } } else { placement })
    }

    /// Rebuilds the body of a placement.
    fn rebuilt(&self, body: u32, at: PlacementRef) -> Result<Body, SceneError> {
        let origin = self.dependents.origin(at);
        let composed = if origin.baked {
            self.dependents.composed(&self.scene, origin)
        } else {
            ComposedTransform::IDENTITY
        };
        self.builder(self.world.body(body).first_surface()).build(origin.node, &composed)
    }

    fn builder(&self, surfaces: u32) -> BodyBuilder<'_> {
        let (stats, choice) = (Stats::default(), AccelChoice::new_unchecked(&self.scene, self.options));
        BodyBuilder { scene: &self.scene, leaves: &self.leaves, choice, surfaces, stats }
    }

    /// Gives a level boxes in its own frame, since the one in which they are small may not be so any more.
    fn straighten(&mut self, level: u32) -> Result<(), SceneError> {
        let count = self.world.level(level).placement_count();
        let boxes = (0..count).map(|number| {
            let target = self.world.level(level).placements[number as usize].target;
            let parent_from_local = self.placement((level, number))?.parent_from_local;
            Ok(self.world.bounds_of(target).transformed(&parent_from_local))
        });
        let boxes = boxes.collect::<Result<Vec<Aabb>, SceneError>>()?;
        let level = Arc::make_mut(&mut Arc::make_mut(&mut self.world).levels[level as usize]);
        for (placed, bounds) in level.placements.iter_mut().zip(&boxes) {
            placed.bounds = *bounds;
        }
        level.box_frame = None;
        level.accel = accel::build(level.accel_name, &boxes);
        Ok(())
    }

    /// Updates some placements of a level. Returns whether the level's box has changed.
    fn update_level(&mut self, level: u32, placements: &BTreeSet<u32>) -> Result<bool, SceneError> {
        let mut boxes = Vec::new();
        if self.world.level(level).box_frame.is_some() {
            self.straighten(level)?;
        }
        for &placement in placements {
            let new = self.placement((level, placement))?;
            let world = Arc::make_mut(&mut self.world);
            world.stats.condition = world.stats.condition.max(new.condition);
            let placed = &mut Arc::make_mut(&mut world.levels[level as usize]).placements[placement as usize];
            placed.local_from_parent = new.local_from_parent;
            let target = placed.target;
            boxes.push(world.bounds_of(target).transformed(&new.parent_from_local));
        }
        let level = Arc::make_mut(&mut Arc::make_mut(&mut self.world).levels[level as usize]);
        let before = level.bounds;
        // If a placement's old box did not touch the faces of the level's box, moving it cannot shrink the level's
        // box.
        let mut faces_stay = true;
        for (&placement, new) in placements.iter().zip(boxes) {
            let old = std::mem::replace(&mut level.placements[placement as usize].bounds, new);
            faces_stay &= before.min.cmplt(old.min).all() && old.max.cmplt(before.max).all();
            level.bounds = level.bounds.union(&new);
        }
        if !faces_stay {
            level.bounds = level.placements.iter().fold(Aabb::EMPTY, |all, p| all.union(&p.bounds));
        }
        let items: Vec<u32> = placements.iter().copied().collect();
        let placed = &level.placements;
        let refits = |accel: &mut Box<dyn Accelerator>| accel.refit(&items, &|i| placed[i as usize].bounds);
        if !level.accel.as_mut().is_some_and(refits) {
            let boxes: Vec<Aabb> = level.placements.iter().map(|p| p.bounds).collect();
            level.accel = accel::build(level.accel_name, &boxes);
        }
        Ok(level.bounds != before)
    }
}

/// The nodes that lattices hold, and those below them.
fn below_lattices(scene: &Scene) -> HashSet<NodeId> {
    let lattices = scene.nodes.iter().filter(|node| matches!(node, Node::Lattice { .. }));
    let mut pending: Vec<NodeId> = lattices.flat_map(Node::children).collect();
    let mut found = HashSet::new();
    while let Some(id) = pending.pop() {
        if found.insert(id) {
            pending.extend(scene.node(id).children());
        }
    }
    found
}

/// Placements to be updated, by level.
#[derive(Default)]
struct DirtyPlacements(BTreeMap<u32, BTreeSet<u32>>);

impl DirtyPlacements {
    fn add(&mut self, (level, placement): PlacementRef) {
        self.0.entry(level).or_default().insert(placement);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::compile;
    use crate::math::Affine;
    use crate::query::{Caster, Hit};
    use crate::ray::{Ray, Span};
    use crate::testkit::random::Random;
    use crate::testkit::scene::random_scene;

    fn hits(world: &World, rays: &[Ray]) -> Vec<Vec<Hit>> {
        let mut caster = Caster::new(world);
        let mut list = |ray| {
            let mut out = Vec::new();
            caster.crossings(ray, Span::FORWARD, &mut out).expect("within limits");
            out
        };
        rays.iter().map(&mut list).collect()
    }

    /// A changed world returns the same bits as a newly compiled one, whichever transform changed: above placements,
    /// shared, around combinations or inside of them.
    #[test]
    fn a_moved_world_is_the_same_as_a_new_one() {
        let mut random = Random::new(21);
        let mut moves = 0;
        for case in 0..60 {
            let scene = random_scene(&mut random);
            let is_transform = |i: &usize| matches!(scene.nodes[*i], Node::Transform { .. });
            let transforms: Vec<usize> = (0..scene.nodes.len()).filter(is_transform).collect();
            let options = Options { accel: Some(accel::NAMES[case % accel::NAMES.len()]) };
            let mut live = DynamicWorld::new(scene, options).unwrap();
            for _ in 0..transforms.len().min(8) {
                let mut some = || NodeId(transforms[random.below(transforms.len())] as u32);
                let nodes = [some(), some()];
                let mut changed = || {
                    let turn = Affine::rotation_xyz(random.point(-90.0, 90.0));
                    LocalTransform::Matrix(Affine::translation(random.point(-1.0, 1.0)).then_after(&turn))
                };
                live.set(&nodes.map(|node| (node, changed()))).unwrap();
                moves += 1;
                let rebuilt = compile(live.scene(), options).unwrap();
                let ray = |_| Ray::new(random.direction() * 6.0, random.direction()).unwrap();
                let aimed = |ray: Ray| Ray::new(ray.origin(), ray.direction() - ray.origin()).unwrap();
                let rays: Vec<Ray> = (0..20).map(ray).map(aimed).collect();
                let (moved, expected) = (hits(live.world(), &rays), hits(&rebuilt, &rays));
                assert_eq!(format!("{moved:?}"), format!("{expected:?}"), "case {case}");
                assert_eq!(live.world().bounds(), rebuilt.bounds(), "case {case}");
            }
        }
        assert!(moves > 200, "{moves}");
    }

    /// Changing a clone leaves the original as it was, and the clone returns the same as a new world.
    #[test]
    fn clones_move_apart() {
        let mut random = Random::new(23);
        for case in 0..40 {
            let scene = random_scene(&mut random);
            let options = Options { accel: Some(accel::NAMES[case % accel::NAMES.len()]) };
            if scene.nodes.iter().any(|node| matches!(node, Node::Lattice { .. })) {
                // Its cells do not move alone.
                continue;
            }
            let first = DynamicWorld::new(scene, options).unwrap();
            let ray = |_| Ray::new(random.direction() * 6.0, random.direction() * -1.0).unwrap();
            let rays: Vec<Ray> = (0..40).map(ray).collect();
            let before = format!("{:?}", hits(first.world(), &rays));
            let names: Vec<String> =
                (0..first.world().path_count().min(3)).map(|p| first.world().path_name(p)).collect();
            let mut moved = first.clone();
            for name in &names {
                let cut = name.match_indices('/').map(|(i, _)| i).nth(case % 3).unwrap_or(name.len());
                let shift = Affine::translation(random.point(-1.0, 1.0));
                moved.place(&name[..cut], shift).unwrap();
            }
            let rebuilt = compile(moved.scene(), options).unwrap();
            assert_eq!(format!("{:?}", hits(moved.world(), &rays)), format!("{:?}", hits(&rebuilt, &rays)));
            assert_eq!(format!("{:?}", hits(first.world(), &rays)), before);
        }
    }

    #[test]
    fn paths_are_placed() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
        let far = scene.add_transform(Affine::translation(crate::math::Vec3::X * 9.0), ball);
        let group = scene.add(Node::Group { members: vec![ball, far] });
        scene.add_object("a/b", None, group);
        let mut live = DynamicWorld::new(scene, Options::default()).unwrap();
        let x_of = |live: &DynamicWorld, path: u64| live.world().path_transform(path).unwrap().rows[0][3];
        let shift = |x: f64| Affine::translation(crate::math::Vec3::X * x);
        live.place("a/b/sphere[1]", shift(5.0)).unwrap();
        assert_eq!((x_of(&live, 0), x_of(&live, 1)), (0.0, 5.0));
        live.place("a/b/sphere[0]", shift(2.0)).unwrap();
        live.place("a/b", shift(-10.0)).unwrap();
        assert_eq!((x_of(&live, 0), x_of(&live, 1)), (-8.0, -5.0));
        live.place("a/b", shift(1.0)).unwrap();
        assert_eq!((x_of(&live, 0), x_of(&live, 1)), (3.0, 6.0));
        for wrong in ["", "a", "a/b/sphere", "a/b/sphere[2]", "a/b/sphere[1]/x"] {
            let errors = live.place(wrong, shift(1.0)).unwrap_err();
            assert!(errors[0].message.contains(&format!("'{wrong}'")), "{errors:?}");
        }
        assert!(live.place("a/b", Affine::scaling(crate::math::Vec3::ZERO)).is_err());
        assert_eq!(x_of(&live, 1), 6.0);
    }

    #[test]
    fn what_cannot_be_set_changes_nothing() {
        let mut random = Random::new(22);
        let mut scene = random_scene(&mut random);
        let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
        let inner = scene.add_transform(Affine::IDENTITY, ball);
        let outer = scene.add_transform(Affine::IDENTITY, inner);
        scene.add_object("ball", None, outer);
        let mut live = DynamicWorld::new(scene, Options::default()).unwrap();
        let rays: Vec<Ray> =
            (0..50).map(|_| Ray::new(random.direction() * 6.0, random.direction()).unwrap()).collect();
        let before = format!("{:?}", hits(live.world(), &rays));
        let shift = LocalTransform::Matrix(Affine::translation(crate::math::Vec3::X));
        let flat = LocalTransform::Matrix(Affine::scaling(crate::math::Vec3::new(1.0, 1.0, 0.0)));
        let error = live.set(&[(outer, shift), (inner, flat)]).unwrap_err();
        assert!(error.message.contains("condition"), "{}", error.message);
        assert!(live.set(&[(outer, shift), (ball, shift)]).is_err());
        assert!(live.set(&[(outer, shift), (NodeId(9999), shift)]).is_err());
        assert_eq!(format!("{:?}", hits(live.world(), &rays)), before);
        let rebuilt = compile(live.scene(), Options::default()).unwrap();
        assert_eq!(format!("{:?}", hits(&rebuilt, &rays)), before);
    }
}
