//! Axis-aligned boxes and bounding spheres that never lose a point to rounding.

use crate::math::{Affine, HALF_ULP, Vec3, length};
use crate::ray::{Line, Span};

/// A closed axis-aligned box. Its corners are infinite where it is unbounded. It is empty if `min > max` on some
/// axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The lowest corner.
    pub min: Vec3,
    /// The highest corner.
    pub max: Vec3,
}

impl Default for Aabb {
    /// The empty box.
    fn default() -> Aabb {
        Aabb::EMPTY
    }
}

impl Aabb {
    /// The empty box.
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

    /// Whether both corners are finite. Those of [`Aabb::EMPTY`] are not.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The intersection of both boxes.
    pub fn intersection(&self, other: &Aabb) -> Aabb {
        Aabb { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Whether a point lies in the closed box.
    pub fn contains(&self, p: Vec3) -> bool {
        self.min.cmple(p).all() && p.cmple(self.max).all()
    }

    /// The centre.
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The edge lengths; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Whether the volume is too small for a normal number although no side is.
    pub fn volume_vanishes(&self) -> bool {
        let size = self.size();
        // Sides near the smallest normal number are the padding of a flat box.
        size.min_element() > 16.0 * f64::MIN_POSITIVE && size.element_product() < f64::MIN_POSITIVE
    }

    /// Half of the surface area, the measure of the surface area heuristic; zero for an empty box.
    pub fn half_area(&self) -> f64 {
        let s = self.size();
        s.x * s.y + s.y * s.z + s.z * s.x
    }

    /// The box with each face moved outward by `ulps` half-ulps of its coordinate. Infinite faces stay.
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
            // Where a side is infinite, so is the padding: `lo` and `hi` may be NaN, and both ends become infinite.
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
/// The tests are conservative: the interval returned contains every `t` at which the exact line is in the exact box.
/// The entry is monotone in the box: that of an inner box is never before that of an outer box.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// The origin, moved along each axis by the bound on its error: forward as the line runs, and back. The `t` of a
    /// near plane is computed from `ahead`, and so is a lower bound; that of a far plane is computed from `behind`,
    /// and so is an upper bound.
    pub(crate) ahead: Vec3,
    pub(crate) behind: Vec3,
    pub(crate) inverse: Vec3,
    /// The direction; zero on an axis that cannot cull.
    d: Vec3,
    /// `1 - e` and `1 + e`, where `e` bounds the relative error of `t` from rounding and from the error of the
    /// direction, on the worst axis.
    pub(crate) shrink: f64,
    pub(crate) grow: f64,
    pub(crate) span: Span,
}

impl BoxRay {
    /// Prepares a line. Boxes that it meets only outside of `span` are missed.
    pub fn new(line: &Line, span: Span) -> BoxRay {
        let Line { o, d, o_err, d_err } = *line;
        let inverse = 1.0 / d;
        let forward = Vec3::select(inverse.cmpge(Vec3::ZERO), o_err, -o_err);
        // A line in world coordinates is exact.
        let doubt = if d_err == Vec3::ZERO { Vec3::ZERO } else { d_err / d.abs() };
        // Exactly parallel: inside or outside for all t, which infinite reciprocals yield. 0 * inf is NaN and counts
        // as inside.
        let parallel = d.cmpeq(Vec3::ZERO) & d_err.cmpeq(Vec3::ZERO);
        let bounded = doubt.cmplt(Vec3::splat(0.25)) & inverse.is_finite_mask();
        // On any other axis the slope is too uncertain to cull.
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

    /// Prepares a line for the boxes inside a box that it meets: `around` is the same line in the frame of that box. The span
    /// is narrowed to where the line is in the box. On an axis where the slope is too uncertain to cull, the line then stays
    /// so near to its origin that it is taken as parallel to the other axes: a ray along the rows of a turned lattice meets
    /// one row, and not all.
    pub(crate) fn inside(line: &Line, around: &BoxRay, bounds: &Aabb) -> BoxRay {
        let part = around.enter_exit(bounds).and_then(|(enter, exit)| Span::new(enter, exit).ok());
        let span = part.unwrap_or(around.span);
        let mut ray = BoxRay::new(line, span);
        let reach = span.t_min().abs().max(span.t_max().abs());
        for axis in 0..3 {
            let travel = (line.d[axis].abs() + line.d_err[axis]) * reach;
            let far = (line.o_err[axis] + travel) * (1.0 + 8.0 * HALF_ULP);
            if ray.inverse[axis].is_nan() && far.is_finite() {
                let rounding = 2.0 * HALF_ULP * (line.o[axis].abs() + far);
                (ray.ahead[axis], ray.behind[axis]) =
                    (line.o[axis] + far + rounding, line.o[axis] - far - rounding);
                ray.inverse[axis] = f64::INFINITY;
            }
        }
        ray
    }

    /// The same line in coordinates `(v - centre) / size`, where `size` is a power of two. The ends of the origin's
    /// error are moved apart by the rounding of the difference, so the tests stay conservative.
    pub(crate) fn relative_to(&self, centre: Vec3, size: f64) -> BoxRay {
        let (ahead, behind) = ((self.ahead - centre) / size, (self.behind - centre) / size);
        let rounding = 4.0 * HALF_ULP * ahead.abs().max(behind.abs());
        let forward = Vec3::select(self.inverse.cmpge(Vec3::ZERO), rounding, -rounding);
        BoxRay {
            ahead: ahead + forward,
            behind: behind - forward,
            inverse: self.inverse * size,
            d: self.d / size,
            ..*self
        }
    }

    /// For eight boxes, given by the lower and then the upper planes of each axis, the interval of the span in which
    /// the line can be in each of them, as in [`BoxRay::enter_exit`]. It is missed where the first end is not at most
    /// the second.
    #[inline]
    pub(crate) fn enter_exit_eight(&self, planes: &[[f32; 8]; 6]) -> [[f64; 8]; 2] {
        let (mut enter, mut exit) = ([f64::NEG_INFINITY; 8], [f64::INFINITY; 8]);
        for axis in 0..3 {
            let (ahead, behind, inverse) = (self.ahead[axis], self.behind[axis], self.inverse[axis]);
            let upper_is_near = usize::from(inverse < 0.0);
            let (near, far) = (&planes[2 * axis + upper_is_near], &planes[2 * axis + 1 - upper_is_near]);
            for i in 0..8 {
                let near = (f64::from(near[i]) - ahead) * inverse;
                let far = (f64::from(far[i]) - behind) * inverse;
                // A NaN compares false: such an axis does not cull.
                enter[i] = if near > enter[i] { near } else { enter[i] };
                exit[i] = if far < exit[i] { far } else { exit[i] };
            }
        }
        let (t_min, t_max) = (self.span.t_min(), self.span.t_max());
        [
            enter.map(|t| (t * self.shrink).min(t * self.grow).max(t_min)),
            exit.map(|t| (t * self.shrink).max(t * self.grow).min(t_max)),
        ]
    }

    /// The span this ray was prepared for.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The same line with another span.
    pub fn over(&self, span: Span) -> BoxRay {
        BoxRay { span, ..*self }
    }

    /// How the line crosses the planes perpendicular to an axis.
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

    /// How the line crosses the planes on which coordinate `i` plus `sign` times coordinate `j` is constant; `sign`
    /// is 1 or -1.
    ///
    /// At any `t` in the interval of a box, each nominal coordinate is outside of the box by at most the origin's
    /// error plus a relative error times the distance travelled along that axis. The sum of the two coordinates is
    /// outside by at most the sum of these errors. The error is divided by the distance travelled across the planes,
    /// so it is large where the line is nearly parallel to them. If it exceeds 1/4, the planes do not cull.
    #[inline]
    pub fn oblique_slope(&self, [i, j]: [usize; 2], sign: f64) -> Slope {
        let (a, b) = (self.d[i], self.d[j] * sign);
        let (travel, both) = (a + b, a.abs() + b.abs());
        // One ulp covers the rounding of the sum, and the margin covers underflow.
        let margin = f64::MIN_POSITIVE * (1.0 + both);
        let (i_ends, j_ends) =
            ((self.ahead[i], self.behind[i]), (self.ahead[j] * sign, self.behind[j] * sign));
        let high = (i_ends.0.max(i_ends.1) + j_ends.0.max(j_ends.1)).next_up() + margin;
        let low = (i_ends.0.min(i_ends.1) + j_ends.0.min(j_ends.1)).next_down() - margin;
        let (ahead, behind) = if travel >= 0.0 { (high, low) } else { (low, high) };
        let doubt = (2.0 * (self.grow - 1.0) + 16.0 * HALF_ULP) * (both / travel.abs());
        let inverse = 1.0 / travel;
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

    /// An estimate of the coordinate at `t`, without an error bound.
    #[inline]
    pub fn coordinate(&self, axis: usize, t: f64) -> f64 {
        self.ahead[axis] + t / self.inverse[axis]
    }

    /// The interval of the span in which the line can be in the box; `None` if the line misses it.
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
        // Widening is monotone, so widening the greatest entry gives the greatest of the widened entries.
        let enter = (enter * self.shrink).min(enter * self.grow).max(self.span.t_min());
        let exit = (exit * self.shrink).max(exit * self.grow).min(self.span.t_max());
        (enter <= exit).then_some((enter, exit))
    }
}

/// A line prepared for tests against many spheres of one frame.
///
/// Wherever [`BoxRay::enter_exit`] meets a box inside a sphere, the sphere is met too. At any `t` in the interval of
/// the box, the nominal point `ahead + t d` is outside of the box, on each axis that culls, by at most the origin's
/// error plus a relative error times the distance to the faces. The radius is padded by that much. Along axes that do
/// not cull, the sphere becomes a cylinder.
#[derive(Clone, Copy, Debug)]
pub struct SphereRay {
    ahead: Vec3,
    d: Vec3,
    /// 1 for axes that cull, else 0.
    culls: Vec3,
    /// The reciprocals of the squared length and of the length of the direction.
    inverse_squared: f64,
    inverse_length: f64,
    /// An upper bound on the reciprocal of that length.
    inverse: f64,
    /// A bound on the distance by which the origin's error displaces the line.
    origin_error: f64,
    /// Twice the relative error of the distance to a face.
    doubt: f64,
    /// The smallest padded radius that is tested; smaller spheres are always met. Infinite where squares might
    /// underflow or overflow.
    min_radius: f64,
    span: Span,
}

impl SphereRay {
    /// Prepares the line of a [`BoxRay`].
    pub fn new(ray: &BoxRay) -> SphereRay {
        let squared = ray.d.length_squared();
        // The direction is at least as long as its largest component, so the smallest reciprocal bounds that of the
        // length without a square root. `min` ignores NaN.
        let inverse = ray.inverse.abs();
        SphereRay {
            ahead: ray.ahead,
            d: ray.d,
            culls: Vec3::select(ray.inverse.is_nan_mask(), Vec3::ZERO, Vec3::ONE),
            inverse_squared: 1.0 / squared,
            inverse_length: (1.0 / squared).sqrt(),
            inverse: inverse.x.min(inverse.y).min(inverse.z) * (1.0 + 8.0 * HALF_ULP),
            origin_error: (ray.ahead - ray.behind).abs().element_sum(),
            doubt: 2.0 * (ray.grow - 1.0 + 16.0 * HALF_ULP),
            min_radius: if (1e-280..1e280).contains(&squared) { 1e-140 } else { f64::INFINITY },
            span: ray.span,
        }
    }

    /// The first `t` of the span at which the line may be in a sphere; `None` if the line misses it.
    ///
    /// The length `doubt` bounds the rounding error of the centre's projection onto the line, and of its distance
    /// from the line.
    #[inline]
    pub fn enter(&self, centre: Vec3, radius: f64) -> Option<f64> {
        let to = (centre - self.ahead) * self.culls;
        let reach = to.abs().element_sum();
        let doubt = 32.0 * HALF_ULP * reach;
        let pad = self.origin_error + self.doubt * (reach + radius + self.origin_error);
        let radius = (radius + pad) * (1.0 + 8.0 * HALF_ULP) + 2.0 * doubt;
        if !(reach < 1e140 && (self.min_radius..1e140).contains(&radius)) {
            return Some(self.span.t_min());
        }
        let foot = to.dot(self.d) * self.inverse_squared;
        // The square of half the chord, rounded up by the errors of both squares.
        let within = radius * radius * (1.0 + 32.0 * HALF_ULP) - (to - self.d * foot).length_squared();
        if within < 0.0 {
            return None;
        }
        // Not the root of a product, which may underflow.
        let half = within.sqrt() * self.inverse_length * (1.0 + 16.0 * HALF_ULP) + doubt * self.inverse;
        let (enter, exit) = ((foot - half).max(self.span.t_min()), (foot + half).min(self.span.t_max()));
        (enter <= exit).then_some(enter)
    }
}

/// How a line crosses a family of parallel planes.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    ahead: f64,
    behind: f64,
    inverse: f64,
    shrink: f64,
    grow: f64,
}

impl Slope {
    /// Whether the line crosses the planes in ascending order. Irrelevant where the planes cannot cull.
    #[inline]
    pub fn ascends(&self) -> bool {
        self.inverse >= 0.0
    }

    /// The first `t` at which the line may be behind the plane at the height `at`. It never decreases from one plane
    /// to the next along the line, and is at most [`Slope::latest`] of the same plane.
    ///
    /// For planes perpendicular to an axis, both are computed exactly as for the faces of boxes. Where such planes
    /// cut a box into pieces, every `t` in the interval of the box is therefore in the interval of a piece:
    /// structures that subdivide space lose no item.
    #[inline]
    pub fn earliest(&self, at: f64) -> f64 {
        let t = (at - self.ahead) * self.inverse;
        let t = t * if t > 0.0 { self.shrink } else { self.grow };
        // NaN, from planes that do not cull, becomes the trivial bound.
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
