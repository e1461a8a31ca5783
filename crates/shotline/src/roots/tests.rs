use proptest::prelude::*;

use super::*;
use crate::lecture::polynomials::{cubic, quartic, quartic_between};

/// The coefficients of the product of `x - root`.
fn with_roots<const N: usize>(roots: &[f64]) -> [f64; N] {
    let mut c = [0.0; N];
    c[0] = 1.0;
    for (degree, root) in roots.iter().enumerate() {
        for i in (0..=degree).rev() {
            c[i + 1] += c[i];
            c[i] *= -root;
        }
    }
    c
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{found:?} {expected:?}");
    }
}

#[test]
fn whole_roots_are_found() {
    assert_eq!(*linear([-6.0, 2.0]), [3.0]);
    assert_eq!(*quadratic(with_roots(&[-2.0, 5.0])), [-2.0, 5.0]);
    assert_near(&cubic(with_roots(&[-2.0, 1.0, 5.0])), &[-2.0, 1.0, 5.0], 1e-15);
    assert_near(&quartic(with_roots(&[-7.0, -2.0, 1.0, 5.0])), &[-7.0, -2.0, 1.0, 5.0], 1e-15);
    assert_eq!(quartic([1.0, 0.0, 0.0, 0.0, 1.0]).len(), 0);
}

#[test]
fn multiple_roots_come_once() {
    assert_eq!(*quadratic(with_roots(&[3.0, 3.0])), [3.0]);
    assert_eq!(*quadratic([0.0, 0.0, 2.0]), [0.0]);
    assert_eq!(*cubic(with_roots(&[0.0, 0.0, 0.0])), [0.0]);
    assert_near(&cubic(with_roots(&[1.0, 1.0, 1.0])), &[1.0], 1e-4);
    assert_near(&cubic(with_roots(&[-1.0, 3.0, 3.0])), &[-1.0, 3.0], 1e-7);
    assert_near(&quartic(with_roots(&[-2.0, 1.0, 1.0, 1.0])), &[-2.0, 1.0], 1e-4);
    assert_eq!(*quartic([0.0, 0.0, 0.0, 0.0, -5.0]), [0.0]);
}

#[test]
fn a_zero_discriminant_is_told_from_a_tiny_one() {
    // (x - (1 + e)) (x - (1 - e)): textbook evaluation of b^2 - 4 a c gives zero.
    let e = f64::EPSILON;
    assert_eq!(quadratic([1.0 - e, -2.0, 1.0]).len(), 2);
    assert_eq!(quadratic([1.0, -2.0, 1.0]).len(), 1);
    assert_eq!(quadratic([1.0 + e, -2.0, 1.0]).len(), 0);
}

#[test]
fn leading_zeros_and_constants() {
    assert_eq!(*quartic([-6.0, 2.0, 0.0, 0.0, 0.0]), [3.0]);
    assert_eq!(*quartic([-4.0, 0.0, 1.0, 0.0, 0.0]), [-2.0, 2.0]);
    assert_eq!(quartic([1.0, 0.0, 0.0, 0.0, 0.0]).len(), 0);
    assert_eq!(quartic([0.0; 5]).len(), 0);
    // A tiny leading coefficient adds distant roots and does not change the others.
    for tiny in [1e-20, 1e-100, -1e-100, 1e-250] {
        let found = cubic([-4.0, 0.0, 1.0, tiny]);
        assert_near(&found.within(-3.0, 3.0), &[-2.0, 2.0], 1e-15);
        assert_near(
            &found.iter().filter(|x| x.abs() > 3.0).copied().collect::<Vec<_>>(),
            &[-1.0 / tiny],
            1e-15,
        );
    }
}

#[test]
fn intervals_are_open() {
    let c = with_roots(&[-7.0, -2.0, 1.0, 5.0]);
    assert_near(&quartic_between(c, -3.0, 4.0, 0.0), &[-2.0, 1.0], 1e-15);
    assert_eq!(quartic_between(c, 6.0, 9.0, 0.0).len(), 0);
    assert_near(&cubic_between(with_roots(&[1.0, 2.0, 3.0]), 1.5, 3.5, 1e-5), &[2.0, 3.0], 1e-8);
}

#[test]
fn extreme_coefficients_end_without_nan() {
    let extremes = [0.0, 5e-324, 1e-300, 1.0, -1.0, 1e300, -f64::MAX, f64::INFINITY, f64::NAN];
    let n = extremes.len();
    for i in 0..n.pow(5) {
        let c = std::array::from_fn(|k| extremes[i / n.pow(k as u32) % n]);
        let found = quartic(c);
        assert!(found.iter().all(|x| x.is_finite()), "{c:?} {found:?}");
        assert!(found.windows(2).all(|w| w[0] < w[1]), "{c:?} {found:?}");
        assert!(c.iter().all(|x| x.is_finite()) || found.is_empty());
    }
}

/// Ascending roots at least 2 apart, none of them near zero.
fn spaced_roots(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-10.0..10.0f64, count).prop_map(|mut x| {
        x.sort_by(f64::total_cmp);
        x.iter().enumerate().map(|(i, x)| x + 2.0 * i as f64).filter(|x| x.abs() > 0.01).collect()
    })
}

proptest! {
    #[test]
    fn known_roots_are_found(roots in spaced_roots(4), factor in prop_oneof![-5.0..-0.1f64, 0.1..5.0f64]) {
        let c: [f64; 5] = with_roots(&roots);
        let found = quartic(c.map(|x| x * factor));
        prop_assert_eq!(found.len(), roots.len());
        for (a, b) in found.iter().zip(&roots) {
            prop_assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn powers_of_two_scale_roots_exactly(
        c in prop::array::uniform5(-1.0..1.0f64),
        k in -60..60i32,
        m in -60..60i32,
    ) {
        let scaled = std::array::from_fn(|i| c[i] * 2f64.powi(m - k * i as i32));
        let (a, b) = (quartic(c), quartic(scaled));
        prop_assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b.iter()) {
            prop_assert_eq!(a * 2f64.powi(k), *b);
        }
    }

    /// Each root found is within rounding of a zero, and between them the sign does not change.
    #[test]
    fn signs_change_only_at_roots(c in prop::array::uniform4(-1.0..1.0f64), x in -20.0..20.0f64) {
        let found = cubic(c);
        let below = found.iter().filter(|r| **r < x).count();
        let value = horner(&c, x).0;
        prop_assume!(found.iter().all(|r| (r - x).abs() > 1e-6 * (1.0 + x.abs())));
        // At the far left the sign is that of -c[3]; a double root may or may not be in the list.
        prop_assume!(value.abs() > 1e-9 && found.len() != 2);
        prop_assert_eq!((value > 0.0) == (c[3] < 0.0), below % 2 == 0);
    }

    #[test]
    fn quadratics_are_stable(x in 1e-9..1e-3f64, y in 1.0..1e9f64) {
        // x + y and x y are rounded, which moves the roots by about an ulp.
        let found = quadratic([x * y, -(x + y), 1.0]);
        prop_assert_eq!(found.len(), 2);
        prop_assert!((found[0] - x).abs() <= 4.0 * f64::EPSILON * x);
        prop_assert!((found[1] - y).abs() <= 4.0 * f64::EPSILON * y);
    }
}
