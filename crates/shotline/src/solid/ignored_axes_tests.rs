//! Quadrics whose forms ignore an axis, or nearly, along lines that hardly move along the others. The roots are compared
//! with the exact polynomial.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::capped_tests::{build, cast};
use super::{Kind, quadric};
use crate::crossing::Crossing;
use crate::testkit::random::Random;
use crate::testkit::solid::conformance;

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).expect("a finite number")
}

/// The exact coefficients `[a, b, c]` of a quadric along a line.
fn polynomial(q: &[f64; 10], o: [f64; 3], d: [f64; 3]) -> [BigRational; 3] {
    let (o, d, q) = (o.map(exact), d.map(exact), q.map(exact));
    let mut sum = [BigRational::zero(), BigRational::zero(), BigRational::zero()];
    for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
        sum[0] += &q[k] * &d[i] * &d[j];
        sum[1] += &q[k] * (&o[i] * &d[j] + &d[i] * &o[j]);
        sum[2] += &q[k] * &o[i] * &o[j];
    }
    for i in 0..3 {
        sum[1] += &q[6 + i] * &d[i];
        sum[2] += &q[6 + i] * &o[i];
    }
    sum[2] += &q[9];
    sum
}

/// The finite crossings of a line. Each is within its bound of a root.
fn finite_crossings(q: &[f64; 10], o: [f64; 3], d: [f64; 3]) -> Vec<Crossing> {
    let [a, b, c] = polynomial(q, o, d);
    let value = |t: &BigRational| (&a * t + &b) * t + &c;
    let mut list = cast(&*build("quadric", q).expect("a quadric"), o, d);
    list.retain(|crossing| crossing.t.is_finite());
    let middle = if a.is_zero() { None } else { Some(-&b / (exact(2.0) * &a)) };
    for crossing in &list {
        let (t, err) = (exact(crossing.t), exact(crossing.t_err));
        let (low, high) = (&t - &err, &t + &err);
        let (at_low, at_high) = (value(&low), value(&high));
        // Or both roots are within the bound, one on each side of the middle.
        let are_both =
            middle.as_ref().is_some_and(|m| low < *m && *m < high && value(m).signum() != at_low.signum());
        assert!(are_both || !(at_low * at_high).is_positive(), "{q:?} {o:?} {d:?}: {list:?}");
    }
    list
}

/// The number of roots, if they are surely within the range of numbers.
fn roots(q: &[f64; 10], o: [f64; 3], d: [f64; 3]) -> Option<usize> {
    let [a, b, c] = polynomial(q, o, d);
    if (&b * &b - exact(4.0) * &a * &c).is_negative() {
        return Some(0);
    }
    let far = exact(1e300);
    let is_in_range = |t: &BigRational| ((&a * t + &b) * t + &c).signum() == a.signum();
    let are_in_range = !a.is_zero() && (&b / (exact(2.0) * &a)).abs() < far;
    (are_in_range && is_in_range(&far) && is_in_range(&-far)).then_some(2)
}

const SLAB: [f64; 10] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
const TURNED_CYLINDER: [f64; 10] = [1.5, 0.0, 0.4, 0.0, 0.3, 0.0, -0.2, 0.0, 0.1, -1.0];

/// Quadrics that ignore an axis or two.
pub(super) const QUADRICS: [[f64; 10]; 6] = [
    SLAB,
    [0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 2.0],
    [1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
    [1.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.25],
    TURNED_CYLINDER,
];

#[test]
fn quadrics_that_ignore_an_axis_pass_the_conformance_suite() {
    for quadric in QUADRICS {
        let example: &'static [&'static [f64]] = vec![&*quadric.to_vec().leak()].leak();
        let kind = Kind { examples: vec![example].leak(), ..quadric::KIND };
        conformance(Box::leak(Box::new(kind)));
    }
}

/// The squares of the components that count underflowed: roots were missing, or had bounds of nearly zero.
#[test]
fn components_along_axes_that_count_may_be_tiny() {
    let (mut random, mut crossings) = (Random::new(5), 0);
    for q in QUADRICS {
        let counts = [[0, 3, 4, 6], [1, 3, 5, 7], [2, 4, 5, 8]].map(|of| of.iter().any(|&k| q[k] != 0.0));
        for power in [0, 100, 150, 154, 160, 200, 290] {
            let small = 10f64.powi(-power);
            for scale in [1.0, 1e-15, 1e15] {
                for _ in 0..3 {
                    let mut d = random.point(-1.0, 1.0).to_array();
                    (0..3).for_each(|i| d[i] *= scale * if counts[i] { small } else { 1.0 });
                    let o = random.point(-2.0, 2.0).to_array();
                    let list = finite_crossings(&q, o, d);
                    let context = format!("{q:?} {o:?} {d:?}: {list:?}");
                    assert!(roots(&q, o, d).is_none_or(|number| list.len() == number), "{context}");
                    assert!(list.iter().all(|c| c.t_err < 1e-9 * c.t.abs()), "{context}");
                    crossings += list.len();
                }
            }
        }
        // The longest component is too long to scale the others by.
        let mut d = [1e-20, 2e-20, -1e-20];
        (0..3).filter(|&i| !counts[i]).for_each(|i| d[i] = 1e300);
        let list = finite_crossings(&q, [0.1, 0.2, 0.3], d);
        assert!(list.iter().all(|c| c.t_err < 1e-9 * c.t.abs()), "{q:?}: {list:?}");
        crossings += list.len();
    }
    assert!(crossings > 300, "{crossings}");
}

/// The leading coefficient underflowed beside a linear one that is tiny too, and the bound was far too small.
#[test]
fn a_leading_coefficient_that_underflows_is_in_the_bound() {
    for (linear, step) in
        [(1e-200, 1e-170), (1e-250, 1e-160), (1e-180, 1e-156), (0.0, 1e-160), (1e-3, 1e-200)]
    {
        let q = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, linear, 0.0, -1.0];
        assert!(!finite_crossings(&q, [0.25, 0.0, 0.0], [step, 1.0, 0.0]).is_empty());
        assert!(!finite_crossings(&q, [0.25, 0.5, 0.0], [-step, 1.0, 3.0]).is_empty());
    }
}

#[test]
fn a_line_along_an_ignored_axis_is_inside_or_outside() {
    for d in [[0.0, 0.0, 1.0], [0.0, 1.0, -3e200], [-0.0, 5e-324, 0.0]] {
        for (x, inside) in [(0.5, true), (1.5, false), (1.0, false)] {
            let list = cast(&*build("quadric", &SLAB).expect("a slab"), [x, 0.0, 0.0], d);
            assert_eq!(list.len(), if inside { 2 } else { 0 }, "{x} {d:?}: {list:?}");
        }
    }
}

#[test]
fn a_quadric_that_ignores_an_axis_is_bounded_along_the_others() {
    let bounds = build("quadric", &TURNED_CYLINDER).expect("a cylinder").bounds();
    assert!(bounds.max.y == f64::INFINITY && bounds.max.x < 1.0 && bounds.max.z < 2.0, "{bounds:?}");
    let bounds = build("quadric", &SLAB).expect("a slab").bounds();
    assert!(bounds.max.x < 1.0 + 1e-12 && bounds.min.y == f64::NEG_INFINITY, "{bounds:?}");
}
