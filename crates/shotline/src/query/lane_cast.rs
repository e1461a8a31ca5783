//! Casts rays in lanes at a body of a few leaves.

use super::lane_leaf::LeafMemory;
use super::level_visit::{Lanes, ManyRays, ones};
use super::{Kinds, Scope};
use crate::accel::ByRay;
use crate::compile::{Leaf, SolidBody};
use crate::crossing::{Crossing, NO_PRIMITIVE};
use crate::csg::lanes::{Boundaries, LaneEvent, LaneEvents};
use crate::csg::{Boundary, HitKind};
use crate::lanes::vector::{covector, units};
use crate::lanes::{BoxLanes, LineLanes};
use crate::math::{Affine, Vec3, unit};
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
    fn find(&self, place: u32, lane: usize) -> LaneFind {
        let crossing =
            Crossing::new(self.t[lane], self.t_err[lane], self.entering, self.surface[lane] as u32);
        let entering = self.inside >> lane & 1 == 1;
        let boundary = Boundary { kind: HitKind::Surface, entering, leaf: self.leaf, crossing };
        LaneFind { place, boundary, normal: Vec3::from(self.normal.map(|numbers| numbers[lane])) }
    }
}

/// Casts the rays of a mask at a body.
pub(super) struct LaneCast<'a, 'c> {
    pub body: &'a SolidBody,
    pub rays: &'a ManyRays,
    pub places: u32,
    /// The transforms from the world to the body, innermost first.
    pub frames: &'a [&'a Affine],
    pub scope: Scope,
    pub wanted: Wanted,
    pub wants_normals: bool,
    pub limits: &'a ByRay,
    pub finds: &'a mut LaneFinds,
    pub scratch: &'a mut Scratch<'c>,
}

impl Task for LaneCast<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        self.finds.all.clear();
        self.finds.open = 0;
        for lanes in Lanes::of(self.places, S::Wide::LANES) {
            self.cast::<S::Wide>(&lanes);
        }
    }
}

impl LaneCast<'_, '_> {
    /// Casts the rays of some lanes.
    #[inline(always)]
    fn cast<F: Doubles>(&mut self, rays: &Lanes) {
        let line = self.rays.line_lanes::<F>(rays).in_frame(self.frames[0]);
        let mut events = LaneEvents::new(self.scope.span);
        let (mut open, mut lanes) = (0, rays.used);
        let mut last_exit = F::splat(f64::NEG_INFINITY);
        // A single leaf is intersected without a box test, as by the plain path.
        let boxes = (self.body.leaves.len() > 1).then(|| BoxLanes::new(&line, self.scope.span));
        for (number, leaf) in (0..).zip(&self.body.leaves) {
            // An empty box: the leaf never matters.
            if leaf.bounds.is_empty() {
                continue;
            }
            let (box_enter, met_box) = match &boxes {
                Some(boxes) => {
                    let (enter, exit) = boxes.enter_exit(&leaf.bounds);
                    let met = enter.is_at_most(exit);
                    last_exit = exit.greater(last_exit).where_set(met, last_exit);
                    (enter, lanes & met)
                }
                None => (F::splat(self.scope.span.t_min()), lanes),
            };
            if met_box == 0 {
                if self.body.program.needs(number) {
                    return;
                }
                continue;
            }
            let local = line.in_frame(&leaf.local_from_body);
            let is_lone = self.body.leaves.len() == 1;
            let inside =
                self.finds.leaves.inside(leaf, is_lone, (&local, met_box), self.scope.span, self.scratch);
            open |= inside.open;
            let mut met = inside.open;
            for interval in &inside.intervals {
                events.add(number, interval, box_enter);
                met |= interval.lanes;
            }
            if self.body.program.needs(number) {
                lanes &= met;
                if lanes == 0 {
                    return;
                }
            }
        }
        if boxes.is_some() {
            events.end_at(last_exit);
        }
        open &= lanes;
        let (program, decided) = (&self.body.program, lanes & !open);
        let boundaries = if self.wanted == Wanted::First {
            let limit = rays.load::<F>(self.limits);
            events.first(program, decided, limit, self.scope.kinds == Kinds::Surfaces)
        } else {
            events.all(program, decided)
        };
        for lane in ones(u32::from(open | boundaries.open)) {
            self.finds.open |= 1 << rays.places[lane];
        }
        self.finds.rows.clear();
        for (i, event) in events.events().iter().enumerate() {
            if boundaries.events[i] != 0 {
                self.add_row(&boundaries, i, event, &line);
            }
        }
        self.gather(&boundaries, rays);
    }

    /// Notes an event that is a boundary.
    #[inline(always)]
    fn add_row<F: Doubles>(
        &mut self,
        boundaries: &Boundaries,
        i: usize,
        event: &LaneEvent<F>,
        line: &LineLanes<F>,
    ) {
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
        if self.wants_normals {
            self.set_normals(&mut row, event, line);
        }
        self.finds.rows.push(row);
    }

    /// Computes the normals at an event, as for a single ray.
    #[inline(always)]
    fn set_normals<F: Doubles>(&self, row: &mut EventRow, event: &LaneEvent<F>, line: &LineLanes<F>) {
        let leaf = &self.body.leaves[event.leaf as usize];
        // Turns -0.0 into 0.0, as in the fold of a single ray.
        let p = line.in_frame(&leaf.local_from_body).at(event.t + F::splat(0.0));
        let outward = match leaf.solid.in_lanes() {
            Some(solid) => solid.normal(p, event.surface),
            None => normals_one_by_one(leaf, &p, row),
        };
        let mut normal = covector(&leaf.local_from_body, outward);
        for frame in self.frames {
            normal = covector(frame, normal);
        }
        let (mut of_length_one, ordinary) = units(normal);
        if self.body.program.is_subtracted(event.leaf) {
            of_length_one = [-of_length_one[0], -of_length_one[1], -of_length_one[2]];
        }
        for (numbers, to) in of_length_one.into_iter().zip(&mut row.normal) {
            numbers.store_some(to, 0);
        }
        let unusual = row.lanes & !ordinary;
        if unusual != 0 {
            let normal = [normal[0].store(), normal[1].store(), normal[2].store()];
            for lane in ones(u32::from(unusual)) {
                let normal = unit(Vec3::new(normal[0][lane], normal[1][lane], normal[2][lane]));
                let normal = if self.body.program.is_subtracted(event.leaf) { -normal } else { normal };
                (0..3).for_each(|axis| row.normal[axis][lane] = normal[axis]);
            }
        }
    }

    /// Gathers the boundaries of each lane, in order.
    fn gather(&mut self, boundaries: &Boundaries, rays: &Lanes) {
        let LaneFinds { all, rows, open, .. } = &mut *self.finds;
        let span = self.scope.span;
        let span_end = |kind: HitKind, t: f64, lane: usize| {
            let boundary = Boundary::of_span_end(kind, t);
            LaneFind { place: u32::from(rays.places[lane]), boundary, normal: Vec3::NAN }
        };
        if self.wanted == Wanted::First {
            all.extend(
                ones(u32::from(boundaries.starts)).map(|lane| span_end(HitKind::Start, span.t_min(), lane)),
            );
            for row in rows.iter() {
                all.extend(
                    ones(u32::from(row.lanes)).map(|lane| row.find(u32::from(rays.places[lane]), lane)),
                );
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
                all.push(row.find(u32::from(rays.places[lane]), lane));
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
                *open |= 1 << rays.places[lane];
                continue;
            }
            if boundaries.ends >> lane & 1 == 1 {
                all.push(span_end(HitKind::End, span.t_max(), lane));
            }
        }
    }
}

/// The normals at points of a solid that takes one line at a time, in the lanes of a row.
#[inline(always)]
fn normals_one_by_one<F: Doubles>(leaf: &Leaf, p: &[F; 3], row: &EventRow) -> [F; 3] {
    let p = [p[0].store(), p[1].store(), p[2].store()];
    let mut normals = [[0.0; 8]; 3];
    for lane in ones(u32::from(row.lanes)) {
        let p = Vec3::new(p[0][lane], p[1][lane], p[2][lane]);
        let normal = leaf.solid.normal(p, row.surface[lane] as u32, NO_PRIMITIVE);
        (0..3).for_each(|axis| normals[axis][lane] = normal[axis]);
    }
    [F::load_some(&normals[0], 0), F::load_some(&normals[1], 0), F::load_some(&normals[2], 0)]
}
