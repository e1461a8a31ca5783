//! Where parts of different objects may overlap: pairs of leaves whose boxes meet.
//!
//! Parts are refined in pairs: of two that meet, what they hold is compared. Pairs within a shared level are looked for at
//! one of its places, so that work and memory grow with the pairs and not with the placements.

use std::collections::{HashMap, HashSet};

use super::box_join::{join, meet};
use super::world::{Body, Placement, Target, World};
use crate::aabb::Aabb;
use crate::math::Affine;

/// Half-ulps of its coordinates by which a box may be larger than what it holds: boxes that abut do not meet.
const PADDING: f64 = 32.0;

/// Pairs of parts that wait to be refined, at most: in a level, and below two parts that meet.
const WAITING: usize = 1 << 22;
const WAITING_BELOW: usize = 1 << 17;

/// Parts of two objects of equal priority whose boxes meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapCandidate {
    /// The objects, the lower number first.
    pub objects: [u32; 2],
    /// What the boxes have in common, in world coordinates; infinite where the parts have no end.
    pub common: Aabb,
}

/// The answer of [`World::meetings`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OverlapCandidates {
    /// Pairs of parts, of all that there are so many as were wanted.
    pub pairs: Vec<OverlapCandidate>,
    /// The number of pairs found.
    pub count: u64,
    /// Whether that is all. If not, the comparisons that were allowed were too few.
    pub complete: bool,
}

/// What levels hold.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SoleObject {
    Nothing,
    /// Parts of one object; `None` stands for the one that is named above.
    One(Option<u32>),
    Several,
}

/// A part in its place.
#[derive(Clone, Copy, Debug)]
struct Subtree {
    /// In world coordinates.
    bounds: Aabb,
    /// The object of all that it holds; `None` where there are several.
    sole: Option<u32>,
    /// The object that was named here or above.
    named: Option<u32>,
    what: SubtreeKind,
}

#[derive(Clone, Copy, Debug)]
enum SubtreeKind {
    Leaf,
    /// With the map from its frame to the world.
    Placement(Target, Affine),
}

impl World {
    /// Pairs of leaves of two objects of equal priority whose boxes meet, with so many comparisons at most. Leaves that
    /// are taken away do not count. Of a shared group the pairs within it are found at one of its places.
    pub fn overlap_candidates(&self, most: usize, comparisons: u64) -> OverlapCandidates {
        let sole = self.sole_objects();
        let mut search = Search {
            children: SubtreeChildren::new(self, &sole),
            most,
            budget: comparisons,
            found: OverlapCandidates::default(),
        };
        search.found.complete = search.run();
        search.found
    }

    /// Boxes of the leaves of each wanted object, in world coordinates, so many of each at most. What many groups hold may
    /// be given in part: after so many `steps` it ends.
    pub fn leaf_boxes(&self, wanted: &[bool], each: usize, mut steps: u64) -> Vec<Vec<Aabb>> {
        let sole = self.sole_objects();
        let mut children = SubtreeChildren::new(self, &sole);
        let mut boxes = vec![Vec::new(); self.object_names().len()];
        let mut waiting = vec![children.root()];
        while let (Some(subtree), true) = (waiting.pop(), steps > 0) {
            let is_full = |object: u32| !wanted[object as usize] || boxes[object as usize].len() >= each;
            match (subtree.what, subtree.sole) {
                (_, Some(object)) if is_full(object) => {}
                (SubtreeKind::Leaf, Some(object)) => boxes[object as usize].push(subtree.bounds),
                _ => {
                    let inner = children.of(&subtree);
                    steps = steps.saturating_sub(1 + inner.len() as u64);
                    waiting.extend(inner);
                }
            }
        }
        boxes
    }

    /// What each level holds. Levels come after those that they place.
    fn sole_objects(&self) -> Vec<SoleObject> {
        let mut sole_objects: Vec<SoleObject> = Vec::with_capacity(self.levels.len());
        for level in &self.levels {
            let sole = level.placements.iter().fold(SoleObject::Nothing, |all, placed| {
                match (all, sole_object_of(placed, &sole_objects)) {
                    (all, SoleObject::Nothing) => all,
                    (SoleObject::Nothing, one) => one,
                    (all, one) if all == one => all,
                    _ => SoleObject::Several,
                }
            });
            sole_objects.push(sole);
        }
        sole_objects
    }
}

fn sole_object_of(placed: &Placement, sole_objects: &[SoleObject]) -> SoleObject {
    match placed.target {
        Target::Body(_) => SoleObject::One(placed.object),
        Target::Level(level) => match sole_objects[level as usize] {
            SoleObject::One(object) => SoleObject::One(object.or(placed.object)),
            other => other,
        },
    }
}

/// What parts hold.
struct SubtreeChildren<'w> {
    world: &'w World,
    sole_objects: &'w [SoleObject],
    /// The boxes of the leaves of a body, each once, in its frame.
    leaves: HashMap<u32, Vec<Aabb>>,
}

impl<'w> SubtreeChildren<'w> {
    fn new(world: &'w World, sole_objects: &'w [SoleObject]) -> SubtreeChildren<'w> {
        SubtreeChildren { world, sole_objects, leaves: HashMap::new() }
    }

    fn root(&self) -> Subtree {
        Subtree {
            bounds: self.world.bounds(),
            sole: None,
            named: None,
            what: SubtreeKind::Placement(Target::Level(self.world.root), Affine::IDENTITY),
        }
    }

    /// The parts of a part that have a volume; none of a leaf.
    fn of(&mut self, subtree: &Subtree) -> Vec<Subtree> {
        let inner: Vec<Subtree> = match subtree.what {
            SubtreeKind::Leaf => return Vec::new(),
            SubtreeKind::Placement(Target::Level(level), map) => {
                let placements = &self.world.level(level).placements;
                placements.iter().filter_map(|placed| self.placed(placed, &map, subtree.named)).collect()
            }
            SubtreeKind::Placement(Target::Body(body), map) => {
                let leaf = |b: &Aabb| Subtree {
                    bounds: b.transformed(&map).widened(-PADDING).intersection(&subtree.bounds),
                    what: SubtreeKind::Leaf,
                    ..*subtree
                };
                self.leaves_of(body).iter().map(leaf).collect()
            }
        };
        inner.into_iter().filter(|subtree| subtree.bounds.min.cmplt(subtree.bounds.max).all()).collect()
    }

    /// What is placed in a level that is placed by `map`.
    fn placed(&self, placed: &Placement, map: &Affine, named: Option<u32>) -> Option<Subtree> {
        // It was inverted once, so it can be again, but for rounding.
        let own = placed.local_from_parent.inverse().ok()?;
        let named = placed.object.or(named);
        let sole = match sole_object_of(placed, self.sole_objects) {
            SoleObject::Nothing => return None,
            SoleObject::One(object) => Some(object.or(named)?),
            SoleObject::Several => None,
        };
        let bounds = placed.bounds.transformed(map).widened(-PADDING);
        Some(Subtree {
            bounds,
            sole,
            named,
            what: SubtreeKind::Placement(placed.target, map.then_after(&own)),
        })
    }

    fn leaves_of(&mut self, body: u32) -> &[Aabb] {
        let world = self.world;
        self.leaves.entry(body).or_insert_with(|| match world.body(body) {
            Body::Surface(surface) => vec![surface.bounds],
            Body::Solid(solid) => {
                let solids = (0..).zip(&solid.leaves).filter(|(leaf, _)| !solid.program.is_subtracted(*leaf));
                let mut seen = HashSet::new();
                let bits =
                    |b: &Aabb| (b.min.to_array().map(f64::to_bits), b.max.to_array().map(f64::to_bits));
                solids.map(|(_, leaf)| leaf.bounds).filter(|b| seen.insert(bits(b))).collect()
            }
        })
    }
}

struct Search<'w> {
    children: SubtreeChildren<'w>,
    most: usize,
    /// Comparisons that are left.
    budget: u64,
    found: OverlapCandidates,
}

impl Search<'_> {
    /// Looks through each level of several objects at one of its places. Whether the budget was enough.
    fn run(&mut self) -> bool {
        let mut seen = HashSet::new();
        let mut levels = vec![self.children.root()];
        while let Some(level) = levels.pop() {
            let SubtreeKind::Placement(Target::Level(number), _) = level.what else { continue };
            if !seen.insert((number, level.named)) {
                continue;
            }
            let children = self.children.of(&level);
            if !self.within(&children) {
                return false;
            }
            levels.extend(children.iter().filter(|subtree| subtree.sole.is_none()));
        }
        true
    }

    /// Looks for pairs among parts that lie beside each other.
    fn within(&mut self, children: &[Subtree]) -> bool {
        let boxes: Vec<Aabb> = children.iter().map(|subtree| subtree.bounds).collect();
        let mut pairs = Vec::new();
        let mut complete = spend(&mut self.budget, children.len());
        let (may, mut all) = (may_overlap(self.children.world), true);
        complete &= join(&boxes, &mut self.budget, |i, j| {
            if may(&children[i], &children[j]) {
                all &= pairs.len() < WAITING;
                if all {
                    pairs.push((i, j));
                }
            }
        });
        complete &= all;
        for (i, j) in pairs {
            complete &= self.between(children[i], children[j]);
        }
        complete
    }

    /// Looks for pairs of leaves, one of each of two parts that meet.
    fn between(&mut self, a: Subtree, b: Subtree) -> bool {
        let mut waiting = vec![(a, b)];
        while let Some((a, b)) = waiting.pop() {
            let (of_a, of_b) = (self.open(&a, &b), self.open(&b, &a));
            if !spend(&mut self.budget, of_a.len() + of_b.len()) {
                return false;
            }
            let children = [&of_a[..], &of_b[..]].concat();
            let boxes: Vec<Aabb> = children.iter().map(|subtree| subtree.bounds).collect();
            let (may, apart, mut all) = (may_overlap(self.children.world), of_a.len(), true);
            let (found, most) = (&mut self.found, self.most);
            let complete = join(&boxes, &mut self.budget, |i, j| {
                if i >= apart || j < apart || !may(&children[i], &children[j]) {
                    return;
                }
                if let (SubtreeKind::Leaf, SubtreeKind::Leaf) = (children[i].what, children[j].what) {
                    found.add(&children[i], &children[j], most);
                } else {
                    all &= waiting.len() < WAITING_BELOW;
                    if all {
                        waiting.push((children[i], children[j]));
                    }
                }
            });
            if !(complete && all) {
                return false;
            }
        }
        true
    }

    /// What a part holds that meets another; itself, if it is a leaf.
    fn open(&mut self, subtree: &Subtree, other: &Subtree) -> Vec<Subtree> {
        if let SubtreeKind::Leaf = subtree.what {
            return vec![*subtree];
        }
        let mut inner = self.children.of(subtree);
        // All are looked at, whether they meet or not.
        self.budget = self.budget.saturating_sub(inner.len() as u64);
        inner.retain(|inner| meet(&inner.bounds, &other.bounds));
        inner
    }
}

impl OverlapCandidates {
    /// Adds a pair of leaves; it is kept if there are not so many yet.
    fn add(&mut self, a: &Subtree, b: &Subtree, most: usize) {
        let (Some(one), Some(other)) = (a.sole, b.sole) else { return };
        self.count += 1;
        if self.pairs.len() < most {
            let common = a.bounds.intersection(&b.bounds);
            self.pairs.push(OverlapCandidate { objects: [one.min(other), one.max(other)], common });
        }
    }
}

fn spend(budget: &mut u64, steps: usize) -> bool {
    let rest = budget.checked_sub(steps as u64);
    *budget = rest.unwrap_or(0);
    rest.is_some()
}

/// Whether parts may belong to different objects of equal priority.
fn may_overlap(world: &World) -> impl Fn(&Subtree, &Subtree) -> bool {
    move |a, b| match (a.sole, b.sole) {
        (Some(a), Some(b)) => a != b && world.object_priority(a) == world.object_priority(b),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{Options, compile};
    use crate::math::Vec3;
    use crate::scene::{Node, NodeId, Op, Scene};

    fn ball(scene: &mut Scene, at: [f64; 3]) -> NodeId {
        let ball = scene.add_solid("sphere", &[&[1.0]]).unwrap();
        scene.add_transform(Affine::translation(Vec3::from_array(at)), ball)
    }

    fn overlap_candidates(scene: &Scene) -> OverlapCandidates {
        compile(scene, Options::default()).unwrap().overlap_candidates(100, 1 << 20)
    }

    #[test]
    fn pairs_are_those_of_leaves_of_different_objects_of_equal_priority() {
        let mut scene = Scene::default();
        let [a, b, far, off] =
            [[0.0; 3], [1.5, 0.0, 0.0], [100.0; 3], [50.0; 3]].map(|at| ball(&mut scene, at));
        let two = scene.add_csg(Op::Union, vec![a, far]);
        scene.add_object("two", None, two);
        scene.add_object("b", None, b);
        // In the box of the union, but of no leaf of it.
        scene.add_object("off", None, off);
        let found = overlap_candidates(&scene);
        assert!(found.complete && found.count == 1, "{found:?}");
        assert_eq!(found.pairs[0].objects, [0, 1]);
        let common = found.pairs[0].common;
        assert!((common.min.x - 0.5).abs() < 1e-12 && (common.max.x - 1.0).abs() < 1e-12, "{common:?}");
    }

    #[test]
    fn pairs_within_a_shared_group_are_found_at_one_place() {
        let mut scene = Scene::default();
        let [a, b] = [[0.0; 3], [1.5, 0.0, 0.0]].map(|at| ball(&mut scene, at));
        let members = [("a", a), ("b", b)].map(|(name, node)| {
            scene.add(Node::Object { name: name.into(), material: None, priority: 0, node })
        });
        let mut group = scene.add(Node::Group { members: members.to_vec() });
        for k in 0..40 {
            let step = 4.0 * f64::powi(2.0, k);
            let moved = scene.add_transform(Affine::translation(Vec3::new(0.0, step, 0.0)), group);
            group = scene.add(Node::Group { members: vec![group, moved] });
        }
        scene.add_object("all", None, group);
        let found = overlap_candidates(&scene);
        assert!(found.complete && found.count == 1, "{found:?}");
    }

    #[test]
    fn comparisons_that_are_too_few_are_told() {
        let mut scene = Scene::default();
        for i in 0..100 {
            let ball = ball(&mut scene, [0.1 * f64::from(i), 0.0, 0.0]);
            scene.add_object(&format!("ball {i}"), None, ball);
        }
        let world = compile(&scene, Options::default()).unwrap();
        let few = world.overlap_candidates(10, 200);
        assert!(!few.complete, "{few:?}");
        let all = world.overlap_candidates(10, 1 << 20);
        assert!(all.complete && all.count > 1000 && all.pairs.len() == 10, "{}", all.count);
    }
}
