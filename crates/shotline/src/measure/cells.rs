//! Distributes the rays along an axis over the square across it: stratified sampling with importance.
//!
//! The boxes of the leaves are projected onto the square. A small k-d tree whose splits are edges of these rectangles
//! divides it into cells, the strata. Each cell gets rays by its area, an equal share, and a share by the volume of the
//! boxes behind it. So thin parts of an object, and the narrow rings that a difference leaves, get rays however small
//! their area is. The weight of a ray is the area of its cell over the number of rays in it, so the estimate is
//! unbiased whatever the cells are.

use crate::aabb::Aabb;
use crate::math::HALF_ULP;

/// The number of cells of a square is at most this.
const MAX_CELLS: usize = 256;

/// With more than [`MIN_LEAVES`] cells, each gets at least this many rays of a sample on average.
const RAYS: usize = 16;

/// For up to this many cells, two rays each are enough.
const MIN_LEAVES: usize = 32;

/// At most this many edges are tried as splits of a cell along one side.
const MAX_TRIED_EDGES: usize = 16;

/// A part of a cell that this many rays of a sample would meet side by side is wide enough without a cell of its own,
/// in which the sequence would be shorter and so less uniform.
const WIDE: f64 = 2.0;

/// A region of which the boxes cover less than this fraction may be cut at any edge, so that less is spent on empty
/// space.
const SPARSE: f64 = 0.25;

/// A cell is assumed to get at least this fraction of all rays.
const MIN_SHARE: f64 = 1.0 / 32.0;

/// The error of an edge, in half-ulps of its coordinates.
const EDGE_ROUNDING: f64 = 128.0;

/// The projection of a box onto the square from -1 to 1, and the fraction of the length of the object's box behind it.
#[derive(Clone, Copy, Debug)]
struct Projection {
    low: [f64; 2],
    high: [f64; 2],
    depth: f64,
}

/// A rectangle of the square, with the shadows in it and its best split.
#[derive(Clone, Debug)]
struct Region {
    low: [f64; 2],
    high: [f64; 2],
    projections: Vec<Projection>,
    split: Option<Split>,
}

/// Decides which edges may be splits.
#[derive(Clone, Copy, Debug)]
struct SplitLimits {
    rays: f64,
    /// The errors of edges.
    blur: [f64; 2],
}

/// A line that cuts a region in two.
#[derive(Clone, Copy, Debug)]
struct Split {
    side: usize,
    at: f64,
    /// The decrease of the spread.
    gain: f64,
}

/// A rectangle of the square with its own rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    middle: [f64; 2],
    half: [f64; 2],
    /// The index of its first ray.
    pub first: usize,
    /// The weight of one of its rays; 1 if there is only one cell.
    pub weight: f64,
}

/// The cells of a square.
#[derive(Clone, Debug)]
pub(super) struct Cells(Vec<Cell>);

impl Cells {
    /// Computes the cells across an axis of a box with leaves in the given boxes; `rays` is the number of rays of each
    /// sample. There is one cell if no edge of a leaf crosses the square.
    pub(super) fn new(bounds: &Aabb, leaves: &[Aabb], axis: usize, rays: usize) -> Cells {
        let (centre, half) = (bounds.centre(), bounds.size() * 0.5);
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        // Edges have the rounding errors of the boxes.
        let blur = across.map(|k| EDGE_ROUNDING * HALF_ULP * (1.0 + centre[k].abs() / half[k]));
        let projection = |leaf: &Aabb| {
            let (low, high) = ((leaf.min - centre) / half, (leaf.max - centre) / half);
            let depth = 0.5 * (high[axis].min(1.0) - low[axis].max(-1.0));
            Projection {
                low: across.map(|k| low[k].max(-1.0)),
                high: across.map(|k| high[k].min(1.0)),
                depth: depth.max(0.0),
            }
        };
        let square = Region { low: [-1.0; 2], high: [1.0; 2], projections: Vec::new(), split: None };
        let projections = leaves.iter().map(projection).filter(|projection| projection.depth > 0.0).collect();
        // Many short sequences are less uniform than few long ones.
        let most = (rays / RAYS).max(MIN_LEAVES).min(rays / 2).clamp(1, MAX_CELLS);
        let guide = SplitLimits { rays: rays as f64, blur };
        Cells::shared(&square.holding(projections, guide).cut(most, guide), rays)
    }

    /// Distributes rays over regions: one to each, and of the rest one half by area, one quarter evenly among regions
    /// that hold anything, and one quarter by the volume that they may hold.
    fn shared(regions: &[Region], rays: usize) -> Cells {
        let areas: Vec<f64> = regions.iter().map(|region| region.area() / 4.0).collect();
        let bulks: Vec<f64> = regions.iter().map(Region::max_volume).collect();
        let used = |max_volume: &f64| if *max_volume > 0.0 { 1.0 } else { 0.0 };
        let (max_volume, count) = (bulks.iter().sum::<f64>(), bulks.iter().map(used).sum::<f64>());
        let part = |share: f64, whole: f64| if whole > 0.0 { 0.25 * share / whole } else { 0.0 };
        let shares: Vec<f64> = (areas.iter().zip(&bulks))
            .map(|(area, own)| 0.5 * area + part(used(own), count) + part(*own, max_volume))
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

    /// Returns the index of the cell of a ray, and the cell.
    pub(super) fn of(&self, ray: usize) -> (usize, &Cell) {
        // There is always a cell, and the first ray of the first cell is ray 0.
        let number = self.0.partition_point(|cell| cell.first <= ray).saturating_sub(1);
        (number, &self.0[number])
    }

    /// The expected number of rays in a rectangle; `rays` is the number that the cells were made for.
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

    /// The largest weight of a ray.
    pub(super) fn most_weight(&self) -> f64 {
        self.0.iter().map(|cell| cell.weight).fold(0.0, f64::max)
    }
}

impl Cell {
    /// Maps a point of the square to the cell.
    pub(super) fn sample_point(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.middle[k] + self.half[k] * point[k])
    }
}

impl Region {
    fn area(&self) -> f64 {
        (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])
    }

    /// The area of the region that a shadow covers.
    fn covered(&self, projection: &Projection) -> f64 {
        let side = |k: usize| projection.high[k].min(self.high[k]) - projection.low[k].max(self.low[k]);
        side(0).max(0.0) * side(1).max(0.0)
    }

    /// An upper bound on the volume of the object behind the region.
    fn max_volume(&self) -> f64 {
        let sum: f64 =
            self.projections.iter().map(|projection| projection.depth * self.covered(projection)).sum();
        sum.min(self.area())
    }

    /// The error if one ray represented the region: the sum of the deviations that its shadows have alone.
    fn spread(&self, projections: &[Projection]) -> f64 {
        let all = self.area();
        let one = |projection: &Projection| {
            let own = self.covered(projection);
            projection.depth * (own * (all - own).max(0.0)).sqrt()
        };
        projections.iter().map(one).sum()
    }

    /// Keeps the shadows that overlap the region, and finds its best split.
    fn holding(mut self, projections: Vec<Projection>, guide: SplitLimits) -> Region {
        let blur = guide.blur;
        self.projections = projections;
        self.projections.retain(|projection| {
            [0, 1].iter().all(|&k| {
                projection.low[k] < self.high[k] - blur[k] && projection.high[k] > self.low[k] + blur[k]
            })
        });
        self.split = self.best_split(guide);
        self
    }

    /// The edge of a shadow that reduces the spread most, of those at narrow parts; of all edges if the region is
    /// sparse.
    fn best_split(&self, guide: SplitLimits) -> Option<Split> {
        let mut best: Option<Split> = None;
        let before = self.spread(&self.projections);
        for side in 0..2 {
            let edges = self.edges(side, guide);
            for at in edges.iter().step_by(edges.len().div_ceil(MAX_TRIED_EDGES).max(1)).copied() {
                let split = Split { side, at, gain: 0.0 };
                let after: f64 = self.halves(split).iter().map(|half| half.spread(&self.projections)).sum();
                if before - after > best.map_or(0.0, |best| best.gain) {
                    best = Some(Split { gain: before - after, ..split });
                }
            }
        }
        best
    }

    /// Whether the shadows cover only a small part of the region.
    fn is_sparse(&self) -> bool {
        self.projections.iter().map(|projection| self.covered(projection)).sum::<f64>() < SPARSE * self.area()
    }

    /// The edges of shadows along a side, ascending: those near another edge or the end of the region, or all if it is
    /// sparse.
    fn edges(&self, side: usize, guide: SplitLimits) -> Vec<f64> {
        let (low, high, blur) = (self.low[side], self.high[side], guide.blur[side]);
        let ends =
            self.projections.iter().flat_map(|projection| [projection.low[side], projection.high[side]]);
        let mut edges: Vec<f64> =
            ends.filter(|at| *at > low + blur && *at < high - blur).chain([low, high]).collect();
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        let rays = guide.rays * (self.area() / 4.0).max(MIN_SHARE);
        let narrow = WIDE / rays.sqrt() * (high - low);
        let all = self.is_sparse();
        let counts = |near: &[f64]| all || near[1] - near[0] < narrow || near[2] - near[1] < narrow;
        edges.windows(3).filter(|three| counts(three)).map(|three| three[1]).collect()
    }

    fn halves(&self, Split { side, at, .. }: Split) -> [Region; 2] {
        let part = || Region { low: self.low, high: self.high, projections: Vec::new(), split: None };
        let (mut below, mut above) = (part(), part());
        (below.high[side], above.low[side]) = (at, at);
        [below, above]
    }

    /// Cuts repeatedly where the gain is largest, into at most `most` regions.
    fn cut(self, most: usize, guide: SplitLimits) -> Vec<Region> {
        let mut regions = vec![self];
        while regions.len() < most {
            let best = (regions.iter().enumerate())
                .filter_map(|(i, region)| Some((i, region.split?)))
                .reduce(|best, other| if other.1.gain > best.1.gain { other } else { best });
            let Some((i, split)) = best else { break };
            let [below, above] = regions[i].halves(split);
            let projections = std::mem::take(&mut regions[i].projections);
            regions[i] = below.holding(projections.clone(), guide);
            regions.push(above.holding(projections, guide));
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

    /// The number of rays in each cell; `rays` is their total.
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
                assert!(
                    counts.len() <= (rays / 2).clamp(1, MAX_CELLS) && counts.iter().all(|count| *count > 0)
                );
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
        assert!(number == 0 && cell.weight == 1.0 && cell.sample_point([0.1, -0.7]) == [0.1, -0.7]);
        let ring = counts(&Cells::new(&CUBE, &[CUBE, cube(1.0 - 1e-9)], 2, 100), 100);
        assert!(ring.len() == 5 && ring.iter().all(|count| *count >= 5), "{ring:?}");
    }

    #[test]
    fn no_ray_counts_more_than_twice_what_one_of_equal_ones_does() {
        let boxes = [cube(0.01), cube(0.011), Aabb::new(Vec3::splat(0.5), Vec3::splat(0.50001))];
        assert!(Cells::new(&CUBE, &boxes, 0, 10_000).most_weight() <= 2.01);
    }
}
