//! The frame of a wide hierarchy: its boxes are float32, relative to the centre and in units of the size.

use crate::aabb::Aabb;
use crate::math::{Vec3, binary_exponent, power_of_two};

/// By how much boxes are padded, in units of the frame. It covers the rounding of the planes of a node when they are
/// tested in float32; the argument is beside that test.
pub(crate) const PAD: f64 = 1.0 / (1 << 22) as f64;

/// A position and a size. A point `v` has the coordinates `(v - centre) / size`, within -1 and 1 for points in the
/// bounds of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub centre: Vec3,
    /// A power of two.
    pub size: f64,
}

impl Default for Frame {
    fn default() -> Frame {
        Frame { centre: Vec3::ZERO, size: 1.0 }
    }
}

impl Frame {
    /// The frame of everything in a box.
    pub fn of(bounds: &Aabb) -> Frame {
        // Half of each, so that no sum overflows.
        let centre = bounds.min * 0.5 + bounds.max * 0.5;
        let reach = (bounds.max - centre).abs().max((bounds.min - centre).abs()).max_element();
        Frame { centre, size: power_of_two(binary_exponent(reach).clamp(-1000, 1000)) }
    }

    /// The coordinates of a padded box, rounded outwards: the lower corner and the upper.
    pub fn outward(&self, bounds: &Aabb) -> [[f32; 3]; 2] {
        // The differences are rounded by at most half an ulp of themselves, far less than the pad.
        padded(self.coordinates(bounds.min), self.coordinates(bounds.max))
    }

    /// The coordinates of a point.
    pub fn coordinates(&self, v: Vec3) -> Vec3 {
        (v - self.centre) * self.size.recip()
    }
}

/// A padded box, rounded outwards: the lower corner and the upper.
pub(super) fn padded(low: Vec3, high: Vec3) -> [[f32; 3]; 2] {
    // Coordinates are at most slightly greater than 1, so rounding moves them by at most a quarter of the pad.
    let pad = 1.25 * PAD;
    [(low - pad).as_vec3().to_array(), (high + pad).as_vec3().to_array()]
}
