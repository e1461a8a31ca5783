//! The ordered stream of boundaries of one body, from one heap of pending boxes and pending crossings.
//!
//! The stream pops the nearest entry: it opens a box, intersects a leaf, or passes a crossing to the sweep. No
//! boundary is returned while a pending box could still begin at or before it. So the cost of a ray grows with what
//! it hits, and a query that only needs the first boundary stops there.

use std::ops::Range;

use super::heap::{Heap, Rank};
use super::repair::repair;
use super::traversal::pushed_node;
use crate::aabb::BoxRay;
use crate::accel::{Child, QueueEntry};
use crate::compile::{Leaf, SolidBody};
use crate::contact::Contact;
use crate::crossing::Crossing;
use crate::csg::{Boundary, Event, EventKind, OrderExchange, SingleLeaf, Sweep};
use crate::outline::Outline;
use crate::ray::{Line, Span};
use crate::scratch::Scratch;
use crate::solid::Wanted;
use crate::tags::Tags;
use crate::trace::{Act, Log};

/// An entry of the heap.
#[derive(Clone, Copy, Debug)]
pub(super) enum Entry {
    /// A node of the accelerator.
    Node(u64),
    /// A leaf, at the `t` at which its own box begins.
    Leaf(u32),
    /// An event, by its index among this ray's events: entries are moved often and should be small.
    Event(u32),
}

/// Crossings of leaves of the next body to be streamed, which were computed before: of any ray that waits for it.
#[derive(Debug, Default)]
pub(super) struct OperandLists {
    pub crossings: Vec<Crossing>,
    /// The leaves with lists, each with the range of its list.
    pub leaves: Vec<(u32, Range<usize>)>,
}

impl OperandLists {
    fn list(&self, leaf: u32) -> Option<&[Crossing]> {
        let (_, range) = self.leaves.iter().find(|(of, _)| *of == leaf)?;
        Some(&self.crossings[range.clone()])
    }
}

/// The memory of one stream; reused from body to body and ray to ray.
#[derive(Debug, Default)]
pub(super) struct StreamScratch {
    pub(super) heap: Heap<Entry>,
    pub(super) events: Vec<Event>,
    pub(super) sweep: Sweep,
    pub(super) children: Vec<QueueEntry>,
    crossings: Vec<Crossing>,
    contacts: Vec<Contact>,
    /// The crossings of leaves that were computed before.
    pub(super) operands: OperandLists,
    /// Tags of leaves. The tags of triangles are in the scratch memory of the solids.
    tags: Tags,
}

/// The boundaries of one body along one line, in order, computed on demand.
pub(super) struct Stream<'a, 'c> {
    pub(super) body: &'a SolidBody,
    pub(super) line: &'a Line,
    span: Span,
    /// The line for box tests; `None` for a body of one leaf, which is intersected without a box test.
    pub(super) ray: Option<BoxRay>,
    /// Set where the body is a single leaf whose boundaries need no sweep.
    single: Option<SingleLeaf>,
    /// Where the line leaves the boxes of all leaves; infinite if that is not known.
    pub(super) exit: f64,
    wanted: Wanted,
    pub(super) scratch: &'a mut StreamScratch,
    /// The scratch memory of the solids, with the counters, the log and the budget of the ray.
    pub(super) below: &'a mut Scratch<'c>,
    pub(super) finished: bool,
}

impl<'a, 'c> Stream<'a, 'c> {
    /// Begins a stream at the start of a span. With [`Wanted::First`] the caller may only request the first boundary.
    pub(super) fn new(
        body: &'a SolidBody,
        line: &'a Line,
        span: Span,
        wanted: Wanted,
        scratch: &'a mut StreamScratch,
        below: &'a mut Scratch<'c>,
    ) -> Stream<'a, 'c> {
        scratch.heap.clear();
        scratch.events.clear();
        scratch.tags.begin();
        scratch.sweep.begin(&body.program, span);
        let mut stream = Stream {
            body,
            line,
            span,
            ray: None,
            single: None,
            exit: f64::INFINITY,
            wanted,
            scratch,
            below,
            finished: false,
        };
        match &body.accel {
            Some(accel) => {
                if accel.has_duplicate_refs() {
                    stream.scratch.tags.reserve(body.leaves.len());
                }
                let ray = stream.ray.insert(BoxRay::new(line, span));
                accel.roots(ray, &mut stream.scratch.children, &mut stream.below.counters);
                stream.push_children(1);
            }
            None if body.leaves.len() == 1 => stream.open_leaf(0, span.t_min()),
            None => {
                stream.ray = Some(BoxRay::new(line, span));
                stream.begin_small_body();
            }
        }
        stream
    }

    /// Returns the next boundary. Also returns `None` when the budget of the ray has ended.
    pub(super) fn next(&mut self) -> Option<Boundary> {
        if let Some(single) = &mut self.single {
            return single.next(&self.scratch.crossings);
        }
        let program = &self.body.program;
        loop {
            if let Some(boundary) = self.scratch.sweep.pop() {
                return Some(boundary);
            }
            if self.finished {
                return None;
            }
            let Some(next) = self.scratch.heap.nearest().filter(|&t| t <= self.span.t_max()) else {
                self.scratch.sweep.finish(program);
                self.finished = true;
                continue;
            };
            self.scratch.sweep.advance(program, next);
            // Return what is certain by now first: the caller may not need more.
            if let Some(boundary) = self.scratch.sweep.pop() {
                return Some(boundary);
            }
            if next > self.exit && self.scratch.sweep.is_outside(program) {
                // No leaf can matter any more.
                self.finished = true;
                return None;
            }
            if !self.below.budget.step() {
                self.finished = true;
                return None;
            }
            match self.scratch.heap.pop() {
                Some((t, Entry::Node(node))) => {
                    if let (Some(accel), Some(ray)) = (&self.body.accel, &self.ray) {
                        self.below.log.add_with_outline(1, Some(t), || {
                            (Act::Expand { node: accel.describe(node, ray) }, accel.outline(node, ray))
                        });
                        accel.expand(node, t, ray, &mut self.scratch.children, &mut self.below.counters);
                        self.push_children(2);
                    }
                }
                Some((t, Entry::Leaf(leaf))) => self.open_leaf(leaf, t),
                Some((_, Entry::Event(event))) => {
                    let event = self.scratch.events[event as usize];
                    let Event { leaf, crossing, .. } = event;
                    self.below.log.add(1, Some(crossing.t), || Act::Toggle {
                        item: self.body.leaf_name(leaf as usize),
                        crossing,
                    });
                    self.scratch.sweep.push(program, event);
                }
                None => {}
            }
        }
    }

    pub(super) fn log(&mut self) -> &mut Log {
        &mut self.below.log
    }

    /// Moves the children that an accelerator returned to the heap; leaves at the `t` at which their own box begins.
    /// The log shows them `deeper` levels below the body.
    fn push_children(&mut self, deeper: usize) {
        let Some(ray) = &self.ray else { return };
        let scratch = &mut *self.scratch;
        let Scratch { counters, log, .. } = &mut *self.below;
        for child in scratch.children.drain(..) {
            let (t, entry) = match child.child {
                Child::Node(node) => {
                    log.add_with_outline(deeper, Some(child.t), || {
                        pushed_node(self.body.accel.as_deref(), node, ray)
                    });
                    (child.t, Entry::Node(node))
                }
                Child::Entered(leaf) => {
                    let bounds = &self.body.leaves[leaf as usize].bounds;
                    debug_assert_eq!(ray.enter_exit(bounds).map(|(t, _)| t), Some(child.t));
                    log.add_with_outline(deeper, Some(child.t), || {
                        let item = self.body.leaf_name(leaf as usize);
                        (Act::PushItem { item }, Some(Outline::Box(*bounds)))
                    });
                    (child.t, Entry::Leaf(leaf))
                }
                Child::Item(leaf) => {
                    let name = || self.body.leaf_name(leaf as usize);
                    let outline = || Some(Outline::Box(self.body.leaves[leaf as usize].bounds));
                    if !scratch.tags.is_first(leaf as usize) {
                        counters.tags_saved += 1;
                        log.add(deeper, None, || Act::Saved { item: name() });
                        continue;
                    }
                    counters.boxes += 1;
                    let Some((t, _)) = ray.enter_exit(&self.body.leaves[leaf as usize].bounds) else {
                        log.add_with_outline(deeper, None, || (Act::Miss { item: name() }, outline()));
                        continue;
                    };
                    log.add_with_outline(deeper, Some(t), || (Act::PushItem { item: name() }, outline()));
                    (t, Entry::Leaf(leaf))
                }
            };
            counters.heap_pushes += 1;
            scratch.heap.push(t, Rank::Box, entry);
        }
    }

    /// Intersects a leaf whose bounds are entered at `enter`.
    fn open_leaf(&mut self, leaf: u32, enter: f64) {
        let line = self.line.in_frame(&self.body.leaves[leaf as usize].local_from_body);
        self.intersect(leaf, &line, enter);
    }

    /// Intersects a leaf, given the line in its frame.
    pub(super) fn intersect(&mut self, leaf: u32, line: &Line, enter: f64) {
        let scratch = &mut *self.scratch;
        let Leaf { solid, .. } = &self.body.leaves[leaf as usize];
        scratch.crossings.clear();
        self.below.in_plane.clear();
        self.below.counters.primitive_tests += 1;
        let name = || self.body.leaf_name(leaf as usize);
        let t = (self.body.leaves.len() > 1).then_some(enter);
        self.below.log.add(1, t, || Act::Test { item: name() });
        let wanted = if self.body.leaves.len() == 1 { self.wanted } else { Wanted::All };
        match scratch.operands.list(leaf) {
            Some(list) => scratch.crossings.extend_from_slice(list),
            None => solid.crossings_within(line, self.span, wanted, &mut scratch.crossings, self.below),
        }
        self.below.counters.repaired += u64::from(repair(&**solid, line, &mut scratch.crossings));
        self.below.log.add(1, None, || Act::Found { crossings: scratch.crossings.clone() });
        let is_lone = self.body.leaves.len() == 1;
        if is_lone && self.body.accel.is_none() && !self.below.log.is_on() {
            self.single = SingleLeaf::begin(&self.scratch.crossings, self.span);
            if self.single.is_some() {
                return;
            }
        }
        let is_missed = self.scratch.crossings.is_empty();
        let perhaps_touched = is_missed || !self.below.in_plane.is_empty();
        if perhaps_touched && !is_lone && self.add_contact(leaf, line, enter) {
            return;
        }
        if is_missed && !is_lone && self.body.program.needs(leaf) {
            // The result is empty: it needs this leaf, and the ray misses it.
            self.finished = true;
        }
        for i in 0..self.scratch.crossings.len() {
            self.take(leaf, EventKind::Membership, self.scratch.crossings[i], enter);
        }
    }

    /// Pushes a crossing of a leaf onto the heap, or applies it to the sweep if it lies before the leaf's bounds.
    fn take(&mut self, leaf: u32, kind: EventKind, crossing: Crossing, enter: f64) {
        let scratch = &mut *self.scratch;
        match Event::new(leaf, kind, crossing, enter) {
            Some(event) => {
                if crossing.t < f64::INFINITY {
                    let entry = Entry::Event(scratch.events.len() as u32);
                    scratch.heap.push(event.low, Rank::Crossing, entry);
                    scratch.events.push(event);
                    self.below.counters.heap_pushes += 1;
                }
            }
            None => {
                let name = || self.body.leaf_name(leaf as usize);
                self.below.log.add(2, Some(crossing.t), || Act::Before { item: name(), crossing });
                scratch.sweep.apply(&self.body.program, leaf, kind);
            }
        }
    }

    /// Adds the intervals on which the line lies in the surface of a leaf; returns whether there are any.
    fn add_contact(&mut self, leaf: u32, line: &Line, enter: f64) -> bool {
        let Leaf { solid, local_from_body, .. } = &self.body.leaves[leaf as usize];
        let mut contacts = std::mem::take(&mut self.scratch.contacts);
        contacts.clear();
        solid.contacts(line, &mut contacts, self.below);
        let mut order_exchanges = Vec::new();
        for contact in &contacts {
            let contact = Contact { sector: contact.sector.in_frame(local_from_body), ..*contact };
            let kind =
                self.scratch.sweep.add_contact(leaf, &contact, self.line.d, enter, &mut order_exchanges);
            self.take(leaf, kind, contact.enter, enter);
            self.take(leaf, kind, contact.exit, enter);
        }
        for OrderExchange { leaf, crossing, enter } in order_exchanges {
            self.take(leaf, EventKind::OrderExchange, crossing, enter);
        }
        let touched = !contacts.is_empty();
        self.scratch.contacts = contacts;
        touched
    }
}

impl Drop for Stream<'_, '_> {
    fn drop(&mut self) {
        self.scratch.sweep.end(&self.body.program);
    }
}
