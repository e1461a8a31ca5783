//! Divides work on a mesh among threads, and sorts values into groups.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::pool;

/// How many elements a thread takes at a time. Loops over fewer run on one thread.
pub(super) const CHUNK: usize = 1 << 14;

/// Work on fewer faces or vertices is not divided: it takes less time than to wake threads.
const MANY: usize = 2048;

/// Does work on some faces or vertices, divided among threads if there are many of them.
pub(super) fn divided<T: Send>(elements: usize, work: impl FnOnce() -> T + Send) -> T {
    if elements < MANY { work() } else { pool::divided(work) }
}

/// Values sorted by the number of their group. Within a group they keep their order.
pub(super) struct Groups<T> {
    chunks: Vec<Chunk<T>>,
    pub(super) count: usize,
}

/// The values of some elements, sorted by group: those of group `g` begin at `starts[g]`.
struct Chunk<T> {
    values: Vec<T>,
    starts: Vec<u32>,
}

impl<T: Copy + Default + Send + Sync> Groups<T> {
    /// Sorts the values of elements; `values` returns those of an element, at most three, each with its group.
    pub(super) fn new<I: IntoIterator<Item = (usize, T)>>(
        elements: usize,
        count: usize,
        values: impl Fn(usize) -> I + Sync,
    ) -> Groups<T> {
        // Chunks grow with the number of groups, so that the starts take little memory.
        let size = CHUNK.max(count);
        let chunk = |index: usize| {
            let range = || index * size..elements.min((index + 1) * size);
            let mut starts = vec![0; count + 1];
            range().flat_map(&values).for_each(|(group, _)| starts[group + 1] += 1);
            (0..count).for_each(|group| starts[group + 1] += starts[group]);
            let mut ends = starts.clone();
            let mut sorted = vec![T::default(); starts[count] as usize];
            for (group, value) in range().flat_map(&values) {
                sorted[ends[group] as usize] = value;
                ends[group] += 1;
            }
            Chunk { values: sorted, starts }
        };
        Groups { chunks: (0..elements.div_ceil(size)).into_par_iter().map(chunk).collect(), count }
    }

    /// The values of a group.
    pub(super) fn group(&self, group: usize) -> impl Iterator<Item = &T> + Clone {
        let of_chunk =
            move |chunk: &'_ Chunk<T>| chunk.starts[group] as usize..chunk.starts[group + 1] as usize;
        self.chunks.iter().flat_map(move |chunk| &chunk.values[of_chunk(chunk)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn values_are_grouped_in_order() {
        let mut random = Random::new(5);
        for (elements, count) in [(0, 1), (10, 1), (100_000, 7), (70_000, 30_000)] {
            let groups: Vec<usize> = (0..elements).map(|_| random.below(count)).collect();
            let values = |i: usize| [(groups[i], i), (i % count, i + elements)];
            let sorted = Groups::new(elements, count, values);
            let mut expected = vec![Vec::new(); count];
            (0..elements).flat_map(values).for_each(|(group, value)| expected[group].push(value));
            for (group, expected) in expected.iter().enumerate() {
                assert!(sorted.group(group).eq(expected));
            }
        }
    }
}
