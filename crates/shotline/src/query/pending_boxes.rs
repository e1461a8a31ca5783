//! The pending boxes of one ray of many that search together.

use crate::accel::Child;

/// The pending boxes of a search, in no order: few of them are ever opened, and a CPU finds the nearest of a few faster than
/// it sorts them, since it cannot predict where each belongs.
#[derive(Debug, Default)]
pub(super) struct PendingBoxes {
    keys: Vec<i64>,
    boxes: Vec<(f64, Child)>,
}

impl PendingBoxes {
    pub fn clear(&mut self) {
        self.keys.clear();
        self.boxes.clear();
    }

    #[inline]
    pub fn push(&mut self, t: f64, child: Child) {
        self.keys.push(ordered(t));
        self.boxes.push((t, child));
    }

    pub fn len(&self) -> usize {
        self.boxes.len()
    }

    /// Removes the nearest box: of those at the same `t` the one that was added last, so that the search goes depth first
    /// there.
    #[inline]
    pub fn pop_nearest(&mut self) -> Option<(f64, Child)> {
        let (mut nearest, mut at) = (i64::MAX, 0);
        for (i, &key) in self.keys.iter().enumerate() {
            let is_nearer = key <= nearest;
            nearest = if is_nearer { key } else { nearest };
            at = if is_nearer { i } else { at };
        }
        if self.keys.is_empty() {
            return None;
        }
        self.keys.swap_remove(at);
        Some(self.boxes.swap_remove(at))
    }

    /// Removes the box that was added last.
    #[inline]
    pub fn pop_last(&mut self) -> Option<(f64, Child)> {
        self.keys.pop();
        self.boxes.pop()
    }
}

/// An integer that increases with a number that is not NaN.
#[inline]
fn ordered(t: f64) -> i64 {
    let bits = t.to_bits() as i64;
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn the_nearest_box_comes_first_and_the_last_one_of_equals() {
        let mut random = Random::new(83);
        for _ in 0..200 {
            let mut pending = PendingBoxes::default();
            let mut expected = Vec::new();
            for number in 0..1 + random.below(20) as u32 {
                let t = [0.0, -2.5, 1e-300, f64::from(random.below(4) as u32), random.number(-3.0, 3.0)];
                let t = t[random.below(5)];
                pending.push(t, Child::Entered(number));
                expected.push(t);
            }
            expected.sort_by(f64::total_cmp);
            for t in expected {
                assert_eq!(pending.pop_nearest().map(|(t, _)| t), Some(t));
            }
            assert_eq!(pending.pop_nearest(), None);
        }
        let mut pending = PendingBoxes::default();
        (0..3).for_each(|number| pending.push(1.0, Child::Entered(number)));
        assert_eq!(pending.pop_nearest(), Some((1.0, Child::Entered(2))));
    }
}
