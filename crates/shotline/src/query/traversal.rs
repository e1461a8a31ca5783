//! The traversal of levels: finds the bodies whose boxes a ray hits, nearest box first.

use super::heap::{Heap, Rank};
use super::level_boxes::box_ray;
use crate::aabb::BoxRay;
use crate::accel::{Accelerator, Child, QueueEntry};
use crate::compile::{Level, Target, World};
use crate::counters::Counters;
use crate::math::{Affine, Vec3};
use crate::outline::Outline;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::tags::VisitTags;
use crate::trace::Act;

/// A visit of a level: a level that the ray has entered, and the path from the root to it.
#[derive(Clone, Copy, Debug)]
struct LevelVisit<'w> {
    level: &'w Level,
    line: Line,
    ray: BoxRay,
    /// The visit of the level above, and the index of the placement in it; `None` for the root.
    above: Option<(u32, u32)>,
    object: u32,
    first_path: u64,
    /// Unique for each visit of a ray. A level that is entered twice is traversed along two different lines, so its
    /// placements are tagged for each visit separately.
    serial: u32,
    /// Whether its placements need tags, because the accelerator may return one of them more than once.
    has_duplicate_refs: bool,
    /// Number of pending entries in it, of visits below it, and of other users. At 0 its memory is reused.
    uses: u32,
}

/// A pending entry of a visit: a node of its accelerator or a placement. Small, so that it stays in registers on its way
/// into the heap.
#[derive(Clone, Copy, Debug)]
struct Entry {
    number: u64,
    visit: u32,
    is_node: bool,
}

/// A placed body that a traversal returned.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedBody {
    pub body: u32,
    pub object: u32,
    pub path: u64,
    /// The visit or the path of the level in which it is placed, for the traversal that returned it, and its placement
    /// there.
    pub visit: u32,
    pub placement: u32,
}

/// A placed body whose box the ray hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyEntry {
    pub placed: PlacedBody,
    /// The ray's line in the frame of the body.
    pub line: Line,
    /// A lower bound on every `t` of the span at which the ray is in the body.
    pub enter: f64,
}

impl BodyEntry {
    /// No body.
    pub const NONE: BodyEntry = BodyEntry {
        placed: PlacedBody { body: u32::MAX, object: 0, path: 0, visit: 0, placement: 0 },
        line: Line { o: Vec3::ZERO, d: Vec3::X, o_err: Vec3::ZERO, d_err: Vec3::ZERO },
        enter: 0.0,
    };
}

/// The ray in a placement, before its target is known to be a body or a level.
struct PlacementEntry {
    target: Target,
    line: Line,
    object: u32,
    path: u64,
    enter: f64,
    visit: u32,
    placement: u32,
}

impl PlacementEntry {
    fn into_body(self, body: u32) -> BodyEntry {
        let PlacementEntry { line, object, path, enter, visit, placement, .. } = self;
        BodyEntry { placed: PlacedBody { body, object, path, visit, placement }, line, enter }
    }
}

/// The memory of a traversal; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct Traversal<'w> {
    visits: Vec<LevelVisit<'w>>,
    /// Visits that are not in use.
    free: Vec<u32>,
    /// The serial number of the next visit.
    serial: u32,
    /// The visit of the body that was returned last: the caller may still need it.
    last_returned: Option<u32>,
    heap: Heap<Entry>,
    /// Pending entries of a traversal without order.
    stack: Vec<(f64, Entry)>,
    children: Vec<QueueEntry>,
    tags: VisitTags,
}

/// The visit of the root, which is never freed.
const ROOT: u32 = 0;

impl<'w> Traversal<'w> {
    /// Begins a ray.
    pub(super) fn begin(&mut self, world: &'w World, line: Line, span: Span) {
        self.visits.clear();
        self.free.clear();
        self.last_returned = None;
        self.heap.clear();
        self.stack.clear();
        self.tags.begin();
        let (level, ray) = (world.root(), BoxRay::new(&line, span));
        let root = LevelVisit {
            level,
            line,
            ray,
            above: None,
            object: 0,
            first_path: 0,
            serial: 0,
            has_duplicate_refs: false,
            uses: 1,
        };
        self.serial = 1;
        self.visits.push(root);
    }

    /// Descends directly to a body along a known path. Returns `None` if the ray misses a box on the path, or if this
    /// world has no such path.
    pub(super) fn descend_along(
        &mut self,
        world: &'w World,
        placements_on_path: &[u32],
        counters: &mut Counters,
    ) -> Option<BodyEntry> {
        let mut visit = ROOT;
        for &item in placements_on_path {
            let LevelVisit { level, ray, .. } = &self.visits[visit as usize];
            counters.boxes += 1;
            if !level.has_placement(item) {
                return None;
            }
            let (enter, _) = ray.enter_exit(&level.bounds_of(item))?;
            let placement_entry = self.enter_placement(visit, item, enter);
            match placement_entry.target {
                Target::Body(body) => {
                    self.visits[visit as usize].uses += 1;
                    self.last_returned = Some(visit);
                    return Some(placement_entry.into_body(body));
                }
                Target::Level(level) => visit = self.new_visit(world.level(level), placement_entry),
            }
        }
        None
    }

    /// Writes the path from the root to a body: the index of the placement in each level.
    pub(super) fn placements_on_path(&self, body_entry: &BodyEntry, placements_on_path: &mut Vec<u32>) {
        placements_on_path.clear();
        placements_on_path.push(body_entry.placed.placement);
        let mut visit = &self.visits[body_entry.placed.visit as usize];
        while let Some((above, placement)) = visit.above {
            placements_on_path.push(placement);
            visit = &self.visits[above as usize];
        }
        placements_on_path.reverse();
    }

    /// Opens the root. After this, [`Traversal::next`] returns bodies.
    pub(super) fn enter_root(&mut self, world: &World, below: &mut Scratch) {
        let t = self.visits[ROOT as usize].ray.span().t_min();
        self.enter(world, ROOT, t, below);
    }

    /// Returns the next body whose box begins at or before `limit`: nearest first, and depth first among boxes that
    /// begin at the same `t`. Also returns `None` when the budget of the ray has ended.
    pub(super) fn next(&mut self, world: &'w World, limit: f64, below: &mut Scratch) -> Option<BodyEntry> {
        self.release_given();
        while let Some((t, entry)) = self.heap.pop() {
            if t > limit {
                below.log.enter(0, Some(Affine::IDENTITY));
                below.log.add(0, Some(t), || Act::Done { pending: 1 + self.heap.len() });
                return None;
            }
            if !below.budget.step() {
                return None;
            }
            if let Some(body) = self.expand(world, t, entry, below) {
                return Some(body);
            }
        }
        None
    }

    /// Returns the next body in any order. The traversal is depth first, so that memory does not grow with the number
    /// of boxes that the ray hits. A traversal uses either this or [`Traversal::next`]. Also returns `None` when the
    /// budget of the ray has ended.
    pub(super) fn next_unordered(&mut self, world: &'w World, below: &mut Scratch) -> Option<BodyEntry> {
        self.release_given();
        loop {
            while let Some(offered) = self.heap.pop() {
                self.stack.push(offered);
            }
            let (t, entry) = self.stack.pop()?;
            if !below.budget.step() {
                return None;
            }
            if let Some(body) = self.expand(world, t, entry, below) {
                return Some(body);
            }
        }
    }

    /// Opens an entry that was pending at `t`. A body is returned; the children of anything else become pending.
    #[inline]
    fn expand(&mut self, world: &'w World, t: f64, entry: Entry, below: &mut Scratch) -> Option<BodyEntry> {
        if below.log.is_on() {
            below.log.enter(1 + self.above(entry.visit).count(), self.frame(entry.visit));
        }
        if entry.is_node {
            let LevelVisit { level, ray, .. } = &self.visits[entry.visit as usize];
            if let Some(accel) = &level.accel {
                below.log.add_with_outline(0, Some(t), || {
                    let node = accel.describe(entry.number, ray);
                    (Act::Expand { node }, accel.outline(entry.number, ray))
                });
                accel.expand(entry.number, t, ray, &mut self.children, &mut below.counters);
            }
            self.push_children(world, entry.visit, below);
        } else {
            let placement_entry = self.enter_placement(entry.visit, entry.number as u32, t);
            match placement_entry.target {
                Target::Body(number) => {
                    below.log.add(0, Some(t), || Act::EnterBody {
                        path: world.path_name(placement_entry.path),
                        leaves: world.body(number).leaf_count() as usize,
                    });
                    if below.log.is_on() {
                        let depth = 1 + self.above(entry.visit).count();
                        below
                            .log
                            .enter(depth, self.frame_of_placement(entry.visit, placement_entry.placement));
                    }
                    // The entry's use of the visit passes to the caller.
                    self.last_returned = Some(entry.visit);
                    return Some(placement_entry.into_body(number));
                }
                Target::Level(level) => {
                    let visit = self.new_visit(world.level(level), placement_entry);
                    self.enter(world, visit, t, below);
                }
            }
        }
        self.release(entry.visit);
        None
    }

    /// Releases the visits on the path to the body that was returned last.
    #[inline]
    fn release_given(&mut self) {
        if let Some(visit) = self.last_returned.take() {
            self.release(visit);
        }
    }

    /// Keeps the visits on the path to a body until [`Traversal::release_body`] or the end of the ray.
    pub(super) fn hold(&mut self, body: &BodyEntry) {
        self.visits[body.placed.visit as usize].uses += 1;
    }

    /// Undoes a [`Traversal::hold`].
    pub(super) fn release_body(&mut self, body: &BodyEntry) {
        self.release(body.placed.visit);
    }

    /// Removes one use of a visit, and frees the visit if none is left.
    #[inline]
    fn release(&mut self, visit: u32) {
        let uses = &mut self.visits[visit as usize].uses;
        *uses -= 1;
        if *uses == 0 {
            self.free_from(visit);
        }
    }

    /// Frees a visit that has no use, and the visits above it that only it used.
    fn free_from(&mut self, visit: u32) {
        self.free.push(visit);
        let mut below = visit;
        while let Some((above, _)) = self.visits[below as usize].above {
            let uses = &mut self.visits[above as usize].uses;
            *uses -= 1;
            if *uses > 0 {
                return;
            }
            self.free.push(above);
            below = above;
        }
    }

    /// The number of visits that memory is kept for.
    #[cfg(test)]
    pub(super) fn kept_visits(&self) -> usize {
        self.visits.capacity()
    }

    /// The number of tags that memory is kept for.
    #[cfg(test)]
    pub(super) fn kept_tags(&self) -> usize {
        self.tags.room()
    }

    /// Transforms the ray into the frame of a placement in a visited level.
    fn enter_placement(&self, visit: u32, placement: u32, enter: f64) -> PlacementEntry {
        let above = &self.visits[visit as usize];
        let placed = above.level.placement(placement);
        PlacementEntry {
            target: placed.target,
            line: above.line.in_frame(&placed.local_from_parent),
            object: placed.object.unwrap_or(above.object),
            path: above.first_path + placed.first_path,
            enter,
            visit,
            placement,
        }
    }

    /// Creates a visit of a level and returns its index.
    fn new_visit(&mut self, level: &'w Level, placement_entry: PlacementEntry) -> u32 {
        let PlacementEntry { line, object, path, visit, placement, .. } = placement_entry;
        let parent = &mut self.visits[visit as usize];
        parent.uses += 1;
        let ray = match level.lattice {
            None => box_ray(level, &line, parent.ray.span()),
            Some(_) => BoxRay::inside(&line, &parent.ray, &parent.level.bounds_of(placement)),
        };
        let above = Some((visit, placement));
        let serial = self.serial;
        self.serial = serial.wrapping_add(1);
        let new = LevelVisit {
            level,
            line,
            ray,
            above,
            object,
            first_path: path,
            serial,
            has_duplicate_refs: false,
            uses: 0,
        };
        match self.free.pop() {
            Some(free) => {
                self.visits[free as usize] = new;
                free
            }
            None => {
                self.visits.push(new);
                (self.visits.len() - 1) as u32
            }
        }
    }

    /// Transforms a normal from the frame of a body to world coordinates: `(T^-1)^T n` on every level of the path
    /// upwards.
    pub(super) fn world_normal(&self, placed: &PlacedBody, normal: Vec3) -> Vec3 {
        let mut at = Some((placed.visit, placed.placement));
        let mut n = normal;
        while let Some((visit, placement)) = at {
            let LevelVisit { level, above, .. } = &self.visits[visit as usize];
            n = level.placement(placement).local_from_parent.covector(n);
            at = *above;
        }
        n
    }

    /// The frame of a visited level, for the log: world from frame.
    fn frame(&self, visit: u32) -> Option<Affine> {
        let mut frame = Affine::IDENTITY;
        for (level, placement) in self.above(visit) {
            frame = frame.then_after(&level.placement(placement).local_from_parent);
        }
        frame.inverse().ok()
    }

    /// The frame of a placement in a visited level, for the log: world from frame.
    fn frame_of_placement(&self, visit: u32, placement: u32) -> Option<Affine> {
        let local_from_parent = self.visits[visit as usize].level.placement(placement).local_from_parent;
        Some(self.frame(visit)?.then_after(&local_from_parent.inverse().ok()?))
    }

    /// The placements through which a visit was reached, innermost first.
    fn above(&self, visit: u32) -> impl Iterator<Item = (&'w Level, u32)> {
        let step = |v: u32| self.visits[v as usize].above;
        let placed = |(v, number): (u32, u32)| (self.visits[v as usize].level, number);
        std::iter::successors(step(visit), move |(v, _)| step(*v)).map(placed)
    }

    /// Opens a visited level, whose box is entered at `t`.
    fn enter(&mut self, world: &World, visit: u32, t: f64, below: &mut Scratch) {
        if below.log.is_on() {
            let mut path: Vec<String> =
                self.above(visit).map(|(level, number)| world.placed_name(level, number)).collect();
            path.reverse();
            below.log.enter(path.len(), self.frame(visit));
            let placements = self.visits[visit as usize].level.placement_count() as usize;
            below.log.add(0, Some(t), || Act::EnterLevel { path: path.join("/"), placements });
        }
        let LevelVisit { level, ray, has_duplicate_refs, .. } = &mut self.visits[visit as usize];
        if let Some(accel) = &level.accel {
            *has_duplicate_refs = accel.has_duplicate_refs();
            accel.roots(ray, &mut self.children, &mut below.counters);
        }
        self.push_children(world, visit, below);
        if self.visits[visit as usize].uses == 0 {
            // Nothing in the level is pending.
            self.free_from(visit);
        }
    }

    fn push_children(&mut self, world: &World, visit: u32, below: &mut Scratch) {
        let LevelVisit { level, ray, serial, has_duplicate_refs, uses, .. } =
            &mut self.visits[visit as usize];
        let Scratch { counters, log, .. } = below;
        for child in self.children.drain(..) {
            let (t, number) = match child.child {
                Child::Node(node) => {
                    log.add_with_outline(1, Some(child.t), || pushed_node(level.accel.as_deref(), node, ray));
                    (child.t, node)
                }
                Child::Entered(item) => {
                    debug_assert_eq!(ray.enter_exit(&level.bounds_of(item)).map(|(t, _)| t), Some(child.t));
                    log.add_with_outline(1, Some(child.t), || {
                        let outline = Outline::Box(level.bounds_of(item));
                        (Act::PushItem { item: world.placed_name(level, item) }, Some(outline))
                    });
                    (child.t, u64::from(item))
                }
                Child::Item(item) => {
                    let name = || world.placed_name(level, item);
                    let outline = || Some(Outline::Box(level.bounds_of(item)));
                    if *has_duplicate_refs && !self.tags.is_first(*serial, item) {
                        counters.tags_saved += 1;
                        log.add(1, None, || Act::Saved { item: name() });
                        continue;
                    }
                    counters.boxes += 1;
                    let Some((t, _)) = ray.enter_exit(&level.bounds_of(item)) else {
                        log.add_with_outline(1, None, || (Act::Miss { item: name() }, outline()));
                        continue;
                    };
                    log.add_with_outline(1, Some(t), || (Act::PushItem { item: name() }, outline()));
                    (t, u64::from(item))
                }
            };
            counters.heap_pushes += 1;
            *uses += 1;
            let is_node = matches!(child.child, Child::Node(_));
            self.heap.push(t, Rank::Box, Entry { number, visit, is_node });
        }
    }
}

/// The step of making a node pending, for the log.
pub(super) fn pushed_node(
    accel: Option<&dyn Accelerator>,
    node: u64,
    ray: &BoxRay,
) -> (Act, Option<Outline>) {
    let description = accel.map(|accel| accel.describe(node, ray)).unwrap_or_default();
    (Act::PushNode { node: description }, accel.and_then(|accel| accel.outline(node, ray)))
}
