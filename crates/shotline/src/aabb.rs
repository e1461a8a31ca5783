//! Axis-aligned boxes and bounding spheres that never lose a point to rounding.

use crate::math::{Affine, HALF_ULP, Vec3, length};
use crate::ray::{Line, Span};

/// An axis-aligned box, closed; infinite where unbounded; `min > max` where empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The lowest corner.
    pub min: Vec3,
    /// The highest corner.
    pub max: Vec3,
}

impl Default for Aabb {
    /// The box without a point.
    fn default() -> Aabb {
        Aabb::EMPTY
    }
}

impl Aabb {
    /// The box without a point.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
    /// All of space.
    pub const EVERYTHING: Aabb = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };

    /// The box between two corners.
    pub const fn new(min: Vec3, max: Vec3) -> Aabb {
        Aabb { min, max }
    }

    /// The smallest box around points.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, |b, p| Aabb { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Whether no point is inside.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether it has finite corners (an empty box has not).
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What lies in both.
    pub fn intersection(&self, other: &Aabb) -> Aabb {
        Aabb { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Whether a point lies in the closed box.
    pub fn contains(&self, p: Vec3) -> bool {
        self.min.cmple(p).all() && p.cmple(self.max).all()
    }

    /// The middle.
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The edge lengths; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Whether the volume is too small for a normal number, though no side is.
    pub fn volume_vanishes(&self) -> bool {
        let size = self.size();
        // Sides near the least number are the padding of what is flat.
        size.min_element() > 16.0 * f64::MIN_POSITIVE && size.element_product() < f64::MIN_POSITIVE
    }

    /// Half of the surface area, the measure of the surface area heuristic; zero for an empty box.
    pub fn half_area(&self) -> f64 {
        let s = self.size();
        s.x * s.y + s.y * s.z + s.z * s.x
    }

    /// The same box with each face moved outward by a relative `ulps` half-ulps of its coordinate.
    pub fn widened(&self, ulps: f64) -> Aabb {
        let pad = |v: Vec3| v.abs() * (ulps * HALF_ULP) + Vec3::splat(f64::MIN_POSITIVE);
        let keep = |moved: Vec3, v: Vec3| Vec3::select(v.is_finite_mask(), moved, v);
        Aabb { min: keep(self.min - pad(self.min), self.min), max: keep(self.max + pad(self.max), self.max) }
    }

    /// A box around the image of this one under an affine map (Arvo, Graphics Gems 1990), widened by the
    /// rounding of the matrix and of the sums.
    pub fn transformed(&self, map: &Affine) -> Aabb {
        if map.is_identity() || self.is_empty() {
            return *self;
        }
        let mut out = Aabb::EMPTY;
        for i in 0..3 {
            let m = &map.rows[i];
            let (mut lo, mut hi, mut size) = (m[3], m[3], m[3].abs());
            for (j, &entry) in m[..3].iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
                let (a, b) = (entry * self.min[j], entry * self.max[j]);
                lo += a.min(b);
                hi += a.max(b);
                size += a.abs().max(b.abs());
            }
            let pad = 6.0 * HALF_ULP * size + f64::MIN_POSITIVE;
            // An infinite side makes its own end infinite, and its padding must not touch the other.
            out.min[i] = if lo.is_finite() && pad.is_finite() { lo - pad } else { f64::NEG_INFINITY };
            out.max[i] = if hi.is_finite() && pad.is_finite() { hi + pad } else { f64::INFINITY };
        }
        out
    }

    /// A sphere around the box: centre and radius, rounded outward.
    pub fn bounding_sphere(&self) -> (Vec3, f64) {
        let c = self.centre();
        let reach = (self.max - c).abs().max((c - self.min).abs());
        (c, length(reach) * (1.0 + 8.0 * HALF_ULP) + c.abs().max_element() * 2.0 * HALF_ULP)
    }
}

/// A line prepared for slab tests against many boxes of one frame (Kay and Kajiya 1986).
///
/// The tests are conservative: the interval returned holds every `t` at which the exact line is in the
/// exact box. Entry is monotone in the box, so a box inside another never seems to begin before it.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// The origin as far along the axis as its error allows, and as far back: seen from the first a near
    /// plane is as near as it can be, seen from the second a far plane is as far.
    ahead: Vec3,
    behind: Vec3,
    inverse: Vec3,
    /// The direction; zero on an axis that cannot cull.
    d: Vec3,
    /// One less and one plus what rounding and the error of the direction do to `t`, relative, on the
    /// worst axis.
    shrink: f64,
    grow: f64,
    span: Span,
}

impl BoxRay {
    /// Prepares a line and the span outside of which boxes do not matter.
    pub fn new(line: &Line, span: Span) -> BoxRay {
        let Line { o, d, o_err, d_err } = *line;
        let inverse = 1.0 / d;
        let forward = Vec3::select(inverse.cmpge(Vec3::ZERO), o_err, -o_err);
        // Of a line of the world nothing is in doubt.
        let doubt = if d_err == Vec3::ZERO { Vec3::ZERO } else { d_err / d.abs() };
        // Exactly parallel: in or out for all t. Infinite reciprocals say so; 0 * inf is NaN and counts as in.
        let parallel = d.cmpeq(Vec3::ZERO) & d_err.cmpeq(Vec3::ZERO);
        let bounded = doubt.cmplt(Vec3::splat(0.25)) & inverse.is_finite_mask();
        // Otherwise the slope is all doubt: such an axis cannot cull.
        let culls = parallel | bounded;
        let worst = Vec3::select(bounded, 2.0 * doubt, Vec3::ZERO);
        let worst = 0.0_f64.max(worst.x).max(worst.y).max(worst.z);
        let relative = worst + 6.0 * HALF_ULP;
        BoxRay {
            ahead: o + forward,
            behind: o - forward,
            inverse: Vec3::select(culls, inverse, Vec3::NAN),
            d: Vec3::select(culls, d, Vec3::ZERO),
            shrink: 1.0 - relative,
            grow: 1.0 + relative,
            span,
        }
    }

    /// The span this ray was prepared for.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The same line with another span.
    pub fn over(&self, span: Span) -> BoxRay {
        BoxRay { span, ..*self }
    }

    /// How the line passes the planes across an axis.
    #[inline]
    pub fn slope(&self, axis: usize) -> Slope {
        Slope {
            ahead: self.ahead[axis],
            behind: self.behind[axis],
            inverse: self.inverse[axis],
            shrink: self.shrink,
            grow: self.grow,
        }
    }

    /// How the line passes the planes where the sum of two coordinates, the second times `sign`, is the same;
    /// `sign` is 1 or -1.
    ///
    /// At any `t` of a box' interval each nominal coordinate is outside of the box by the origin's error and a
    /// relative doubt of its way at most. So the two together are by the sums; compared to the way across the
    /// planes the doubt is large where the line runs along them, and from a quarter on they do not cull.
    #[inline]
    pub fn oblique_slope(&self, [i, j]: [usize; 2], sign: f64) -> Slope {
        let (a, b) = (self.d[i], self.d[j] * sign);
        let (way, both) = (a + b, a.abs() + b.abs());
        // An ulp for the sum, and something for what is too small for ulps.
        let margin = f64::MIN_POSITIVE * (1.0 + both);
        let (i_ends, j_ends) =
            ((self.ahead[i], self.behind[i]), (self.ahead[j] * sign, self.behind[j] * sign));
        let high = (i_ends.0.max(i_ends.1) + j_ends.0.max(j_ends.1)).next_up() + margin;
        let low = (i_ends.0.min(i_ends.1) + j_ends.0.min(j_ends.1)).next_down() - margin;
        let (ahead, behind) = if way >= 0.0 { (high, low) } else { (low, high) };
        let doubt = (2.0 * (self.grow - 1.0) + 16.0 * HALF_ULP) * (both / way.abs());
        let inverse = 1.0 / way;
        let culls = doubt <= 0.25
            && !self.inverse[i].is_nan()
            && !self.inverse[j].is_nan()
            && inverse.is_finite()
            && (high - low).is_finite();
        let relative = 2.0 * doubt + 16.0 * HALF_ULP;
        Slope {
            ahead,
            behind,
            inverse: if culls { inverse } else { f64::NAN },
            shrink: 1.0 - relative,
            grow: 1.0 + relative,
        }
    }

    /// About the coordinate reached at `t`: a first guess, without a bound.
    #[inline]
    pub fn coordinate(&self, axis: usize, t: f64) -> f64 {
        self.ahead[axis] + t / self.inverse[axis]
    }

    /// The part of the span in which the line can be in the box; `None` if it passes by.
    #[inline]
    pub fn enter_exit(&self, b: &Aabb) -> Option<(f64, f64)> {
        let (mut enter, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..3 {
            let forward = self.inverse[i] >= 0.0;
            let (near, far) = if forward { (b.min[i], b.max[i]) } else { (b.max[i], b.min[i]) };
            let near = (near - self.ahead[i]) * self.inverse[i];
            let far = (far - self.behind[i]) * self.inverse[i];
            // A NaN compares false: such an axis does not cull.
            if near > enter {
                enter = near;
            }
            if far < exit {
                exit = far;
            }
        }
        // Widening is monotone, so the greatest entry widened is the greatest of the widened.
        let enter = (enter * self.shrink).min(enter * self.grow).max(self.span.t_min());
        let exit = (exit * self.shrink).max(exit * self.grow).min(self.span.t_max());
        (enter <= exit).then_some((enter, exit))
    }
}

/// A line prepared for tests against many spheres of one frame.
///
/// A sphere is met wherever [`BoxRay::enter_exit`] meets a box inside it. At any `t` of a box' interval the nominal
/// point `ahead + t d` is, on each axis that culls, not farther outside of the box than the origin's error and a
/// relative doubt of the way to its faces: the sphere is padded by as much. Along axes that do not cull it is a
/// cylinder.
#[derive(Clone, Copy, Debug)]
pub struct SphereRay {
    ahead: Vec3,
    d: Vec3,
    /// 1, and 0 for axes that do not cull.
    culls: Vec3,
    /// One over the square of the direction's length.
    inverse_squared: f64,
    /// At least one over that length.
    inverse: f64,
    /// How far the origin's error spreads.
    spread: f64,
    /// Twice the relative doubt of the way to a face.
    doubt: f64,
    /// Infinite where squares might vanish or overflow, so that everything is met.
    least: f64,
    span: Span,
}

impl SphereRay {
    /// Prepares what the line is for boxes.
    pub fn new(ray: &BoxRay) -> SphereRay {
        let squared = ray.d.length_squared();
        // The direction is no shorter than its longest side: so the least reciprocal bounds that of its length, without
        // a root. `min` passes over NaN.
        let inverse = ray.inverse.abs();
        SphereRay {
            ahead: ray.ahead,
            d: ray.d,
            culls: Vec3::select(ray.inverse.is_nan_mask(), Vec3::ZERO, Vec3::ONE),
            inverse_squared: 1.0 / squared,
            inverse: inverse.x.min(inverse.y).min(inverse.z) * (1.0 + 8.0 * HALF_ULP),
            spread: (ray.ahead - ray.behind).abs().element_sum(),
            doubt: 2.0 * (ray.grow - 1.0 + 16.0 * HALF_ULP),
            least: if (1e-280..1e280).contains(&squared) { 1e-140 } else { f64::INFINITY },
            span: ray.span,
        }
    }

    /// The first `t` of the span at which the line may be in a sphere; `None` if it passes by.
    ///
    /// What rounding does to the foot of the centre on the line, and to its distance, is below `doubt`, a length.
    #[inline]
    pub fn enter(&self, centre: Vec3, radius: f64) -> Option<f64> {
        let to = (centre - self.ahead) * self.culls;
        let reach = to.abs().element_sum();
        let doubt = 32.0 * HALF_ULP * reach;
        let pad = self.spread + self.doubt * (reach + radius + self.spread);
        let radius = (radius + pad) * (1.0 + 8.0 * HALF_ULP) + 2.0 * doubt;
        if !(reach < 1e140 && (self.least..1e140).contains(&radius)) {
            return Some(self.span.t_min());
        }
        let foot = to.dot(self.d) * self.inverse_squared;
        // The square of half of what is inside, and more by the rounding of both squares.
        let within = radius * radius * (1.0 + 32.0 * HALF_ULP) - (to - self.d * foot).length_squared();
        if within < 0.0 {
            return None;
        }
        let half = (within * self.inverse_squared).sqrt() * (1.0 + 16.0 * HALF_ULP) + doubt * self.inverse;
        let (enter, exit) = ((foot - half).max(self.span.t_min()), (foot + half).min(self.span.t_max()));
        (enter <= exit).then_some(enter)
    }
}

/// How a line passes parallel planes.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    ahead: f64,
    behind: f64,
    inverse: f64,
    shrink: f64,
    grow: f64,
}

impl Slope {
    /// Whether planes are passed in ascending order. Where they cannot cull it is no matter.
    #[inline]
    pub fn ascends(&self) -> bool {
        self.inverse >= 0.0
    }

    /// The first `t` at which the line may be behind the plane at a height; ascends along the line, and never
    /// exceeds [`Slope::latest`] of the same plane.
    ///
    /// Across an axis both are worked out as for the faces of boxes. So where planes cut a box into pieces, and
    /// `t` is in the interval of the box, then it is in that of a piece: structures that cut space lose nothing.
    #[inline]
    pub fn earliest(&self, at: f64) -> f64 {
        let t = (at - self.ahead) * self.inverse;
        let t = t * if t > 0.0 { self.shrink } else { self.grow };
        // NaN, planes that do not cull, becomes no bound at all.
        if t > f64::NEG_INFINITY { t } else { f64::NEG_INFINITY }
    }

    /// The last `t` at which the line may be before that plane.
    #[inline]
    pub fn latest(&self, at: f64) -> f64 {
        let t = (at - self.behind) * self.inverse;
        let t = t * if t > 0.0 { self.grow } else { self.shrink };
        if t < f64::INFINITY { t } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn enter_exit(o: [f64; 3], d: [f64; 3], b: &Aabb) -> Option<(f64, f64)> {
        BoxRay::new(&Line::exact(o.into(), d.into()), Span::FORWARD).enter_exit(b)
    }

    const UNIT: Aabb = Aabb::new(Vec3::ZERO, Vec3::ONE);

    #[test]
    fn parallel_rays_in_outside_and_on_a_face() {
        assert!(enter_exit([0.5, 0.5, -1.0], [0.0, -0.0, 1.0], &UNIT).is_some());
        assert!(enter_exit([1.5, 0.5, -1.0], [0.0, 0.0, 1.0], &UNIT).is_none());
        assert!(enter_exit([1.5, 0.5, -1.0], [-0.0, 0.0, 1.0], &UNIT).is_none());
        assert!(enter_exit([1.0, 0.0, -1.0], [0.0, 0.0, 1.0], &UNIT).is_some());
    }

    #[test]
    fn unbounded_and_empty_boxes() {
        assert_eq!(enter_exit([0.0; 3], [1.0, 0.0, 0.0], &Aabb::EVERYTHING), Some((0.0, f64::INFINITY)));
        assert_eq!(enter_exit([0.0; 3], [1.0, 1.0, 0.0], &Aabb::EMPTY), None);
    }

    proptest! {
        /// Points of the box seen from the origin are inside the interval, however flat the box.
        #[test]
        fn the_interval_holds_every_point_of_the_box(
            o in prop::array::uniform3(-1e3..1e3f64),
            a in prop::array::uniform3(-1.0..1.0f64),
            flat in 0..4usize,
            w in prop::array::uniform3(0.0..1.0f64),
        ) {
            let (o, a) = (Vec3::from(o), Vec3::from(a));
            let mut size = Vec3::new(0.5, 0.25, 1.0);
            if flat < 3 { size[flat] = 0.0; }
            let b = Aabb::new(a, a + size);
            let p = a + size * Vec3::from(w);
            // The direction is exact by construction only in part, so aim with a box around the point.
            let d = p - o;
            let near = b.union(&Aabb::new(o + d, o + d));
            let (enter, exit) = BoxRay::new(&Line::exact(o, d), Span::FORWARD).enter_exit(&near).unwrap();
            prop_assert!(enter <= 1.0 && 1.0 <= exit);
        }

        #[test]
        fn transformed_boxes_hold_transformed_points(
            t in crate::math::tests_support::affine_strategy(),
            w in prop::array::uniform3(0.0..1.0f64),
        ) {
            let p = Vec3::from(w);
            prop_assert!(UNIT.transformed(&t).contains(t.point(p)));
            let (c, r) = UNIT.transformed(&t).bounding_sphere();
            prop_assert!((t.point(p) - c).length() <= r);
        }
    }

    #[test]
    fn tiny_boxes_have_a_sphere_around_them() {
        for size in [1e-200, 1e-310, 1e160] {
            let (c, r) = Aabb::new(Vec3::ZERO, Vec3::splat(size)).bounding_sphere();
            assert!(r >= 0.86 * size && length(c) <= r, "{c} {r}");
        }
    }
}
