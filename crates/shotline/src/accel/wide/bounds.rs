//! Boxes in the frame of the tree, in float32.

/// A box, or the centres of boxes. The fourth components make it a vector register wide.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Bounds {
    pub low: [f32; 4],
    pub high: [f32; 4],
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    pub fn of([low, high]: [[f32; 3]; 2]) -> Bounds {
        let vector = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        Bounds { low: vector(low), high: vector(high) }
    }

    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.low[axis] > self.high[axis])
    }

    /// The box, or the standard empty one, which changes no union.
    pub fn or_empty(self) -> Bounds {
        if self.is_empty() { Bounds::EMPTY } else { self }
    }

    pub fn intersection(self, other: Bounds) -> Bounds {
        Bounds { low: greater(self.low, other.low), high: lesser(self.high, other.high) }
    }

    #[inline(always)]
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds { low: lesser(self.low, other.low), high: greater(self.high, other.high) }
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let size: [f32; 3] = std::array::from_fn(|i| self.high[i] - self.low[i]);
        size[0] * size[1] + size[1] * size[2] + size[2] * size[0]
    }
}

#[inline(always)]
fn lesser(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|i| if b[i] < a[i] { b[i] } else { a[i] })
}

#[inline(always)]
fn greater(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|i| if b[i] > a[i] { b[i] } else { a[i] })
}

/// An item and its box. The fourth components are halves of the number of the item, as the fractions of numbers between
/// 1 and 2: so vector registers are loaded as they are, and no operation on all components meets a NaN or a subnormal
/// number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct ItemBox {
    low: [f32; 4],
    high: [f32; 4],
}

const ONE: u32 = 1f32.to_bits();

impl ItemBox {
    pub fn new(item: u32, [low, high]: [[f32; 3]; 2]) -> ItemBox {
        let with = |[x, y, z]: [f32; 3], half: u32| [x, y, z, f32::from_bits(ONE | half)];
        ItemBox { low: with(low, item & 0xffff), high: with(high, item >> 16) }
    }

    pub fn item(&self) -> u32 {
        let half = |x: f32| x.to_bits() & 0xffff;
        half(self.high[3]) << 16 | half(self.low[3])
    }

    /// The same item with another box.
    pub fn within(&self, bounds: &Bounds) -> ItemBox {
        let corner = |[x, y, z, _]: [f32; 4]| [x, y, z];
        ItemBox::new(self.item(), [corner(bounds.low), corner(bounds.high)])
    }

    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        Bounds { low: self.low, high: self.high }
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn centre(&self) -> [f32; 4] {
        std::array::from_fn(|i| self.low[i] + self.high[i])
    }

    /// Twice the centre along an axis.
    #[inline(always)]
    pub fn centre_along(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }
}

/// The bounds of items, and those of their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub bounds: Bounds,
    pub centres: Bounds,
}

impl Extent {
    pub const EMPTY: Extent = Extent { bounds: Bounds::EMPTY, centres: Bounds::EMPTY };

    pub fn of(items: &[ItemBox]) -> Extent {
        items.iter().fold(Extent::EMPTY, Extent::with)
    }

    #[inline(always)]
    pub fn with(self, item: &ItemBox) -> Extent {
        let centre = item.centre();
        Extent {
            bounds: self.bounds.union(item.bounds()),
            centres: self.centres.union(Bounds { low: centre, high: centre }),
        }
    }

    pub fn union(self, other: Extent) -> Extent {
        Extent { bounds: self.bounds.union(other.bounds), centres: self.centres.union(other.centres) }
    }
}
