//! All boundaries of a body of many leaves along the rays of a bundle.
//!
//! All boundaries are needed, so the search has no early end, and needs no heap of pending boxes: the accelerator is
//! traversed depth first, nearer boxes first. The crossings with a leaf stay in lanes where they were
//! computed. Each ray gathers a sorted list of its events, which is swept at once, and normals are computed in lanes where
//! there are boundaries.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Scope;
use super::lane_bodies::Bodies;
use super::lane_events::{EndEvents, representative};
use super::lane_leaf::LeafMemory;
use super::lane_normals::{Frames, Leaves, NormalLanes, Normals};
use super::level_visit::{Lanes, ManyRays, ones};
use crate::accel::{BEAM_RAYS, BeamEntry, ByRay, Child};
use crate::compile::{Leaf, SolidBody};
use crate::crossing::Crossing;
use crate::csg::{
    Boundary, Event, EventKind, HitKind, ListSweep, ListedBoundary, ListedCrossings, ListedEvent, Program,
    ProgramState, Sweep, Tally,
};
use crate::lanes::{EndLanes, IntervalLanes};
use crate::math::{Affine, Vec3};
use crate::ray::Span;
use crate::scratch::Scratch;
use crate::simd::{Doubles, Simd, Task, dispatch};

/// If the rays of a bundle have more events than this, they take the plain path, which has those of one ray at a time.
const MAX_EVENTS: usize = if cfg!(test) { 2_000 } else { 1 << 16 };

/// A ray with more events than this takes the plain path, which has a heap of them: here each is moved to its place.
const MAX_OF_RAY: usize = if cfg!(test) { 200 } else { 1 << 12 };

/// How many cache lines of a solid are prefetched before it is intersected: as many as a quadric with caps has.
const SOLID_LINES: usize = 8;

/// What rays request of a body.
pub(super) struct ListRequest<'a> {
    pub body: &'a SolidBody,
    /// The rays in the frame of the body, and which of them.
    pub rays: &'a ManyRays,
    pub places: u32,
    pub scope: Scope,
    /// The transforms from the world to the body, innermost first, if normals are needed.
    pub frames: Option<&'a [&'a Affine]>,
    pub cancel: Option<&'a AtomicBool>,
}

/// The memory of lists; reused from body to body.
#[derive(Debug, Default)]
pub(super) struct BundleLists {
    /// Pending boxes, the next one last.
    pending: Vec<BeamEntry>,
    children: Vec<BeamEntry>,
    leaves: LeafMemory,
    rows: Rows,
    /// The events of each ray, sorted.
    events: Vec<Vec<ListedEvent>>,
    event_count: usize,
    /// The rays whose events the quick sweep would toggle in the wrong order.
    unusual: u32,
    /// The rays with too many events.
    crowded: u32,
    sweep: Sweep,
    state: ProgramState,
    /// The boundaries of the rays, one ray after the other, and those of each.
    boundaries: Vec<ListedBoundary>,
    of_rays: Vec<Range<usize>>,
    normals: Vec<NormalLanes>,
}

/// One end of the interval in which the rays of some lanes are inside a leaf.
#[derive(Clone, Copy, Debug)]
struct EndRow {
    t: [f64; 8],
    t_err: [f64; 8],
    surface: [f64; 8],
    lanes: Lanes,
    leaf: u32,
    entering: bool,
    /// The lanes in which it is a boundary.
    boundaries: u8,
    /// The number of its normals, if it has any.
    normals: u32,
}

/// The crossings. That of a lane has the number `8 * row + lane`.
#[derive(Debug, Default)]
struct Rows(Vec<EndRow>);

impl BundleLists {
    /// The boundaries of the ray at a place, after [`BundleLists::run`]; with their normals in world coordinates, if these
    /// were requested.
    pub fn boundaries(&self, place: usize, span: Span) -> impl Iterator<Item = (Boundary, Vec3)> {
        let Range { start, end } = self.of_rays[place];
        self.boundaries[start..end].iter().map(move |&ListedBoundary { kind, entering, number }| {
            let (row, lane) = match kind {
                HitKind::Surface => self.rows.of(number),
                HitKind::Start => return (Boundary::of_span_end(kind, span.t_min()), Vec3::NAN),
                HitKind::End => return (Boundary::of_span_end(kind, span.t_max()), Vec3::NAN),
            };
            let boundary = Boundary { kind, entering, leaf: row.leaf, crossing: row.crossing(lane) };
            let normal = self.normals.get(row.normals as usize);
            (boundary, normal.map_or(Vec3::NAN, |normal| Vec3::from(normal.map(|axis| axis[lane]))))
        })
    }

    /// Finds the boundaries of all rays. Returns a mask of those that are left open. After a cancellation they mean
    /// nothing.
    pub fn run(&mut self, request: &ListRequest, scratch: &mut Scratch) -> u32 {
        let Some(accel) = &request.body.accel else { return request.places };
        self.begin();
        let mut limits = [[f64::NEG_INFINITY; 8]; BEAM_RAYS / 8];
        ones(request.places).for_each(|place| limits[place / 8][place % 8] = request.scope.span.t_max());
        let mut open = 0;
        accel.beam_roots(&request.rays.some(request.places, &limits), &mut self.children);
        self.push_children();
        while let Some(BeamEntry { child, places, .. }) = self.pending.pop() {
            let places = places & !open;
            match child {
                _ if places == 0 => {}
                Child::Node(node) => {
                    if request.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                        return open;
                    }
                    accel.expand_beam(node, &request.rays.some(places, &limits), &mut self.children);
                    self.push_children();
                }
                Child::Entered(leaf) | Child::Item(leaf) => {
                    open |=
                        dispatch(LeafCast { lists: self, request, leaf, places, limits: &limits, scratch });
                    open |= self.crowded;
                    if self.event_count > MAX_EVENTS {
                        return request.places;
                    }
                }
            }
        }
        open |= self.sweep_all(request, request.places & !open);
        if let Some(frames) = request.frames {
            dispatch(NormalCast { lists: self, request, frames });
        }
        open
    }

    fn begin(&mut self) {
        self.pending.clear();
        self.children.clear();
        self.rows.0.clear();
        self.events.resize_with(BEAM_RAYS, Vec::new);
        self.events.iter_mut().for_each(Vec::clear);
        (self.event_count, self.unusual, self.crowded) = (0, 0, 0);
        self.boundaries.clear();
        self.of_rays.clear();
        self.of_rays.resize(BEAM_RAYS, 0..0);
        self.normals.clear();
    }

    /// Moves the children of a node to the pending boxes, nearest last.
    fn push_children(&mut self) {
        let start = self.pending.len();
        for child in self.children.drain(..) {
            let mut at = self.pending.len();
            self.pending.push(child);
            while at > start && self.pending[at - 1].t < child.t {
                self.pending[at] = self.pending[at - 1];
                at -= 1;
            }
            self.pending[at] = child;
        }
    }

    /// Sweeps the events of some rays. Returns those that are left open.
    fn sweep_all(&mut self, request: &ListRequest, places: u32) -> u32 {
        let (program, span) = (&request.body.program, request.scope.span);
        let tally = program.tally();
        let mut open = 0;
        self.state.reset(program);
        let value = tally.map_or_else(|| self.state.value(program), Tally::value);
        for place in ones(places) {
            let BundleLists { events, rows, boundaries, state, .. } = self;
            let (events, start) = (&events[place], boundaries.len());
            let mut swept = SweptRows { rows, program, tally, state };
            let is_swept = self.unusual >> place & 1 == 0
                && ListSweep::new(span, value).finish(events, &mut swept, boundaries);
            if tally.is_none() {
                state.clear(program);
            }
            if !is_swept {
                boundaries.truncate(start);
                if !self.sweep_unusual(place, program, span) {
                    self.boundaries.truncate(start);
                    open |= 1 << place;
                }
            }
            for boundary in &self.boundaries[start..] {
                if boundary.kind == HitKind::Surface {
                    self.rows.0[boundary.number as usize / 8].boundaries |= 1 << (boundary.number % 8);
                }
            }
            self.of_rays[place] = start..self.boundaries.len();
        }
        open
    }

    /// Sweeps the events of a ray among which are chains, or some at the start of the span. Returns `false` if the ray is
    /// left open.
    fn sweep_unusual(&mut self, place: usize, program: &Program, span: Span) -> bool {
        let BundleLists { events, rows, sweep, boundaries, .. } = self;
        // What begins behind the span does not count.
        let end = span.t_max().next_up();
        let events = &events[place][..];
        sweep.begin(program, span);
        for event in events.iter().take_while(|event| event.low < end) {
            let (row, lane) = rows.of(event.number);
            if event.is_before_box() {
                sweep.advance(program, event.low);
                sweep.apply(program, row.leaf, EventKind::Membership);
            } else {
                let (low, crossing) = (event.low, row.crossing(lane));
                sweep.push(program, Event { low, leaf: row.leaf, kind: EventKind::Membership, crossing });
            }
        }
        sweep.finish(program);
        let mut are_found = true;
        while let Some(Boundary { kind, entering, leaf, crossing }) = sweep.pop() {
            let is_of = |event: &&ListedEvent| {
                let (row, lane) = rows.of(event.number);
                row.leaf == leaf && row.crossing(lane) == crossing
            };
            let number = events.iter().find(is_of).map(|event| event.number);
            are_found &= kind != HitKind::Surface || number.is_some();
            boundaries.push(ListedBoundary { kind, entering, number: number.unwrap_or(0) });
        }
        sweep.end(program);
        are_found
    }
}

impl EndRow {
    fn crossing(&self, lane: usize) -> Crossing {
        Crossing::new(self.t[lane], self.t_err[lane], self.entering, self.surface[lane] as u32)
    }
}

impl Rows {
    /// The row and the lane of a number.
    fn of(&self, number: u32) -> (&EndRow, usize) {
        (&self.0[number as usize / 8], number as usize % 8)
    }
}

/// The crossings of a ray, for the sweep.
struct SweptRows<'a> {
    rows: &'a Rows,
    program: &'a Program,
    /// Set for programs of one node. The state is used for others.
    tally: Option<Tally>,
    state: &'a mut ProgramState,
}

impl ListedCrossings for SweptRows<'_> {
    #[inline]
    fn toggle(&mut self, event: &ListedEvent) -> bool {
        if let Some(tally) = &mut self.tally {
            tally.add(event.step);
            return tally.value();
        }
        self.state.toggle(self.program, self.rows.of(event.number).0.leaf);
        self.state.value(self.program)
    }

    #[inline]
    fn t(&self, number: u32) -> f64 {
        let (row, lane) = self.rows.of(number);
        row.t[lane]
    }

    fn representative(&self, group: &[ListedEvent], entering: bool) -> Option<u32> {
        representative(group, self.program, entering, |number| {
            let (row, lane) = self.rows.of(number);
            (row.leaf, row.crossing(lane))
        })
    }
}

/// Computes the crossings of a leaf with the rays that meet its box, and adds them to the lists. Returns the rays that are
/// left open.
struct LeafCast<'a, 'c> {
    lists: &'a mut BundleLists,
    request: &'a ListRequest<'a>,
    leaf: u32,
    places: u32,
    limits: &'a ByRay,
    scratch: &'a mut Scratch<'c>,
}

impl Task for LeafCast<'_, '_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self) -> u32 {
        let LeafCast { lists, request, leaf: number, places, limits, scratch } = self;
        let ListRequest { body, rays, scope, .. } = request;
        let leaf = &body.leaves[number as usize];
        lists.prefetch::<S>(body);
        let mut met = rays.boxes.enter_by::<S>(&leaf.bounds, limits);
        met.rays &= places;
        let mut open = 0;
        for lanes in Lanes::of(met.rays, S::Wide::LANES) {
            let line = rays.line_lanes::<S::Wide>(&lanes).in_frame(&leaf.local_from_body);
            let inside = lists.leaves.inside(leaf, false, (&line, lanes.used), scope.span, scratch);
            let to = EndsOf {
                leaf: number,
                step: body.program.step(number),
                lanes,
                enter: lanes.load(&met.enter),
            };
            for interval in &inside.intervals {
                lists.add(&to, interval, interval.lanes & !inside.open);
            }
            for lane in ones(u32::from(inside.open & lanes.used)) {
                open |= 1 << lanes.places[lane];
            }
        }
        open
    }
}

/// The leaf and the rays of ends.
struct EndsOf<F> {
    leaf: u32,
    step: i32,
    lanes: Lanes,
    /// Where the rays enter the box of the leaf.
    enter: F,
}

impl BundleLists {
    /// Prefetches what comes next, which is rarely in the cache: the solid of the next leaf, and the leaf after it, whose solid
    /// is prefetched later.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, body: &SolidBody) {
        if let [.., after, next] = &self.pending[..]
            && let (Child::Entered(next), Child::Entered(after)) = (next.child, after.child)
        {
            let solid = std::ptr::from_ref(&*body.leaves[next as usize].solid).cast::<u8>();
            let leaf = std::ptr::from_ref(&body.leaves[after as usize]).cast::<u8>();
            (0..SOLID_LINES).for_each(|line| S::prefetch(solid.wrapping_add(64 * line)));
            (0..=size_of::<Leaf>() / 64).for_each(|line| S::prefetch(leaf.wrapping_add(64 * line)));
        }
    }

    /// Adds the interval of some lanes.
    #[inline(always)]
    fn add<F: Doubles>(&mut self, to: &EndsOf<F>, interval: &IntervalLanes<F>, of: u8) {
        if of == 0 {
            return;
        }
        let entry = self.add_end(to, &interval.enter, true, of);
        let exit = self.add_end(to, &interval.exit, false, of);
        // An exit before the box with an entry that may be in it: the sweep toggles them in that order.
        for lane in ones(u32::from(entry.events & exit.before)) {
            self.unusual |= 1 << to.lanes.places[lane];
        }
    }

    /// Adds one end of the interval of some lanes.
    #[inline(always)]
    fn add_end<F: Doubles>(
        &mut self,
        to: &EndsOf<F>,
        end: &EndLanes<F>,
        entering: bool,
        of: u8,
    ) -> EndEvents<F> {
        let events = EndEvents::new(end, to.enter, of);
        let first = 8 * self.rows.0.len() as u32;
        let step = if entering { to.step } else { -to.step };
        for lane in ones(u32::from(events.events | events.before)) {
            let place = to.lanes.places[lane];
            let list = &mut self.events[usize::from(place)];
            events.listed(lane, first + lane as u32, step).insert_into(list);
            self.crowded |= u32::from(list.len() > MAX_OF_RAY) << place;
            self.event_count += 1;
        }
        let (lanes, leaf) = (to.lanes, to.leaf);
        let [t, t_err, surface] = [[0.0; 8]; 3];
        let mut row = EndRow { t, t_err, surface, lanes, leaf, entering, boundaries: 0, normals: u32::MAX };
        end.t.store_some(&mut row.t, 0);
        end.t_err.store_some(&mut row.t_err, 0);
        end.surface.store_some(&mut row.surface, 0);
        self.rows.0.push(row);
        events
    }
}

/// Computes the normals at all boundaries.
struct NormalCast<'a> {
    lists: &'a mut BundleLists,
    request: &'a ListRequest<'a>,
    frames: &'a [&'a Affine],
}

impl Task for NormalCast<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let NormalCast { lists: BundleLists { rows, normals, .. }, request, frames } = self;
        for row in rows.0.iter_mut().filter(|row| row.boundaries != 0) {
            let line = &request.rays.line_lanes::<S::Wide>(&row.lanes);
            let of = Normals {
                leaves: Leaves::Of(Bodies::Same(request.body)),
                line,
                frames: Frames::Same(frames),
            };
            let t = S::Wide::load_some(&row.t, 0);
            row.normals = normals.len() as u32;
            normals.push(of.at(row.leaf, t, S::Wide::load_some(&row.surface, 0), row.boundaries));
        }
    }
}
