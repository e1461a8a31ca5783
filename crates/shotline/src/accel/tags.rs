//! Tags, or mailboxes: an item met in several cells is intersected once a ray (Amanatides and Woo 1987;
//! Arnaldi, Priol and Bouatouch 1987).

/// For each item the number of the ray that met it last. Rays are counted up, so nothing is cleared between
/// them. Part of the caller's scratch: structures and solids keep no state of a ray.
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
            // Once in 2^32 rays the numbers begin again.
            self.met.fill(0);
            self.ray = 1;
        }
    }

    /// Makes room for items below `count`: not needed where no structure repeats them.
    pub fn reserve(&mut self, count: usize) {
        if self.met.len() < count {
            self.met.resize(count, 0);
        }
    }

    /// Tags an item, and answers whether this is its first time on this ray. Where there is no room for it
    /// every time is the first.
    #[inline]
    pub fn is_first(&mut self, item: usize) -> bool {
        self.met.get_mut(item).is_none_or(|met| std::mem::replace(met, self.ray) != self.ray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
