//! Decides whether a line passes through a triangle, exactly and in every case.
//!
//! The watertight test of Woop, Benthin and Wald (2013, "Watertight ray/triangle intersection", JCGT 2(1)), in f64. The
//! mesh is sheared so that the line becomes an axis, and an edge function gives the side of each edge on which the line
//! passes. Signs that rounding may hide are computed exactly, from the original line and corners. All triangles that
//! share an edge evaluate the same two corners and get opposite signs for opposite directions of the edge. So a line
//! passes through a closed mesh as often from the front as from behind: nothing leaks, nothing is counted twice, and
//! the hits are those of the exact line.
//!
//! Unlike in the paper, the sign of the direction does not swap the two axes across: a line and its reverse resolve
//! ties alike.

use std::cmp::Ordering;

use super::exact::{Expansion, minus, unit_sized, wide};
use crate::aabb::Aabb;
use crate::math::{HALF_ULP, Vec3};

/// The orientation of a triangle's corners, seen along the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Facing {
    CounterClockwise,
    Clockwise,
}

/// A vertex after shearing: the line is the origin of this plane.
#[derive(Clone, Copy, Debug)]
struct Sheared {
    x: f64,
    y: f64,
}

/// A line with its shear.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    o: Vec3,
    d: Vec3,
    /// The axis in which the direction is largest, and the two others in cyclic order.
    along: usize,
    across: [usize; 2],
    /// Steps across per step along the axis.
    slope: [f64; 2],
    /// A bound on the rounding of edge functions, see [`ShearedRay::new`].
    doubt: f64,
    /// The perturbation that resolves ties: the line counts as moved by the first of these vectors times `e` and by the
    /// second times `e^2`, with an infinitesimal `e` (Edelsbrunner and Muecke 1990, "Simulation of simplicity").
    perturbation: [Vec3; 2],
}

impl ShearedRay {
    /// Prepares a line, with a direction of size 1, for triangles within a box, and for detecting triangles in planes
    /// at most `near` from the line.
    ///
    /// Rounding: if no vertex is farther than `reach` from the origin along any axis, the error of `v - o` is at most
    /// half an ulp of `reach`, that of the slope times the depth three and that of the difference two. So the error of
    /// a sheared coordinate is less than `e = 6.5 HALF_ULP reach`. Let the line pass through a box inside the given
    /// one, exactly or within the rounding of a box test (see [`crate::aabb::BoxRay`]). A sheared coordinate of a
    /// vertex in that box is its distance from a point of the line in the box, along that axis and, times the slope,
    /// along the main one. It is less than `width`: twice the size of the given box and a margin for rounding. So the
    /// error of an edge function `a.x b.y - a.y b.x` is at most `4 width e + 2 e^2` and four half-ulps of `2 (width +
    /// e)^2`. Nothing is promised for triangles whose box the line misses by more. Edge functions of triangles in a
    /// plane at most `near` from the line are as large as the length of an edge times `near`, less than `2 width near`.
    pub(super) fn new(o: Vec3, d: Vec3, bounds: &Aabb, near: f64) -> ShearedRay {
        let size = d.abs();
        let along = if size.z >= size.x && size.z >= size.y { 2 } else { usize::from(size.y >= size.x) };
        let across = [(along + 1) % 3, (along + 2) % 3];
        let reach = reach(o, bounds);
        let e = 6.5 * HALF_ULP * reach;
        let width = 2.0 * bounds.size().max_element() + 64.0 * HALF_ULP * reach + 2.0 * near;
        let rounding = 4.0 * width * e + 2.0 * e * e + 8.0 * HALF_ULP * (width + e) * (width + e);
        let slope = across.map(|axis| d[axis] / d[along]);
        let doubt = 1.01 * (rounding + 2.0 * width * near) + f64::MIN_POSITIVE;
        ShearedRay { o, d, along, across, slope, doubt, perturbation: across.map(|axis| Vec3::AXES[axis]) }
    }

    /// The same line, with ties resolved as if it were moved in the first direction or, if that does not decide, in the
    /// second.
    pub(super) fn moved_aside(self, perturbation: [Vec3; 2]) -> ShearedRay {
        ShearedRay { perturbation, ..self }
    }

    /// The axis in which the direction is largest.
    pub(super) fn along(&self) -> usize {
        self.along
    }

    #[inline]
    fn shear(&self, v: Vec3) -> Sheared {
        let p = v - self.o;
        let depth = p[self.along];
        Sheared { x: p[self.across[0]] - self.slope[0] * depth, y: p[self.across[1]] - self.slope[1] * depth }
    }

    /// Returns the orientation of a triangle that the line passes through; `None` if the line misses it. Calls
    /// `edge_on` if the triangle is seen edge-on, up to rounding, and its plane is near.
    #[inline]
    pub(super) fn through(&self, corners: &[Vec3; 3], edge_on: impl FnOnce()) -> Option<Facing> {
        let [a, b, c] = corners.map(|v| self.shear(v));
        let edges = [edge(b, c), edge(c, a), edge(a, b)];
        let [u, v, w] = edges;
        let doubt = self.doubt;
        let left = u > doubt || v > doubt || w > doubt;
        let right = u < -doubt || v < -doubt || w < -doubt;
        if left && right {
            return None;
        }
        if u.abs() > doubt && v.abs() > doubt && w.abs() > doubt {
            return Some(if left { Facing::CounterClockwise } else { Facing::Clockwise });
        }
        if !left && !right {
            edge_on();
        }
        self.through_near_edge(corners, edges)
    }

    /// [`ShearedRay::through`] for lines so near an edge that rounding may hide the side.
    #[cold]
    fn through_near_edge(&self, corners: &[Vec3; 3], edges: [f64; 3]) -> Option<Facing> {
        let side = |i: usize| self.side(corners[(i + 1) % 3], corners[(i + 2) % 3], edges[i]);
        let first = side(0);
        if first == Ordering::Equal || side(1) != first || side(2) != first {
            return None;
        }
        Some(if first == Ordering::Greater { Facing::CounterClockwise } else { Facing::Clockwise })
    }

    /// Whether the line runs exactly in the plane of a triangle.
    pub(super) fn is_in_plane(&self, [a, b, c]: &[Vec3; 3]) -> bool {
        [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| self.determinant(*p, *q) == Ordering::Equal)
    }

    /// A bound on the rounding of the edge function of two corners, as in `new` but for these two only.
    fn rounding(&self, a: Vec3, b: Vec3) -> f64 {
        let (p, q) = (self.shear(a), self.shear(b));
        let e = |v: Vec3| 6.5 * HALF_ULP * (v - self.o).abs().max_element() + f64::MIN_POSITIVE;
        let (e_p, e_q) = (e(a), e(b));
        let products = (p.x * q.y).abs() + (p.y * q.x).abs();
        let doubt = (p.x.abs() + p.y.abs()) * e_q
            + (q.x.abs() + q.y.abs()) * e_p
            + 2.0 * e_p * e_q
            + 4.0 * HALF_ULP * products;
        1.01 * doubt + f64::MIN_POSITIVE
    }

    /// Returns the sign of an edge function, given its rounded value. A line exactly on the edge counts as moved, see
    /// `perturbation`. The result is `Equal` only for an edge seen as a point; any triangle with that edge is then parallel to
    /// the line.
    fn side(&self, a: Vec3, b: Vec3, value: f64) -> Ordering {
        if value.abs() > self.rounding(a, b) {
            return value.total_cmp(&0.0);
        }
        let (step, _) = unit_sized(&minus(b, a));
        let moved = |by: Vec3| Expansion::determinant(&step, &wide(by), &wide(self.d)).sign();
        let [first, second] = self.perturbation;
        let sign = self.determinant(a, b).then_with(|| moved(first)).then_with(|| moved(second));
        if self.d[self.along] < 0.0 { sign.reverse() } else { sign }
    }

    /// Returns the exact sign of the determinant of both corners, relative to the origin of the line, and the
    /// direction. Shearing preserves it, and turns the direction into `d[along]` times the axis.
    fn determinant(&self, a: Vec3, b: Vec3) -> Ordering {
        let ((p, _), (q, _)) = (unit_sized(&minus(a, self.o)), unit_sized(&minus(b, self.o)));
        Expansion::determinant(&p, &q, &wide(self.d)).sign()
    }
}

/// The largest distance from a point to a point of a box along any axis, with a margin for rounding.
pub(super) fn reach(o: Vec3, bounds: &Aabb) -> f64 {
    (bounds.min - o).abs().max((bounds.max - o).abs()).max_element() * (1.0 + 4.0 * HALF_ULP)
}

/// The edge function: twice the area of the triangle that the line spans with an edge.
#[inline]
fn edge(a: Sheared, b: Sheared) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use num_rational::BigRational;
    use num_traits::{Signed, Zero};

    use super::*;
    use crate::testkit::random::Random;

    fn ray(o: Vec3, d: Vec3, points: &[Vec3]) -> ShearedRay {
        ShearedRay::new(
            o,
            d / 2f64.powi(libm::frexp(d.abs().max_element()).1),
            &Aabb::around(points.iter().copied()),
            0.0,
        )
    }

    /// `d . (a - o) x (b - o)`, exactly.
    fn exact_edge(o: Vec3, d: Vec3, a: Vec3, b: Vec3) -> BigRational {
        let number = |x: f64| BigRational::from_float(x).unwrap();
        let minus = |a: Vec3| [0, 1, 2].map(|i| number(a[i]) - number(o[i]));
        let (p, q) = (minus(a), minus(b));
        (0..3).fold(BigRational::zero(), |sum, i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sum + (&p[j] * &q[k] - &p[k] * &q[j]) * number(d[i])
        })
    }

    /// A line and a triangle with corners on a small grid or on the line, some far from the origin.
    fn scene(random: &mut Random) -> (Vec3, Vec3, [Vec3; 3]) {
        let far = [0.0, 1e3, 1e8, 3.3e8][random.below(4)];
        let home = Vec3::new(far, -0.7 * far, 0.3 * far);
        let mut grid = || Vec3::new(random.below(5) as f64, random.below(5) as f64, random.below(5) as f64);
        let (o, d) = (grid(), grid() - Vec3::splat(2.0));
        let mut corners = [grid(), grid(), grid()];
        let d = if d == Vec3::ZERO { Vec3::X } else { d };
        let facing = if random.below(2) == 0 { 1.0 } else { random.number(0.1, 10.0) };
        for corner in &mut corners {
            if random.below(2) == 0 {
                // On the line, exactly or up to rounding.
                *corner = o + d * (random.below(7) as f64 * 0.5 * facing);
            }
            *corner += home;
        }
        (o + home, d, corners)
    }

    #[test]
    fn sides_are_those_of_fractions() {
        let mut random = Random::new(8);
        let (mut doubtful, mut ties) = (0, 0);
        for _ in 0..6_000 {
            let (o, d, corners) = scene(&mut random);
            let ray = ray(o, d, &corners);
            let sides = [0, 1, 2].map(|i| {
                let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                let value = edge(ray.shear(a), ray.shear(b));
                let side = ray.side(a, b, value);
                assert_eq!(side, ray.side(b, a, -value).reverse());
                let exact = exact_edge(o, d, a, b);
                let exact = if d[ray.along()] < 0.0 { -exact } else { exact };
                if !exact.is_zero() {
                    assert_eq!(side == Ordering::Greater, exact.is_positive(), "{o:?} {d:?} {a:?} {b:?}");
                }
                doubtful += usize::from(value.abs() <= ray.doubt);
                ties += usize::from(exact.is_zero() && side != Ordering::Equal);
                side
            });
            let all = |side| sides.iter().all(|s| *s == side);
            let facing = match (all(Ordering::Greater), all(Ordering::Less)) {
                (true, _) => Some(Facing::CounterClockwise),
                (_, true) => Some(Facing::Clockwise),
                _ => None,
            };
            assert_eq!(ray.through(&corners, || ()), facing);
            // The same for the reversed line, for ties as well.
            let mirrored = ShearedRay { d: -ray.d, ..ray };
            assert_eq!(mirrored.through(&corners, || ()), facing);
        }
        assert!(doubtful > 3_000 && ties > 600, "{doubtful} {ties}");
    }

    /// A fan of triangles around a closed polygon covers the line once, even where the line meets its corners and
    /// edges, and however far from the origin the fan is.
    #[test]
    fn a_fan_covers_the_line_once() {
        let mut random = Random::new(9);
        let ring = [(3, 0), (3, 3), (0, 3), (-3, 3), (-3, 0), (-3, -3), (0, -3), (3, -3)];
        for _ in 0..4_000 {
            let home = random.direction() * [0.0, 1.0, 1e4, 1e8][random.below(4)];
            let mut bump = || random.number(-0.5, 0.5) * f64::from(u8::from(random.below(2) == 0));
            let ring = ring.map(|(x, y)| home + Vec3::new(f64::from(x), f64::from(y), bump()));
            let hub = home + Vec3::new(bump(), bump(), bump());
            let o = home + Vec3::new(random.below(3) as f64 - 1.0, random.below(3) as f64 - 1.0, 9.0);
            let target = if random.below(2) == 0 { hub } else { home };
            let ray = ray(o, target - o, &[ring.as_slice(), &[hub]].concat());
            let turns = (0..8).filter_map(|i| ray.through(&[hub, ring[i], ring[(i + 1) % 8]], || ()));
            let sum: i32 = turns.map(|facing| if facing == Facing::CounterClockwise { 1 } else { -1 }).sum();
            assert_eq!(sum.abs(), 1);
        }
    }

    #[test]
    fn triangles_without_area_are_missed() {
        let mut random = Random::new(10);
        for _ in 0..2_000 {
            let (o, d, _) = scene(&mut random);
            let mut grid = || random.point(-1e9, 1e9).round();
            let (a, step) = (grid(), grid());
            for c in [a, a + step, a + step * 2.0, a - step * 3.0] {
                let corners = [a, a + step, c];
                assert_eq!(ray(o, d, &corners).through(&corners, || ()), None);
                // Also from one of their own points.
                assert_eq!(ray(a, d, &corners).through(&corners, || ()), None);
            }
        }
    }
}
