use proptest::prelude::*;

use super::Torus;
use super::oracle::ROWS;
use crate::crossing::{Crossing, are_coincident, is_alternating};
use crate::lecture::surfaces::torus_quartic;
use crate::math::Vec3;
use crate::ray::Line;
use crate::solid::Solid;

fn cross(torus: &Torus, line: &Line) -> Vec<Crossing> {
    let mut out = Vec::new();
    torus.crossings(line, &mut out);
    assert!(is_alternating(&out), "{torus:?} {line:?} {out:?}");
    out
}

fn ts(major: f64, minor: f64, o: [f64; 3], d: [f64; 3]) -> Vec<f64> {
    let torus = Torus::new(major, minor).unwrap();
    cross(&torus, &Line::exact(o.into(), d.into())).iter().map(|c| c.t).collect()
}

#[test]
fn the_axis_passes_through_the_hole() {
    assert_eq!(ts(1.0, 0.25, [0.0, 0.0, -3.0], [0.0, 0.0, 1.0]), []);
    assert_eq!(ts(1.0, 0.25, [0.5, 0.0, -3.0], [0.0, 0.0, 1.0]), []);
    assert_eq!(ts(1.0, 0.25, [1.0, 0.0, -3.0], [0.0, 0.0, 1.0]), [2.75, 3.25]);
}

/// On its axis a spindle is crossed at its tips. The bounds stay small there even if the frame has rounding
/// errors.
#[test]
fn bounds_stay_small_on_the_axis() {
    let torus = Torus::new(1.625, 3.6875).unwrap();
    let up = Line::exact(Vec3::new(0.0, 0.0, -5.0), Vec3::Z * 3.0);
    for err in [Vec3::ZERO, Vec3::Z * 1e-15, Vec3::splat(1e-15)] {
        let list = cross(&torus, &Line { o_err: err, d_err: err, ..up });
        assert!(list.len() == 2 && list.iter().all(|c| c.t_err < 1e-14), "{list:?}");
    }
}

#[test]
fn a_line_in_the_equator_meets_the_tube_twice() {
    assert_eq!(ts(1.0, 0.25, [-4.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [2.75, 3.25, 4.75, 5.25]);
    // The whole line counts, including what lies behind the origin. `t` is in units of the direction's length.
    assert_eq!(ts(1.0, 0.25, [0.0, 4.0, 0.0], [0.0, 0.5, 0.0]), [-10.5, -9.5, -6.5, -5.5]);
}

#[test]
fn touching_is_not_crossing() {
    // Along the tangent of the outer equator, across the top circle, and inside the hole.
    assert_eq!(ts(1.0, 0.25, [1.25, -3.0, 0.0], [0.0, 1.0, 0.0]), []);
    assert_eq!(ts(1.0, 0.25, [-3.0, 0.0, 0.25], [1.0, 0.0, 0.0]), []);
    assert_eq!(ts(1.0, 0.25, [0.75, 0.0, -3.0], [0.0, 0.0, 1.0]), []);
    // One ulp further inside there is a crossing. Its ends are sqrt(2 * 1.25 * ulp) from the middle.
    let inner = ts(1.0, 0.25, [1.25f64.next_down(), -3.0, 0.0], [0.0, 1.0, 0.0]);
    let half = (2.5 * f64::EPSILON).sqrt();
    assert_eq!(inner.len(), 2);
    assert!((inner[1] - inner[0] - 2.0 * half).abs() < 1e-6 * half);
}

#[test]
fn touching_from_within_leaves_nothing() {
    // Along the tangent of the inner equator, the line stays inside the tube except at one point.
    assert_eq!(ts(1.0, 0.25, [0.75, -3.0, 0.0], [0.0, 1.0, 0.0]), [2.0, 4.0]);
}

#[test]
fn horn_and_spindle_have_no_inner_surface() {
    assert_eq!(ts(1.0, 1.0, [-4.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [2.0, 6.0]);
    assert_eq!(ts(1.0, 1.0, [0.0, 0.0, -4.0], [0.0, 0.0, 1.0]), []);
    assert_eq!(ts(3.0, 5.0, [-9.0, 0.0, 0.0], [1.0, 0.0, 0.0]), [1.0, 17.0]);
    // The axis meets the tips, at a height of sqrt(r^2 - R^2).
    assert_eq!(ts(3.0, 5.0, [0.0, 0.0, -9.0], [0.0, 0.0, 1.0]), [5.0, 13.0]);
}

/// A horn torus touches itself at one point. A line through that point is inside on both sides of it.
#[test]
fn the_pinch_of_a_horn_is_no_gap() {
    for (radius, o, d) in [(0.03125, -4.8125, 4.7565535), (1.0, -3.0, 1.0), (1.6875, -1.1, 0.7)] {
        let list = cross(&Torus::new(radius, radius).unwrap(), &Line::exact(Vec3::splat(o), Vec3::splat(d)));
        assert_eq!(list.len(), 2, "{list:?}");
    }
}

/// Every crossing is within an ulp of the exact one, and its bound is at most two ulps.
#[test]
fn exact_lists() {
    for &([major, minor], o, d, exact) in ROWS {
        let torus = Torus::new(major, minor).unwrap();
        let found = cross(&torus, &Line::exact(o.into(), d.into()));
        let found: Vec<Crossing> = found.into_iter().filter(|c| c.t > 0.0).collect();
        assert_eq!(found.len(), exact.len(), "{torus:?} {o:?} {d:?} {found:?}");
        for (c, &t) in found.iter().zip(exact) {
            let ulp = t.next_up() - t;
            assert!((c.t - t).abs() <= ulp && c.t_err <= 2.0 * ulp, "{torus:?} {o:?} {d:?} {c:?} {t}");
        }
    }
}

#[test]
fn far_origins_and_any_length_of_direction() {
    let (o, d) = (Vec3::new(0.3, -0.2, 0.1), Vec3::new(0.6, 0.7, 0.2));
    let torus = Torus::new(1.0, 0.4).unwrap();
    let near = cross(&torus, &Line::exact(o, d));
    assert!(!near.is_empty());
    for away in [1e6, -1e6] {
        let far = cross(&torus, &Line::exact(o - d * away, d));
        assert_eq!(far.len(), near.len());
        // Moving the origin displaces the line by an ulp of its coordinates.
        assert!(far.iter().zip(&near).all(|(f, n)| (f.t - away - n.t).abs() < 1e-8));
    }
    for length in [1e-6, 1e-3, 1e3, 1e6] {
        let other = cross(&torus, &Line::exact(o, d * length));
        assert!(other.iter().zip(&near).all(|(a, n)| (a.t * length - n.t).abs() < 1e-14));
    }
}

#[test]
fn extreme_numbers_end_and_alternate() {
    let extremes = [1e-300, 1e-160, 1.0, 1e160, 1e300];
    for size in extremes {
        for far in extremes {
            for length in [5e-324, 1e-300, 1.0, 1e300] {
                for thin in [1.0, 1e-7, 1e-200] {
                    let Ok(torus) = Torus::new(size, size * thin) else { continue };
                    let line = Line::exact(Vec3::new(-far, 0.0, 0.0), Vec3::new(length, 0.0, length / 4.0));
                    assert!(cross(&torus, &line).iter().all(|c| !c.t.is_nan() && !c.t_err.is_nan()));
                }
            }
        }
    }
}

/// The longest directions give every crossing a subnormal `t`. The bounds must not make the crossings coincident.
#[test]
fn crossings_of_the_longest_directions_stay_apart() {
    let torus = Torus::new(1.0, 0.25).unwrap();
    let list = cross(&torus, &Line::exact(Vec3::new(-4.0, 0.0, 0.0), Vec3::X * 1.7e308));
    assert_eq!(list.len(), 4);
    assert!(list.windows(2).all(|w| !are_coincident(&w[0], &w[1])), "{list:?}");
}

#[test]
fn bad_radii_are_refused() {
    for (major, minor, named) in
        [(0.0, 1.0, "R"), (1.0, -1.0, "r"), (f64::NAN, 1.0, "R"), (1.7e308, 1.7e308, "R")]
    {
        assert_eq!(Torus::new(major, minor).unwrap_err().param, named);
    }
}

/// Tori from thin to spindle, and lines that pass near them.
fn torus_and_line() -> impl Strategy<Value = (Torus, Line)> {
    let vector = || prop::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from);
    let minor = prop_oneof![0.01..1.0f64, 1.0..4.0f64, Just(1.0)];
    (minor, vector(), vector(), 0.0..100.0f64).prop_filter_map("no direction", |(minor, p, d, far)| {
        let torus = Torus::new(1.0, minor).unwrap();
        (d.length() > 0.1).then(|| (torus, Line::exact(p * (1.0 + minor) - d * far, d)))
    })
}

proptest! {
    /// Between its crossings, at 400 points, the line is inside exactly where the list says so.
    #[test]
    fn lists_agree_with_membership((torus, line) in torus_and_line()) {
        let list = cross(&torus, &line);
        let middle = -line.o.dot(line.d) / line.d.length_squared();
        let half = 1.1 * (1.0 + torus.minor) / line.d.length();
        for i in 0..=400 {
            let t = middle + half * (f64::from(i) / 200.0 - 1.0);
            let clear = torus.implicit(line.at(t), 0, 0).abs() > 1e-11;
            let inside = list.iter().filter(|c| c.t < t).count() % 2 == 1;
            prop_assert!(!clear || torus.contains(line.at(t)) == inside, "at {t}: {list:?}");
        }
    }

    /// At a crossing f is zero, and the sign of the gradient along the line agrees with `entering`.
    #[test]
    fn crossings_lie_on_the_surface((torus, line) in torus_and_line()) {
        for c in cross(&torus, &line) {
            let p = line.at(c.t);
            prop_assert!(torus.implicit(p, 0, 0).abs() < 1e-12 * (1.0 + line.o.length()) * (1.0 + torus.minor));
            let rate = torus.normal(p, 0, 0).dot(line.d);
            prop_assert!(rate.abs() < 1e-6 || (rate < 0.0) == c.entering);
        }
    }

    /// Scaling the scene or the direction by a power of two changes no digit.
    #[test]
    fn powers_of_two_change_no_digit((torus, line) in torus_and_line(), k in -300..300i32, m in -300..300i32) {
        let (size, length) = (2f64.powi(k), 2f64.powi(m));
        let scaled = Torus::new(torus.major * size, torus.minor * size).unwrap();
        let list = cross(&torus, &line);
        let other = cross(&scaled, &Line::exact(line.o * size, line.d * (size * length)));
        prop_assert_eq!(list.len(), other.len());
        for (a, b) in list.iter().zip(&other) {
            prop_assert_eq!(a.t, b.t * length);
        }
    }

    /// A line displaced within its own bounds crosses within the bounds of `t`.
    #[test]
    fn bounds_hold_for_lines_that_are_off(
        (torus, line) in torus_and_line(),
        size in 1e-15..1e-7f64,
        w in prop::array::uniform6(-1.0..1.0f64),
    ) {
        let (o_err, d_err) = (Vec3::splat(size), Vec3::splat(size * 0.1));
        let nominal = cross(&torus, &Line { o_err, d_err, ..line });
        let off = Line::exact(
            line.o + o_err * Vec3::new(w[0], w[1], w[2]),
            line.d + d_err * Vec3::new(w[3], w[4], w[5]),
        );
        let exact = cross(&torus, &off);
        if exact.len() == nominal.len() {
            for (n, e) in nominal.iter().zip(&exact) {
                prop_assert!((n.t - e.t).abs() <= n.t_err + e.t_err, "{n:?} {e:?}");
            }
        }
    }

    /// The textbook quartic has the sign of the distance, except in the lemon of a spindle.
    #[test]
    fn the_quartic_agrees_outside_the_lemon(
        minor in 0.05..3.0f64,
        p in prop::array::uniform3(-4.0..4.0f64),
    ) {
        let (torus, p) = (Torus::new(1.0, minor).unwrap(), Vec3::from(p));
        let f = torus.implicit(p, 0, 0);
        let lemon = (p.x.hypot(p.y) + 1.0).powi(2) + p.z * p.z - minor * minor;
        prop_assert!((torus_quartic(&torus, p) - f * lemon).abs() < 1e-12 * (1.0 + p.length_squared() + minor * minor).powi(2));
        prop_assume!(f.abs() > 1e-9 && lemon.abs() > 1e-9);
        prop_assert_eq!(torus_quartic(&torus, p) < 0.0, (f < 0.0) == (lemon > 0.0));
    }
}
