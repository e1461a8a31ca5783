//! Finds where instances of objects may be in conflict: pairs of leaves whose boxes intersect.
//!
//! Subtrees are refined in pairs: where the boxes of two intersect, their children are compared. Pairs within a
//! shared level are searched for in one of its placements only, so that work and memory grow with the pairs and not
//! with the placements.

use std::collections::{HashMap, HashSet};

use super::box_join::{intersects, join};
use super::placements::{Level, ObjectScope, Placement, Target};
use super::world::{Body, World};
use crate::aabb::Aabb;
use crate::math::Affine;

/// Half-ulps of its coordinates by which a box may be larger than its contents. Boxes are shrunk by this, so that
/// boxes that abut do not intersect.
const PADDING: f64 = 32.0;

/// Maximum number of pairs of subtrees that wait to be refined: in a level, and below two subtrees that intersect.
const MAX_PENDING_PAIRS: usize = 1 << 22;
const MAX_PENDING_PAIRS_BELOW: usize = 1 << 17;

/// How two instances of objects can be in conflict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ConflictKind {
    /// Both contain a point, their priorities are equal, and neither is in the other.
    Overlap,
    /// One sticks out of the other, which contains it and clips.
    Protrusion,
}

/// Leaves of two instances that may be in conflict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConflictCandidate {
    /// What may be wrong.
    pub kind: ConflictKind,
    /// The objects; the one that may stick out comes first.
    pub objects: [u32; 2],
    /// Where, in world coordinates: the intersection of the boxes of two leaves that may overlap, infinite where both are
    /// unbounded; the box of a leaf that may stick out of an object that contains it and clips.
    pub place: Aabb,
}

/// The result of [`World::conflict_candidates`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConflictCandidates {
    /// The pairs found, at most as many as requested.
    pub pairs: Vec<ConflictCandidate>,
    /// The number of all pairs found.
    pub count: u64,
    /// Whether the search was complete. If not, it needed more comparisons or more waiting pairs than were allowed.
    pub complete: bool,
    /// Whether there is a lattice of so many cells that only those near a corner were searched.
    pub has_cut_lattices: bool,
}

/// A subtree of the world, placed in the world.
#[derive(Clone, Copy, Debug)]
struct Subtree {
    /// In world coordinates.
    bounds: Aabb,
    /// The innermost instance that all of it is in, and whether no other begins in it.
    instance: Option<InstanceId>,
    is_sole: bool,
    kind: SubtreeKind,
}

#[derive(Clone, Copy, Debug)]
enum SubtreeKind {
    Leaf,
    /// With the transform from its frame to the world.
    Placement(Target, Affine),
}

/// The number of an instance of an object, among those that a search has met.
type InstanceId = u32;

/// An instance of an object.
#[derive(Clone, Copy, Debug)]
struct Instance {
    object: u32,
    /// The instance that it is in.
    parent: Option<InstanceId>,
}

impl World {
    /// Finds pairs of leaves of two instances of equal priority whose boxes intersect, unless one instance is in the other;
    /// and of an instance and what it contains, if it clips. Returns at most `most` of them, and makes at most `comparisons`
    /// comparisons. Subtracted leaves do not count. Pairs within a shared group are found in only one of its placements.
    pub fn conflict_candidates(&self, most: usize, comparisons: u64) -> ConflictCandidates {
        let mut search = Search {
            children: SubtreeChildren::new(self),
            most,
            budget: comparisons,
            found: ConflictCandidates::default(),
        };
        search.found.complete = search.run();
        search.found.has_cut_lattices = search.children.is_cut;
        search.found
    }

    /// Boxes of the leaves of each wanted object, in world coordinates, at most `each` per object. The search ends
    /// after `steps` steps, so objects in many groups may be incomplete.
    pub fn leaf_boxes(&self, wanted: &[bool], each: usize, mut steps: u64) -> Vec<Vec<Aabb>> {
        let mut children = SubtreeChildren::new(self);
        let mut boxes = vec![Vec::new(); self.object_names().len()];
        let mut waiting = vec![children.root()];
        while let (Some(subtree), true) = (waiting.pop(), steps > 0) {
            let is_full = |object: u32| !wanted[object as usize] || boxes[object as usize].len() >= each;
            match (subtree.kind, children.sole_object(&subtree)) {
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

    /// For each level whether an instance begins in it. Levels come after those that they place.
    fn levels_with_objects(&self) -> Vec<bool> {
        let mut found: Vec<bool> = Vec::with_capacity(self.levels.len());
        for level in &self.levels {
            let is_below = |placed: &Placement| match placed.target {
                Target::Body(_) => false,
                Target::Level(below) => found[below as usize],
            };
            found.push(level.placements.iter().any(|placed| placed.object.is_some() || is_below(placed)));
        }
        found
    }
}

/// The largest number of cells of a lattice that are all compared with what is around it. Of a larger one only those near its
/// first corner are, which shows whether neighbours overlap.
const MAX_SEARCHED_CELLS: u32 = 1 << 16;
const CORNER: u32 = 32;

/// The placements of a level that are searched. The empty cells of a lattice are left out.
fn cells_to_search(level: &Level) -> Vec<u32> {
    match &level.lattice {
        Some(cells) if cells.count() > MAX_SEARCHED_CELLS => {
            let lattice = &cells.lattice;
            let [rows, layers] = [lattice.rows(), lattice.layers()].map(|count| count.min(CORNER));
            let row = |k, j| (0..lattice.row(j).count.min(CORNER)).map(move |i| lattice.number([i, j, k]));
            let near = (0..layers).flat_map(|k| (0..rows).flat_map(move |j| row(k, j)));
            near.filter(|&number| level.has_placement(number)).collect()
        }
        _ => level.numbers().collect(),
    }
}

/// Computes the children of subtrees.
struct SubtreeChildren<'w> {
    world: &'w World,
    /// Whether some cells of a lattice were left out.
    is_cut: bool,
    instances: Vec<Instance>,
    levels_with_objects: Vec<bool>,
    /// The boxes of the leaves of a body, without duplicates, in its frame.
    leaves: HashMap<u32, Vec<Aabb>>,
}

impl<'w> SubtreeChildren<'w> {
    fn new(world: &'w World) -> SubtreeChildren<'w> {
        let levels_with_objects = world.levels_with_objects();
        SubtreeChildren {
            world,
            is_cut: false,
            instances: Vec::new(),
            levels_with_objects,
            leaves: HashMap::new(),
        }
    }

    fn root(&self) -> Subtree {
        Subtree {
            bounds: self.world.bounds(),
            instance: None,
            is_sole: false,
            kind: SubtreeKind::Placement(Target::Level(self.world.root), Affine::IDENTITY),
        }
    }

    fn object(&self, instance: InstanceId) -> u32 {
        self.instances[instance as usize].object
    }

    /// The object of all leaves of a subtree, if they are of one instance.
    fn sole_object(&self, subtree: &Subtree) -> Option<u32> {
        subtree.instance.filter(|_| subtree.is_sole).map(|instance| self.object(instance))
    }

    /// The children of a subtree that have a volume; none for a leaf.
    fn of(&mut self, subtree: &Subtree) -> Vec<Subtree> {
        let inner: Vec<Subtree> = match subtree.kind {
            SubtreeKind::Leaf => return Vec::new(),
            SubtreeKind::Placement(Target::Level(level), map) => {
                let level = self.world.level(level);
                let mut scopes = vec![None; level.scopes.len()];
                let numbers = cells_to_search(level);
                self.is_cut |= (numbers.len() as u64) < u64::from(level.placement_count());
                let world = self.world;
                let mut placed = |number: u32| {
                    let placed = Placement {
                        bounds: world.placed_bounds(level, number),
                        ..level.placement(number).into_owned()
                    };
                    self.placed(level, &placed, &map, subtree.instance, &mut scopes)
                };
                numbers.into_iter().filter_map(&mut placed).collect()
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

    /// The subtree of a placement in a level that is itself placed by `map`, in the instance `above`. `scopes` are the
    /// instances of the scopes of the level that are known.
    fn placed(
        &mut self,
        level: &Level,
        placed: &Placement,
        map: &Affine,
        above: Option<InstanceId>,
        scopes: &mut [Option<InstanceId>],
    ) -> Option<Subtree> {
        // This matrix is itself an inverse, so it can be inverted, except for rounding.
        let own = placed.local_from_parent.inverse().ok()?;
        let around = placed.scope.map(|scope| self.scope(level, scope, above, scopes)).or(above);
        let is_of_scope =
            |object| placed.scope.is_some_and(|scope| level.scopes[scope as usize].object == object);
        let instance = match placed.object.filter(|object| !is_of_scope(*object)) {
            Some(object) => Some(self.add(object, around)),
            None => around,
        };
        let is_sole = match placed.target {
            Target::Body(_) => true,
            Target::Level(level) => !self.levels_with_objects[level as usize],
        };
        let bounds = placed.bounds.transformed(map).widened(-PADDING);
        Some(Subtree {
            bounds,
            instance,
            is_sole,
            kind: SubtreeKind::Placement(placed.target, map.then_after(&own)),
        })
    }

    /// The instance of a scope.
    fn scope(
        &mut self,
        level: &Level,
        scope: u32,
        above: Option<InstanceId>,
        scopes: &mut [Option<InstanceId>],
    ) -> InstanceId {
        // Outermost first, since an instance is in one that exists.
        let mut missing = vec![scope];
        while let Some(&innermost) = missing.last()
            && let Some(parent) = level.scopes[innermost as usize].parent
            && scopes[parent as usize].is_none()
        {
            missing.push(parent);
        }
        while let Some(number) = missing.pop() {
            if scopes[number as usize].is_none() {
                let ObjectScope { object, parent, .. } = level.scopes[number as usize];
                let parent = parent.and_then(|parent| scopes[parent as usize]).or(above);
                scopes[number as usize] = Some(self.add(object, parent));
            }
        }
        scopes[scope as usize].unwrap_or_default()
    }

    fn add(&mut self, object: u32, parent: Option<InstanceId>) -> InstanceId {
        self.instances.push(Instance { object, parent });
        (self.instances.len() - 1) as InstanceId
    }

    /// Whether an instance is another or in it. Each is numbered after those that it is in.
    fn is_within(&self, mut inner: Option<InstanceId>, outer: InstanceId) -> bool {
        while let Some(instance) = inner.filter(|&inner| inner > outer) {
            inner = self.instances[instance as usize].parent;
        }
        inner == Some(outer)
    }

    /// Whether there may be leaves in two subtrees that are candidates.
    fn may_conflict(&self, a: &Subtree, b: &Subtree) -> bool {
        let (Some(of_a), Some(of_b)) = (a.instance, b.instance) else { return true };
        if a.is_sole && self.is_within(b.instance, of_a) {
            return self.may_protrude(a, b);
        }
        if b.is_sole && self.is_within(a.instance, of_b) {
            return self.may_protrude(b, a);
        }
        let priority = |instance| self.world.object_priority(self.object(instance));
        !(a.is_sole && b.is_sole) || priority(of_a) == priority(of_b)
    }

    /// Whether leaves of the contents of an instance, or leaves in a part of them, may stick out of it.
    fn may_protrude(&self, container: &Subtree, contents: &Subtree) -> bool {
        let Some(outer) = container.instance.filter(|&outer| self.world.object_clips(self.object(outer)))
        else {
            return false;
        };
        // What clips an instance is the innermost one around it that does.
        let clip_around = |inner: InstanceId| {
            let mut around = self.instances[inner as usize].parent;
            while let Some(instance) = around.filter(|&i| !self.world.object_clips(self.object(i))) {
                around = self.instances[instance as usize].parent;
            }
            around
        };
        match contents.instance {
            Some(inner) if inner == outer => true,
            Some(inner) => clip_around(inner) == Some(outer),
            None => false,
        }
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
    found: ConflictCandidates,
}

impl Search<'_> {
    /// Searches each level of several objects in one of its placements. Returns whether the search was complete.
    fn run(&mut self) -> bool {
        let mut seen = HashSet::new();
        let mut levels = vec![self.children.root()];
        while let Some(level) = levels.pop() {
            let SubtreeKind::Placement(Target::Level(number), _) = level.kind else { continue };
            let object = level.instance.map(|instance| self.children.object(instance));
            if !seen.insert((number, object)) {
                continue;
            }
            let children = self.children.of(&level);
            if !self.search_siblings(&children) {
                return false;
            }
            levels.extend(children.iter().filter(|subtree| !subtree.is_sole));
        }
        true
    }

    /// Searches for pairs among siblings. Returns whether the search was complete.
    fn search_siblings(&mut self, children: &[Subtree]) -> bool {
        let boxes: Vec<Aabb> = children.iter().map(|subtree| subtree.bounds).collect();
        let mut pairs = Vec::new();
        let mut complete = spend(&mut self.budget, children.len());
        let (of, mut all) = (&self.children, true);
        complete &= join(&boxes, &mut self.budget, |i, j| {
            if of.may_conflict(&children[i], &children[j]) {
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
            let (of, apart, mut all) = (&self.children, of_a.len(), true);
            let (found, most) = (&mut self.found, self.most);
            let complete = join(&boxes, &mut self.budget, |i, j| {
                if i >= apart || j < apart || !of.may_conflict(&children[i], &children[j]) {
                    return;
                }
                if let (SubtreeKind::Leaf, SubtreeKind::Leaf) = (children[i].kind, children[j].kind) {
                    found.add(of, &children[i], &children[j], most);
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

impl ConflictCandidates {
    /// Counts a pair of leaves, and keeps it if fewer than `most` have been kept.
    fn add(&mut self, of: &SubtreeChildren, a: &Subtree, b: &Subtree, most: usize) {
        let (Some(in_a), Some(in_b)) = (a.instance, b.instance) else { return };
        self.count += 1;
        if self.pairs.len() < most {
            let (of_a, of_b) = (of.object(in_a), of.object(in_b));
            let (kind, objects, place) = if of.is_within(b.instance, in_a) {
                (ConflictKind::Protrusion, [of_b, of_a], b.bounds)
            } else if of.is_within(a.instance, in_b) {
                (ConflictKind::Protrusion, [of_a, of_b], a.bounds)
            } else {
                let common = a.bounds.intersection(&b.bounds);
                (ConflictKind::Overlap, [of_a.min(of_b), of_a.max(of_b)], common)
            };
            self.pairs.push(ConflictCandidate { kind, objects, place });
        }
    }
}

fn spend(budget: &mut u64, steps: usize) -> bool {
    let rest = budget.checked_sub(steps as u64);
    *budget = rest.unwrap_or(0);
    rest.is_some()
}

#[cfg(test)]
#[path = "conflict_tests.rs"]
mod tests;
