//! Bins along each axis, and the best split between two of them.

use super::bounds::{Bounds, ItemBox};
use super::partition::partition;

/// The number of bins along each axis.
const BINS: usize = 16;

/// Added to a float32 number, it rounds it to an integer, which is then in the low bits.
const ROUND: f32 = 1.5 * (1 << 23) as f32;

/// How centres are mapped to bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    count: usize,
    start: [f32; 4],
    /// Bins per unit; 0 along an axis on which all centres agree.
    scale: [f32; 4],
}

impl Binning {
    pub fn of(items: usize, centres: &Bounds) -> Binning {
        // Few items need few bins.
        let count = if items < 2 * BINS { (items / 2 + 2).min(BINS) } else { BINS };
        let scale = |axis: usize| {
            let size = centres.high[axis] - centres.low[axis];
            // Slightly less than the number of bins, so that the last centre is in the last bin.
            if size > 0.0 { count as f32 * 0.9999 / size } else { 0.0 }
        };
        Binning { count, start: centres.low, scale: [scale(0), scale(1), scale(2), 0.0] }
    }

    #[inline(always)]
    fn bins_of(&self, item: &ItemBox) -> [usize; 4] {
        let centre = item.centre();
        std::array::from_fn(|i| rounded_down((centre[i] - self.start[i]) * self.scale[i]))
    }

    #[inline(always)]
    fn bin_of(&self, item: &ItemBox, axis: usize) -> usize {
        rounded_down((item.centre_along(axis) - self.start[axis]) * self.scale[axis])
    }
}

/// A number between 0 and [`BINS`], rounded down. Exactly which way a number next to an integer goes does not matter.
#[inline(always)]
fn rounded_down(x: f32) -> usize {
    (x - 0.5 + ROUND).to_bits() as usize % BINS
}

/// A split: items in bins from `bin` on go right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    binning: Binning,
    axis: usize,
    bin: usize,
}

impl Split {
    #[inline(always)]
    fn goes_right(&self, item: &ItemBox) -> bool {
        self.binning.bin_of(item, self.axis) >= self.bin
    }

    /// Sorts items to both sides; returns how many go left.
    pub fn partition(&self, items: &mut [ItemBox]) -> usize {
        partition(items, |item| self.goes_right(item))
    }
}

/// The items of a node, sorted into bins by their centres.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    binning: Binning,
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Default for Bins {
    fn default() -> Bins {
        let binning = Binning { count: BINS, start: [0.0; 4], scale: [0.0; 4] };
        Bins { binning, bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] }
    }
}

impl Bins {
    /// Removes what is in the bins, and fills them with items.
    pub fn fill(&mut self, items: &[ItemBox], binning: Binning) {
        self.binning = binning;
        for axis in 0..3 {
            self.bounds[axis][..binning.count].fill(Bounds::EMPTY);
            self.counts[axis][..binning.count].fill(0);
        }
        for item in items {
            let bounds = item.bounds();
            let [x, y, z, _] = binning.bins_of(item);
            for (axis, bin) in [x, y, z].into_iter().enumerate() {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(bounds);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// Adds the items of other bins.
    pub fn merged(mut self, other: &Bins) -> Bins {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// The split with the least cost; `None` if all centres agree.
    pub fn best_split(&self) -> Option<Split> {
        let (mut best, mut least) = (None, f32::INFINITY);
        for axis in (0..3).filter(|&axis| self.binning.scale[axis] != 0.0) {
            let (before, behind) = self.sides(axis);
            let costs: [f32; BINS] = std::array::from_fn(|bin| before.cost(bin) + behind.cost(bin));
            for (bin, &cost) in costs.iter().enumerate().take(self.binning.count).skip(1) {
                if cost < least && before.counts[bin] > 0.0 && behind.counts[bin] > 0.0 {
                    least = cost;
                    best = Some(Split { binning: self.binning, axis, bin });
                }
            }
        }
        best
    }

    /// What is before each bin, and what is in it and behind.
    fn sides(&self, axis: usize) -> (Sides, Sides) {
        let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
        let count = self.binning.count;
        let (mut before, mut behind) = (Sides::default(), Sides::default());
        let (mut all, mut items) = (Bounds::EMPTY, 0);
        for bin in 1..count {
            all = all.union(bounds[bin - 1]);
            items += counts[bin - 1];
            before.set(bin, &all, items);
        }
        let (mut all, mut items) = (Bounds::EMPTY, 0);
        for bin in (1..count).rev() {
            all = all.union(bounds[bin]);
            items += counts[bin];
            behind.set(bin, &all, items);
        }
        (before, behind)
    }
}

/// The sizes of boxes and the numbers of items on one side of every bin.
#[derive(Default)]
struct Sides {
    sizes: [[f32; BINS]; 3],
    counts: [f32; BINS],
}

impl Sides {
    #[inline(always)]
    fn set(&mut self, bin: usize, bounds: &Bounds, items: u32) {
        for axis in 0..3 {
            self.sizes[axis][bin] = bounds.high[axis] - bounds.low[axis];
        }
        self.counts[bin] = items as f32;
    }

    /// Half the area of the box times the number of items. It means nothing where there are none.
    #[inline(always)]
    fn cost(&self, bin: usize) -> f32 {
        let [x, y, z] = [self.sizes[0][bin], self.sizes[1][bin], self.sizes[2][bin]];
        (x * y + y * z + z * x) * self.counts[bin]
    }
}
