//! The special case of the stream for bodies of few leaves: it uses no accelerator, and does not intersect leaves
//! that the line runs deep inside.

use super::heap::Rank;
use super::stream::{Entry, Stream};
use crate::aabb::Aabb;
use crate::accel::{Child, QueueEntry};
use crate::compile::Leaf;
use crate::csg::EventKind;
use crate::trace::Act;

impl Stream<'_, '_> {
    /// Tests the boxes of all leaves of a body without an accelerator. The leaves whose boxes begin first are
    /// intersected at once, and the others are pushed onto the heap. If the ray misses a leaf that the result needs,
    /// the stream ends.
    pub(super) fn begin_small_body(&mut self) {
        let Some(ray) = &self.ray else { return };
        let leaves = &self.body.leaves;
        let mut last: Option<(&Aabb, Option<(f64, f64)>)> = None;
        let (mut first, mut exit) = (f64::INFINITY, f64::NEG_INFINITY);
        for (leaf, Leaf { bounds, .. }) in (0..).zip(leaves) {
            // The operands of an intersection often have the same box.
            let met = match last {
                Some((same, met)) if same == bounds => met,
                _ => {
                    self.below.counters.boxes += 1;
                    ray.enter_exit(bounds).filter(|_| !bounds.is_empty())
                }
            };
            last = Some((bounds, met));
            let name = || Act::PushItem { item: self.body.leaf_name(leaf as usize) };
            if let Some((t, end)) = met {
                self.below.log.add(1, Some(t), name);
                (first, exit) = (first.min(t), exit.max(end));
                self.scratch.children.push(QueueEntry { t, child: Child::Item(leaf) });
            } else {
                self.below.log.add(1, None, || Act::Miss { item: self.body.leaf_name(leaf as usize) });
                self.finished |= self.body.program.needs(leaf);
            }
        }
        self.exit = exit;
        if self.finished {
            self.scratch.children.clear();
            return;
        }
        let (mut now, mut are_all) = (0, true);
        while let Some(child) = self.scratch.children.pop() {
            let Child::Item(leaf) = child.child else { continue };
            if child.t > first {
                are_all = false;
                self.below.counters.heap_pushes += 1;
                self.scratch.heap.push(child.t, Rank::Box, Entry::Leaf(leaf));
            } else {
                now |= 1 << leaf;
            }
        }
        self.intersect_first(now, first, are_all);
    }

    /// Intersects a set of leaves whose boxes are entered first, at the same `t`. `are_all`: the ray hits no other
    /// box. Then a leaf is not intersected if the line stays clearly inside it up to the last `t` at which another
    /// leaf can matter, because it has no event up to there.
    fn intersect_first(&mut self, leaves: u32, enter: f64, are_all: bool) {
        let all = &self.body.leaves;
        let mut clear = 0;
        let each = |set: u32| (0..all.len() as u32).filter(move |leaf| set >> leaf & 1 == 1);
        for leaf in each(leaves) {
            let Leaf { solid, local_from_body, .. } = &all[leaf as usize];
            let line = self.line.in_frame(local_from_body);
            if are_all && !self.below.log.is_on() && solid.is_clear_of_surface(&line, enter, self.exit) {
                clear |= 1 << leaf;
            } else {
                self.intersect(leaf, &line, enter);
            }
            if self.finished {
                return;
            }
        }
        if clear == 0 {
            return;
        }
        // An event that begins before the exit may end after it.
        let (exit, events) = (self.exit, &self.scratch.events);
        let reach = events.iter().filter(|e| e.low <= exit).fold(exit, |reach, e| reach.max(e.high()));
        let is_last = !events.iter().any(|e| e.low > exit && e.low <= reach);
        for leaf in each(clear) {
            let Leaf { solid, local_from_body, .. } = &all[leaf as usize];
            let line = self.line.in_frame(local_from_body);
            if is_last && (reach <= exit || solid.is_clear_of_surface(&line, enter, reach)) {
                self.scratch.sweep.apply(&self.body.program, leaf, EventKind::Membership);
            } else if !self.finished {
                self.intersect(leaf, &line, enter);
            }
        }
    }
}
