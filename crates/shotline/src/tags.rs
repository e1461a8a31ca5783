//! Tags, or mailboxes: an item met in several cells is intersected once per ray (Amanatides and Woo 1987; Arnaldi,
//! Priol and Bouatouch 1987).

/// For each item the number of the ray that met it last. Ray numbers increase, so nothing is cleared between rays.
/// Tags belong to the caller's scratch memory: structures and solids keep no state of a ray.
#[derive(Clone, Debug, Default)]
pub struct Tags {
    met: Vec<u32>,
    ray: u32,
}

impl Tags {
    /// Begins a ray: no item is tagged.
    pub fn begin(&mut self) {
        self.ray = self.ray.wrapping_add(1);
        if self.ray == 0 {
            // The numbers wrap around once in 2^32 rays.
            self.met.fill(0);
            self.ray = 1;
        }
    }

    /// Makes room for items below `count`. Not needed if the structure proposes no item more than once.
    pub fn reserve(&mut self, count: usize) {
        if self.met.len() < count {
            self.met.resize(count, 0);
        }
    }

    /// Tags an item. Returns whether the ray had not met it before; always `true` for an item without room.
    #[inline]
    pub fn is_first(&mut self, item: usize) -> bool {
        self.met.get_mut(item).is_none_or(|met| std::mem::replace(met, self.ray) != self.ray)
    }
}

/// Like [`Tags`], for the items of levels that one ray may visit many times. A hash set, because a visit meets few of
/// the items of its level.
#[derive(Clone, Debug, Default)]
pub struct VisitTags {
    /// Open addressing by linear probing, at most half full; a power of two, or empty.
    slots: Vec<Slot>,
    used: usize,
    ray: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    ray: u32,
    visit: u32,
    item: u32,
}

/// Maximum number of slots kept from ray to ray.
const MAX_KEPT_SLOTS: usize = 1 << 16;

impl VisitTags {
    /// Begins a ray: no item is tagged.
    pub fn begin(&mut self) {
        self.ray = self.ray.wrapping_add(1);
        self.used = 0;
        if self.ray == 0 || self.slots.len() > MAX_KEPT_SLOTS {
            (self.ray, self.slots) = (1, Vec::new());
        }
    }

    /// Tags an item in a visit. Returns whether the ray had not met it before in this visit.
    #[inline]
    pub fn is_first(&mut self, visit: u32, item: u32) -> bool {
        if 2 * self.used >= self.slots.len() {
            self.grow();
        }
        let new = Slot { ray: self.ray, visit, item };
        let index = self.index(new);
        let slot = &mut self.slots[index];
        let is_first = slot.ray != self.ray;
        if is_first {
            *slot = new;
            self.used += 1;
        }
        is_first
    }

    /// The number of slots that are allocated.
    #[cfg(test)]
    pub(crate) fn room(&self) -> usize {
        self.slots.capacity()
    }

    /// The index of the slot in which an item is, or belongs.
    fn index(&self, new: Slot) -> usize {
        let mask = self.slots.len() - 1;
        let key = u64::from(new.visit) << 32 | u64::from(new.item);
        // Fibonacci hashing (Knuth): the high bits are well mixed.
        let mut index = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        loop {
            let slot = &self.slots[index];
            if slot.ray != new.ray || (slot.visit == new.visit && slot.item == new.item) {
                return index;
            }
            index = (index + 1) & mask;
        }
    }

    #[cold]
    fn grow(&mut self) {
        let size = (2 * self.slots.len()).max(64);
        let before = std::mem::replace(&mut self.slots, vec![Slot::default(); size]);
        for slot in before.into_iter().filter(|slot| slot.ray == self.ray) {
            let index = self.index(slot);
            self.slots[index] = slot;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn visits_have_tags_of_their_own() {
        let (mut tags, mut random) =
            (VisitTags { ray: u32::MAX - 2, ..VisitTags::default() }, Random::new(1));
        for most in [10, 300, 50_000, 300, 10, 10] {
            tags.begin();
            let mut met = HashSet::new();
            for _ in 0..most {
                let [visit, item] = [20, most].map(|n| random.below(n) as u32);
                assert_eq!(tags.is_first(visit, item), met.insert((visit, item)));
            }
        }
        tags.begin();
        assert!(tags.slots.len() <= MAX_KEPT_SLOTS);
    }

    #[test]
    fn once_a_ray_also_where_numbers_begin_again() {
        let mut tags = Tags { ray: u32::MAX - 2, ..Tags::default() };
        tags.reserve(2);
        for _ in 0..5 {
            tags.begin();
            assert!(tags.is_first(1));
            assert!(!tags.is_first(1));
            assert!(tags.is_first(0));
            assert!(tags.is_first(2) && tags.is_first(2));
        }
    }
}
