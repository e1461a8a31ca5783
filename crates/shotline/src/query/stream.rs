//! The ordered stream inside one body: one heap of pending boxes and pending crossings.
//!
//! The nearest is popped. A box is opened, a leaf answers its crossings, a crossing goes to the sweep. No
//! boundary is given out while a pending box could still begin at or before it. So the cost of a ray grows
//! with what it meets, and whoever wants only the first boundary stops there.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::aabb::BoxRay;
use crate::accel::{Offer, Pending, Work};
use crate::compile::{Leaf, SolidBody};
use crate::crossing::Crossing;
use crate::csg::{Boundary, Event, Sweep};
use crate::ray::{Line, Span};
use crate::solid::Wanted;

/// What the heap holds; ordered so that the nearest is popped first, and boxes before crossings.
#[derive(Clone, Copy, Debug)]
enum Entry {
    Part { t: f64, part: u64 },
    Leaf { t: f64, leaf: u32 },
    Event(Event),
}

impl Entry {
    fn key(&self) -> f64 {
        match self {
            Entry::Part { t, .. } | Entry::Leaf { t, .. } => *t,
            Entry::Event(event) => event.low,
        }
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Entry) -> Ordering {
        let is_box = |e: &Entry| !matches!(e, Entry::Event(_));
        other.key().total_cmp(&self.key()).then(is_box(self).cmp(&is_box(other)))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Entry) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// The memory of one stream; reused from body to body and ray to ray.
#[derive(Debug, Default)]
pub(super) struct StreamScratch {
    heap: BinaryHeap<Entry>,
    sweep: Sweep,
    offers: Vec<Pending>,
    crossings: Vec<Crossing>,
    /// The number of the ray that met a leaf last: a leaf proposed twice is intersected once.
    tags: Vec<u64>,
    ray_number: u64,
}

/// The boundaries of one body along one line, in order, pulled one by one.
pub(super) struct Stream<'a> {
    body: &'a SolidBody,
    line: &'a Line,
    ray: BoxRay,
    wanted: Wanted,
    scratch: &'a mut StreamScratch,
    work: &'a mut Work,
    finished: bool,
}

impl<'a> Stream<'a> {
    /// Begins at the start of a span. With [`Wanted::First`] only the first boundary may be pulled.
    pub(super) fn new(
        body: &'a SolidBody,
        line: &'a Line,
        span: Span,
        wanted: Wanted,
        scratch: &'a mut StreamScratch,
        work: &'a mut Work,
    ) -> Stream<'a> {
        scratch.heap.clear();
        scratch.ray_number += 1;
        if scratch.tags.len() < body.leaves.len() {
            scratch.tags.resize(body.leaves.len(), 0);
        }
        scratch.sweep.begin(&body.program, span);
        let ray = BoxRay::new(line, span);
        let mut stream = Stream { body, line, ray, wanted, scratch, work, finished: false };
        match &body.accel {
            Some(accel) => {
                accel.start(&stream.ray, &mut stream.scratch.offers, stream.work);
                stream.take_offers();
            }
            None => stream.intersect(0, span.t_min()),
        }
        stream
    }

    /// The next boundary.
    pub(super) fn next(&mut self) -> Option<Boundary> {
        let program = &self.body.program;
        loop {
            if let Some(boundary) = self.scratch.sweep.pop() {
                return Some(boundary);
            }
            if self.finished {
                return None;
            }
            let next = self.scratch.heap.peek().map_or(f64::INFINITY, Entry::key);
            if next > self.ray.span().t_max() || self.scratch.heap.is_empty() {
                self.scratch.sweep.finish(program);
                self.finished = true;
                continue;
            }
            self.scratch.sweep.advance(program, next);
            // What was settled comes first: perhaps nothing further is wanted.
            if let Some(boundary) = self.scratch.sweep.pop() {
                return Some(boundary);
            }
            match self.scratch.heap.pop() {
                Some(Entry::Part { part, .. }) => {
                    if let Some(accel) = &self.body.accel {
                        accel.open(part, &self.ray, &mut self.scratch.offers, self.work);
                    }
                    self.take_offers();
                }
                Some(Entry::Leaf { t, leaf }) => self.intersect(leaf, t),
                Some(Entry::Event(event)) => self.scratch.sweep.offer(program, event),
                None => {}
            }
        }
    }

    /// Moves what an accelerator offered to the heap; leaves with the bound of their own box.
    fn take_offers(&mut self) {
        let scratch = &mut *self.scratch;
        for offer in scratch.offers.drain(..) {
            let entry = match offer.what {
                Offer::Part(part) => Entry::Part { t: offer.t, part },
                Offer::Item(leaf) => {
                    let tag = &mut scratch.tags[leaf as usize];
                    if *tag == scratch.ray_number {
                        self.work.tags_saved += 1;
                        continue;
                    }
                    *tag = scratch.ray_number;
                    self.work.boxes += 1;
                    match self.ray.enter_exit(&self.body.leaves[leaf as usize].bounds) {
                        Some((t, _)) => Entry::Leaf { t, leaf },
                        None => continue,
                    }
                }
            };
            self.work.heap_pushes += 1;
            scratch.heap.push(entry);
        }
    }

    /// Intersects a leaf whose bounds are entered at `enter`.
    fn intersect(&mut self, leaf: u32, enter: f64) {
        let scratch = &mut *self.scratch;
        let Leaf { solid, local_from_body, .. } = &self.body.leaves[leaf as usize];
        scratch.crossings.clear();
        self.work.solids += 1;
        let line = self.line.in_frame(local_from_body);
        let wanted = if self.body.leaves.len() == 1 { self.wanted } else { Wanted::All };
        solid.crossings_within(&line, self.ray.span(), wanted, &mut scratch.crossings, self.work);
        for &crossing in &scratch.crossings {
            match Event::new(leaf, crossing, enter) {
                Some(event) => {
                    if crossing.t < f64::INFINITY {
                        scratch.heap.push(Entry::Event(event));
                        self.work.heap_pushes += 1;
                    }
                }
                None => scratch.sweep.preset(&self.body.program, leaf),
            }
        }
    }
}

impl Drop for Stream<'_> {
    fn drop(&mut self) {
        self.scratch.sweep.end(&self.body.program);
    }
}
