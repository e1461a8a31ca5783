//! How the rays along an axis are shared out over the square across it: stratified sampling with importance.
//!
//! The boxes of the leaves are projected on the square. A small kd-tree whose splits are edges of these rectangles cuts
//! it into cells, the strata. Each gets a share of the rays by its area, a share that is the same for all, and a share by
//! the volume of the boxes behind it. So thin parts of an object, and the narrow rings that a difference leaves, get rays
//! however small their area is. The weight of a ray is the area of its cell over the number of rays in it, so the estimate
//! is unbiased whatever the cells are.

use crate::aabb::Aabb;
use crate::math::HALF_ULP;

/// Cells of a square at most.
const MOST: usize = 256;

/// Rays of a sample for each cell, where there are more cells than few.
const RAYS: usize = 16;

/// So many cells are few: of these, two rays each are enough.
const FEW: usize = 32;

/// Edges that are tried as splits of a cell along one side at most.
const TRIES: usize = 16;

/// A part of a cell that so many rays of a sample would meet side by side is wide enough without a cell of its own, in
/// which the sequence is shorter and so less even.
const WIDE: f64 = 2.0;

/// A region of which the boxes cover less than this is cut at any edge, so that less is spent on what is empty.
const SPARSE: f64 = 0.25;

/// A cell is expected to have such a part of all rays at least.
const LEAST: f64 = 1.0 / 32.0;

/// Half-ulps of its coordinates by which an edge may be off.
const BLUR: f64 = 128.0;

/// The rectangle of a box in the square from -1 to 1, and how much of the length of the object's box is behind it.
#[derive(Clone, Copy, Debug)]
struct Shadow {
    low: [f64; 2],
    high: [f64; 2],
    depth: f64,
}

/// A rectangle of the square, and the shadows in it.
#[derive(Clone, Debug)]
struct Region {
    low: [f64; 2],
    high: [f64; 2],
    shadows: Vec<Shadow>,
    split: Option<Split>,
}

/// What edges may be splits.
#[derive(Clone, Copy, Debug)]
struct Guide {
    rays: f64,
    /// By how much edges may be off.
    blur: [f64; 2],
}

/// A line that cuts a region in two.
#[derive(Clone, Copy, Debug)]
struct Split {
    side: usize,
    at: f64,
    /// By how much it lessens the spread.
    gain: f64,
}

/// A rectangle of the square with rays of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    middle: [f64; 2],
    half: [f64; 2],
    /// The number of its first ray.
    pub first: usize,
    /// What a ray of it counts, if a ray counts 1 where there is one cell only.
    pub weight: f64,
}

/// The cells of a square.
#[derive(Clone, Debug)]
pub(super) struct Cells(Vec<Cell>);

impl Cells {
    /// The cells across an axis of a box with leaves in some boxes, for so many rays of each sample. One cell where no edge
    /// of a leaf crosses the square.
    pub(super) fn new(bounds: &Aabb, leaves: &[Aabb], axis: usize, rays: usize) -> Cells {
        let (centre, half) = (bounds.centre(), bounds.size() * 0.5);
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        // As the boxes may be off by rounding, so may their edges.
        let blur = across.map(|k| BLUR * HALF_ULP * (1.0 + centre[k].abs() / half[k]));
        let shadow = |leaf: &Aabb| {
            let (low, high) = ((leaf.min - centre) / half, (leaf.max - centre) / half);
            let depth = 0.5 * (high[axis].min(1.0) - low[axis].max(-1.0));
            Shadow {
                low: across.map(|k| low[k].max(-1.0)),
                high: across.map(|k| high[k].min(1.0)),
                depth: depth.max(0.0),
            }
        };
        let square = Region { low: [-1.0; 2], high: [1.0; 2], shadows: Vec::new(), split: None };
        let shadows = leaves.iter().map(shadow).filter(|shadow| shadow.depth > 0.0).collect();
        // Many short sequences are less even than few long ones.
        let most = (rays / RAYS).max(FEW).min(rays / 2).clamp(1, MOST);
        let guide = Guide { rays: rays as f64, blur };
        Cells::shared(&square.holding(shadows, guide).cut(most, guide), rays)
    }

    /// Shares rays out over regions: one to each, and of the rest one half by area, one quarter evenly among regions with
    /// anything in them, and one quarter by the volume that may be in them.
    fn shared(regions: &[Region], rays: usize) -> Cells {
        let areas: Vec<f64> = regions.iter().map(|region| region.area() / 4.0).collect();
        let bulks: Vec<f64> = regions.iter().map(Region::bulk).collect();
        let used = |bulk: &f64| if *bulk > 0.0 { 1.0 } else { 0.0 };
        let (bulk, count) = (bulks.iter().sum::<f64>(), bulks.iter().map(used).sum::<f64>());
        let part = |share: f64, whole: f64| if whole > 0.0 { 0.25 * share / whole } else { 0.0 };
        let shares: Vec<f64> = (areas.iter().zip(&bulks))
            .map(|(area, own)| 0.5 * area + part(used(own), count) + part(*own, bulk))
            .collect();
        let (all, rest) = (shares.iter().sum::<f64>(), rays.saturating_sub(regions.len()));
        let (mut cells, mut sum, mut first) = (Vec::with_capacity(regions.len()), 0.0, 0);
        for (i, region) in regions.iter().enumerate() {
            sum += shares[i];
            let is_last = i + 1 == regions.len();
            let end = if is_last { rest } else { ((sum / all * rest as f64) as usize).min(rest) } + i + 1;
            let end = end.max(first + 1);
            cells.push(Cell {
                middle: [0, 1].map(|k| region.low[k].midpoint(region.high[k])),
                half: [0, 1].map(|k| 0.5 * (region.high[k] - region.low[k])),
                first,
                weight: areas[i] * rays as f64 / (end - first) as f64,
            });
            first = end;
        }
        Cells(cells)
    }

    /// The number of the cell of a ray, and the cell.
    pub(super) fn of(&self, ray: usize) -> (usize, &Cell) {
        // There always is one, and its first ray is the first of all.
        let number = self.0.partition_point(|cell| cell.first <= ray).saturating_sub(1);
        (number, &self.0[number])
    }

    /// The expected number of rays in a rectangle, of all `rays` that the cells were made for.
    pub(super) fn rays_in(&self, low: [f64; 2], high: [f64; 2], rays: usize) -> f64 {
        let ends = self.0.iter().skip(1).map(|cell| cell.first).chain([rays]);
        let part = |(cell, end): (&Cell, usize)| {
            let side = |k: usize| {
                let (from, to) = (cell.middle[k] - cell.half[k], cell.middle[k] + cell.half[k]);
                (high[k].min(to) - low[k].max(from)).max(0.0) / (to - from)
            };
            (end - cell.first) as f64 * side(0) * side(1)
        };
        self.0.iter().zip(ends).map(part).sum()
    }

    /// The most that a ray counts.
    pub(super) fn most_weight(&self) -> f64 {
        self.0.iter().map(|cell| cell.weight).fold(0.0, f64::max)
    }
}

impl Cell {
    /// Takes a point of the square to the cell.
    pub(super) fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.middle[k] + self.half[k] * point[k])
    }
}

impl Region {
    fn area(&self) -> f64 {
        (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])
    }

    /// The part of its area that a shadow covers.
    fn covered(&self, shadow: &Shadow) -> f64 {
        let side = |k: usize| shadow.high[k].min(self.high[k]) - shadow.low[k].max(self.low[k]);
        side(0).max(0.0) * side(1).max(0.0)
    }

    /// As much as the object may have behind it.
    fn bulk(&self) -> f64 {
        let sum: f64 = self.shadows.iter().map(|shadow| shadow.depth * self.covered(shadow)).sum();
        sum.min(self.area())
    }

    /// How much one ray in place of the region would be off: the deviations that its shadows have by themselves.
    fn spread(&self, shadows: &[Shadow]) -> f64 {
        let all = self.area();
        let one = |shadow: &Shadow| {
            let own = self.covered(shadow);
            shadow.depth * (own * (all - own).max(0.0)).sqrt()
        };
        shadows.iter().map(one).sum()
    }

    /// Takes the shadows that overlap the region, and finds its best split.
    fn holding(mut self, shadows: Vec<Shadow>, guide: Guide) -> Region {
        let blur = guide.blur;
        self.shadows = shadows;
        self.shadows.retain(|shadow| {
            [0, 1]
                .iter()
                .all(|&k| shadow.low[k] < self.high[k] - blur[k] && shadow.high[k] > self.low[k] + blur[k])
        });
        self.split = self.best_split(guide);
        self
    }

    /// The edge of a shadow that lessens the spread most, of those at narrow parts; of all where there is little.
    fn best_split(&self, guide: Guide) -> Option<Split> {
        let mut best: Option<Split> = None;
        let before = self.spread(&self.shadows);
        for side in 0..2 {
            let edges = self.edges(side, guide);
            for at in edges.iter().step_by(edges.len().div_ceil(TRIES).max(1)).copied() {
                let split = Split { side, at, gain: 0.0 };
                let after: f64 = self.halves(split).iter().map(|half| half.spread(&self.shadows)).sum();
                if before - after > best.map_or(0.0, |best| best.gain) {
                    best = Some(Split { gain: before - after, ..split });
                }
            }
        }
        best
    }

    /// Whether the shadows cover little of the region.
    fn is_sparse(&self) -> bool {
        self.shadows.iter().map(|shadow| self.covered(shadow)).sum::<f64>() < SPARSE * self.area()
    }

    /// The edges of shadows along a side that have another, or the end of the region, near them, or all: ascending.
    fn edges(&self, side: usize, guide: Guide) -> Vec<f64> {
        let (low, high, blur) = (self.low[side], self.high[side], guide.blur[side]);
        let ends = self.shadows.iter().flat_map(|shadow| [shadow.low[side], shadow.high[side]]);
        let mut edges: Vec<f64> =
            ends.filter(|at| *at > low + blur && *at < high - blur).chain([low, high]).collect();
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        let rays = guide.rays * (self.area() / 4.0).max(LEAST);
        let narrow = WIDE / rays.sqrt() * (high - low);
        let all = self.is_sparse();
        let counts = |near: &[f64]| all || near[1] - near[0] < narrow || near[2] - near[1] < narrow;
        edges.windows(3).filter(|three| counts(three)).map(|three| three[1]).collect()
    }

    fn halves(&self, Split { side, at, .. }: Split) -> [Region; 2] {
        let part = || Region { low: self.low, high: self.high, shadows: Vec::new(), split: None };
        let (mut below, mut above) = (part(), part());
        (below.high[side], above.low[side]) = (at, at);
        [below, above]
    }

    /// Cuts the region where that gains most, over and over, into so many at most.
    fn cut(self, most: usize, guide: Guide) -> Vec<Region> {
        let mut regions = vec![self];
        while regions.len() < most {
            let best = (regions.iter().enumerate())
                .filter_map(|(i, region)| Some((i, region.split?)))
                .reduce(|best, other| if other.1.gain > best.1.gain { other } else { best });
            let Some((i, split)) = best else { break };
            let [below, above] = regions[i].halves(split);
            let shadows = std::mem::take(&mut regions[i].shadows);
            regions[i] = below.holding(shadows.clone(), guide);
            regions.push(above.holding(shadows, guide));
        }
        regions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    const CUBE: Aabb = Aabb::new(Vec3::splat(-1.0), Vec3::ONE);

    fn cube(half: f64) -> Aabb {
        Aabb::new(Vec3::splat(-half), Vec3::splat(half))
    }

    /// The rays of each cell, of so many.
    fn counts(Cells(cells): &Cells, rays: usize) -> Vec<usize> {
        let ends = cells.iter().skip(1).map(|cell| cell.first).chain([rays]);
        cells.iter().zip(ends).map(|(cell, end)| end - cell.first).collect()
    }

    #[test]
    fn cells_tile_the_square_and_share_out_all_rays() {
        let post = Aabb::new(Vec3::new(-1e-6, -1.0, -1e-3), Vec3::new(1e-6, 1.0, 1e-3));
        let many: Vec<Aabb> = (1..2000).map(|i| cube(f64::from(i) / 2000.0)).collect();
        for leaves in [vec![], vec![CUBE], vec![cube(0.5)], vec![CUBE, cube(1.0 - 1e-9), post], many] {
            for (axis, rays) in [(0, 1), (1, 2), (2, 100), (0, 10_000)] {
                let cells = Cells::new(&CUBE, &leaves, axis, rays);
                let counts = counts(&cells, rays);
                assert!(counts.len() <= (rays / 2).clamp(1, MOST) && counts.iter().all(|count| *count > 0));
                let weights: f64 = cells.0.iter().zip(&counts).map(|(cell, n)| cell.weight * *n as f64).sum();
                assert!((weights / rays as f64 - 1.0).abs() < 1e-12, "{weights}");
                let mut found = vec![0; counts.len()];
                (0..rays).for_each(|i| found[cells.of(i).0] += 1);
                assert_eq!(found, counts);
            }
        }
    }

    #[test]
    fn one_cell_is_the_square_itself_and_a_ring_is_cut_into_four() {
        let one = Cells::new(&CUBE, &[CUBE, CUBE], 1, 100);
        let (number, cell) = one.of(99);
        assert!(number == 0 && cell.weight == 1.0 && cell.place([0.1, -0.7]) == [0.1, -0.7]);
        let ring = counts(&Cells::new(&CUBE, &[CUBE, cube(1.0 - 1e-9)], 2, 100), 100);
        assert!(ring.len() == 5 && ring.iter().all(|count| *count >= 5), "{ring:?}");
    }

    #[test]
    fn no_ray_counts_more_than_twice_what_one_of_equal_ones_does() {
        let boxes = [cube(0.01), cube(0.011), Aabb::new(Vec3::splat(0.5), Vec3::splat(0.50001))];
        assert!(Cells::new(&CUBE, &boxes, 0, 10_000).most_weight() <= 2.01);
    }
}
