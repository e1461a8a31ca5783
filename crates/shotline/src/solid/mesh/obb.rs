//! Oriented boxes around small convex sets (S. Gottschalk, M. C. Lin and D. Manocha 1996, "OBBTree").
//!
//! Long thin triangles that are not aligned with the axes have axis-aligned boxes that overlap by the thousands, though
//! the triangles are far apart. Boxes along the principal axes of a set fit tightly.

use crate::aabb::Aabb;
use crate::math::Vec3;

/// A bound on the effect of rounding on a separation, relative to the sizes and the distance of the boxes: thousands of
/// half-ulps, while the sums below need some dozens.
const MARGIN: f64 = 1e-12;

/// A box along its own three axes, which are orthonormal up to rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obb {
    centre: Vec3,
    axes: [Vec3; 3],
    half: Vec3,
    /// The axis-aligned box of the same set: tested first because that is cheap.
    bounds: Aabb,
}

impl Obb {
    /// A box around points, along their principal axes.
    pub(super) fn around(points: impl Iterator<Item = Vec3> + Clone) -> Obb {
        let axes = principal_axes(points.clone());
        let bounds = Aabb::around(points.clone());
        let middle = bounds.centre();
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in points {
            let along = in_axes(&axes, p - middle);
            (low, high) = (low.min(along), high.max(along));
        }
        let offset = (low + high) * 0.5;
        let centre = middle + axes[0] * offset.x + axes[1] * offset.y + axes[2] * offset.z;
        // The centre has the rounding error of its coordinates, however small the box is.
        let rounding = 2.0 * f64::EPSILON * (centre.abs() + offset.abs()).max_element();
        Obb { centre, axes, half: (high - low) * 0.5 + Vec3::splat(rounding), bounds }
    }

    /// An axis-aligned box around two others.
    pub(super) fn union(&self, other: &Obb) -> Obb {
        let bounds = self.bounds.union(&other.bounds);
        let centre = bounds.centre();
        let rounding = 2.0 * f64::EPSILON * centre.abs().max_element();
        Obb { centre, axes: Vec3::AXES, half: bounds.size() * 0.5 + Vec3::splat(rounding), bounds }
    }

    /// Returns the axis of the box along which the points have the largest extent.
    pub(super) fn widest_axis(&self, points: impl Iterator<Item = Vec3>) -> Vec3 {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in points {
            let along = in_axes(&self.axes, p - self.centre);
            (low, high) = (low.min(along), high.max(along));
        }
        let spread = high - low;
        let widest = (0..3).fold(0, |best, i| if spread[i] > spread[best] { i } else { best });
        self.axes[widest]
    }

    pub(super) fn centre(&self) -> Vec3 {
        self.centre
    }

    /// The sum of the half edges, which decides which of two boxes is opened first.
    pub(super) fn size(&self) -> f64 {
        self.half.element_sum()
    }

    /// Whether one of the fifteen candidate axes separates the two boxes, with a margin for rounding.
    pub(super) fn is_apart_from(&self, other: &Obb) -> bool {
        let between = other.centre - self.centre;
        let reach = between.abs().element_sum() + self.half.element_sum() + other.half.element_sum();
        let margin = MARGIN * reach;
        let gap = (other.bounds.min - self.bounds.max).max(self.bounds.min - other.bounds.max);
        if gap.max_element() > margin {
            return true;
        }
        let separates =
            |axis: Vec3| between.dot(axis).abs() > self.reach_along(axis) + other.reach_along(axis) + margin;
        self.axes.iter().chain(&other.axes).any(|axis| separates(*axis))
            || self.axes.iter().any(|a| other.axes.iter().any(|b| separates(a.cross(*b))))
    }

    fn reach_along(&self, axis: Vec3) -> f64 {
        let [a, b, c] = self.axes.map(|a| a.dot(axis).abs());
        a * self.half.x + b * self.half.y + c * self.half.z
    }
}

/// The coordinates of a vector along three axes.
pub(super) fn in_axes(axes: &[Vec3; 3], v: Vec3) -> Vec3 {
    Vec3::new(axes[0].dot(v), axes[1].dot(v), axes[2].dot(v))
}

/// The principal axes of points, orthonormal up to rounding: the eigenvectors of their covariance, by Jacobi's method.
pub(super) fn principal_axes(points: impl Iterator<Item = Vec3> + Clone) -> [Vec3; 3] {
    let bounds = Aabb::around(points.clone());
    let (middle, size) = (bounds.centre(), bounds.size().max_element());
    if !(size > 0.0 && size.is_finite()) {
        return Vec3::AXES;
    }
    let (mut count, mut sum, mut m) = (0.0, Vec3::ZERO, [[0.0; 3]; 3]);
    for p in points {
        let r = (p - middle) / size;
        (count, sum) = (count + 1.0, sum + r);
        for i in 0..3 {
            (0..3).for_each(|j| m[i][j] += r[i] * r[j]);
        }
    }
    let mean = sum / count;
    for i in 0..3 {
        (0..3).for_each(|j| m[i][j] = m[i][j] / count - mean[i] * mean[j]);
    }
    eigenvectors(m)
}

/// The eigenvectors of a symmetric matrix, approximately: after any number of sweeps they are orthonormal, so a few
/// suffice.
fn eigenvectors(mut m: [[f64; 3]; 3]) -> [Vec3; 3] {
    let mut axes = Vec3::AXES;
    for _ in 0..4 {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            if m[i][j].abs() <= 1e-30 {
                continue;
            }
            let theta = (m[j][j] - m[i][i]) / (2.0 * m[i][j]);
            let t = 1f64.copysign(theta) / (theta.abs() + theta.hypot(1.0));
            let (c, s) = (1.0 / t.hypot(1.0), t / t.hypot(1.0));
            for row in &mut m {
                (row[i], row[j]) = (c * row[i] - s * row[j], s * row[i] + c * row[j]);
            }
            let (upper, lower) = (m[i], m[j]);
            m[i] = std::array::from_fn(|k| c * upper[k] - s * lower[k]);
            m[j] = std::array::from_fn(|k| s * upper[k] + c * lower[k]);
            (axes[i], axes[j]) = (c * axes[i] - s * axes[j], s * axes[i] + c * axes[j]);
        }
    }
    if axes.iter().all(|axis| axis.is_finite()) { axes } else { Vec3::AXES }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    #[test]
    fn the_axes_follow_a_rod() {
        let along = Vec3::new(1.0, 2.0, -0.5).normalize();
        let points: Vec<Vec3> =
            (0..50).map(|i| along * f64::from(i) + Vec3::splat(f64::from(i % 3) * 1e-3)).collect();
        let rod = Obb::around(points.iter().copied());
        assert!(rod.half.max_element() > 24.0);
        assert_eq!(rod.half.to_array().iter().filter(|h| **h < 0.01).count(), 2, "{rod:?}");
    }

    #[test]
    fn sets_that_share_a_point_are_never_apart() {
        let mut random = Random::new(7);
        for _ in 0..2000 {
            let shared = random.point(-1.0, 1.0);
            let mut set = |size: f64| {
                let others: Vec<Vec3> = (0..3).map(|_| shared + random.point(-1.0, 1.0) * size).collect();
                Obb::around(others.into_iter().chain([shared]).collect::<Vec<_>>().into_iter())
            };
            let (a, b) = (set(1.0), set(1e-6));
            assert!(!a.is_apart_from(&b) && !b.is_apart_from(&a));
        }
    }

    #[test]
    fn parallel_rods_across_the_axes_are_apart() {
        let along = Vec3::new(1.0, 1.0, 1.0);
        let side = Vec3::new(1.0, -1.0, 0.0);
        let rod = |k: f64| {
            let from = side * k;
            let corners = [from, from + along, from + side * 0.4, from + along + side * 0.4];
            Obb::around(corners.into_iter())
        };
        assert!(rod(0.0).is_apart_from(&rod(0.01 + 0.4)) && !rod(0.0).is_apart_from(&rod(0.39)));
    }
}
