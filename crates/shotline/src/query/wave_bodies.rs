//! Casts rays of waves at a body of many leaves.
//!
//! Each ray searches the accelerator of the body alone: nearest box first, as the stream of a single ray does, unless it
//! needs all boundaries. Where rays have met leaves they wait for each other: leaves of one kind are intersected in lanes,
//! each by its own ray in its own frame. Each ray has a list of events, which is swept as they become certain.

use arrayvec::ArrayVec;

use super::Scope;
use super::lane_cast::{LaneFind, LaneFinds};
use super::lane_events::{EndEvents, representative};
use super::lane_normals::{Frames, Leaves, Normals};
use super::level_visit::ones;
use super::pending_boxes::PendingBoxes;
use super::wave::{Pair, WaveRay, level_frames};
use crate::aabb::BoxRay;
use crate::accel::{Child, QueueEntry};
use crate::compile::{Leaf, SolidBody};
use crate::counters::Counters;
use crate::crossing::Crossing;
use crate::csg::{
    Boundary, HitKind, ListSweep, ListedBoundary, ListedCrossings, ListedEvent, Program, Tally,
};
use crate::lanes::vector::gather;
use crate::lanes::{IntervalLanes, LineLanes};
use crate::math::Vec3;
use crate::ray::Line;
use crate::simd::{Doubles, Simd, Task, dispatch};
use crate::solid::Wanted;
use crate::solid::lanes::InLanes;

/// A ray with more events than this takes the plain path.
const MAX_EVENTS: usize = if cfg!(test) { 200 } else { 1 << 12 };

/// A ray with more pending boxes than this takes the plain path, which has a heap of them.
const MAX_PENDING: usize = 1 << 8;

/// What rays of a wave request of a body.
#[derive(Clone, Copy)]
pub(super) struct BodyRequest<'a, 'w> {
    pub body: &'w SolidBody,
    pub pairs: &'a [Pair<'w>],
    pub rays: &'a [WaveRay<'w>],
    pub scope: Scope,
    pub wanted: Wanted,
    pub wants_normals: bool,
}

/// The memory of searches; reused from body to body.
#[derive(Debug, Default)]
pub(super) struct BodyWave {
    searches: Vec<Search>,
    children: Vec<QueueEntry>,
    waiting: Vec<Waiting>,
    normals: Vec<OpenNormal>,
}

/// A ray that waits for its crossings with a leaf.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    search: u32,
    leaf: u32,
    /// Leaves with the same number can be intersected together.
    group: u32,
    /// Where the ray enters the box of the leaf.
    enter: f64,
}

/// A boundary whose normal is still open: its number among what was found, its search, its leaf and the number of that.
#[derive(Clone, Copy, Debug)]
struct OpenNormal {
    find: usize,
    search: u32,
    leaf: u32,
    group: u32,
}

/// The search of one ray.
#[derive(Debug)]
struct Search {
    line: Line,
    boxes: BoxRay,
    pending: PendingBoxes,
    /// The crossings with leaves, by the numbers of their events.
    crossings: Vec<(u32, Crossing)>,
    events: Vec<ListedEvent>,
    sweep: ListSweep,
    tally: Tally,
    boundaries: Vec<ListedBoundary>,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Searching,
    Done,
    /// The ray is left open.
    Open,
}

/// The crossings of a ray, for the sweep.
struct Swept<'a> {
    crossings: &'a [(u32, Crossing)],
    program: &'a Program,
    tally: &'a mut Tally,
}

impl ListedCrossings for Swept<'_> {
    #[inline]
    fn toggle(&mut self, event: &ListedEvent) -> bool {
        self.tally.add(event.step);
        self.tally.value()
    }

    #[inline]
    fn t(&self, number: u32) -> f64 {
        self.crossings[number as usize].1.t
    }

    fn representative(&self, group: &[ListedEvent], entering: bool) -> Option<u32> {
        representative(group, self.program, entering, |number| self.crossings[number as usize])
    }
}

impl Search {
    fn new(line: &Line, boxes: BoxRay, tally: Tally) -> Search {
        Search {
            line: *line,
            boxes,
            pending: PendingBoxes::default(),
            crossings: Vec::new(),
            events: Vec::new(),
            sweep: ListSweep::new(boxes.span(), tally.value()),
            tally,
            boundaries: Vec::new(),
            state: State::Searching,
        }
    }

    /// Begins with another ray.
    fn begin(&mut self, line: &Line, boxes: BoxRay, tally: Tally) {
        (self.line, self.boxes, self.tally, self.state) = (*line, boxes, tally, State::Searching);
        self.sweep = ListSweep::new(boxes.span(), tally.value());
        self.pending.clear();
        self.crossings.clear();
        self.events.clear();
        self.boundaries.clear();
    }

    /// Adds the children of a node to the pending boxes. For all boundaries they are sorted, the nearest last: then most events
    /// come in the order of the list.
    fn push(&mut self, children: &mut Vec<QueueEntry>, wanted: Wanted) {
        if wanted == Wanted::All {
            children.sort_unstable_by(|a, b| b.t.total_cmp(&a.t));
        }
        for QueueEntry { t, child } in children.drain(..) {
            self.pending.push(t, child);
        }
    }

    /// Sweeps the events before `up_to`, or all that are left. Returns whether the search has ended.
    fn sweep(&mut self, up_to: Option<f64>, request: &BodyRequest) -> bool {
        let Search { crossings, events, sweep, tally, boundaries, .. } = self;
        let mut swept = Swept { crossings, program: &request.body.program, tally };
        let is_usual = match up_to {
            Some(up_to) => sweep.advance(events, up_to, &mut swept, boundaries),
            None => sweep.finish(events, &mut swept, boundaries),
        };
        if !is_usual || events.len() > MAX_EVENTS || self.pending.len() > MAX_PENDING {
            self.state = State::Open;
        } else if request.wanted == Wanted::First {
            self.boundaries.retain(|boundary| request.scope.kinds.hold(boundary.kind));
            if !self.boundaries.is_empty() {
                self.boundaries.truncate(1);
                self.state = State::Done;
            }
        }
        if up_to.is_none() && self.state == State::Searching {
            self.state = State::Done;
        }
        self.state != State::Searching
    }

    /// Goes on to the next leaf whose box the ray enters. Returns it with where it is entered; `None` if the search has
    /// ended.
    fn advance(&mut self, request: &BodyRequest, children: &mut Vec<QueueEntry>) -> Option<(u32, f64)> {
        let (body, t_max) = (request.body, request.scope.span.t_max());
        let accel = body.accel.as_ref()?;
        let wants_all = request.wanted == Wanted::All;
        loop {
            // For all boundaries every leaf is needed, so the search goes depth first.
            let next = if wants_all { self.pending.pop_last() } else { self.pending.pop_nearest() };
            let Some((t, child)) = next.filter(|(t, _)| wants_all || *t <= t_max) else {
                self.sweep(None, request);
                return None;
            };
            let is_due = !self.events.is_empty() || self.pending.len() > MAX_PENDING;
            if !wants_all && is_due && self.sweep(Some(t), request) {
                return None;
            }
            match child {
                Child::Node(node) => {
                    accel.expand(node, t, &self.boxes, children, &mut Counters::default());
                    self.push(children, request.wanted);
                }
                Child::Entered(leaf) => return Some((leaf, t)),
                Child::Item(leaf) => {
                    if let Some((enter, _)) = self.boxes.enter_exit(&body.leaves[leaf as usize].bounds) {
                        return Some((leaf, enter));
                    }
                }
            }
        }
    }
}

impl BodyWave {
    /// Finds the boundaries of the rays of pairs, and those that are left open. After a cancellation they mean nothing.
    pub fn run(&mut self, request: &BodyRequest, finds: &mut LaneFinds, is_cancelled: impl Fn() -> bool) {
        finds.clear();
        let mut active = u32::MAX >> (32 - request.pairs.len());
        let Some(tally) = request.body.program.tally() else {
            finds.open = active;
            return;
        };
        self.begin(request, tally);
        while !is_cancelled() {
            self.waiting.clear();
            for number in ones(active) {
                let search = &mut self.searches[number];
                let next = match search.state {
                    State::Searching => search.advance(request, &mut self.children),
                    State::Done | State::Open => None,
                };
                let Some((leaf, enter)) = next else {
                    active &= !(1 << number);
                    continue;
                };
                let group = group_of(request.body, leaf);
                self.waiting.push(Waiting { search: number as u32, leaf, group, enter });
            }
            if self.waiting.is_empty() {
                break;
            }
            self.waiting.sort_unstable_by_key(|waiting| (waiting.group, waiting.leaf));
            dispatch(LeafCasts { wave: self, body: request.body });
        }
        self.gather(request, finds);
    }

    /// Begins the searches.
    fn begin(&mut self, request: &BodyRequest, tally: Tally) {
        let span = request.scope.span;
        for (number, pair) in request.pairs.iter().enumerate() {
            let ray = &request.rays[pair.ray];
            let frame = &pair.met.placement.local_from_parent;
            let line = ray.line().in_frame(frame);
            let of_level = ray.boxes().filter(|_| frame.is_identity());
            let boxes = of_level.copied().unwrap_or_else(|| BoxRay::new(&line, span));
            match self.searches.get_mut(number) {
                Some(search) => search.begin(&line, boxes, tally),
                None => self.searches.push(Search::new(&line, boxes, tally)),
            }
            let search = &mut self.searches[number];
            if let Some(accel) = &request.body.accel {
                accel.roots(&search.boxes, &mut self.children, &mut Counters::default());
            }
            search.push(&mut self.children, request.wanted);
        }
    }

    /// Gathers what has been found, the boundaries of a ray one after the other.
    fn gather(&mut self, request: &BodyRequest, finds: &mut LaneFinds) {
        let span = request.scope.span;
        self.normals.clear();
        for (place, search) in (0..).zip(&self.searches[..request.pairs.len()]) {
            if search.state == State::Open {
                finds.open |= 1 << place;
                continue;
            }
            for &ListedBoundary { kind, entering, number } in &search.boundaries {
                let boundary = match kind {
                    HitKind::Surface => {
                        let (leaf, crossing) = search.crossings[number as usize];
                        if request.wants_normals {
                            let (find, group) = (finds.all.len(), group_of(request.body, leaf));
                            self.normals.push(OpenNormal { find, search: place, leaf, group });
                        }
                        Boundary { kind, entering, leaf, crossing }
                    }
                    HitKind::Start => Boundary::of_span_end(kind, span.t_min()),
                    HitKind::End => Boundary::of_span_end(kind, span.t_max()),
                };
                finds.all.push(LaneFind { place, boundary, normal: Vec3::NAN });
            }
        }
        if !self.normals.is_empty() {
            self.normals.sort_unstable_by_key(|open| open.group);
            dispatch(NormalCasts { wave: self, request, finds: &mut finds.all });
        }
    }
}

/// The number of a leaf: leaves with the same can be intersected together.
fn group_of(body: &SolidBody, leaf: u32) -> u32 {
    in_lanes(body, leaf).group()
}

fn in_lanes(body: &SolidBody, leaf: u32) -> InLanes<'_> {
    let Leaf { solid, .. } = &body.leaves[leaf as usize];
    solid.in_lanes().expect("waves are cast at bodies all of whose leaves take lanes")
}

/// Intersects the leaves for which rays wait.
struct LeafCasts<'a> {
    wave: &'a mut BodyWave,
    body: &'a SolidBody,
}

impl Task for LeafCasts<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let LeafCasts { wave: BodyWave { searches, waiting, .. }, body } = self;
        for group in waiting.chunk_by(|a, b| a.group == b.group) {
            for some in group.chunks(S::Wide::LANES) {
                cast_some::<S::Wide>(searches, some, body);
            }
        }
    }
}

/// Intersects leaves of one group, as many as there are lanes.
#[inline(always)]
fn cast_some<F: Doubles>(searches: &mut [Search], some: &[Waiting], body: &SolidBody) {
    let first = &body.leaves[some[0].leaf as usize];
    let solid = in_lanes(body, some[0].leaf);
    let (mut lines, mut frames) = ([&searches[some[0].search as usize].line; 8], [&first.local_from_body; 8]);
    let (mut solids, mut is_one) = ([solid; 8], true);
    for (lane, waiting) in some.iter().enumerate() {
        lines[lane] = &searches[waiting.search as usize].line;
        if waiting.leaf != some[0].leaf {
            frames[lane] = &body.leaves[waiting.leaf as usize].local_from_body;
            solids[lane] = in_lanes(body, waiting.leaf);
            is_one = false;
        }
    }
    let used = u8::MAX >> (8 - some.len());
    let line = LineLanes::<F>::each(&lines);
    let inside = if is_one {
        solid.inside(&line.in_frame(&first.local_from_body), used)
    } else {
        InLanes::inside_each(&solids, &line.in_frames(&frames), used)
    };
    let enter = gather(|lane| some.get(lane).unwrap_or(&some[0]).enter);
    for interval in &inside.intervals {
        add(searches, some, &body.program, (interval, enter), interval.lanes & used & !inside.open);
    }
    for lane in ones(u32::from(inside.open & used)) {
        searches[some[lane].search as usize].state = State::Open;
    }
}

/// Adds the ends of the interval of some lanes to the lists of their rays.
#[inline(always)]
fn add<F: Doubles>(
    searches: &mut [Search],
    some: &[Waiting],
    program: &Program,
    (interval, enter): (&IntervalLanes<F>, F),
    of: u8,
) {
    if of == 0 {
        return;
    }
    let ends = [&interval.enter, &interval.exit];
    let events = [EndEvents::new(ends[0], enter, of), EndEvents::new(ends[1], enter, of)];
    let mut numbers = [[[0.0; 8]; 3]; 2];
    for (to, end) in numbers.iter_mut().zip(ends) {
        end.t.store_some(&mut to[0], 0);
        end.t_err.store_some(&mut to[1], 0);
        end.surface.store_some(&mut to[2], 0);
    }
    for lane in ones(u32::from(of)) {
        let Waiting { search, leaf, .. } = some[lane];
        let (search, step) = (&mut searches[search as usize], program.step(leaf));
        for ((events, numbers), entering) in events.iter().zip(&numbers).zip([true, false]) {
            if (events.events | events.before) >> lane & 1 == 1 {
                let number = search.crossings.len() as u32;
                let surface = numbers[2][lane] as u32;
                let crossing = Crossing::new(numbers[0][lane], numbers[1][lane], entering, surface);
                search.crossings.push((leaf, crossing));
                let step = if entering { step } else { -step };
                events.listed(lane, number, step).insert_into(&mut search.events);
            }
        }
    }
    // An exit before the box with an entry that may be in it: the sweep toggles them in that order.
    for lane in ones(u32::from(events[0].events & events[1].before)) {
        searches[some[lane].search as usize].state = State::Open;
    }
}

/// Computes the normals that are open.
struct NormalCasts<'a, 'w> {
    wave: &'a BodyWave,
    request: &'a BodyRequest<'a, 'w>,
    finds: &'a mut [LaneFind],
}

impl Task for NormalCasts<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        for group in self.wave.normals.chunk_by(|a, b| a.group == b.group) {
            for some in group.chunks(S::Wide::LANES) {
                self.set_some::<S::Wide>(some);
            }
        }
    }
}

impl NormalCasts<'_, '_> {
    /// Computes normals at leaves of one group, as many as there are lanes.
    #[inline(always)]
    fn set_some<F: Doubles>(&mut self, some: &[OpenNormal]) {
        let &BodyRequest { body, pairs, rays, .. } = self.request;
        let mut of_rays: ArrayVec<&Pair, 8> = ArrayVec::new_const();
        let mut lines = [&self.wave.searches[some[0].search as usize].line; 8];
        let mut frames = [&body.leaves[some[0].leaf as usize].local_from_body; 8];
        let (mut solids, mut subtracted) = ([in_lanes(body, some[0].leaf); 8], 0);
        for (lane, open) in some.iter().enumerate() {
            of_rays.push(&pairs[open.search as usize]);
            lines[lane] = &self.wave.searches[open.search as usize].line;
            frames[lane] = &body.leaves[open.leaf as usize].local_from_body;
            solids[lane] = in_lanes(body, open.leaf);
            subtracted |= u8::from(body.program.is_subtracted(open.leaf)) << lane;
        }
        let crossing = |lane: usize| self.finds[some.get(lane).unwrap_or(&some[0]).find].boundary.crossing;
        let (t, surface) =
            (gather::<F>(|lane| crossing(lane).t), gather(|lane| f64::from(crossing(lane).surface)));
        let normals = Normals {
            leaves: Leaves::Each { solids: &solids, frames, subtracted },
            line: &LineLanes::each(&lines),
            frames: Frames::Each(&level_frames(rays, &of_rays)),
        };
        let normals = normals.at(some[0].leaf, t, surface, u8::MAX >> (8 - some.len()));
        for (lane, open) in some.iter().enumerate() {
            self.finds[open.find].normal = Vec3::from(normals.map(|axis| axis[lane]));
        }
    }
}
