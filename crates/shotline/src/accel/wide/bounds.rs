//! Boxes in the frame of the tree, in float32.

/// Greater than every coordinate of a padded box in the frame.
const REACH: f32 = 1.0 + 1.0 / (1 << 16) as f32;

/// Added to the planes of an item, so that no rounding here moves a plane inwards: of a sum below 4, and of a coordinate.
const MARGIN: f32 = 1.0 / (1 << 22) as f32;

/// A box: how far the lower planes are below [`REACH`] and the upper ones above its negative, each with a fourth component
/// that means nothing. So no number is negative, their bits are ordered as they are, and a union is one operation on
/// the integers of a vector register.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Bounds {
    planes: [f32; 8],
}

impl Bounds {
    /// Less than all others.
    pub const EMPTY: Bounds = Bounds { planes: [-1.0; 8] };

    /// The box between two corners, each slightly moved outwards.
    #[inline(always)]
    pub fn of([low, high]: [[f32; 3]; 2]) -> Bounds {
        const OUT: f32 = REACH + MARGIN;
        let [below, above] = [low.map(|x| OUT - x), high.map(|x| OUT + x)];
        Bounds { planes: [below[0], below[1], below[2], 0.0, above[0], above[1], above[2], 0.0] }
    }

    #[inline(always)]
    pub fn low(&self, axis: usize) -> f32 {
        REACH - self.planes[axis]
    }

    #[inline(always)]
    pub fn high(&self, axis: usize) -> f32 {
        self.planes[4 + axis] - REACH
    }

    #[inline(always)]
    pub fn size(&self, axis: usize) -> f32 {
        self.planes[4 + axis] + self.planes[axis] - 2.0 * REACH
    }

    /// The sizes along the axes, and a number that means nothing.
    #[inline(always)]
    pub fn sizes(&self) -> [f32; 4] {
        [self.size(0), self.size(1), self.size(2), self.size(3)]
    }

    /// The lower corner and the upper.
    #[inline(always)]
    pub fn corners(&self) -> [[f32; 3]; 2] {
        [[self.low(0), self.low(1), self.low(2)], [self.high(0), self.high(1), self.high(2)]]
    }

    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.size(axis) < 0.0)
    }

    /// The box, or the standard empty one, which changes no union.
    pub fn or_empty(self) -> Bounds {
        if self.is_empty() { Bounds::EMPTY } else { self }
    }

    pub fn intersection(self, other: Bounds) -> Bounds {
        self.zip(other, i32::min)
    }

    #[inline(always)]
    pub fn union(self, other: Bounds) -> Bounds {
        self.zip(other, i32::max)
    }

    #[inline(always)]
    fn zip(mut self, other: Bounds, with: impl Fn(i32, i32) -> i32) -> Bounds {
        for (a, b) in self.planes.iter_mut().zip(other.planes) {
            *a = f32::from_bits(with(a.to_bits() as i32, b.to_bits() as i32) as u32);
        }
        self
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z, _] = self.sizes();
        x * y + y * z + z * x
    }
}

/// An item and its box, as in [`Bounds`]. The fourth components are halves of the number of the item, as the fractions of
/// numbers between 1 and 2: so vector registers are loaded as they are, and no operation on all components meets a NaN or
/// a subnormal number.
#[derive(Clone, Copy, Debug)]
pub(super) struct ItemBox {
    bounds: Bounds,
}

const ONE: u32 = 1f32.to_bits();

impl Default for ItemBox {
    fn default() -> ItemBox {
        ItemBox { bounds: Bounds { planes: [0.0; 8] } }
    }
}

impl ItemBox {
    #[inline(always)]
    pub fn new(item: u32, corners: [[f32; 3]; 2]) -> ItemBox {
        ItemBox { bounds: Bounds::of(corners) }.with_item(item)
    }

    #[inline(always)]
    fn with_item(mut self, item: u32) -> ItemBox {
        self.bounds.planes[3] = f32::from_bits(ONE | (item & 0xffff));
        self.bounds.planes[7] = f32::from_bits(ONE | item >> 16);
        self
    }

    #[inline(always)]
    pub fn item(&self) -> u32 {
        let half = |x: f32| x.to_bits() & 0xffff;
        half(self.bounds.planes[7]) << 16 | half(self.bounds.planes[3])
    }

    /// The same item with another box.
    pub fn within(&self, bounds: &Bounds) -> ItemBox {
        ItemBox { bounds: *bounds }.with_item(self.item())
    }

    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn centre(&self) -> [f32; 4] {
        let [a, b, c, d, e, f, g, h] = self.bounds.planes;
        [e - a, f - b, g - c, h - d]
    }

    /// Twice the centre along an axis.
    #[inline(always)]
    pub fn centre_along(&self, axis: usize) -> f32 {
        self.bounds.planes[4 + axis] - self.bounds.planes[axis]
    }
}

/// The box around points, each with a fourth component that means nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Centres {
    pub low: [f32; 4],
    pub high: [f32; 4],
}

impl Centres {
    const EMPTY: Centres = Centres { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn union(mut self, other: Centres) -> Centres {
        for i in 0..4 {
            self.low[i] = if other.low[i] < self.low[i] { other.low[i] } else { self.low[i] };
            self.high[i] = if other.high[i] > self.high[i] { other.high[i] } else { self.high[i] };
        }
        self
    }
}

/// The bounds of items, and those of their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub bounds: Bounds,
    pub centres: Centres,
}

impl Extent {
    pub const EMPTY: Extent = Extent { bounds: Bounds::EMPTY, centres: Centres::EMPTY };

    #[inline(always)]
    pub fn of(items: &[ItemBox]) -> Extent {
        Extent::EMPTY.with_all(items)
    }

    #[inline(always)]
    pub fn with_all(mut self, items: &[ItemBox]) -> Extent {
        for item in items {
            self = self.with(item);
        }
        self
    }

    #[inline(always)]
    fn with(self, item: &ItemBox) -> Extent {
        let centre = item.centre();
        Extent {
            bounds: self.bounds.union(item.bounds()),
            centres: self.centres.union(Centres { low: centre, high: centre }),
        }
    }

    pub fn union(self, other: Extent) -> Extent {
        Extent { bounds: self.bounds.union(other.bounds), centres: self.centres.union(other.centres) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    fn corners(random: &mut Random) -> [[f32; 3]; 2] {
        let [a, b] = [random.point(-1.0, 1.0), random.point(-1.0, 1.0)];
        // Some boxes have no size along an axis.
        let flat = random.below(9);
        let high = a.max(b);
        let mut low = a.min(b);
        if flat < 3 {
            low[flat] = high[flat];
        }
        [low, high].map(|v| v.as_vec3().to_array())
    }

    fn is_around(outer: [[f32; 3]; 2], inner: [[f32; 3]; 2]) -> bool {
        (0..3).all(|axis| outer[0][axis] <= inner[0][axis] && inner[1][axis] <= outer[1][axis])
    }

    #[test]
    fn boxes_hold_their_corners_and_little_more() {
        let mut random = Random::new(2);
        for _ in 0..10_000 {
            let given = corners(&mut random);
            let kept = Bounds::of(given).corners();
            let larger = [given[0].map(|x| x - 3.0 * MARGIN), given[1].map(|x| x + 3.0 * MARGIN)];
            assert!(is_around(kept, given) && is_around(larger, kept), "{given:?} {kept:?}");
            assert_eq!(ItemBox::new(7, given).within(&Bounds::of(given)).bounds().corners(), kept);
        }
    }

    #[test]
    fn a_union_holds_both_boxes_and_an_intersection_is_in_both() {
        let mut random = Random::new(3);
        for _ in 0..1000 {
            let [a, b] = [(); 2].map(|()| Bounds::of(corners(&mut random)));
            let (union, shared) = (a.union(b), a.intersection(b));
            for each in [a, b] {
                assert!(is_around(union.corners(), each.corners()));
                assert!(is_around(each.corners(), shared.corners()));
            }
            assert!(a.intersection(a.union(b)).corners() == a.corners() && !a.is_empty());
            assert!(
                Bounds::EMPTY.union(a).corners() == a.corners() && a.intersection(Bounds::EMPTY).is_empty()
            );
        }
    }
}
