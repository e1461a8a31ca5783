//! Objects in objects: what owns each part of a ray, against a walk over the whole scene.

use std::collections::{BTreeSet, HashMap};

use super::world;
use crate::compile::World;
use crate::math::{Affine, Vec3};
use crate::query::{Caster, ConflictKind, Overlaps, QueryError};
use crate::ray::{Ray, Span};
use crate::scene::{LocalTransform, Node, NodeId, Scene};
use crate::testkit::random::Random;

/// Boxes have whole corners, so the middle of a cell of the unit grid is far from all faces.
const CELLS: i32 = 12;

/// A nest: objects in objects, which are placed several times and stick out of one another.
pub(super) struct Nest {
    pub(super) scene: Scene,
    /// Objects and groups of them, innermost first.
    parts: Vec<NodeId>,
}

impl Nest {
    pub(super) fn random(random: &mut Random, clips: bool) -> Nest {
        let mut nest = Nest { scene: Scene::default(), parts: Vec::new() };
        for i in 0..3 + random.below(10) {
            if i > 1 && random.below(4) == 0 {
                let members = (0..random.below(4)).map(|_| nest.placed_part(random)).collect();
                let group = nest.scene.add(Node::Group { members });
                nest.parts.push(group);
            } else {
                let object = nest.object(i, random, clips);
                nest.parts.push(object);
            }
        }
        for _ in 0..1 + random.below(3) {
            let last = nest.parts.len();
            let part = nest.parts[last - 1 - random.below(last.min(3))];
            // A root is an object.
            let part = match nest.scene.node(part) {
                Node::Object { .. } => part,
                _ => nest.parts[0],
            };
            let root = nest.translated(part, random, 4);
            nest.scene.objects.push(root);
        }
        nest
    }

    fn object(&mut self, number: usize, random: &mut Random, clips: bool) -> NodeId {
        let bodies: Vec<NodeId> = (0..1 + random.below(8) / 6).map(|_| self.a_box(random)).collect();
        let mut members = bodies;
        let has_contents = number > 0;
        if has_contents && random.below(4) == 0 {
            // An object in the group of another.
            members.push(self.placed_part(random));
        }
        let node = match members[..] {
            [only] => only,
            _ => self.scene.add(Node::Group { members }),
        };
        let count = if has_contents { random.below(4) } else { 0 };
        let contents = (0..count).map(|_| self.placed_part(random)).collect();
        let priority = [0, 0, 0, 0, 1, -1][random.below(6)];
        let (name, clip) = (format!("object {number}"), clips && random.below(2) == 0);
        self.scene.add(Node::Object { name, material: None, priority, node, contents, clip })
    }

    fn a_box(&mut self, random: &mut Random) -> NodeId {
        let from = [0; 3].map(|_| random.below(5) as i32);
        let to = from.map(|from| f64::from(from + 1 + random.below(6) as i32));
        self.scene.add_solid("box", &[&from.map(f64::from), &to]).expect("a box")
    }

    fn placed_part(&mut self, random: &mut Random) -> NodeId {
        let part = self.parts[random.below(self.parts.len())];
        if random.below(4) == 0 { part } else { self.translated(part, random, 2) }
    }

    fn translated(&mut self, child: NodeId, random: &mut Random, reach: usize) -> NodeId {
        let offset = [0; 3].map(|_| f64::from(random.below(2 * reach + 1) as i32 - reach as i32));
        self.scene.add_transform(Affine::translation(offset.into()), child)
    }
}

/// A body as the walk finds it: its box in the world, and its innermost instance.
pub(super) struct WalkedBody {
    low: Vec3,
    high: Vec3,
    pub(super) instance: usize,
}

/// A placement of an object, as the walk finds it.
pub(super) struct WalkedInstance {
    pub(super) object: u32,
    priority: i32,
    clip: bool,
    parent: Option<usize>,
}

/// A walk over all paths of a scene. The number of a body is that of its path.
pub(super) struct Walk<'s> {
    scene: &'s Scene,
    numbers: HashMap<&'s str, u32>,
    pub(super) bodies: Vec<WalkedBody>,
    pub(super) instances: Vec<WalkedInstance>,
}

impl<'s> Walk<'s> {
    pub(super) fn of(scene: &'s Scene, world: &'s World) -> Walk<'s> {
        let names = world.object_names().iter().map(String::as_str);
        let mut walk =
            Walk { scene, numbers: names.zip(0..).collect(), bodies: Vec::new(), instances: Vec::new() };
        scene.objects.iter().for_each(|&root| walk.node(root, Vec3::ZERO, None));
        walk
    }

    fn node(&mut self, id: NodeId, at: Vec3, instance: Option<usize>) {
        match self.scene.node(id) {
            Node::Solid { params, .. } => {
                let corner = |index: usize| Vec3::from_slice(&params.entries[index].1) + at;
                let instance = instance.expect("bodies are in objects");
                self.bodies.push(WalkedBody { low: corner(0), high: corner(1), instance });
            }
            Node::Transform { transform: LocalTransform::Matrix(matrix), child } => {
                self.node(*child, at + matrix.point(Vec3::ZERO), instance);
            }
            Node::Object { name, priority, node, contents, clip, .. } => {
                let (object, priority, clip) = (self.numbers[name.as_str()], *priority, *clip);
                self.instances.push(WalkedInstance { object, priority, clip, parent: instance });
                let instance = Some(self.instances.len() - 1);
                self.node(*node, at, instance);
                contents.iter().for_each(|&part| self.node(part, at, instance));
            }
            node => node.children().for_each(|child| self.node(child, at, instance)),
        }
    }

    fn around(&self, instance: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.instances[instance].parent, |&inner| self.instances[inner].parent)
    }

    fn is_inside(&self, body: usize, p: Vec3) -> bool {
        let WalkedBody { low, high, .. } = self.bodies[body];
        low.cmplt(p).all() && p.cmplt(high).all()
    }

    fn holds(&self, instance: usize, p: Vec3) -> bool {
        (0..self.bodies.len()).any(|body| self.bodies[body].instance == instance && self.is_inside(body, p))
    }

    /// The bodies that count at a point.
    fn count_at(&self, p: Vec3) -> Vec<usize> {
        let counts = |body: &usize| {
            self.is_inside(*body, p)
                && self
                    .around(self.bodies[*body].instance)
                    .all(|around| !self.instances[around].clip || self.holds(around, p))
        };
        (0..self.bodies.len()).filter(counts).collect()
    }

    /// The body that owns a point, and whether it overlaps another.
    pub(super) fn owner_at(&self, p: Vec3) -> Option<(usize, bool)> {
        let counted = self.count_at(p);
        let rank = |&body: &usize| {
            let instance = self.bodies[body].instance;
            (self.instances[instance].priority, instance, std::cmp::Reverse(body))
        };
        let owner = counted.iter().copied().max_by_key(rank)?;
        Some((owner, counted.iter().any(|&body| self.are_in_conflict(owner, body))))
    }

    /// Whether two bodies that count have equal priorities, and neither is in the instance of the other.
    fn are_in_conflict(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|body| self.bodies[body].instance);
        let is_in = |inner: usize, outer: usize| self.around(inner).any(|around| around == outer);
        self.instances[a].priority == self.instances[b].priority && a != b && !is_in(a, b) && !is_in(b, a)
    }

    /// The pairs of an object that sticks out at a point, and the one that it sticks out of.
    fn protrusions_at(&self, p: Vec3) -> Vec<(u32, u32)> {
        let pair = |body: usize| {
            let instance = self.bodies[body].instance;
            let clip = self.around(instance).find(|&around| self.instances[around].clip)?;
            let sticks_out = self.is_inside(body, p) && !self.holds(clip, p);
            sticks_out.then_some((self.instances[instance].object, self.instances[clip].object))
        };
        let mut pairs: Vec<_> = (0..self.bodies.len()).filter_map(pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }
}

/// The middle of a cell.
fn middle(x: i32, y: i32, z: i32) -> Vec3 {
    Vec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(z) + 0.5)
}

/// Checks the rays along x through some cells of a nest. Returns how many overlaps and protrusions were met.
fn check(case: usize, nest: &Nest, random: &mut Random) -> [usize; 2] {
    let world = world(&nest.scene, "bvh");
    let walk = Walk::of(&nest.scene, &world);
    let (mut caster, mut met) = (Caster::new(&world), [0; 2]);
    for _ in 0..6 {
        let [y, z] = [0; 2].map(|_| random.below(CELLS as usize) as i32 - 3);
        let ray = Ray::new(middle(-40, y, z), Vec3::X).expect("a ray");
        let (mut segments, mut found) = (Vec::new(), Vec::new());
        let count = caster.segments(&ray, Span::FORWARD, Overlaps::Priority, &mut segments).expect("solids");
        caster.conflicts(&ray, Span::FORWARD, &mut found).expect("solids");
        let mut all = Vec::new();
        caster.segments(&ray, Span::FORWARD, Overlaps::All, &mut all).expect("solids");
        assert!(all.is_sorted_by_key(|segment| (segment.t_in.to_bits(), segment.path)), "case {case}");
        let mut overlaps = 0;
        for x in -30..40 {
            let p = middle(x, y, z);
            let t = p.x - ray.origin().x;
            let segment = segments.iter().find(|s| s.t_in < t && t < s.t_out).map(|s| s.path as usize);
            let owner = walk.owner_at(p);
            assert_eq!(segment, owner.map(|(owner, _)| owner), "case {case} at {p}");
            let at_point = caster.owner_at(p).expect("solids").map(|(_, path)| path as usize);
            assert_eq!(at_point, segment, "case {case} at {p}");
            let is_overlap = owner.is_some_and(|(_, overlaps)| overlaps);
            let here = |kind| found.iter().filter(move |o| o.kind == kind && o.t_in < t && t < o.t_out);
            let pair = here(ConflictKind::Overlap).next().map(|o| [o.first, o.second]);
            assert_eq!(pair.is_some(), is_overlap, "case {case} at {p}");
            let owned = owner.map(|(body, _)| walk.instances[walk.bodies[body].instance].object);
            assert!(pair.is_none_or(|pair| pair.map(Some).contains(&owned)), "case {case} at {p}: {pair:?}");
            overlaps += usize::from(is_overlap);
            let mut pairs: Vec<_> = here(ConflictKind::Protrusion).map(|o| (o.first, o.second)).collect();
            pairs.sort_unstable();
            pairs.dedup();
            met[1] += pairs.len();
            assert_eq!(pairs, walk.protrusions_at(p), "case {case} at {p}");
            let (mut objects, counted) = (Vec::new(), walk.count_at(p));
            let kept = all.iter().filter(|s| s.t_in < t && t < s.t_out).map(|s| s.path as usize);
            assert_eq!(
                kept.collect::<BTreeSet<_>>(),
                counted.iter().copied().collect(),
                "case {case} at {p}"
            );
            caster.contains(p, &mut objects).expect("solids");
            let object = |&body: &usize| walk.instances[walk.bodies[body].instance].object;
            let mut expected: Vec<u32> = counted.iter().map(object).collect();
            expected.sort_unstable();
            expected.dedup();
            assert_eq!(objects, expected, "case {case} at {p}");
        }
        assert_eq!(count > 0, overlaps > 0, "case {case}: {ray:?}");
        let refused = caster.segments(&ray, Span::FORWARD, Overlaps::Error, &mut Vec::new());
        assert_eq!(matches!(refused, Err(QueryError::Overlap { .. })), overlaps > 0, "case {case}: {ray:?}");
        met[0] += overlaps;
    }
    met
}

/// Objects in objects, groups shared at several depths, copies that overlap, contents that stick out, priorities.
#[test]
fn the_owner_is_that_of_a_walk_over_the_scene() {
    let mut random = Random::new(81);
    let mut met = [0; 2];
    for case in 0..2000 {
        let nest = Nest::random(&mut random, case % 2 == 0);
        for (sum, more) in met.iter_mut().zip(check(case, &nest, &mut random)) {
            *sum += more;
        }
    }
    assert!(met.iter().all(|&met| met > 1000), "{met:?}");
}

/// An object that displaces the ones around it, to any depth, needs no priority.
#[test]
fn ten_thousand_objects_in_one_another() {
    let (mut scene, n) = (Scene::default(), 10_000);
    let mut inner: Vec<NodeId> = Vec::new();
    for i in (0..n).rev() {
        let node = scene.add_solid("box", &[&[f64::from(i), -1.0, -1.0], &[f64::from(3 * n - i), 1.0, 1.0]]);
        let (name, clip) = (format!("shell {i}"), i % 2 == 0);
        let node = node.expect("a box");
        let object = Node::Object { name, material: None, priority: 0, node, contents: inner, clip };
        inner = vec![scene.add(object)];
    }
    scene.objects = inner;
    let world = world(&scene, "bvh");
    let (ray, mut segments) = (Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X).expect("a ray"), Vec::new());
    let met = Caster::new(&world).segments(&ray, Span::FORWARD, Overlaps::Error, &mut segments);
    assert_eq!((met, segments.len()), (Ok(0), 2 * n as usize - 1));
    assert_eq!(world.path_name(segments[2].path), "shell 0/shell 1[0]/shell 2[0]");
}

/// Copies of a shared object are instances of their own: they overlap each other, and not what they contain.
#[test]
fn copies_of_one_object_can_overlap() {
    let mut scene = Scene::default();
    let object = |scene: &mut Scene, name: &str, size: f64, contents: Vec<NodeId>| {
        let node = scene.add_solid("box", &[&[-size; 3], &[size; 3]]).expect("a box");
        scene.add(Node::Object { name: name.into(), material: None, priority: 0, node, contents, clip: true })
    };
    let core = object(&mut scene, "core", 1.0, Vec::new());
    let cell = object(&mut scene, "cell", 2.0, vec![core]);
    let contents = [0.0, 3.0, 10.0].map(|x| scene.add_transform(Affine::translation(Vec3::X * x), cell));
    let world_object = object(&mut scene, "world", 100.0, contents.to_vec());
    scene.objects = vec![world_object];
    let world = world(&scene, "bvh");
    let ray = Ray::new(Vec3::new(-200.0, 0.0, 0.0), Vec3::X).expect("a ray");
    let mut found = Vec::new();
    Caster::new(&world).conflicts(&ray, Span::FORWARD, &mut found).expect("solids");
    let found: Vec<_> = found.iter().map(|o| (o.first, o.second, o.t_in - 200.0, o.t_out - 200.0)).collect();
    assert_eq!(found, [(1, 1, 1.0, 2.0)]);
    let mut segments = Vec::new();
    Caster::new(&world).segments(&ray, Span::FORWARD, Overlaps::Priority, &mut segments).expect("solids");
    let names: Vec<_> = segments.iter().map(|s| world.path_name(s.path)).collect();
    let of = |i: usize| {
        [format!("world/cell[{i}]"), format!("world/cell[{i}]/core[0]"), format!("world/cell[{i}]")]
    };
    let w = || vec!["world".to_owned()];
    // The second cell owns the overlap.
    let expected = [w(), of(0)[..2].to_vec(), of(1).to_vec(), w(), of(2).to_vec(), w()].concat();
    assert_eq!(names, expected);
}
