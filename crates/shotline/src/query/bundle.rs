//! The traversal of levels by a bundle of rays: some rays that run close together, or one ray.
//!
//! It is depth first, nearer boxes first. Bodies are offered to each ray in about the order in which the ray enters their
//! boxes; what is found does not depend on that order. While rays are cast at what they were offered, the traversal
//! waits, so that it skips what is behind their hits. It also waits at a body without meshes that several rays meet, and
//! those are cast at it together.

use super::level_paths::LevelPaths;
use super::level_visit::{LevelVisit, ManyRays, OneRay, ones};
use super::offers::{Offer, Offers};
use super::traversal::{BodyEntry, PlacedBody};
use crate::accel::{BEAM_RAYS, BeamEntry, ByRay, Child, MetRays, QueueEntry};
use crate::compile::{Level, Placement, Target, World};
use crate::math::{Affine, Vec3};
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::tags::VisitTags;

/// With more paths to levels than this the rays of a bundle take the plain path, which forgets paths that it has left.
const MAX_PATHS: usize = if cfg!(test) { 50 } else { 1 << 14 };

/// Fewer rays than this are cast at a body one by one.
const FEWEST_IN_LANES: u32 = 2;

/// A pending entry of a visit.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// No ray of the visit enters it before.
    t: f64,
    number: u64,
    visit: u32,
    /// The rays of the visit that may meet it.
    places: u32,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A node of the accelerator.
    Node,
    /// A placement that rays of a beam may meet.
    Item,
    /// A placement whose box the only ray of the visit enters at `t`.
    Entered,
}

/// Why a traversal waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pause {
    /// A ray has as many offers as it can have.
    Offered,
    /// Rays have met a body at which they are cast together.
    Met,
    /// There is nothing else.
    Done,
    /// It takes too many steps or too much memory, or has been cancelled.
    Refused,
}

/// A body whose box some rays of a visit meet.
#[derive(Clone, Debug)]
pub(super) struct Meeting {
    pub visit: u32,
    pub placement: u32,
    pub rays: MetRays,
}

/// What an advance needs beside the bundle.
pub(super) struct Advance<'a, 'w> {
    pub world: &'w World,
    pub span: Span,
    /// How far each ray looks; -infinity for those that have ended.
    pub limits: &'a ByRay,
    /// The largest of the limits.
    pub limit: f64,
    /// The offers of each ray, all empty.
    pub offers: &'a mut [Offers],
    pub scratch: &'a mut Scratch<'w>,
}

/// The traversal of a bundle.
#[derive(Debug, Default)]
pub(super) struct Bundle<'w> {
    visits: Vec<LevelVisit<'w>>,
    /// The ray of each visit of only one ray; means nothing for other visits.
    ones: Vec<OneRay>,
    /// Visits that are not in use.
    free: Vec<u32>,
    stack: Vec<Entry>,
    tags: VisitTags,
    serial: u32,
    /// Steps taken so far.
    pub steps: u64,
    pub paths: LevelPaths<'w>,
    /// What was met last, after [`Pause::Met`]. Its visit is in use until it is released.
    pub meeting: Option<Meeting>,
}

/// The limits of rays that look up to the end of their span.
const NO_LIMITS: ByRay = [[f64::INFINITY; 8]; BEAM_RAYS / 8];

/// Memory that bundles share.
#[derive(Debug, Default)]
pub(super) struct BundleMemory {
    /// The children of one entry, for one ray and for several.
    children: Vec<QueueEntry>,
    beam_children: Vec<BeamEntry>,
    /// Rays that are not in use.
    spare: Vec<Box<ManyRays>>,
}

impl BundleMemory {
    fn rays(&mut self) -> Box<ManyRays> {
        self.spare.pop().unwrap_or_default()
    }

    fn keep(&mut self, rays: Option<Box<ManyRays>>) {
        self.spare.extend(rays);
    }
}

impl<'w> Bundle<'w> {
    /// Begins with some rays, which may run apart: then they are loose.
    pub fn begin(
        &mut self,
        world: &'w World,
        (rows, is_loose): (&[[f64; 6]], bool),
        span: Span,
        memory: &mut BundleMemory,
        scratch: &mut Scratch,
    ) {
        self.visits.iter_mut().for_each(|visit| memory.keep(visit.many.take()));
        self.visits.clear();
        self.free.clear();
        self.stack.clear();
        self.tags.begin();
        (self.serial, self.steps) = (0, 0);
        self.paths.begin(world.root());
        let many = (rows.len() > 1).then(|| {
            let mut rays = memory.rays();
            rays.set_exact(rows, is_loose, span);
            rays
        });
        let root = self.new_visit(LevelVisit::new(world.root(), many), memory);
        if let [[ox, oy, oz, dx, dy, dz]] = *rows {
            let line = Line::exact(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
            self.set_one(root, OneRay::new(0, line, span));
        }
        self.enter(root, (f64::INFINITY, &NO_LIMITS), memory, scratch);
    }

    /// Offers bodies to rays.
    pub fn advance(
        &mut self,
        most_steps: u64,
        memory: &mut BundleMemory,
        advance: &mut Advance<'_, 'w>,
    ) -> Pause {
        advance.scratch.budget.begin(most_steps.saturating_sub(self.steps));
        let pause = self.next_offers(memory, advance);
        self.steps += advance.scratch.budget.used();
        pause
    }

    fn next_offers(&mut self, memory: &mut BundleMemory, advance: &mut Advance<'_, 'w>) -> Pause {
        while let Some(entry) = self.stack.pop() {
            if entry.t > advance.limit {
                self.release(entry.visit);
                continue;
            }
            if !advance.scratch.budget.step() || self.paths.len() > MAX_PATHS {
                return Pause::Refused;
            }
            let pause = match entry.kind {
                Kind::Node => {
                    self.expand(&entry, memory, advance);
                    None
                }
                Kind::Item | Kind::Entered => self.open(&entry, memory, advance),
            };
            self.release(entry.visit);
            if let Some(pause) = pause {
                return pause;
            }
        }
        Pause::Done
    }

    /// Whether nothing is pending.
    pub fn is_done(&self) -> bool {
        self.stack.is_empty()
    }

    /// Queues the children of a node.
    fn expand(&mut self, entry: &Entry, memory: &mut BundleMemory, advance: &mut Advance<'_, 'w>) {
        let LevelVisit { level, many, .. } = &self.visits[entry.visit as usize];
        let Some(accel) = &level.accel else { return };
        match many {
            None => {
                let (one, counters) = (&self.ones[entry.visit as usize], &mut advance.scratch.counters);
                accel.expand(entry.number, entry.t, &one.boxes, &mut memory.children, counters);
            }
            Some(rays) => {
                let some = rays.some(entry.places, advance.limits);
                accel.expand_beam(entry.number, &some, &mut memory.beam_children);
            }
        }
        self.push_children(entry.visit, advance.limit, memory);
    }

    /// Opens a placement for the rays that meet its box. Returns why the traversal waits, if it does.
    fn open(
        &mut self,
        entry: &Entry,
        memory: &mut BundleMemory,
        advance: &mut Advance<'_, 'w>,
    ) -> Option<Pause> {
        let LevelVisit { level, many, .. } = &self.visits[entry.visit as usize];
        let placement = entry.number as u32;
        let placed = &*level.placement(placement);
        let mut is_full = false;
        let mut count = 0;
        let mut offer = |place: usize, enter: f64| {
            let offers = &mut advance.offers[place];
            offers.add(Offer { enter, visit: entry.visit, placement });
            is_full |= offers.is_full();
            count += 1;
        };
        let met = match many {
            None => {
                let one = &self.ones[entry.visit as usize];
                let is_met = entry.t <= advance.limits[one.place / 8][one.place % 8];
                if is_met && let Target::Body(_) = placed.target {
                    offer(one.place, entry.t);
                }
                u32::from(is_met) << one.place
            }
            Some(rays) => {
                let met = rays.boxes.enter(&placed.bounds, advance.limits);
                let places = met.rays & entry.places;
                if let Target::Body(body) = placed.target
                    && places.count_ones() >= FEWEST_IN_LANES
                    && advance.world.body(body).takes_bundles()
                {
                    let rays = MetRays { rays: places, ..met };
                    self.meeting = Some(Meeting { visit: entry.visit, placement, rays });
                    self.visits[entry.visit as usize].uses += 1;
                    return Some(Pause::Met);
                }
                if let Target::Body(_) = placed.target {
                    ones(places).for_each(|place| offer(place, met.enter[place / 8][place % 8]));
                }
                places
            }
        };
        self.visits[entry.visit as usize].uses += count;
        if let Target::Level(level) = placed.target
            && met != 0
        {
            let level = advance.world.level(level);
            self.enter_level(level, entry, placed, met, memory, advance);
        }
        is_full.then_some(Pause::Offered)
    }

    /// Enters a level with the rays of a mask: with each of them alone if its accelerator takes no beams.
    fn enter_level(
        &mut self,
        level: &'w Level,
        entry: &Entry,
        placed: &Placement,
        mut rays: u32,
        memory: &mut BundleMemory,
        advance: &mut Advance<'_, 'w>,
    ) {
        let span = advance.span;
        let above = &self.visits[entry.visit as usize];
        let path = self.paths.add(level, above.path, entry.number as u32);
        let takes_beams = level.accel.as_ref().is_none_or(|accel| accel.takes_beams());
        while rays != 0 {
            let some = if takes_beams { rays } else { rays & rays.wrapping_neg() };
            rays &= !some;
            let above = &self.visits[entry.visit as usize];
            let (frame, mut one, mut many) = (&placed.local_from_parent, None, None);
            match &above.many {
                Some(rays_above) if some.count_ones() > 1 => {
                    let mut rays = memory.rays();
                    rays.set_below(rays_above, some, frame, level.box_frame.as_deref(), span);
                    many = Some(rays);
                }
                _ => {
                    let first = some.trailing_zeros() as usize;
                    let line_above = self.line(entry.visit, first);
                    one = Some(OneRay::below(first, (above.level, &line_above), placed, level, span));
                }
            }
            let visit = LevelVisit {
                path,
                object: placed.object.unwrap_or(above.object),
                first_path: above.first_path + placed.first_path,
                ..LevelVisit::new(level, many)
            };
            let number = self.new_visit(visit, memory);
            if let Some(one) = one {
                self.set_one(number, one);
            }
            self.enter(number, (advance.limit, advance.limits), memory, advance.scratch);
        }
    }

    /// Makes a visit, with memory that is not in use.
    fn new_visit(&mut self, visit: LevelVisit<'w>, memory: &mut BundleMemory) -> u32 {
        match self.free.pop() {
            Some(free) => {
                memory.keep(self.visits[free as usize].many.take());
                self.visits[free as usize] = visit;
                free
            }
            None => {
                self.visits.push(visit);
                (self.visits.len() - 1) as u32
            }
        }
    }

    /// Sets the only ray of a visit.
    fn set_one(&mut self, visit: u32, one: OneRay) {
        match self.ones.get_mut(visit as usize) {
            Some(ray) => *ray = one,
            None => self.ones.resize(visit as usize + 1, one),
        }
    }

    /// Queues the first entries of a visit.
    fn enter(
        &mut self,
        number: u32,
        (limit, limits): (f64, &ByRay),
        memory: &mut BundleMemory,
        scratch: &mut Scratch,
    ) {
        self.serial = self.serial.wrapping_add(1);
        let visit = &mut self.visits[number as usize];
        (visit.serial, visit.uses) = (self.serial, 1);
        if let Some(accel) = &visit.level.accel {
            match &visit.many {
                None => {
                    let boxes = &self.ones[number as usize].boxes;
                    accel.roots(boxes, &mut memory.children, &mut scratch.counters);
                }
                Some(rays) => accel.beam_roots(&rays.some(rays.places, limits), &mut memory.beam_children),
            }
            visit.has_duplicate_refs = accel.has_duplicate_refs();
        }
        self.push_children(number, limit, memory);
        self.release(number);
    }

    /// The line of the ray at a place, in the frame of a visit.
    fn line(&self, visit: u32, place: usize) -> Line {
        match &self.visits[visit as usize].many {
            Some(rays) => rays.line(place),
            None => self.ones[visit as usize].line,
        }
    }

    /// Queues what an accelerator has proposed, the nearest on top.
    fn push_children(&mut self, number: u32, limit: f64, memory: &mut BundleMemory) {
        let start = self.stack.len();
        let LevelVisit { level, uses, serial, has_duplicate_refs, .. } = &mut self.visits[number as usize];
        let BundleMemory { children, beam_children, .. } = memory;
        let mut push = |t: f64, number_of: u64, places: u32, kind: Kind| {
            if t <= limit {
                *uses += 1;
                self.stack.push(Entry { t, number: number_of, visit: number, places, kind });
            }
        };
        for BeamEntry { t, child, places } in beam_children.drain(..) {
            match child {
                Child::Node(node) => push(t, node, places, Kind::Node),
                Child::Entered(item) | Child::Item(item) => push(t, u64::from(item), places, Kind::Item),
            }
        }
        for child in children.drain(..) {
            match child.child {
                Child::Node(node) => push(child.t, node, 0, Kind::Node),
                Child::Entered(item) => push(child.t, u64::from(item), 0, Kind::Entered),
                Child::Item(item) => {
                    if *has_duplicate_refs && !self.tags.is_first(*serial, item) {
                        continue;
                    }
                    if let Some((t, _)) = self.ones[number as usize].boxes.enter_exit(&level.bounds_of(item))
                    {
                        push(t, u64::from(item), 0, Kind::Entered);
                    }
                }
            }
        }
        nearest_last(&mut self.stack[start..]);
    }

    /// The body of an offer to the ray at a place.
    pub fn body(&mut self, offer: &Offer, place: usize) -> BodyEntry {
        let body_entry = self.body_entry(offer, place);
        self.release(offer.visit);
        body_entry
    }

    /// The rays of a visit, if it has several.
    pub fn rays(&self, visit: u32) -> Option<&ManyRays> {
        self.visits[visit as usize].many.as_deref()
    }

    /// Whether the boxes of the level of a visit are in the frame of the level.
    pub fn has_own_boxes(&self, visit: u32) -> bool {
        self.visits[visit as usize].level.box_frame.is_none()
    }

    /// The transform into a placement in the level of a visit with several rays. Rays go through lattices one by one.
    pub fn frame(&self, visit: u32, placement: u32) -> &'w Affine {
        &self.visits[visit as usize].level.placements[placement as usize].local_from_parent
    }

    /// A body that is placed in the level of a visit.
    pub fn placed_body(&self, visit: u32, placement: u32) -> PlacedBody {
        let visit = &self.visits[visit as usize];
        let placed = visit.level.placement(placement);
        let Target::Body(body) = placed.target else { unreachable!("levels are not offered") };
        PlacedBody {
            body,
            object: placed.object.unwrap_or(visit.object),
            path: visit.first_path + placed.first_path,
            visit: visit.path,
            placement,
        }
    }

    /// The body of an offer to the ray at a place, which stays in use.
    pub fn body_entry(&self, offer: &Offer, place: usize) -> BodyEntry {
        let level = self.visits[offer.visit as usize].level;
        let local_from_parent = level.frame_of(offer.placement);
        BodyEntry {
            placed: self.placed_body(offer.visit, offer.placement),
            line: self.line(offer.visit, place).in_frame(&local_from_parent),
            enter: offer.enter,
        }
    }

    /// Removes one use of a visit, and frees the visit if none is left.
    pub fn release(&mut self, visit: u32) {
        let uses = &mut self.visits[visit as usize].uses;
        *uses -= 1;
        if *uses == 0 {
            self.free.push(visit);
        }
    }
}

/// Sorts entries by descending `t`.
fn nearest_last(entries: &mut [Entry]) {
    // A node has at most eight children. Other structures may have many.
    if entries.len() > 20 {
        return entries.sort_unstable_by(|a, b| b.t.total_cmp(&a.t));
    }
    for end in 1..entries.len() {
        let (entry, mut index) = (entries[end], end);
        while index > 0 && entries[index - 1].t < entry.t {
            entries[index] = entries[index - 1];
            index -= 1;
        }
        entries[index] = entry;
    }
}
