//! Casts rays in lanes at bodies of a few leaves.

use super::lane_bodies::Bodies;
use super::lane_leaf::LeafMemory;
use super::lane_normals::{Frames, Leaves, Normals};
use super::level_visit::{Lanes, ManyRays, ones};
use super::{Kinds, Scope};
use crate::accel::ByRay;
use crate::compile::SolidBody;
use crate::crossing::Crossing;
use crate::csg::lanes::{Boundaries, LaneEvent, LaneEvents};
use crate::csg::{Boundary, HitKind, Program};
use crate::lanes::{BoxLanes, LineLanes};
use crate::math::{Affine, Vec3};
use crate::scratch::Scratch;
use crate::simd::{Doubles, Simd, Task};
use crate::solid::Wanted;

/// A boundary of the ray at a place of a bundle, with its normal in world coordinates if normals are needed.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneFind {
    pub place: u32,
    pub boundary: Boundary,
    pub normal: Vec3,
}

/// What is found of the rays of a bundle.
#[derive(Debug, Default)]
pub(super) struct LaneFinds {
    /// The boundaries: those of a ray one after the other, in order.
    pub all: Vec<LaneFind>,
    /// The rays that are left open.
    pub open: u32,
    rows: Vec<EventRow>,
    leaves: LeafMemory,
}

/// An event that is a boundary in some lanes, number by number.
#[derive(Clone, Copy, Debug)]
struct EventRow {
    lanes: u8,
    /// The lanes that are inside behind it.
    inside: u8,
    leaf: u32,
    entering: bool,
    t: [f64; 8],
    t_err: [f64; 8],
    surface: [f64; 8],
    normal: [[f64; 8]; 3],
}

impl EventRow {
    /// An event that is a boundary, without normals.
    #[inline(always)]
    fn new<F: Doubles>(boundaries: &Boundaries, i: usize, event: &LaneEvent<F>) -> EventRow {
        let mut row = EventRow {
            lanes: boundaries.events[i],
            inside: boundaries.after(i),
            leaf: event.leaf,
            entering: event.entering,
            t: [0.0; 8],
            t_err: [0.0; 8],
            surface: [0.0; 8],
            normal: [[f64::NAN; 8]; 3],
        };
        event.t.store_some(&mut row.t, 0);
        event.t_err.store_some(&mut row.t_err, 0);
        event.surface.store_some(&mut row.surface, 0);
        row
    }

    fn find(&self, place: u32, lane: usize) -> LaneFind {
        let crossing =
            Crossing::new(self.t[lane], self.t_err[lane], self.entering, self.surface[lane] as u32);
        let entering = self.inside >> lane & 1 == 1;
        let boundary = Boundary { kind: HitKind::Surface, entering, leaf: self.leaf, crossing };
        LaneFind { place, boundary, normal: Vec3::from(self.normal.map(|numbers| numbers[lane])) }
    }
}

/// How rays are cast at a body in lanes.
pub(super) struct LaneQuery<'a, 'c> {
    pub scope: Scope,
    pub wanted: Wanted,
    pub finds: &'a mut LaneFinds,
    pub scratch: &'a mut Scratch<'c>,
}

/// The lanes of a cast: those that have rays, how far these look, and their places.
#[derive(Clone, Copy)]
pub(super) struct Cast<F> {
    pub used: u8,
    pub limit: F,
    pub places: [u8; 8],
}

/// Casts the rays of a mask at a body.
pub(super) struct LaneCast<'a, 'c> {
    pub query: LaneQuery<'a, 'c>,
    pub body: &'a SolidBody,
    pub rays: &'a ManyRays,
    pub places: u32,
    /// The transforms from the world to the body, innermost first.
    pub frames: &'a [&'a Affine],
    pub wants_normals: bool,
    pub limits: &'a ByRay,
}

impl Task for LaneCast<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        self.query.finds.clear();
        let frames = self.wants_normals.then_some(Frames::Same(self.frames));
        for lanes in Lanes::of(self.places, S::Wide::LANES) {
            let line = self.rays.line_lanes::<S::Wide>(&lanes).in_frame(self.frames[0]);
            let cast = Cast { used: lanes.used, limit: lanes.load(self.limits), places: lanes.places };
            self.query.at_bodies(Bodies::Same(self.body), &line, &cast, frames);
        }
    }
}

impl LaneFinds {
    pub fn clear(&mut self) {
        self.all.clear();
        self.open = 0;
    }
}

/// What the events of a cast belong to.
struct Events<'e, F> {
    program: &'e Program,
    events: &'e LaneEvents<F>,
    /// The lanes that may have boundaries, and those that are left open.
    lanes: u8,
    open: u8,
}

impl LaneQuery<'_, '_> {
    /// Casts at bodies of a few leaves. `frames` are given if normals are needed.
    #[inline(always)]
    pub fn at_bodies<F: Doubles>(
        &mut self,
        bodies: Bodies<'_>,
        line: &LineLanes<F>,
        cast: &Cast<F>,
        frames: Option<Frames>,
    ) {
        let SolidBody { leaves, program, .. } = bodies.first();
        let mut events = LaneEvents::new(self.scope.span);
        let (mut open, mut lanes) = (0, cast.used);
        let mut last_exit = F::splat(f64::NEG_INFINITY);
        // A single leaf is intersected without a box test, as by the plain path.
        let boxes = if leaves.len() == 1 { None } else { Some(BoxLanes::new(line, self.scope.span)) };
        for number in 0..leaves.len() as u32 {
            let (box_enter, met_box) = match &boxes {
                Some(boxes) => {
                    let (enter, exit, met) = bodies.enter_exit(number as usize, boxes);
                    last_exit = exit.greater(last_exit).where_set(met, last_exit);
                    (enter, lanes & met)
                }
                None => (F::splat(self.scope.span.t_min()), lanes),
            };
            if met_box == 0 {
                if program.needs(number) {
                    return;
                }
                continue;
            }
            let (of_leaf, memory) = ((line, met_box), &mut self.finds.leaves);
            let inside = bodies.inside(number, of_leaf, self.scope.span, memory, self.scratch);
            open |= inside.open;
            let mut met = inside.open;
            for interval in &inside.intervals {
                events.add(number, interval, box_enter);
                met |= interval.lanes;
            }
            if program.needs(number) {
                lanes &= met;
                if lanes == 0 {
                    return;
                }
            }
        }
        if boxes.is_some() {
            events.end_at(last_exit);
        }
        let normals = frames.map(|frames| Normals { leaves: Leaves::Of(bodies), line, frames });
        self.find(Events { program, events: &events, lanes, open }, cast, normals);
    }

    /// Finds the boundaries.
    #[inline(always)]
    fn find<F: Doubles>(&mut self, of: Events<'_, F>, cast: &Cast<F>, normals: Option<Normals<'_, F>>) {
        let Events { program, events, lanes, mut open } = of;
        open &= lanes;
        let decided = lanes & !open;
        let boundaries = if self.wanted == Wanted::First {
            events.first(program, decided, cast.limit, self.scope.kinds == Kinds::Surfaces)
        } else {
            events.all(program, decided)
        };
        for lane in ones(u32::from(open | boundaries.open)) {
            self.finds.open |= 1 << cast.places[lane];
        }
        self.finds.rows.clear();
        for (i, event) in events.events().iter().enumerate() {
            if boundaries.events[i] != 0 {
                let mut row = EventRow::new(&boundaries, i, event);
                if let Some(normals) = &normals {
                    row.normal = normals.at(event.leaf, event.t, event.surface, row.lanes);
                }
                self.finds.rows.push(row);
            }
        }
        self.gather(&boundaries, &cast.places);
    }

    /// Gathers the boundaries of each lane, in order.
    fn gather(&mut self, boundaries: &Boundaries, places: &[u8; 8]) {
        let LaneFinds { all, rows, open, .. } = &mut *self.finds;
        let span = self.scope.span;
        let span_end = |kind: HitKind, t: f64, lane: usize| {
            let boundary = Boundary::of_span_end(kind, t);
            LaneFind { place: u32::from(places[lane]), boundary, normal: Vec3::NAN }
        };
        if self.wanted == Wanted::First {
            all.extend(
                ones(u32::from(boundaries.starts)).map(|lane| span_end(HitKind::Start, span.t_min(), lane)),
            );
            for row in rows.iter() {
                all.extend(ones(u32::from(row.lanes)).map(|lane| row.find(u32::from(places[lane]), lane)));
            }
            return;
        }
        let any = rows.iter().fold(boundaries.starts, |any, row| any | row.lanes);
        for lane in ones(u32::from(any)) {
            let begin = all.len();
            let starts_inside = boundaries.starts >> lane & 1 == 1;
            if starts_inside {
                all.push(span_end(HitKind::Start, span.t_min(), lane));
            }
            let start = all.len();
            for row in rows.iter().filter(|row| row.lanes >> lane & 1 == 1) {
                all.push(row.find(u32::from(places[lane]), lane));
                let mut at = all.len() - 1;
                while at > start && all[at - 1].boundary.crossing.t > all[at].boundary.crossing.t {
                    all.swap(at - 1, at);
                    at -= 1;
                }
            }
            let alternate =
                |(i, find): (usize, &LaneFind)| find.boundary.entering == (starts_inside == (i % 2 == 1));
            if !all[start..].iter().enumerate().all(alternate) {
                // Underflow has made a bound too small.
                all.truncate(begin);
                *open |= 1 << places[lane];
                continue;
            }
            if boundaries.ends >> lane & 1 == 1 {
                all.push(span_end(HitKind::End, span.t_max(), lane));
            }
        }
    }
}
