//! Tests a ray against the triangles of a block.
//!
//! A lane is hit or missed for certain where the edge functions exceed the bound on their rounding. The `t` of a
//! certain hit is then known up to an interval, which decides almost always whether it is in the span and nearer than
//! the best hit. What the numbers leave open is decided by the plain path, [`Kernel::plain_hit`].

use super::block::{Block, Coordinate};
use super::context::Kernel;
use super::found::{Found, LaneHit, Mode};
use super::ray::{INSET, KernelRay, MISS, SMALLEST};
use crate::accel::wide::LEAF_SIZE;
use crate::crossing::Crossing;
use crate::math::{HALF_ULP, Real};
use crate::simd::{Doubles, Simd};
use crate::solid::mesh::winding::order;

/// The lanes of a block that a ray hits, and that it may hit.
pub(super) struct Tested {
    certain: u8,
    doubtful: u8,
    /// The certain hits that are off the edges.
    off_edges: u8,
    /// For certain hits, an interval that contains `t`.
    low: [f64; LEAF_SIZE],
    high: [f64; LEAF_SIZE],
}

/// The corners of the triangles of a block: their coordinates by role of the axis and by corner.
#[derive(Clone, Copy)]
pub(super) struct Corners<F>([[F; 3]; 3]);

/// Loads the corners of a block, as rays see them whose direction is largest along the same axis.
#[inline(always)]
pub(super) fn corners<S: Simd, C: Coordinate>(block: &Block<C>, axes: [u32; 3]) -> Corners<S::F64x4> {
    // Not `map` or `from_fn`, which are not inlined where values are vector registers.
    let load = |role: usize, corner: usize| C::load::<S>(&block.coordinates[axes[role] as usize % 3][corner]);
    let of_role = |role: usize| [load(role, 0), load(role, 1), load(role, 2)];
    Corners([of_role(0), of_role(1), of_role(2)])
}

/// The triangles of a block, projected along a ray.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Projection {
    /// The edge functions: for each corner, that of the opposite edge.
    edges: [[f64; LEAF_SIZE]; 3],
    /// The depths of the corners.
    depths: [[f64; LEAF_SIZE]; 3],
    /// The lanes that the ray may hit, and those whose edge functions exceed the bound on their rounding.
    possible: u8,
    certain: u8,
}

impl Projection {
    /// Whether the ray may hit any of the triangles.
    #[inline(always)]
    pub fn is_possible(&self) -> bool {
        self.possible != 0
    }
}

/// Projects the triangles of a block.
#[inline(always)]
pub(super) fn project<S: Simd>(corners: &Corners<S::F64x4>, ray: &KernelRay) -> Projection {
    let splat = <S::F64x4 as Real>::splat;
    let load = |role: usize, corner: usize| corners.0[role][corner] - splat(ray.origin(role));
    let z = [load(2, 0), load(2, 1), load(2, 2)];
    let sheared =
        |role: usize, corner: usize| splat(ray.slope(role)).neg_mul_add(z[corner], load(role, corner));
    let x = [sheared(0, 0), sheared(0, 1), sheared(0, 2)];
    let y = [sheared(1, 0), sheared(1, 1), sheared(1, 2)];
    let edge = |a: usize, b: usize| x[a].mul_sub(y[b], y[a] * x[b]);
    let (u, v, w) = (edge(1, 2), edge(2, 0), edge(0, 1));
    let (least, most) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
    let doubt = splat(ray.doubt());
    // Neither is true of unused lanes, where all numbers are NaN.
    let possible = (-doubt).is_at_most(least) | most.is_at_most(doubt);
    let certain = doubt.is_less(least) | most.is_less(-doubt);
    let edges = [u.store(), v.store(), w.store()];
    Projection { edges, depths: [z[0].store(), z[1].store(), z[2].store()], possible, certain }
}

/// Decides which triangles are hit.
#[inline(always)]
pub(super) fn test<S: Simd>(projection: &Projection, ray: &KernelRay) -> Tested {
    let splat = <S::F64x4 as Real>::splat;
    let &Projection { edges, depths, possible, certain } = projection;
    let load = S::F64x4::load;
    let [u, v, w] = [load(&edges[0]), load(&edges[1]), load(&edges[2])];
    let depths = [load(&depths[0]), load(&depths[1]), load(&depths[2])];
    let doubtful = possible & !certain;
    let mut tested =
        Tested { certain, doubtful, off_edges: 0, low: [0.0; LEAF_SIZE], high: [0.0; LEAF_SIZE] };
    if certain != 0 {
        let sum = u + v + w;
        let [low, high] = interval::<S>(ray, [u, v, w], sum, depths);
        (tested.low, tested.high) = (low.store(), high.store());
        // All edge functions have one sign, so this is the size of the least.
        let share = u.abs().lesser(v.abs()).lesser(w.abs());
        let of_sum = sum.abs() * splat(INSET);
        // The doubt changes a share of `INSET` by less than half of it.
        let doubt = splat(ray.doubt() * 8.0);
        tested.off_edges = certain & of_sum.is_at_most(share) & doubt.is_at_most(of_sum);
    }
    tested
}

/// An interval that contains the `t` of each lane that is hit: its depth is that of the corners, weighted with the edge
/// functions, and `t` is clamped to the depths of the corners just as [`crate::aabb::BoxRay`] computes them.
#[inline(always)]
fn interval<S: Simd>(
    ray: &KernelRay,
    edges: [S::F64x4; 3],
    sum: S::F64x4,
    z: [S::F64x4; 3],
) -> [S::F64x4; 2] {
    let splat = <S::F64x4 as Real>::splat;
    let inverse = splat(ray.inverse());
    let t = [z[0] * inverse, z[1] * inverse, z[2] * inverse];
    let (near, far) = (t[0].lesser(t[1]).lesser(t[2]), t[0].greater(t[1]).greater(t[2]));
    let (shrink, grow) = (splat(1.0 - 6.0 * HALF_ULP), splat(1.0 + 6.0 * HALF_ULP));
    let near = (near * shrink).lesser(near * grow);
    let far = (far * shrink).greater(far * grow);
    // With the true sums `n` and `s` and errors `e_n` and `e_s`: |n'/s' - n/s| <= (|e_n| + |n/s| |e_s|) / |s'|, and
    // |n/s| is a depth within the reach.
    let [u, v, w] = edges;
    let weighted = u.mul_add(z[0], v.mul_add(z[1], w * z[2]));
    let per_sum = inverse / sum;
    let middle = weighted * per_sum;
    let error = splat(ray.depth_doubt()) * per_sum.abs();
    let error = middle.abs().mul_add(splat(16.0 * HALF_ULP), error);
    // If the sum is so small that the error overflows, the corners remain. A `t` of the plain path that underflows may
    // be beyond the corners.
    let smallest = splat(SMALLEST);
    [(middle - error).greater(near) - smallest, (middle + error).lesser(far) + smallest]
}

/// Iterates over the lanes of a mask.
fn lanes(mut mask: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LEAF_SIZE).then_some(lane)
    })
}

impl<C: Coordinate> Kernel<'_, C> {
    /// Takes the hits of a leaf that are nearer than the best one.
    #[inline(always)]
    pub(super) fn closest_in_leaf<S: Simd>(&self, projection: &Projection, ray: &mut KernelRay, leaf: u32) {
        let tested = test::<S>(projection, ray);
        for lane in lanes(tested.certain) {
            let (low, high) = (tested.low[lane], tested.high[lane]);
            if low > ray.best()[1] + ray.margin() || high < ray.from() || low > ray.to() {
                continue;
            }
            if low >= ray.from() && high <= ray.to() && high + ray.margin() < ray.best()[0] {
                ray.set_best([low, high]);
                (ray.leaf, ray.lane, ray.may_coincide) = (leaf, lane as u32, false);
                ray.is_off_edges = tested.off_edges >> lane & 1 == 1;
            } else {
                self.offer_exactly(ray, leaf, lane, tested.off_edges);
            }
        }
        for lane in lanes(tested.doubtful) {
            self.offer_exactly(ray, leaf, lane, tested.off_edges);
        }
    }

    /// Compares a hit with the best one by the plain path.
    #[cold]
    #[inline(never)]
    fn offer_exactly(&self, ray: &mut KernelRay, leaf: u32, lane: usize, off_edges: u8) {
        if self.has_duplicates
            && ray.leaf != MISS
            && self.face(ray.leaf, ray.lane as usize) == self.face(leaf, lane)
        {
            return;
        }
        let Some((hit, t)) = self.hit_in_span(ray, leaf, lane) else { return };
        let best = if ray.leaf == MISS { None } else { self.hit_in_span(ray, ray.leaf, ray.lane as usize) };
        if let Some((best, best_t)) = best {
            ray.set_best([best_t; 2]);
            let is_near = (t - best_t).abs() <= ray.margin();
            if order(&best, &hit).is_lt() {
                ray.may_coincide |= is_near;
                return;
            }
            ray.may_coincide = is_near;
        }
        ray.set_best([t; 2]);
        (ray.leaf, ray.lane, ray.is_off_edges) = (leaf, lane as u32, off_edges >> lane & 1 == 1);
    }

    /// Whether the ray has a hit in a leaf that counts; the ray takes it.
    #[inline(always)]
    pub(super) fn any_in_leaf<S: Simd, M: Mode>(
        &self,
        projection: &Projection,
        ray: &mut KernelRay,
        leaf: u32,
    ) -> bool {
        if M::OFF_EDGES {
            return self.any_off_edges_in_leaf::<S>(projection, ray, leaf);
        }
        let is_hit = self.is_hit_in_leaf::<S>(projection, ray, leaf);
        if is_hit {
            ray.leaf = leaf;
        }
        is_hit
    }

    /// Whether the ray has a hit in a leaf that is off the edges and farther from the ends of the span than the width of
    /// an event; the ray takes it. Other hits in the span, or near it, leave the ray to the plain path unless such a hit
    /// is found.
    #[inline(always)]
    fn any_off_edges_in_leaf<S: Simd>(
        &self,
        projection: &Projection,
        ray: &mut KernelRay,
        leaf: u32,
    ) -> bool {
        let tested = test::<S>(projection, ray);
        for lane in lanes(tested.certain) {
            // The interval was widened by one margin: see `prepare`.
            let (low, high) = (tested.low[lane], tested.high[lane]);
            let is_within = low - 2.0 * ray.margin() >= ray.from() && high + 2.0 * ray.margin() <= ray.to();
            if is_within && tested.off_edges >> lane & 1 == 1 {
                (ray.leaf, ray.lane) = (leaf, lane as u32);
                (ray.may_coincide, ray.is_off_edges) = (false, true);
                return true;
            }
            ray.may_coincide |= high >= ray.from() && low <= ray.to();
        }
        ray.may_coincide |= tested.doubtful != 0;
        false
    }

    /// Whether the ray hits any triangle of a leaf in the span.
    #[inline(always)]
    fn is_hit_in_leaf<S: Simd>(&self, projection: &Projection, ray: &KernelRay, leaf: u32) -> bool {
        let tested = test::<S>(projection, ray);
        let mut open = tested.doubtful;
        for lane in lanes(tested.certain) {
            if tested.low[lane] >= ray.from() && tested.high[lane] <= ray.to() {
                return true;
            }
            if tested.high[lane] >= ray.from() && tested.low[lane] <= ray.to() {
                open |= 1 << lane;
            }
        }
        open != 0 && lanes(open).any(|lane| self.hit_in_span(ray, leaf, lane).is_some())
    }

    /// Appends all hits of a leaf in the span.
    #[inline(always)]
    pub(super) fn all_in_leaf<S: Simd>(
        &self,
        projection: &Projection,
        ray: &KernelRay,
        leaf: u32,
        found: &mut Found,
    ) {
        let tested = test::<S>(projection, ray);
        let hits = &mut found.lane_hits;
        let mut take = |lane: usize| {
            let is_off_edges = tested.off_edges >> lane & 1 == 1;
            hits.push(LaneHit { row: ray.row, leaf, lane: lane as u32, is_off_edges });
        };
        let mut open = tested.doubtful;
        for lane in lanes(tested.certain) {
            if tested.low[lane] >= ray.from() && tested.high[lane] <= ray.to() {
                take(lane);
            } else if tested.high[lane] >= ray.from() && tested.low[lane] <= ray.to() {
                open |= 1 << lane;
            }
        }
        if open != 0 {
            lanes(open).filter(|&lane| self.hit_in_span(ray, leaf, lane).is_some()).for_each(take);
            if self.preparation.is_for_operands()
                && lanes(tested.doubtful).any(|lane| self.is_in_plane(ray, leaf, lane))
            {
                found.plain.push(ray.row);
            }
        }
    }

    /// Whether a ray runs in the plane of a triangle.
    #[cold]
    #[inline(never)]
    fn is_in_plane(&self, ray: &KernelRay, leaf: u32, lane: usize) -> bool {
        let mut is_in_plane = false;
        self.plain_hit(ray.row as usize, leaf, lane, || is_in_plane = true);
        is_in_plane
    }

    /// The hit of one triangle by the plain path, and its scaled `t`, if it is in the span.
    #[cold]
    #[inline(never)]
    fn hit_in_span(&self, ray: &KernelRay, leaf: u32, lane: usize) -> Option<(Crossing, f64)> {
        let hit = self.plain_hit(ray.row as usize, leaf, lane, || ())?;
        (ray.from() <= hit.1 && hit.1 <= ray.to()).then_some(hit)
    }
}
