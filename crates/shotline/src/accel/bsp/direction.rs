//! The directions across which planes cut, and the axes among them.

use std::fmt::Debug;
use std::ops::Index;

use crate::aabb::{Aabb, BoxRay, Slope};
use crate::accel::prim_ref::{self, PrimRef, measure};

/// A direction, with heights along it.
pub(in crate::accel) trait Direction: Copy + Debug + Send + Sync + 'static {
    /// All directions across which a tree may cut.
    const ALL: &'static [Self];

    /// Its place among all.
    fn index(self) -> usize;

    /// The height along it, for people.
    fn display(self) -> String;

    /// How a ray passes the planes across it.
    fn slope(self, ray: &BoxRay) -> Slope;

    /// How a ray passes the planes across each direction, by place.
    type Slopes: Index<usize, Output = Slope>;

    /// Works them out.
    fn slopes(ray: &BoxRay) -> Self::Slopes;

    /// The lowest and the greatest height in a box, rounded outward.
    fn extent(self, b: &Aabb) -> (f64, f64);

    /// Boxes around the parts of a box below and above a plane, perhaps rounded.
    fn cut(self, b: &Aabb, at: f64) -> (Aabb, Aabb);

    /// Items below and above a plane, or what of them is.
    fn divide(self, items: &[PrimRef], at: f64) -> (Vec<PrimRef>, Vec<PrimRef>);

    /// What a ray through a box is expected to cost, in tests of an item, if a plane cuts it and so many items
    /// are below and above.
    fn cost(self, b: &Aabb, at: f64, items: [usize; 2]) -> f64;
}

/// What passing a plane across an axis costs, in tests of an item.
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

    fn divide(self, items: &[PrimRef], at: f64) -> (Vec<PrimRef>, Vec<PrimRef>) {
        prim_ref::divide(items, self.index(), at)
    }

    fn cost(self, b: &Aabb, at: f64, [below, above]: [usize; 2]) -> f64 {
        let (low, high) = self.cut(b, at);
        let measure = measure(b);
        PLANE_COST + (measure(&low) * below as f64 + measure(&high) * above as f64) / measure(b)
    }
}
