//! The bodies that a ray of a bundle has been offered.

/// A body whose box the ray enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offer {
    /// Where it enters it.
    pub enter: f64,
    /// The visit of the level in which the body is placed.
    pub visit: u32,
    pub placement: u32,
}

/// The most offers that a ray has.
const MOST: usize = 4;

/// The offers of a ray, nearest last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Offers {
    enter: [f64; MOST],
    bodies: [(u32, u32); MOST],
    count: usize,
}

impl Offers {
    /// Removes all offers.
    #[inline]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds an offer. There must be room.
    #[inline]
    pub fn add(&mut self, offer: Offer) {
        let mut index = self.count;
        self.count += 1;
        while index > 0 && self.enter[index - 1] < offer.enter {
            self.enter[index] = self.enter[index - 1];
            self.bodies[index] = self.bodies[index - 1];
            index -= 1;
        }
        self.enter[index] = offer.enter;
        self.bodies[index] = (offer.visit, offer.placement);
    }

    /// Whether there is no room.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count == MOST
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Removes the nearest offer.
    #[inline]
    pub fn take(&mut self) -> Option<Offer> {
        self.count = self.count.checked_sub(1)?;
        let (visit, placement) = self.bodies[self.count];
        Some(Offer { enter: self.enter[self.count], visit, placement })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn the_nearest_is_taken_first() {
        let mut random = Random::new(5);
        let mut offers = Offers::default();
        for count in [0, 1, 2, 3, MOST, MOST, MOST] {
            let mut all: Vec<f64> = (0..count).map(|_| random.below(5) as f64).collect();
            for (number, &enter) in all.iter().enumerate() {
                assert!(!offers.is_full());
                offers.add(Offer { enter, visit: number as u32, placement: enter as u32 });
            }
            assert_eq!(offers.is_full(), count == MOST);
            all.sort_by(f64::total_cmp);
            let taken: Vec<f64> = std::iter::from_fn(|| offers.take())
                .map(|offer| {
                    assert_eq!(offer.placement, offer.enter as u32);
                    offer.enter
                })
                .collect();
            assert_eq!(taken, all);
        }
    }
}
