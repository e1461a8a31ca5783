//! Decides how a chunk of rays is traversed.

use std::ops::Range;

use super::block::Coordinate;
use super::context::Kernel;
use super::found::{Mode, bits};
use super::prepare::AT_A_TIME;
use super::ray::KernelRay;
use crate::simd::Simd;

impl<C: Coordinate> Kernel<'_, C> {
    /// Whether rays that follow each other enter the mesh's box close together, and in similar directions where the
    /// tree is larger than the caches. Four groups of eight rays are examined.
    #[inline(always)]
    pub(super) fn is_coherent<S: Simd, M: Mode>(&self, rows: Range<usize>) -> bool {
        let size = size_of_val(&self.tree.nodes[..]) + size_of_val(self.blocks);
        let most = if size > large::<M>() { 0.5 } else { f64::INFINITY };
        let (mut groups, mut coherent) = (0, 0);
        for group in 0..4 {
            let first = rows.start + rows.len() / 4 * group;
            let mut spread = Spread::default();
            let mut rays = [KernelRay::default(); AT_A_TIME];
            let of_group = std::array::from_fn(|i| (first + 8 * i).min(rows.end - 1));
            let prepared = self.prepare::<S>(of_group, std::array::from_fn(|i| i), &mut rays);
            bits(u64::from(prepared.ready)).for_each(|i| spread.add(&rays[i]));
            if spread.count > 1 {
                groups += 1;
                coherent += usize::from(spread.of_entries() < 0.75 && spread.of_directions() <= most);
            }
        }
        2 * coherent >= groups
    }
}

/// In a tree of more bytes than this a stream of rays in all directions waits for memory more than a wave. The fewer
/// nodes a query visits, the larger the tree may be.
fn large<M: Mode>() -> usize {
    if M::ANY {
        100_000_000
    } else if M::CLOSEST {
        30_000_000
    } else {
        10_000_000
    }
}

/// How far apart rays enter, and how different their directions are, along the worst axis.
#[derive(Default)]
struct Spread {
    count: usize,
    bounds: [[f64; 2]; 6],
}

impl Spread {
    fn add(&mut self, ray: &KernelRay) {
        for axis in 0..3 {
            let direction = 1.0 / f64::from(ray.reciprocal(axis));
            let entry = f64::from(ray.offset(axis)) * direction;
            for (i, x) in [(axis, entry), (axis + 3, direction)] {
                let [low, high] = if self.count == 0 { [x, x] } else { self.bounds[i] };
                self.bounds[i] = [low.min(x), high.max(x)];
            }
        }
        self.count += 1;
    }

    fn of_entries(&self) -> f64 {
        self.widest(0)
    }

    fn of_directions(&self) -> f64 {
        self.widest(3)
    }

    fn widest(&self, first: usize) -> f64 {
        self.bounds[first..first + 3].iter().fold(0.0, |widest: f64, [low, high]| widest.max(high - low))
    }
}
