//! Partitions items without branches that depend on the data (Edelkamp and Weiss 2016, "BlockQuicksort: How branch
//! mispredictions don't affect quicksort").

use super::bounds::{Extent, ItemBox};

/// So many items of each end are classified before any are swapped.
const BLOCK: usize = 16;

/// Moves the items that go right behind the others; returns the number of the others, and the extents of both sides.
#[inline(always)]
pub(super) fn partition(
    items: &mut [ItemBox],
    goes_right: impl Fn(&ItemBox) -> bool,
) -> (usize, [Extent; 2]) {
    let (mut left, mut right) = (0, items.len());
    let [mut left_extent, mut right_extent] = [Extent::EMPTY; 2];
    let (mut of_left, mut of_right) = (Misplaced::default(), Misplaced::default());
    while right - left > 2 * BLOCK {
        if of_left.is_empty() {
            of_left.fill(|i| goes_right(&items[left + i]));
        }
        if of_right.is_empty() {
            of_right.fill(|i| !goes_right(&items[right - 1 - i]));
        }
        for _ in 0..of_left.len().min(of_right.len()) {
            items.swap(left + of_left.next(), right - 1 - of_right.next());
        }
        // A block that is done is still in the cache.
        if of_left.is_empty() {
            left_extent = left_extent.with_all(&items[left..left + BLOCK]);
            left += BLOCK;
        }
        if of_right.is_empty() {
            right_extent = right_extent.with_all(&items[right - BLOCK..right]);
            right -= BLOCK;
        }
    }
    let start = left;
    left += partition_few(&mut items[start..right], goes_right);
    left_extent = left_extent.with_all(&items[start..left]);
    right_extent = right_extent.with_all(&items[left..right]);
    (left, [left_extent, right_extent])
}

/// The same for at most `2 BLOCK` items.
#[inline(always)]
fn partition_few(items: &mut [ItemBox], goes_right: impl Fn(&ItemBox) -> bool) -> usize {
    let mut behind = [ItemBox::default(); 2 * BLOCK];
    let (mut left, mut right) = (0, 0);
    for i in 0..items.len() {
        let item = items[i];
        let goes_right = usize::from(goes_right(&item));
        (items[left], behind[right % (2 * BLOCK)]) = (item, item);
        left += 1 - goes_right;
        right += goes_right;
    }
    items[left..].copy_from_slice(&behind[..right]);
    left
}

/// Which items of a block belong to the other side.
#[derive(Default)]
struct Misplaced {
    offsets: [u8; BLOCK],
    start: usize,
    end: usize,
}

impl Misplaced {
    #[inline(always)]
    fn fill(&mut self, is_misplaced: impl Fn(usize) -> bool) {
        (self.start, self.end) = (0, 0);
        for i in 0..BLOCK {
            self.offsets[self.end % BLOCK] = i as u8;
            self.end += usize::from(is_misplaced(i));
        }
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.start == self.end
    }

    #[inline(always)]
    fn len(&self) -> usize {
        self.end - self.start
    }

    #[inline(always)]
    fn next(&mut self) -> usize {
        self.start += 1;
        usize::from(self.offsets[(self.start - 1) % BLOCK])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn items_go_to_their_side_and_none_is_lost() {
        let mut random = Random::new(8);
        for _ in 0..2000 {
            let (count, share) = (random.below(200), random.below(11));
            let mut items: Vec<ItemBox> =
                (0..count as u32).map(|i| ItemBox::new(i, [[i as f32 / 256.0; 3]; 2])).collect();
            let side: Vec<bool> = (0..count).map(|_| random.below(10) < share).collect();
            let goes_right = |item: &ItemBox| side[item.item() as usize];
            let (left, extents) = partition(&mut items, goes_right);
            assert!(!items[..left].iter().any(goes_right) && items[left..].iter().all(goes_right));
            for (items, extent) in [&items[..left], &items[left..]].into_iter().zip(&extents) {
                let of_items = Extent::of(items);
                assert_eq!(extent.bounds.corners(), of_items.bounds.corners());
                assert_eq!(extent.centres.low[..3], of_items.centres.low[..3]);
                assert_eq!(extent.centres.high[..3], of_items.centres.high[..3]);
            }
            let mut numbers: Vec<u32> = items.iter().map(ItemBox::item).collect();
            numbers.sort_unstable();
            assert!(numbers.into_iter().eq(0..count as u32));
        }
    }

    #[test]
    fn all_numbers_of_items_are_kept() {
        for item in [0, 1, 0xffff, 0x1_0000, 0x1234_5678, u32::MAX - 1] {
            assert_eq!(ItemBox::new(item, [[0.0; 3]; 2]).item(), item);
        }
    }
}
