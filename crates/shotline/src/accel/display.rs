//! Formats numbers and boxes for people.

use crate::aabb::Aabb;

/// At most six significant digits, without trailing zeros.
pub(super) fn number(x: f64) -> String {
    let rounded = format!("{x:.5e}").parse().unwrap_or(x);
    let digits = format!("{rounded:?}");
    digits.strip_suffix(".0").map_or(digits.clone(), str::to_owned)
}

/// The interval along each axis.
pub(super) fn box_of(b: &Aabb) -> String {
    let axis = |i: usize| format!("[{}, {}]", number(b.min[i]), number(b.max[i]));
    format!("{} x {} x {}", axis(0), axis(1), axis(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn numbers_are_short() {
        let corner = Vec3::new(0.1 + 0.2, 1e300, 2.0 / 3.0);
        let b = Aabb::new(-corner, corner + Vec3::X);
        assert_eq!(box_of(&b), "[-0.3, 1.3] x [-1e300, 1e300] x [-0.666667, 0.666667]");
    }
}
