//! The walk through levels: which bodies a ray can meet, nearest box first.

use super::heap::{Heap, Rank};
use crate::aabb::BoxRay;
use crate::accel::{Child, QueueEntry};
use crate::compile::{Level, Placement, Target, World};
use crate::counters::Counters;
use crate::math::Vec3;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::tags::VisitTags;
use crate::trace::Act;

/// A level met by the ray: where, on the way from the root.
#[derive(Clone, Copy, Debug)]
struct LevelVisit<'w> {
    level: &'w Level,
    line: Line,
    ray: BoxRay,
    /// The visit of the level above and the placement in it; `None` for the root.
    above: Option<(u32, u32)>,
    object: u32,
    first_path: u64,
    /// Different for each visit of a ray: a level that is entered twice is met by two lines, so its placements are
    /// tagged for each visit.
    serial: u32,
    /// Whether its placements need tags.
    has_duplicate_refs: bool,
    /// Entries that are pending in it, visits below it, and whoever else needs it. At 0 its memory is used again.
    uses: u32,
}

/// What a visit has still to offer.
#[derive(Clone, Copy, Debug)]
struct Entry {
    visit: u32,
    what: Child,
}

/// A placed body that the ray may meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyEntry {
    pub body: u32,
    /// The ray's line in the frame of the body.
    pub line: Line,
    pub object: u32,
    pub path: u64,
    /// A lower bound of every `t` of the span at which the ray is in the body.
    pub enter: f64,
    visit: u32,
    placement: u32,
}

/// The ray in a placement, before what is placed is known to be a body or a level.
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
        BodyEntry { body, line, object, path, enter, visit, placement }
    }
}

/// The memory of a walk; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct Traversal<'w> {
    visits: Vec<LevelVisit<'w>>,
    /// Visits without a use.
    free: Vec<u32>,
    /// The serial number of the next visit.
    serial: u32,
    /// The visit of the body that was given last: the caller may still need it.
    given: Option<u32>,
    heap: Heap<Entry>,
    /// What is pending where the order does not matter.
    stack: Vec<(f64, Entry)>,
    children: Vec<QueueEntry>,
    tags: VisitTags,
}

/// The visit of the root: it is never freed.
const ROOT: u32 = 0;

impl<'w> Traversal<'w> {
    /// Begins a ray.
    pub(super) fn begin(&mut self, world: &'w World, line: Line, span: Span) {
        self.visits.clear();
        self.free.clear();
        self.given = None;
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

    /// Goes straight to a body by a way known beforehand; `None` where the ray misses a box on it, or where this
    /// world has no such way.
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
            let (enter, _) = ray.enter_exit(&level.placements.get(item as usize)?.bounds)?;
            let placement_entry = self.pass(visit, item, enter);
            match placement_entry.target {
                Target::Body(body) => {
                    self.visits[visit as usize].uses += 1;
                    self.given = Some(visit);
                    return Some(placement_entry.into_body(body));
                }
                Target::Level(level) => visit = self.descend(world.level(level), placement_entry),
            }
        }
        None
    }

    /// The way from the root to a body: the number of the placement in each level.
    pub(super) fn placements_on_path(&self, body_entry: &BodyEntry, placements_on_path: &mut Vec<u32>) {
        placements_on_path.clear();
        placements_on_path.push(body_entry.placement);
        let mut visit = &self.visits[body_entry.visit as usize];
        while let Some((above, placement)) = visit.above {
            placements_on_path.push(placement);
            visit = &self.visits[above as usize];
        }
        placements_on_path.reverse();
    }

    /// Opens the root; from now on there is a next body.
    pub(super) fn enter_root(&mut self, world: &World, below: &mut Scratch) {
        let t = self.visits[ROOT as usize].ray.span().t_min();
        self.enter(world, ROOT, t, below);
    }

    /// The next body whose box begins at or before `limit`, nearest first, and depth first where boxes begin at one `t`.
    /// `None` as well when the budget of the ray has ended.
    pub(super) fn next(&mut self, world: &'w World, limit: f64, below: &mut Scratch) -> Option<BodyEntry> {
        self.release_given();
        while let Some((t, entry)) = self.heap.pop() {
            if t > limit {
                below.log.depth = 0;
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

    /// The next body in whatever order: depth first, so that memory does not grow with what the ray meets. A walk is
    /// done either by this or by [`Traversal::next`]. `None` as well when the budget of the ray has ended.
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

    /// Opens an entry that was pending at `t`: a body is returned, anything else adds to what is pending.
    #[inline]
    fn expand(&mut self, world: &'w World, t: f64, entry: Entry, below: &mut Scratch) -> Option<BodyEntry> {
        if below.log.is_on() {
            below.log.depth = 1 + self.above(entry.visit).count();
        }
        match entry.what {
            Child::Node(node) => {
                let LevelVisit { level, ray, .. } = &self.visits[entry.visit as usize];
                if let Some(accel) = &level.accel {
                    below.log.add(0, Some(t), || Act::Expand { node: accel.describe(node, ray) });
                    accel.expand(node, t, ray, &mut self.children, &mut below.counters);
                }
                self.push_children(world, entry.visit, below);
            }
            Child::Item(item) | Child::Entered(item) => {
                let placement_entry = self.pass(entry.visit, item, t);
                match placement_entry.target {
                    Target::Body(number) => {
                        below.log.add(0, Some(t), || Act::EnterBody {
                            path: world.path_name(placement_entry.path),
                            leaves: world.body(number).leaf_count() as usize,
                        });
                        // Its use of the visit is the caller's now.
                        self.given = Some(entry.visit);
                        return Some(placement_entry.into_body(number));
                    }
                    Target::Level(level) => {
                        let visit = self.descend(world.level(level), placement_entry);
                        self.enter(world, visit, t, below);
                    }
                }
            }
        }
        self.release(entry.visit);
        None
    }

    /// Takes back the visits on the way to the body that was given last.
    #[inline]
    fn release_given(&mut self) {
        if let Some(visit) = self.given.take() {
            self.release(visit);
        }
    }

    /// Keeps the visits on the way to a body until [`Traversal::release_body`], or the end of the ray.
    pub(super) fn hold(&mut self, body: &BodyEntry) {
        self.visits[body.visit as usize].uses += 1;
    }

    /// Undoes a [`Traversal::hold`].
    pub(super) fn release_body(&mut self, body: &BodyEntry) {
        self.release(body.visit);
    }

    /// Takes away a use of a visit. What is not used any more is free.
    #[inline]
    fn release(&mut self, visit: u32) {
        let uses = &mut self.visits[visit as usize].uses;
        *uses -= 1;
        if *uses == 0 {
            self.free_from(visit);
        }
    }

    /// Frees a visit that has no use, and what is only used by it.
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

    /// Visits that memory is kept for.
    #[cfg(test)]
    pub(super) fn kept_visits(&self) -> usize {
        self.visits.capacity()
    }

    /// Tags that memory is kept for.
    #[cfg(test)]
    pub(super) fn kept_tags(&self) -> usize {
        self.tags.room()
    }

    /// Passes into a placement of a visited level.
    fn pass(&self, visit: u32, placement: u32, enter: f64) -> PlacementEntry {
        let above = &self.visits[visit as usize];
        let placed = &above.level.placements[placement as usize];
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

    /// Visits a level, and answers the number of the visit.
    fn descend(&mut self, level: &'w Level, placement_entry: PlacementEntry) -> u32 {
        let PlacementEntry { line, object, path, visit, placement, .. } = placement_entry;
        let parent = &mut self.visits[visit as usize];
        parent.uses += 1;
        let ray = BoxRay::new(&line, parent.ray.span());
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

    /// A normal in the frame of a body, in world terms: `(T^-1)^T n` on every level of the way up.
    pub(super) fn world_normal(&self, body_entry: &BodyEntry, normal: Vec3) -> Vec3 {
        let mut at = Some((body_entry.visit, body_entry.placement));
        let mut n = normal;
        while let Some((visit, placement)) = at {
            let LevelVisit { level, above, .. } = &self.visits[visit as usize];
            n = level.placements[placement as usize].local_from_parent.covector(n);
            at = *above;
        }
        n
    }

    /// The placements through which a visit was reached, innermost first.
    fn above(&self, visit: u32) -> impl Iterator<Item = &'w Placement> {
        let step = |v: u32| self.visits[v as usize].above;
        let placed = |(v, i): (u32, u32)| &self.visits[v as usize].level.placements[i as usize];
        std::iter::successors(step(visit), move |(v, _)| step(*v)).map(placed)
    }

    /// Opens a visited level, whose box is entered at `t`.
    fn enter(&mut self, world: &World, visit: u32, t: f64, below: &mut Scratch) {
        if below.log.is_on() {
            let mut path: Vec<String> = self.above(visit).map(|p| world.placed_name(p)).collect();
            path.reverse();
            below.log.depth = path.len();
            let placements = self.visits[visit as usize].level.placements.len();
            below.log.add(0, Some(t), || Act::EnterLevel { path: path.join("/"), placements });
        }
        let LevelVisit { level, ray, has_duplicate_refs, .. } = &mut self.visits[visit as usize];
        if let Some(accel) = &level.accel {
            *has_duplicate_refs = accel.has_duplicate_refs();
            accel.roots(ray, &mut self.children, &mut below.counters);
        }
        self.push_children(world, visit, below);
        if self.visits[visit as usize].uses == 0 {
            // It offers nothing.
            self.free_from(visit);
        }
    }

    fn push_children(&mut self, world: &World, visit: u32, below: &mut Scratch) {
        let LevelVisit { level, ray, serial, has_duplicate_refs, uses, .. } =
            &mut self.visits[visit as usize];
        let Scratch { counters, log, .. } = below;
        for child in self.children.drain(..) {
            let t = match child.child {
                Child::Node(node) => {
                    let describe = || level.accel.as_ref().map(|accel| accel.describe(node, ray));
                    log.add(1, Some(child.t), || Act::PushNode { node: describe().unwrap_or_default() });
                    child.t
                }
                Child::Entered(item) => {
                    let placed = &level.placements[item as usize];
                    debug_assert_eq!(ray.enter_exit(&placed.bounds).map(|(t, _)| t), Some(child.t));
                    log.add(1, Some(child.t), || Act::PushItem { item: world.placed_name(placed) });
                    child.t
                }
                Child::Item(item) => {
                    let placed = &level.placements[item as usize];
                    let name = || world.placed_name(placed);
                    if *has_duplicate_refs && !self.tags.is_first(*serial, item) {
                        counters.tags_saved += 1;
                        log.add(1, None, || Act::Saved { item: name() });
                        continue;
                    }
                    counters.boxes += 1;
                    let Some((t, _)) = ray.enter_exit(&placed.bounds) else {
                        log.add(1, None, || Act::Miss { item: name() });
                        continue;
                    };
                    log.add(1, Some(t), || Act::PushItem { item: name() });
                    t
                }
            };
            counters.heap_pushes += 1;
            *uses += 1;
            self.heap.push(t, Rank::Box, Entry { visit, what: child.child });
        }
    }
}
