//! A ray prepared for the nodes and the blocks of one mesh.

/// No leaf.
pub(super) const MISS: u32 = u32::MAX;

/// The state of a ray in the kernel.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct KernelRay {
    /// For boxes, from the entry into the mesh's box, in units of the tree's frame: the reciprocal direction, the
    /// origin times that, and whether the upper planes are nearer.
    pub reciprocal: [f32; 3],
    pub offset: [f32; 3],
    pub near: [u32; 3],
    /// Boxes beyond this are skipped.
    pub limit: f32,
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
    /// The origin along these axes.
    pub origin: [f64; 3],
    /// Steps along the first two axes per step along the third.
    pub slope: [f64; 2],
    /// The reciprocal of the direction along the third axis.
    pub inverse: f64,
    /// A bound on the rounding error of an edge function.
    pub doubt: f64,
    /// A bound on the error of the sum of edge functions times depths, and of the sum of edge functions times the
    /// largest depth, together.
    pub depth_doubt: f64,
    /// The `t` at which it enters the mesh's box, and units of the frame for boxes per `t`.
    pub entry: f64,
    pub per_t: f64,
    /// The interval of `t` in which hits count.
    pub from: f64,
    pub to: f64,
    /// Hits whose `t` differ by more are separate events.
    pub margin: f64,
    /// An interval that contains the `t` of the best hit.
    pub best: [f64; 2],
}

/// Whether a ray can hit the mesh, and who decides it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prepared {
    Ready,
    Misses,
    /// It may begin inside the solid.
    ReadyInside,
    /// The numbers are extreme: the plain path has to do it.
    Plain,
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
pub(super) fn beyond(depth: f64) -> f32 {
    (depth.max(0.0) * (1.0 + 6e-7)) as f32 + 1e-12
}
