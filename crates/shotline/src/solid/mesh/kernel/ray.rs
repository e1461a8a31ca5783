//! A ray prepared for the nodes and the blocks of one mesh.

use crate::simd::Doubles;

/// No leaf.
pub(super) const MISS: u32 = u32::MAX;

/// The state of a ray in the kernel. Its numbers are written eight at a time: the methods name them.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct KernelRay {
    /// For boxes: the reciprocal direction, the origin times that, and the depth beyond which boxes are skipped. All are
    /// from the entry into the mesh's box, in units of the tree's frame.
    pub boxes: [f32; 8],
    /// The number of the ray in its block.
    pub row: u32,
    /// The best hit so far: its leaf and lane.
    pub leaf: u32,
    pub lane: u32,
    /// Whether another hit is so near the best one that both may be coincident.
    pub may_coincide: bool,
    /// Whether the best hit is certainly not near an edge: see [`INSET`].
    pub is_off_edges: bool,
    /// For triangles: the axis in which the direction is largest, after the two others in cyclic order.
    pub axes: [u32; 3],
    /// For triangles: the origin along these axes, the steps along the first two per step along the third, the reciprocal
    /// of the direction along the third, and the doubts.
    pub triangles: [f64; 8],
    /// In units of `t`: the entry, the units of the frame for boxes per `t`, the interval in which hits count, the
    /// margin, and the interval of the best hit.
    pub ts: [f64; 8],
}

impl KernelRay {
    #[inline(always)]
    pub fn reciprocal(&self, axis: usize) -> f32 {
        self.boxes[axis]
    }

    #[inline(always)]
    pub fn offset(&self, axis: usize) -> f32 {
        self.boxes[3 + axis]
    }

    /// Boxes beyond this are skipped.
    #[inline(always)]
    pub fn limit(&self) -> f32 {
        self.boxes[6]
    }

    /// Whether the ray meets upper planes of an axis first: 1 or 0.
    #[inline(always)]
    pub fn upper_is_near(&self, axis: usize) -> usize {
        (self.boxes[axis].to_bits() >> 31) as usize
    }

    /// The origin along one of the axes for triangles.
    #[inline(always)]
    pub fn origin(&self, role: usize) -> f64 {
        self.triangles[role]
    }

    /// Steps along the first or the second axis per step along the third.
    #[inline(always)]
    pub fn slope(&self, role: usize) -> f64 {
        self.triangles[3 + role]
    }

    /// The reciprocal of the direction along the third axis.
    #[inline(always)]
    pub fn inverse(&self) -> f64 {
        self.triangles[5]
    }

    /// A bound on the rounding error of an edge function.
    #[inline(always)]
    pub fn doubt(&self) -> f64 {
        self.triangles[6]
    }

    /// A bound on the error of the sum of edge functions times depths, and of the sum of edge functions times the
    /// largest depth, together.
    #[inline(always)]
    pub fn depth_doubt(&self) -> f64 {
        self.triangles[7]
    }

    /// The interval of `t` in which hits count.
    #[inline(always)]
    pub fn from(&self) -> f64 {
        self.ts[2]
    }

    #[inline(always)]
    pub fn to(&self) -> f64 {
        self.ts[3]
    }

    /// Hits whose `t` differ by more are separate events.
    #[inline(always)]
    pub fn margin(&self) -> f64 {
        self.ts[4]
    }

    /// An interval that contains the `t` of the best hit.
    #[inline(always)]
    pub fn best(&self) -> [f64; 2] {
        [self.ts[5], self.ts[6]]
    }

    /// Sets the interval of the best hit, and skips boxes beyond it and beyond what may be one event with it.
    #[inline(always)]
    pub fn set_best(&mut self, [low, high]: [f64; 2]) {
        let [entry, per_t, ..] = self.ts;
        (self.ts[5], self.ts[6]) = (low, high);
        self.boxes[6] = beyond((high + self.margin() - entry) * per_t);
    }
}

/// Which of some rays that were prepared together can hit the mesh, and who decides it: masks of them. The others miss
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Prepared {
    pub ready: u8,
    /// Those of the ready ones that may begin inside the solid.
    pub inside: u8,
    /// Those whose numbers are extreme: the plain path has to do them.
    pub plain: u8,
}

impl Prepared {
    /// These rays and others that follow at a position.
    #[inline(always)]
    pub fn with(self, others: Prepared, position: usize) -> Prepared {
        Prepared {
            ready: self.ready | others.ready << position,
            inside: self.inside | others.inside << position,
            plain: self.plain | others.plain << position,
        }
    }
}

/// Intervals of `t` are widened by this, so that `t` that underflow when they are scaled back count as equal.
pub(super) const SMALLEST: f64 = f64::from_bits((1023 - 100) << 52);

/// A hit is off the edges if its barycentric coordinates, which are the shares of the edge functions in their sum, are
/// certainly larger than half of this.
pub(in crate::solid::mesh) const INSET: f64 = 1.0 / 512.0;

/// If all other faces are farther from a hit than this, after scaling, then the `t` of the other hits of the ray differ
/// by more than half of this and an eighth of that: no direction is longer than the root of 3.
pub(in crate::solid::mesh) const CLEARANCE: f64 = f64::from_bits((1023 - 36) << 52);

/// A float32 limit for boxes behind a depth from the entry: larger by more than the rounding of a box test.
#[inline(always)]
fn beyond(depth: f64) -> f32 {
    (depth.max(0.0) * (1.0 + 6e-7) + 1e-12) as f32
}

/// [`beyond`] lane by lane, before it is rounded to float32.
#[inline(always)]
pub(super) fn beyond_all<F: Doubles>(depth: F) -> F {
    depth.greater(F::splat(0.0)) * F::splat(1.0 + 6e-7) + F::splat(1e-12)
}
