//! On which side of an edge the ray passes: decided exactly, and never undecided.
//!
//! All triangles that share an edge ask with the same two points and get opposite answers for opposite
//! directions of the edge. So a closed mesh, seen along a ray, covers the ray as often from the front as
//! from behind: nothing leaks and nothing counts twice.

use std::cmp::Ordering;

/// A vertex seen along the ray: the ray is the origin of this plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) x: f64,
    pub(super) y: f64,
}

/// Which way round the corners of a triangle are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    CounterClockwise,
    Clockwise,
}

/// The edge function: twice the area of the triangle that the ray spans with an edge.
#[inline]
pub(super) fn edge(a: Seen, b: Seen) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Whether the ray passes through a triangle, and which way round that is seen; `None` if it passes by.
///
/// The sign of each rounded edge function is right unless it is zero: rounding is monotone, so products
/// that differ after rounding differ the same way before it, and a difference never rounds to zero.
#[inline]
pub(super) fn through(a: Seen, b: Seen, c: Seen) -> Option<Turn> {
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let (left, right) = (u > 0.0 || v > 0.0 || w > 0.0, u < 0.0 || v < 0.0 || w < 0.0);
    if left && right {
        return None;
    }
    if u == 0.0 || v == 0.0 || w == 0.0 {
        return through_exactly(a, b, c);
    }
    Some(if left { Turn::CounterClockwise } else { Turn::Clockwise })
}

/// [`through`] for rays so near an edge that rounding hides the side.
#[cold]
fn through_exactly(a: Seen, b: Seen, c: Seen) -> Option<Turn> {
    match (side(b, c), side(c, a), side(a, b)) {
        (Ordering::Greater, Ordering::Greater, Ordering::Greater) => Some(Turn::CounterClockwise),
        (Ordering::Less, Ordering::Less, Ordering::Less) => Some(Turn::Clockwise),
        _ => None,
    }
}

/// The exact sign of the edge function. A ray exactly on the edge counts as moved by `(e, e^2)` with an
/// infinitely small `e` (Edelsbrunner and Muecke 1990, "Simulation of simplicity"), which changes the
/// function by `-e (b.y - a.y) + e^2 (b.x - a.x)`. Equal only for an edge without length.
fn side(a: Seen, b: Seen) -> Ordering {
    let order = |p: f64, q: f64| p.partial_cmp(&q).unwrap_or(Ordering::Equal);
    compare_products(a.x, b.y, a.y, b.x).then(order(a.y, b.y)).then(order(b.x, a.x))
}

/// Compares `a b` with `c d` exactly, by integers, so that neither underflow nor overflow matters.
fn compare_products(a: f64, b: f64, c: f64, d: f64) -> Ordering {
    // A product as m 2^e where |m| is zero or from 2^104 up to 2^106.
    let product = |p: f64, q: f64| {
        let ((p, i), (q, j)) = (libm::frexp(p), libm::frexp(q));
        let integer = |fraction: f64| (fraction * 2f64.powi(53)) as i128;
        (integer(p) * integer(q), i + j)
    };
    let ((m, i), (n, j)) = (product(a, b), product(c, d));
    // Two places more make the one with the greater exponent the greater in size, so no shift need be longer.
    let shift = |e: i32| (e - i.min(j)).min(2);
    (m << shift(i)).cmp(&(n << shift(j)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Small integers, times powers of two: products often agree, and can be checked in integers.
    fn coordinate() -> impl Strategy<Value = i32> {
        -6..=6
    }

    fn seen((x, y): (i32, i32), scale: f64) -> Seen {
        Seen { x: f64::from(x) * scale, y: f64::from(y) * scale }
    }

    #[test]
    fn products_below_the_smallest_number_and_above_the_greatest_are_told_apart() {
        let (tiny, next) = (f64::from_bits(3), f64::from_bits(4));
        assert_eq!(compare_products(tiny, tiny, tiny, next), Ordering::Less);
        assert_eq!(compare_products(-tiny, tiny, 0.0, next), Ordering::Less);
        assert_eq!(compare_products(-0.0, 1.0, 0.0, 1.0), Ordering::Equal);
        assert_eq!(compare_products(f64::MAX, 2.0, f64::MAX, 3.0), Ordering::Less);
        let a = 1.0 + f64::EPSILON;
        assert_eq!(compare_products(a, a, 1.0 + 2.0 * f64::EPSILON, 1.0), Ordering::Greater);
    }

    proptest! {
        #[test]
        fn products_compare_like_integers(p in prop::array::uniform4(coordinate()), k in -500..500i32) {
            let s = 2f64.powi(k);
            let [a, b, c, d] = p.map(f64::from);
            prop_assert_eq!(compare_products(a * s, b, c, d * s), (p[0] * p[1]).cmp(&(p[2] * p[3])));
        }

        /// The two directions of an edge give opposite answers, and only an edge without length gives none.
        #[test]
        fn sides_are_antisymmetric(
            a in (coordinate(), coordinate()), b in (coordinate(), coordinate()), k in -600..500i32,
        ) {
            let s = 2f64.powi(k);
            let (p, q) = (seen(a, s), seen(b, s));
            prop_assert_eq!(side(p, q), side(q, p).reverse());
            prop_assert_eq!(side(p, q) == Ordering::Equal, a == b);
        }

        /// A fan of triangles around a closed polygon covers the ray once, even where the ray meets corners
        /// and edges of the fan.
        #[test]
        fn a_fan_covers_the_ray_once(hub in (-1..=1, -1..=1)) {
            let ring = [(3, 0), (3, 3), (0, 3), (-3, 3), (-3, 0), (-3, -3), (0, -3), (3, -3)];
            let hub = seen(hub, 1.0);
            let hits = (0..ring.len())
                .filter(|&i| through(hub, seen(ring[i], 1.0), seen(ring[(i + 1) % 8], 1.0)).is_some());
            prop_assert_eq!(hits.count(), 1);
        }

        /// What has no area as seen is never hit.
        #[test]
        fn flat_triangles_are_missed(a in (coordinate(), coordinate()), b in (coordinate(), coordinate()), k in -3..=3) {
            let c = (a.0 + k * (b.0 - a.0), a.1 + k * (b.1 - a.1));
            prop_assert_eq!(through(seen(a, 1.0), seen(b, 1.0), seen(c, 1.0)), None);
        }
    }
}
