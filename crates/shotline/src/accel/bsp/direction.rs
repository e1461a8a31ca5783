//! The directions perpendicular to which planes may cut. Here are the axes; `oblique` adds others.

use std::fmt::Debug;
use std::ops::Index;

use crate::aabb::{Aabb, BoxRay, Slope};
use crate::accel::prim_ref::{self, PrimRef, measure};
use crate::math::Vec3;

/// A direction perpendicular to planes. A plane is given by its height along the direction.
pub(in crate::accel) trait Direction: Copy + Debug + Send + Sync + 'static {
    /// All directions that the planes of a tree may have.
    const ALL: &'static [Self];

    /// Its index in `ALL`.
    fn index(self) -> usize;

    /// The formula of the height, for people.
    fn display(self) -> String;

    /// The vector whose product with a point is its height.
    fn normal(self) -> Vec3;

    /// How a ray crosses the planes with this direction.
    fn slope(self, ray: &BoxRay) -> Slope;

    /// How a ray crosses the planes with each direction, by `index`.
    type Slopes: Index<usize, Output = Slope>;

    /// Computes the slopes of a ray.
    fn slopes(ray: &BoxRay) -> Self::Slopes;

    /// The least and the greatest height in a box, rounded outward.
    fn extent(self, b: &Aabb) -> (f64, f64);

    /// Boxes around the pieces of a box below and above a plane; they may have rounding errors.
    fn cut(self, b: &Aabb, at: f64) -> (Aabb, Aabb);

    /// The items below and above a plane. Their boxes may be clipped to it.
    fn partition_by_plane(self, items: &[PrimRef], at: f64) -> (Vec<PrimRef>, Vec<PrimRef>);

    /// The expected cost of a ray through a box that a plane cuts, in units of an item test; `items` are the numbers
    /// of items below and above the plane.
    fn cost(self, b: &Aabb, at: f64, items: [usize; 2]) -> f64;
}

/// The cost of crossing a plane perpendicular to an axis, in units of an item test.
const PLANE_COST: f64 = 1.0;

/// An axis; heights are coordinates.
#[derive(Clone, Copy, Debug)]
pub(in crate::accel) struct Axis(pub u8);

impl Direction for Axis {
    const ALL: &'static [Axis] = &[Axis(0), Axis(1), Axis(2)];

    #[inline]
    fn index(self) -> usize {
        self.0.into()
    }

    fn display(self) -> String {
        ["x", "y", "z"][self.index()].to_owned()
    }

    fn normal(self) -> Vec3 {
        Vec3::AXES[self.index()]
    }

    fn slope(self, ray: &BoxRay) -> Slope {
        ray.slope(self.index())
    }

    type Slopes = [Slope; 3];

    fn slopes(ray: &BoxRay) -> [Slope; 3] {
        [0, 1, 2].map(|axis| ray.slope(axis))
    }

    fn extent(self, b: &Aabb) -> (f64, f64) {
        (b.min[self.index()], b.max[self.index()])
    }

    fn cut(self, b: &Aabb, at: f64) -> (Aabb, Aabb) {
        prim_ref::cut(b, self.index(), at)
    }

    fn partition_by_plane(self, items: &[PrimRef], at: f64) -> (Vec<PrimRef>, Vec<PrimRef>) {
        prim_ref::partition_by_plane(items, self.index(), at)
    }

    fn cost(self, b: &Aabb, at: f64, [below, above]: [usize; 2]) -> f64 {
        let (low, high) = self.cut(b, at);
        let measure = measure(b);
        PLANE_COST + (measure(&low) * below as f64 + measure(&high) * above as f64) / measure(b)
    }
}
