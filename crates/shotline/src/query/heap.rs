//! The heap of pending entries along a ray. The nearest entry is popped first; among entries at the same `t`, the
//! last one pushed. So coincident boxes are traversed depth first, and the heap does not grow with their number.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Which entry is popped first among those at the same `t`: the one of the higher rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// Crossings wait until every box that may begin at their `t` has been opened.
    Crossing,
    Box,
}

#[derive(Clone, Copy, Debug)]
struct Slot<T> {
    /// Increases with `t`, in the order of [`f64::total_cmp`]: -0 comes before 0.
    key: i64,
    /// The rank in the high bits and the number of the push in the low bits. Among equal keys the highest tie is
    /// popped first.
    tie: u64,
    what: T,
}

/// Maps the bits of a `t` to its key, and a key back to the bits of its `t`.
fn key(bits: i64) -> i64 {
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

impl<T> Slot<T> {
    fn t(&self) -> f64 {
        f64::from_bits(key(self.key) as u64)
    }

    #[inline]
    fn is_before(&self, other: &Slot<T>) -> bool {
        self.key < other.key || (self.key == other.key && self.tie > other.tie)
    }
}

impl<T> Ord for Slot<T> {
    /// The greatest is popped first.
    fn cmp(&self, other: &Slot<T>) -> Ordering {
        other.key.cmp(&self.key).then(self.tie.cmp(&other.tie))
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

/// Number of entries that are kept sorted: most rays never have more pending, and most new entries are near.
const SORTED: usize = 24;

/// A heap of pending entries; reused from ray to ray.
#[derive(Debug)]
pub(super) struct Heap<T> {
    /// The nearest entries, nearest last.
    near: Vec<Slot<T>>,
    /// All other entries; none comes before an entry in `near`.
    far: BinaryHeap<Slot<T>>,
    pushed: u32,
}

impl<T> Default for Heap<T> {
    fn default() -> Heap<T> {
        Heap { near: Vec::with_capacity(SORTED), far: BinaryHeap::new(), pushed: 0 }
    }
}

impl<T: Copy> Heap<T> {
    pub(super) fn clear(&mut self) {
        self.near.clear();
        self.far.clear();
        self.pushed = 0;
    }

    pub(super) fn len(&self) -> usize {
        self.near.len() + self.far.len()
    }

    #[inline]
    pub(super) fn push(&mut self, t: f64, rank: Rank, what: T) {
        // After 2^32 pushes this wraps: only the order among entries at the same `t` is lost.
        self.pushed = self.pushed.wrapping_add(1);
        let tie = u64::from(rank == Rank::Box) << 32 | u64::from(self.pushed);
        let slot = Slot { key: key(t.to_bits() as i64), tie, what };
        if self.near.len() < SORTED && self.far.is_empty() {
            self.insert(slot);
        } else {
            self.push_far(slot);
        }
    }

    /// Inserts an entry at its position in `near`.
    #[inline]
    fn insert(&mut self, slot: Slot<T>) {
        self.near.push(slot);
        let mut index = self.near.len() - 1;
        while index > 0 && self.near[index - 1].is_before(&slot) {
            self.near[index] = self.near[index - 1];
            index -= 1;
        }
        self.near[index] = slot;
    }

    #[cold]
    fn push_far(&mut self, slot: Slot<T>) {
        let is_behind = |near: &[Slot<T>]| near.first().is_none_or(|last| last.is_before(&slot));
        if !is_behind(&self.near) && self.near.len() == SORTED {
            self.far.extend(self.near.drain(..SORTED / 2));
        }
        // The entry may belong among those that have just been moved to `far`.
        if is_behind(&self.near) {
            self.far.push(slot);
        } else {
            self.insert(slot);
        }
    }

    /// The `t` of the nearest entry.
    #[inline]
    pub(super) fn nearest(&self) -> Option<f64> {
        self.near.last().or_else(|| self.far.peek()).map(Slot::t)
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<(f64, T)> {
        self.near.pop().or_else(|| self.far.pop()).map(|slot| (slot.t(), slot.what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

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

    /// The new entry belongs among the entries that are moved out of `near` to make room for it.
    #[test]
    fn an_entry_behind_the_nearest_half_waits_for_those_before_it() {
        let mut random = Random::new(8);
        for count in [SORTED, SORTED + 1, 2 * SORTED, 300] {
            let mut heap = Heap::default();
            let mut all: Vec<f64> = (0..count).map(|_| random.number(0.0, 9.0)).collect();
            all.iter().for_each(|t| heap.push(*t, Rank::Box, ()));
            all.sort_by(f64::total_cmp);
            let popped: Vec<f64> = std::iter::from_fn(|| heap.pop()).map(|(t, ())| t).collect();
            assert_eq!(popped, all);
        }
    }

    #[test]
    fn many_entries_come_in_the_same_order_as_few() {
        let mut random = Random::new(7);
        for most in [3, SORTED, 2 * SORTED, 500] {
            let (mut heap, mut plain) = (Heap::default(), Vec::new());
            for number in 0..4 * most as u64 {
                // Few different `t`, so that many are equal; both zeros, and infinities.
                let t = [-0.0, 0.0, f64::INFINITY, -1.0, 1e300, 0.5, random.number(0.0, 9.0), 4.0]
                    [random.below(8)];
                let rank = if random.below(2) == 0 { Rank::Box } else { Rank::Crossing };
                heap.push(t, rank, number);
                plain.push((t, rank, number));
                if plain.len() == most || random.below(3) == 0 {
                    let order = |a: &(f64, Rank, u64), b: &(f64, Rank, u64)| {
                        b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2))
                    };
                    let best = (0..plain.len()).max_by(|&a, &b| order(&plain[a], &plain[b]));
                    let (t, _, number) = plain.swap_remove(best.unwrap());
                    assert_eq!(heap.nearest().map(f64::to_bits), Some(t.to_bits()));
                    assert_eq!(
                        heap.pop().map(|(t, number)| (t.to_bits(), number)),
                        Some((t.to_bits(), number))
                    );
                }
                assert_eq!(heap.len(), plain.len());
            }
        }
    }
}
