//! The first boundary of a body of many leaves along each ray of a bundle.
//!
//! All rays share one heap of pending boxes, nearest first, and their crossings with a leaf are computed together. Each ray
//! has a sweep of its own, which gets its events as they become certain: as in the stream of a single ray, no event of it
//! can come before the nearest pending box.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Scope;
use super::heap::{Heap, Rank};
use super::lane_leaf::LeafMemory;
use super::level_visit::{Lanes, ManyRays, ones};
use crate::accel::{BEAM_RAYS, BeamEntry, ByRay, Child, MetRays};
use crate::compile::{Leaf, SolidBody};
use crate::crossing::Crossing;
use crate::csg::{Boundary, Event, EventKind, Program, Sweep};
use crate::lanes::IntervalLanes;
use crate::scratch::Scratch;
use crate::simd::{Doubles, Simd, Task, dispatch};

/// If the rays of a bundle have more pending events than this, they take the plain path, which has those of one ray at a
/// time.
const MAX_EVENTS: usize = if cfg!(test) { 2_000 } else { 1 << 16 };

/// What rays request of a body.
pub(super) struct StreamRequest<'a> {
    pub body: &'a SolidBody,
    /// The rays in the frame of the body, and which of them.
    pub rays: &'a ManyRays,
    pub places: u32,
    pub scope: Scope,
    /// How far each ray looks.
    pub limits: &'a ByRay,
    pub cancel: Option<&'a AtomicBool>,
}

/// The memory of streams; reused from body to body.
#[derive(Debug, Default)]
pub(super) struct BundleStream {
    heap: Heap<(Child, u32)>,
    children: Vec<BeamEntry>,
    rays: Vec<RayStream>,
    leaves: LeafMemory,
    /// The number of events that wait.
    waiting: usize,
}

/// The stream of one ray.
#[derive(Debug, Default)]
struct RayStream {
    /// What waits, nearest last.
    waiting: Vec<Waiting>,
    sweep: Sweep,
    first: Option<Boundary>,
}

/// What the sweep of a ray gets at some `t`.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    t: f64,
    leaf: u32,
    /// An event, or a crossing that only changes the state where the ray enters the box of the leaf.
    event: Option<Event>,
}

/// The rays that go on.
struct Active {
    places: u32,
    /// The end of the span; -infinity for rays that do not go on.
    limits: ByRay,
    /// Where the next event of each ray begins.
    next: [f64; BEAM_RAYS],
    /// The rays that are left open.
    open: u32,
}

impl Active {
    /// All rays. They look up to the end of the span: where it was cut at the limit, the first boundary would depend on the
    /// bodies that were visited before, since crossings that are one event may lie on both sides of it.
    fn of(request: &StreamRequest) -> Active {
        let mut limits = [[f64::NEG_INFINITY; 8]; BEAM_RAYS / 8];
        let t_max = request.scope.span.t_max();
        ones(request.places).for_each(|place| limits[place / 8][place % 8] = t_max);
        Active { places: request.places, limits, next: [f64::INFINITY; BEAM_RAYS], open: 0 }
    }

    fn end(&mut self, place: usize) {
        self.places &= !(1 << place);
        self.limits[place / 8][place % 8] = f64::NEG_INFINITY;
        self.next[place] = f64::INFINITY;
    }

    fn leave_open(&mut self, places: u32) {
        self.open |= places;
        ones(places).for_each(|place| self.end(place));
    }
}

impl BundleStream {
    /// The first boundary of the ray at a place, after [`BundleStream::run`].
    pub fn first(&self, place: usize) -> Option<Boundary> {
        self.rays[place].first
    }

    /// Finds the first boundaries of all rays. Returns a mask of those that are left open. After a cancellation they mean
    /// nothing.
    pub fn run(&mut self, request: &StreamRequest, scratch: &mut Scratch) -> u32 {
        let StreamRequest { body, rays, places, .. } = *request;
        let Some(accel) = &body.accel else { return places };
        let mut active = Active::of(request);
        self.begin(request);
        accel.beam_roots(&rays.some(places, &active.limits), &mut self.children);
        self.push_children();
        while let Some((t, (child, of))) = self.heap.pop() {
            self.advance(request, t, &mut active);
            let places = of & active.places;
            if active.places == 0 || request.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                break;
            }
            match child {
                _ if places == 0 => {}
                Child::Node(node) => {
                    accel.expand_beam(node, &rays.some(places, &active.limits), &mut self.children);
                    self.push_children();
                }
                Child::Entered(leaf) | Child::Item(leaf) => {
                    self.open_leaf(request, leaf, places, &mut active, scratch);
                }
            }
        }
        self.finish(request, &mut active);
        active.open
    }

    fn begin(&mut self, request: &StreamRequest) {
        self.heap.clear();
        self.children.clear();
        self.waiting = 0;
        self.rays.resize_with(BEAM_RAYS, RayStream::default);
        for place in ones(request.places) {
            let ray = &mut self.rays[place];
            ray.waiting.clear();
            ray.first = None;
            ray.sweep.begin(&request.body.program, request.scope.span);
        }
    }

    fn push_children(&mut self) {
        for BeamEntry { t, child, places } in self.children.drain(..) {
            self.heap.push(t, Rank::Box, (child, places));
        }
    }

    /// Lets the sweeps of all rays take the events before `t`, where the nearest pending box begins.
    fn advance(&mut self, request: &StreamRequest, t: f64, active: &mut Active) {
        let mut due = 0;
        for (place, &next) in active.next.iter().enumerate() {
            due |= u32::from(next < t) << place;
        }
        for place in ones(due & active.places) {
            let ray = &mut self.rays[place];
            self.waiting -= ray.take_waiting(&request.body.program, t);
            ray.sweep.advance(&request.body.program, t);
            if ray.is_done(request, place) {
                self.waiting -= ray.waiting.len();
                active.end(place);
            } else {
                active.next[place] = ray.next();
            }
        }
    }

    /// Ends all rays: there are no more boxes.
    fn finish(&mut self, request: &StreamRequest, active: &mut Active) {
        let program = &request.body.program;
        for place in ones(active.places) {
            let ray = &mut self.rays[place];
            // What begins behind the span does not count, even if it is one event with something before its end.
            ray.take_waiting(program, request.scope.span.t_max().next_up());
            ray.sweep.finish(program);
            ray.is_done(request, place);
        }
        ones(request.places).for_each(|place| self.rays[place].sweep.end(program));
    }

    /// Computes the crossings of a leaf with the rays that meet its box.
    fn open_leaf(
        &mut self,
        request: &StreamRequest,
        leaf: u32,
        places: u32,
        active: &mut Active,
        scratch: &mut Scratch,
    ) {
        let bounds = &request.body.leaves[leaf as usize].bounds;
        let mut met = request.rays.boxes.enter(bounds, &active.limits);
        met.rays &= places;
        if met.rays == 0 {
            return;
        }
        let BundleStream { rays, leaves, waiting, .. } = self;
        let open = dispatch(LeafCast { request, leaf, met: &met, rays, leaves, waiting, scratch });
        for place in ones(met.rays) {
            active.next[place] = rays[place].next();
        }
        let open = if *waiting > MAX_EVENTS { active.places } else { open };
        ones(open).for_each(|place| *waiting -= std::mem::take(&mut rays[place].waiting).len());
        active.leave_open(open);
    }
}

impl RayStream {
    /// Where the next thing waits.
    fn next(&self) -> f64 {
        self.waiting.last().map_or(f64::INFINITY, |next| next.t)
    }

    /// Passes what waits before `t` to the sweep. Returns how much that is.
    fn take_waiting(&mut self, program: &Program, t: f64) -> usize {
        let mut count = 0;
        while let Some(next) = self.waiting.pop_if(|next| next.t < t) {
            match next.event {
                Some(event) => self.sweep.push(program, event),
                None => {
                    self.sweep.advance(program, next.t);
                    self.sweep.apply(program, next.leaf, EventKind::Membership);
                }
            }
            count += 1;
        }
        count
    }

    /// Takes the boundaries that are certain. Returns whether no other one is needed.
    fn is_done(&mut self, request: &StreamRequest, place: usize) -> bool {
        let limit = request.limits[place / 8][place % 8];
        while let Some(boundary) = self.sweep.pop() {
            if boundary.crossing.t > limit {
                return true;
            }
            if request.scope.kinds.hold(boundary.kind) {
                self.first = Some(boundary);
                return true;
            }
        }
        false
    }

    /// Adds a crossing of a leaf, whose box the ray enters at `enter`, as the stream of a single ray does. Returns whether it
    /// waits.
    fn take(&mut self, leaf: u32, crossing: Crossing, enter: f64) -> bool {
        let event = Event::new(leaf, EventKind::Membership, crossing, enter);
        let t = event.map_or(enter, |event| event.low);
        if event.is_some() && crossing.t == f64::INFINITY {
            return false;
        }
        // Boxes are opened before the events that begin there.
        let is_later = |other: &Waiting| other.t > t || (other.t == t && event.is_none());
        let at = self.waiting.partition_point(is_later);
        self.waiting.insert(at, Waiting { t, leaf, event });
        true
    }
}

/// Computes the crossings of a leaf, and adds them to the events of the rays. Returns the rays that are left open.
struct LeafCast<'a, 'c> {
    request: &'a StreamRequest<'a>,
    leaf: u32,
    met: &'a MetRays,
    rays: &'a mut [RayStream],
    leaves: &'a mut LeafMemory,
    waiting: &'a mut usize,
    scratch: &'a mut Scratch<'c>,
}

impl Task for LeafCast<'_, '_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> u32 {
        let mut open = 0;
        for lanes in Lanes::of(self.met.rays, S::Wide::LANES) {
            open |= self.cast::<S::Wide>(&lanes);
        }
        open
    }
}

impl LeafCast<'_, '_> {
    #[inline(always)]
    fn cast<F: Doubles>(&mut self, lanes: &Lanes) -> u32 {
        let body = self.request.body;
        let leaf: &Leaf = &body.leaves[self.leaf as usize];
        let line = self.request.rays.line_lanes::<F>(lanes).in_frame(&leaf.local_from_body);
        let inside =
            self.leaves.inside(leaf, false, (&line, lanes.used), self.request.scope.span, self.scratch);
        for interval in &inside.intervals {
            if interval.lanes & !inside.open != 0 {
                self.add(interval, interval.lanes & !inside.open, lanes);
            }
        }
        ones(u32::from(inside.open & lanes.used)).fold(0, |open, lane| open | 1 << lanes.places[lane])
    }

    #[inline(always)]
    fn add<F: Doubles>(&mut self, interval: &IntervalLanes<F>, of: u8, lanes: &Lanes) {
        let mut numbers = [[[0.0; 8]; 3]; 2];
        for (to, end) in numbers.iter_mut().zip([interval.enter, interval.exit]) {
            end.t.store_some(&mut to[0], 0);
            end.t_err.store_some(&mut to[1], 0);
            end.surface.store_some(&mut to[2], 0);
        }
        for lane in ones(u32::from(of)) {
            let place = usize::from(lanes.places[lane]);
            let enter = self.met.enter[place / 8][place % 8];
            for (end, entering) in numbers.iter().zip([true, false]) {
                let crossing = Crossing::new(end[0][lane], end[1][lane], entering, end[2][lane] as u32);
                let waits = self.rays[place].take(self.leaf, crossing, enter);
                *self.waiting += usize::from(waits);
            }
        }
    }
}
