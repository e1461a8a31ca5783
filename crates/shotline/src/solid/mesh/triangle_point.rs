//! The point of a triangle that is nearest to the origin.

use crate::math::Vec3;

/// Returns the weights of the corners at the nearest point, and the point.
///
/// The candidates are the nearest points of the sides, and the foot of the perpendicular if it is inside. The foot is found
/// along the longest side and across it (Gram and Schmidt), which stays accurate in slivers, where the determinant of C.
/// Ericson's barycentric coordinates ("Real-Time Collision Detection", 2005, section 3.4) has no correct digit. Every
/// candidate is a point of the triangle, so an error never makes a distance too small.
pub(super) fn nearest_to_origin(corners: [Vec3; 3]) -> ([f64; 3], Vec3) {
    let sides = [0, 1, 2].map(|i| corners[(i + 1) % 3] - corners[i]);
    let squares = sides.map(|side| side.length_squared());
    let first = if squares[0] >= squares[1] && squares[0] >= squares[2] {
        0
    } else if squares[1] >= squares[2] {
        1
    } else {
        2
    };
    let (mut weights, mut best, mut least) = ([0.0; 3], Vec3::ZERO, f64::INFINITY);
    let mut meet = |of: [f64; 3], point: Vec3| {
        let square = point.length_squared();
        if square < least {
            (weights, best, least) = (of, point, square);
        }
    };
    for i in [0, 1, 2] {
        let along = -corners[i].dot(sides[i]) / squares[i];
        // A side without length has no square, or one that underflows.
        let along = if along.is_nan() { 0.0 } else { along.clamp(0.0, 1.0) };
        let mut of = [0.0; 3];
        (of[i], of[(i + 1) % 3]) = (1.0 - along, along);
        // From the nearer end, which makes a corner exact.
        let point = if along <= 0.5 {
            corners[i] + sides[i] * along
        } else {
            corners[(i + 1) % 3] - sides[i] * (1.0 - along)
        };
        meet(of, point);
    }
    if let Some((across, along)) = foot(corners[first], sides[first], squares[first], -sides[(first + 2) % 3])
    {
        let point = corners[first] + sides[first] * along - sides[(first + 2) % 3] * across;
        let mut of = [0.0; 3];
        (of[first], of[(first + 1) % 3], of[(first + 2) % 3]) = (1.0 - along - across, along, across);
        meet(of, point);
    }
    (weights, best)
}

/// The weights of the third and the second corner at the foot of the perpendicular, if it is inside. The other two corners are
/// at `side` and `other` from the corner `a`.
fn foot(a: Vec3, side: Vec3, square: f64, other: Vec3) -> Option<(f64, f64)> {
    let slant = other.dot(side) / square;
    let height = other - side * slant;
    // Both without their parts along the side: where the height is small, a rest of such a part would be large beside it.
    let beyond = -a.dot(side) / square;
    let across = (-a - side * beyond).dot(height) / height.length_squared();
    let along = beyond - across * slant;
    // NaN is not inside.
    let is_inside = across > 0.0 && along > 0.0 && along + across < 1.0;
    is_inside.then_some((across, along))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::random::Random;

    /// No point of a fine grid of the triangle is nearer.
    #[test]
    fn no_other_point_is_nearer() {
        let mut random = Random::new(9);
        for _ in 0..500 {
            let shift = random.point(-1.0, 1.0) * [0.1, 1.0, 100.0][random.below(3)];
            let corners = [0; 3].map(|_| random.point(-1.0, 1.0) + shift);
            let ([u, v, w], found) = nearest_to_origin(corners);
            let at = |u: f64, v: f64, w: f64| corners[0] * u + corners[1] * v + corners[2] * w;
            assert!((at(u, v, w) - found).length() < 1e-13 * (1.0 + shift.length()));
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    assert!(at(u, v, 1.0 - u - v).length() > found.length() - 1e-13 * (1.0 + shift.length()));
                }
            }
        }
    }

    /// Points of slivers, along their whole length, are found where they are.
    #[test]
    fn points_of_slivers_are_found() {
        let mut random = Random::new(10);
        for width in [1e-3, 1e-8, 1e-13] {
            for _ in 0..300 {
                let direction = random.direction();
                let aside = direction.any_orthonormal_vector() * width;
                let corners = [Vec3::ZERO, direction, direction * random.number(0.1, 0.9) + aside];
                let weights = [random.number(0.1, 1.0), random.number(0.1, 1.0), random.number(0.1, 1.0)];
                let sum: f64 = weights.iter().sum();
                let p = (corners[1] * weights[1] + corners[2] * weights[2]) / sum;
                let (_, found) = nearest_to_origin(corners.map(|corner| corner - p));
                assert!(found.length() < 4e-15, "{width} {}", found.length());
                let height = direction.cross(aside).normalize() * 0.5;
                let (_, found) = nearest_to_origin(corners.map(|corner| corner - p - height));
                assert!((found.length() - 0.5).abs() < 4e-15);
            }
        }
    }

    #[test]
    fn triangles_without_area_have_nearest_points() {
        let (x, z) = (Vec3::X, Vec3::Z);
        let (_, found) = nearest_to_origin([z, z, z]);
        assert_eq!(found, z);
        let (weights, found) = nearest_to_origin([z - x, z + x * 3.0, z - x]);
        assert_eq!((weights[1], found), (0.25, z));
        let tiny = 1e-170;
        assert_eq!(nearest_to_origin([z, z + x * tiny, z + Vec3::Y * tiny]).1, z);
    }
}
