//! What the kernel finds, and how it searches.

use std::ops::Range;

use super::ray::{KernelRay, MISS, Prepared};

/// A hit that was found: the row of the ray, and the leaf and the lane of the triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneHit {
    pub row: u32,
    pub leaf: u32,
    pub lane: u32,
    /// Whether it is known to be off the edges of the triangle.
    pub is_off_edges: bool,
}

/// What a run of the kernel has found.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// Rays that take the plain path, by row.
    pub plain: Vec<u32>,
    pub lane_hits: Vec<LaneHit>,
    /// Rays that may begin inside the solid, by row.
    pub inside: Vec<u32>,
    /// Memory for sorting.
    unsorted: Vec<LaneHit>,
    ends: Vec<u32>,
}

/// If the rays of a chunk have more hits than this, they take the plain path, which needs memory for one at a time.
const MAX_LANE_HITS: usize = if cfg!(test) { 20_000 } else { 1 << 20 };

impl Found {
    /// Whether there are too many hits to go on.
    pub fn is_full(&self) -> bool {
        self.lane_hits.len() > MAX_LANE_HITS
    }

    /// Sorts the hits by row, all of which are in a range: a counting sort, before the hits are finished and become larger.
    pub fn sort_by_row(&mut self, rows: Range<usize>) {
        let Found { lane_hits, unsorted, ends, .. } = self;
        ends.clear();
        ends.resize(rows.len() + 1, 0);
        let place = |hit: &LaneHit| hit.row as usize - rows.start;
        lane_hits.iter().for_each(|hit| ends[place(hit) + 1] += 1);
        for row in 0..rows.len() {
            ends[row + 1] += ends[row];
        }
        unsorted.clear();
        unsorted.extend_from_slice(lane_hits);
        // Entry `row` is the start of the ray's hits, and moves to their end.
        for hit in unsorted {
            let at = &mut ends[place(hit)];
            lane_hits[*at as usize] = *hit;
            *at += 1;
        }
    }

    /// Takes the rows of rays that were prepared, of which only the first `count` are wanted. Returns a mask of those that
    /// are to be cast.
    #[inline(always)]
    pub fn take_prepared(&mut self, first_row: usize, count: usize, prepared: Prepared) -> u8 {
        let wanted = if count < 8 { (1 << count) - 1 } else { u8::MAX };
        let Prepared { ready, inside, plain } = prepared;
        let row = |i: usize| (first_row + i) as u32;
        self.inside.extend(bits(u64::from(inside & wanted)).map(row));
        self.plain.extend(bits(u64::from(plain & wanted)).map(row));
        ready & wanted
    }

    /// Takes the result of a ray that has no more to do.
    #[inline(always)]
    pub fn finish(&mut self, ray: &KernelRay) {
        if ray.may_coincide {
            self.plain.push(ray.row);
        } else if ray.leaf != MISS {
            let KernelRay { row, leaf, lane, is_off_edges, .. } = *ray;
            self.lane_hits.push(LaneHit { row, leaf, lane, is_off_edges });
        }
    }
}

/// The positions of the bits of a mask.
#[inline(always)]
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < u64::BITS as usize).then_some(bit)
    })
}

/// How rays are traversed.
pub(super) trait Mode {
    const CLOSEST: bool = false;
    const ANY: bool = false;
    /// Whether only hits off the edges and well within the span count. Rays with other hits alone are left to the plain
    /// path.
    const OFF_EDGES: bool = false;
}

/// The closest hit.
pub(super) struct Closest;
/// Whether there is any hit.
pub(super) struct Any;
/// All hits.
pub(super) struct All;
/// Whether there is any hit off the edges.
pub(super) struct AnyOffEdges;

impl Mode for Closest {
    const CLOSEST: bool = true;
}
impl Mode for Any {
    const ANY: bool = true;
}
impl Mode for All {}
impl Mode for AnyOffEdges {
    const ANY: bool = true;
    const OFF_EDGES: bool = true;
}
