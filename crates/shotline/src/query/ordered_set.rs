//! A set of small numbers that knows its order: a tree of bits, in which each bit of a word says whether a word of the level
//! below has any bit. Every operation looks at one word of each of `log64 n` levels.

/// A set of numbers below a bound.
#[derive(Debug, Default)]
pub(super) struct OrderedSet {
    /// The members first, then each level above; the last in use has one word.
    levels: Vec<Vec<u64>>,
    /// How many levels are in use.
    height: usize,
}

const BITS: usize = 64;

impl OrderedSet {
    /// Empties the set, and makes room for the numbers below `bound`. Memory is reused.
    pub fn begin(&mut self, bound: usize) {
        let mut words = bound;
        for level in 0.. {
            words = words.div_ceil(BITS);
            if self.levels.len() == level {
                self.levels.push(Vec::new());
            }
            self.levels[level].clear();
            self.levels[level].resize(words, 0);
            if words <= 1 {
                self.height = level + 1;
                return;
            }
        }
    }

    /// Adds a number; tells whether it is new.
    pub fn insert(&mut self, number: u32) -> bool {
        let mut at = number as usize;
        for (level, words) in self.levels[..self.height].iter_mut().enumerate() {
            let (word, bit) = (&mut words[at / BITS], 1 << (at % BITS));
            let was_empty = *word == 0;
            if level == 0 && *word & bit != 0 {
                return false;
            }
            *word |= bit;
            if !was_empty {
                return true;
            }
            at /= BITS;
        }
        true
    }

    /// Removes a number; tells whether it was there.
    pub fn remove(&mut self, number: u32) -> bool {
        let mut at = number as usize;
        for (level, words) in self.levels[..self.height].iter_mut().enumerate() {
            let (word, bit) = (&mut words[at / BITS], 1 << (at % BITS));
            if level == 0 && *word & bit == 0 {
                return false;
            }
            *word &= !bit;
            if *word != 0 {
                return true;
            }
            at /= BITS;
        }
        true
    }

    /// Whether a number is in the set.
    pub fn contains(&self, number: u32) -> bool {
        let at = number as usize;
        self.levels[0][at / BITS] >> (at % BITS) & 1 != 0
    }

    /// The largest number.
    pub fn last(&self) -> Option<u32> {
        let top = self.height.checked_sub(1)?;
        let word = *self.levels[top].first()?;
        (word != 0).then(|| self.descend(top, highest(word), highest))
    }

    /// The largest number below another.
    pub fn below(&self, number: u32) -> Option<u32> {
        let mut at = number as usize;
        for (level, words) in self.levels[..self.height].iter().enumerate() {
            let lower = words[at / BITS] & !(u64::MAX << (at % BITS));
            if lower != 0 {
                return Some(self.descend(level, at / BITS * BITS + highest(lower), highest));
            }
            at /= BITS;
        }
        None
    }

    /// The smallest number above another.
    pub fn above(&self, number: u32) -> Option<u32> {
        let mut at = number as usize;
        for (level, words) in self.levels[..self.height].iter().enumerate() {
            let higher = words[at / BITS] & (u64::MAX << (at % BITS) << 1);
            if higher != 0 {
                return Some(self.descend(level, at / BITS * BITS + lowest(higher), lowest));
            }
            at /= BITS;
        }
        None
    }

    /// The smallest number from another on.
    pub fn at_or_above(&self, number: u32) -> Option<u32> {
        if self.contains(number) { Some(number) } else { self.above(number) }
    }

    /// The member below a bit of a level, by the highest or the lowest bit of each word.
    fn descend(&self, level: usize, bit: usize, choose: fn(u64) -> usize) -> u32 {
        let below = self.levels[..level].iter().rev();
        below.fold(bit, |at, words| at * BITS + choose(words[at])) as u32
    }
}

fn highest(word: u64) -> usize {
    BITS - 1 - word.leading_zeros() as usize
}

fn lowest(word: u64) -> usize {
    word.trailing_zeros() as usize
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn it_agrees_with_a_tree_of_the_standard_library() {
        let mut random = Random::new(7);
        let mut set = OrderedSet::default();
        for bound in [1, 2, 63, 64, 65, 4096, 4097, 300_000] {
            set.begin(bound);
            let mut expected = BTreeSet::new();
            for _ in 0..3000 {
                let number = match random.below(3) {
                    0 => random.below(bound),
                    1 => random.below(bound.min(70)),
                    _ => bound - 1 - random.below(bound.min(70)),
                } as u32;
                match random.below(2) {
                    0 => assert_eq!(set.insert(number), expected.insert(number)),
                    _ => assert_eq!(set.remove(number), expected.remove(&number)),
                }
                let other = random.below(bound) as u32;
                assert_eq!(set.contains(other), expected.contains(&other));
                assert_eq!(set.last(), expected.last().copied());
                assert_eq!(set.below(other), expected.range(..other).next_back().copied());
                assert_eq!(set.above(other), expected.range(other + 1..).next().copied());
                assert_eq!(set.at_or_above(other), expected.range(other..).next().copied());
            }
        }
        set.begin(0);
        assert_eq!(set.last(), None);
    }
}
