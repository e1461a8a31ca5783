//! Bins along each axis, and the best split between two of them.

use super::bounds::{Bounds, Centres, Extent, ItemBox};
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
    #[inline(always)]
    pub fn of(items: usize, centres: &Centres) -> Binning {
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
    fn bins_of(&self, item: &ItemBox) -> [u32; 4] {
        let (centre, mut bins) = (item.centre(), [0; 4]);
        for i in 0..4 {
            bins[i] = rounded_down((centre[i] - self.start[i]) * self.scale[i]);
        }
        bins
    }

    #[inline(always)]
    fn bin_of(&self, item: &ItemBox, axis: usize) -> u32 {
        rounded_down((item.centre_along(axis) - self.start[axis]) * self.scale[axis])
    }
}

/// A number between 0 and [`BINS`], rounded down. Exactly which way a number next to an integer goes does not matter.
#[inline(always)]
fn rounded_down(x: f32) -> u32 {
    (x - 0.5 + ROUND).to_bits() % BINS as u32
}

/// A split: items in bins from `bin` on go right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    binning: Binning,
    axis: usize,
    bin: u32,
}

impl Split {
    #[inline(always)]
    fn goes_right(&self, item: &ItemBox) -> bool {
        self.binning.bin_of(item, self.axis) >= self.bin
    }

    /// Sorts items to both sides; returns how many go left, and the extents of both sides.
    #[inline(always)]
    pub fn partition(&self, items: &mut [ItemBox]) -> (usize, [Extent; 2]) {
        partition(items, |item| self.goes_right(item))
    }
}

/// The items of a node, sorted into bins by their centres.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    binning: Binning,
    bins: [Bin; BINS],
}

/// For each axis the items in one bin. The fourth count is not used.
#[derive(Clone, Copy, Debug)]
struct Bin {
    bounds: [Bounds; 3],
    counts: [i32; 4],
}

impl Default for Bins {
    fn default() -> Bins {
        let binning = Binning { count: BINS, start: [0.0; 4], scale: [0.0; 4] };
        Bins { binning, bins: [Bin::EMPTY; BINS] }
    }
}

impl Bins {
    /// Removes what is in the bins, and fills them with items.
    #[inline(always)]
    pub fn fill(&mut self, items: &[ItemBox], binning: Binning) {
        self.binning = binning;
        for bin in &mut self.bins[..binning.count] {
            *bin = Bin::EMPTY;
        }
        for item in items {
            let bounds = item.bounds();
            let [x, y, z, _] = binning.bins_of(item);
            for (axis, bin) in [x, y, z].into_iter().enumerate() {
                let bin = &mut self.bins[bin as usize];
                bin.bounds[axis] = bin.bounds[axis].union(bounds);
                bin.counts[axis] += 1;
            }
        }
    }

    /// Adds the items of other bins.
    pub fn merged(mut self, other: &Bins) -> Bins {
        for (bin, other) in self.bins.iter_mut().zip(&other.bins) {
            bin.add(other);
        }
        self
    }

    /// The split with the least cost; `None` if all centres agree.
    #[inline(always)]
    pub fn best_split(&self) -> Option<Split> {
        let count = self.binning.count;
        let mut before = [[f32::INFINITY; 4]; BINS];
        let mut all = Bin::EMPTY;
        for (bin, before) in self.bins[..count - 1].iter().zip(&mut before[1..]) {
            all.add(bin);
            *before = all.costs();
        }
        // The least cost on each axis, and the bin.
        let (mut least, mut first) = ([f32::INFINITY; 4], [0; 4]);
        let mut all = Bin::EMPTY;
        for bin in (1..count).rev() {
            all.add(&self.bins[bin]);
            let behind = all.costs();
            for axis in 0..4 {
                let cost = before[bin][axis] + behind[axis];
                let is_best = cost <= least[axis];
                least[axis] = if is_best { cost } else { least[axis] };
                first[axis] = if is_best { bin as u32 } else { first[axis] };
            }
        }
        let axis = if least[1] < least[0] { 1 } else { 0 };
        let axis = if least[2] < least[axis] { 2 } else { axis };
        (least[axis] < f32::INFINITY).then_some(Split { binning: self.binning, axis, bin: first[axis] })
    }
}

impl Bin {
    const EMPTY: Bin = Bin { bounds: [Bounds::EMPTY; 3], counts: [0; 4] };

    #[inline(always)]
    fn add(&mut self, other: &Bin) {
        for axis in 0..3 {
            self.bounds[axis] = self.bounds[axis].union(other.bounds[axis]);
        }
        for axis in 0..4 {
            self.counts[axis] += other.counts[axis];
        }
    }

    /// For each axis half the area of the box times the number of items; infinite if there are none.
    #[inline(always)]
    fn costs(&self) -> [f32; 4] {
        let sizes = self.bounds.map(|bounds| bounds.sizes());
        let mut costs = [f32::INFINITY; 4];
        for axis in 0..3 {
            let [x, y, z, _] = sizes[axis];
            let cost = (x * y + y * z + z * x) * self.counts[axis] as f32;
            costs[axis] = if self.counts[axis] > 0 { cost } else { f32::INFINITY };
        }
        costs
    }
}
