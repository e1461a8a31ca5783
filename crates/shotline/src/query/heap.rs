//! The heap of what is pending along a ray: nearest first, and of what begins at one `t` the last first. So where boxes
//! lie in one place the order is depth first, and the heap does not grow with their number.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What is popped first among entries at the same `t`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// Crossings wait until every box that may begin at their `t` is open.
    Crossing,
    Box,
}

#[derive(Clone, Copy, Debug)]
struct Slot<T> {
    t: f64,
    rank: Rank,
    /// Ascends from push to push.
    order: u32,
    what: T,
}

impl<T> Ord for Slot<T> {
    fn cmp(&self, other: &Slot<T>) -> Ordering {
        other.t.total_cmp(&self.t).then(self.rank.cmp(&other.rank)).then(self.order.cmp(&other.order))
    }
}

impl<T> PartialOrd for Slot<T> {
    fn partial_cmp(&self, other: &Slot<T>) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Slot<T> {
    fn eq(&self, other: &Slot<T>) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Slot<T> {}

/// A heap of pending entries; reused from ray to ray.
#[derive(Debug)]
pub(super) struct Heap<T> {
    slots: BinaryHeap<Slot<T>>,
    pushed: u32,
}

impl<T> Default for Heap<T> {
    fn default() -> Heap<T> {
        Heap { slots: BinaryHeap::new(), pushed: 0 }
    }
}

impl<T> Heap<T> {
    pub(super) fn clear(&mut self) {
        self.slots.clear();
        self.pushed = 0;
    }

    pub(super) fn len(&self) -> usize {
        self.slots.len()
    }

    pub(super) fn push(&mut self, t: f64, rank: Rank, what: T) {
        // Beyond 2^32 only the order among equals is lost.
        self.pushed = self.pushed.wrapping_add(1);
        self.slots.push(Slot { t, rank, order: self.pushed, what });
    }

    /// The `t` of the nearest entry.
    pub(super) fn nearest(&self) -> Option<f64> {
        self.slots.peek().map(|slot| slot.t)
    }

    pub(super) fn pop(&mut self) -> Option<(f64, T)> {
        self.slots.pop().map(|slot| (slot.t, slot.what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_first_and_boxes_before_crossings() {
        let mut heap = Heap::default();
        heap.push(2.0, Rank::Box, 'd');
        heap.push(2.0, Rank::Box, 'c');
        heap.push(1.0, Rank::Crossing, 'b');
        heap.push(1.0, Rank::Box, 'a');
        assert_eq!(heap.nearest(), Some(1.0));
        let order: String = std::iter::from_fn(|| heap.pop()).map(|(_, name)| name).collect();
        assert_eq!(order, "abcd");
    }
}
