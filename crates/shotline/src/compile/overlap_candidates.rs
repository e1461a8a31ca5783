//! Finds where different objects may overlap: pairs of leaves whose boxes intersect.
//!
//! Subtrees are refined in pairs: where the boxes of two intersect, their children are compared. Pairs within a
//! shared level are searched for in one of its placements only, so that work and memory grow with the pairs and not
//! with the placements.

use std::collections::{HashMap, HashSet};

use super::box_join::{intersects, join};
use super::world::{Body, Placement, Target, World};
use crate::aabb::Aabb;
use crate::math::Affine;

/// Half-ulps of its coordinates by which a box may be larger than its contents. Boxes are shrunk by this, so that
/// boxes that abut do not intersect.
const PADDING: f64 = 32.0;

/// Maximum number of pairs of subtrees that wait to be refined: in a level, and below two subtrees that intersect.
const MAX_PENDING_PAIRS: usize = 1 << 22;
const MAX_PENDING_PAIRS_BELOW: usize = 1 << 17;

/// Leaves of two objects of equal priority whose boxes intersect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapCandidate {
    /// The objects, the lower number first.
    pub objects: [u32; 2],
    /// The intersection of the boxes, in world coordinates; infinite where both leaves are unbounded.
    pub common: Aabb,
}

/// The result of [`World::overlap_candidates`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OverlapCandidates {
    /// The pairs found, at most as many as requested.
    pub pairs: Vec<OverlapCandidate>,
    /// The number of all pairs found.
    pub count: u64,
    /// Whether the search was complete. If not, it needed more comparisons or more waiting pairs than were allowed.
    pub complete: bool,
}

/// The objects in a level.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SoleObject {
    Nothing,
    /// Leaves of a single object; `None` stands for the object that is named above the level.
    One(Option<u32>),
    Several,
}

/// A subtree of the world, placed in the world.
#[derive(Clone, Copy, Debug)]
struct Subtree {
    /// In world coordinates.
    bounds: Aabb,
    /// The object of all its leaves; `None` where there are several.
    sole: Option<u32>,
    /// The object that was named at the subtree or above it.
    named: Option<u32>,
    kind: SubtreeKind,
}

#[derive(Clone, Copy, Debug)]
enum SubtreeKind {
    Leaf,
    /// With the transform from its frame to the world.
    Placement(Target, Affine),
}

impl World {
    /// Finds pairs of leaves of two objects of equal priority whose boxes intersect. Returns at most `most` of them,
    /// and makes at most `comparisons` comparisons. Subtracted leaves do not count. Pairs within a shared group are
    /// found in only one of its placements.
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

    /// Boxes of the leaves of each wanted object, in world coordinates, at most `each` per object. The search ends
    /// after `steps` steps, so objects in many groups may be incomplete.
    pub fn leaf_boxes(&self, wanted: &[bool], each: usize, mut steps: u64) -> Vec<Vec<Aabb>> {
        let sole = self.sole_objects();
        let mut children = SubtreeChildren::new(self, &sole);
        let mut boxes = vec![Vec::new(); self.object_names().len()];
        let mut waiting = vec![children.root()];
        while let (Some(subtree), true) = (waiting.pop(), steps > 0) {
            let is_full = |object: u32| !wanted[object as usize] || boxes[object as usize].len() >= each;
            match (subtree.kind, subtree.sole) {
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

    /// The objects in each level. Levels come after those that they place.
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

/// Computes the children of subtrees.
struct SubtreeChildren<'w> {
    world: &'w World,
    sole_objects: &'w [SoleObject],
    /// The boxes of the leaves of a body, without duplicates, in its frame.
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
            kind: SubtreeKind::Placement(Target::Level(self.world.root), Affine::IDENTITY),
        }
    }

    /// The children of a subtree that have a volume; none for a leaf.
    fn of(&mut self, subtree: &Subtree) -> Vec<Subtree> {
        let inner: Vec<Subtree> = match subtree.kind {
            SubtreeKind::Leaf => return Vec::new(),
            SubtreeKind::Placement(Target::Level(level), map) => {
                let placements = &self.world.level(level).placements;
                placements.iter().filter_map(|placed| self.placed(placed, &map, subtree.named)).collect()
            }
            SubtreeKind::Placement(Target::Body(body), map) => {
                let leaf = |b: &Aabb| Subtree {
                    bounds: b.transformed(&map).widened(-PADDING).intersection(&subtree.bounds),
                    kind: SubtreeKind::Leaf,
                    ..*subtree
                };
                self.leaves_of(body).iter().map(leaf).collect()
            }
        };
        inner.into_iter().filter(|subtree| subtree.bounds.min.cmplt(subtree.bounds.max).all()).collect()
    }

    /// The subtree of a placement in a level that is itself placed by `map`.
    fn placed(&self, placed: &Placement, map: &Affine, named: Option<u32>) -> Option<Subtree> {
        // This matrix is itself an inverse, so it can be inverted, except for rounding.
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
            kind: SubtreeKind::Placement(placed.target, map.then_after(&own)),
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
    /// The number of comparisons that are left.
    budget: u64,
    found: OverlapCandidates,
}

impl Search<'_> {
    /// Searches each level of several objects in one of its placements. Returns whether the search was complete.
    fn run(&mut self) -> bool {
        let mut seen = HashSet::new();
        let mut levels = vec![self.children.root()];
        while let Some(level) = levels.pop() {
            let SubtreeKind::Placement(Target::Level(number), _) = level.kind else { continue };
            if !seen.insert((number, level.named)) {
                continue;
            }
            let children = self.children.of(&level);
            if !self.search_siblings(&children) {
                return false;
            }
            levels.extend(children.iter().filter(|subtree| subtree.sole.is_none()));
        }
        true
    }

    /// Searches for pairs among siblings. Returns whether the search was complete.
    fn search_siblings(&mut self, children: &[Subtree]) -> bool {
        let boxes: Vec<Aabb> = children.iter().map(|subtree| subtree.bounds).collect();
        let mut pairs = Vec::new();
        let mut complete = spend(&mut self.budget, children.len());
        let (may, mut all) = (may_overlap(self.children.world), true);
        complete &= join(&boxes, &mut self.budget, |i, j| {
            if may(&children[i], &children[j]) {
                all &= pairs.len() < MAX_PENDING_PAIRS;
                if all {
                    pairs.push((i, j));
                }
            }
        });
        complete &= all;
        for (i, j) in pairs {
            complete &= self.search_pair(children[i], children[j]);
        }
        complete
    }

    /// Searches for pairs of leaves, one from each of two subtrees that intersect. Returns whether the search was
    /// complete.
    fn search_pair(&mut self, a: Subtree, b: Subtree) -> bool {
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
                if let (SubtreeKind::Leaf, SubtreeKind::Leaf) = (children[i].kind, children[j].kind) {
                    found.add(&children[i], &children[j], most);
                } else {
                    all &= waiting.len() < MAX_PENDING_PAIRS_BELOW;
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

    /// The children of a subtree whose boxes intersect another subtree; the subtree itself if it is a leaf.
    fn open(&mut self, subtree: &Subtree, other: &Subtree) -> Vec<Subtree> {
        if let SubtreeKind::Leaf = subtree.kind {
            return vec![*subtree];
        }
        let mut inner = self.children.of(subtree);
        // All children are compared, whether they intersect or not.
        self.budget = self.budget.saturating_sub(inner.len() as u64);
        inner.retain(|inner| intersects(&inner.bounds, &other.bounds));
        inner
    }
}

impl OverlapCandidates {
    /// Counts a pair of leaves, and keeps it if fewer than `most` have been kept.
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

/// Whether subtrees may contain leaves of different objects of equal priority.
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
        // In the box of the union, but in none of the boxes of its leaves.
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
