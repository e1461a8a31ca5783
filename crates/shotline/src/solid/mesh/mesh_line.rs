//! A line prepared for the triangles of one mesh.
//!
//! Whether the line passes through a triangle is decided exactly (`sheared_ray`). Where it does is computed in
//! double-double from exact differences (`plane`). So for an exact line the bound of `t` is half an ulp of `t`: neither
//! the position of the mesh nor other triangles add to it. A line that was transformed into the frame of the mesh has
//! an error, and the bounds of its hits consist of the effects of that error.
//!
//! All arithmetic uses the mesh and the direction scaled to size 1 by powers of two, which is exact. So no product
//! overflows, and the results do not depend on the size of the mesh or the length of the direction.

use super::plane::{PlaneHit, normal, worst_err};
use super::sheared_ray::{Facing, ShearedRay, reach};
use crate::aabb::{Aabb, BoxRay};
use crate::crossing::{Crossing, GROUPING};
use crate::math::{HALF_ULP, Vec3, binary_exponent, power_of_two};
use crate::ray::{Line, Span};

/// Lines whose origin is more than this many sizes of the mesh away hit nothing. The exponents of f64 would not suffice
/// for the products, and half an ulp of such an origin is far more than the mesh.
const FARTHEST: f64 = 1e150;

/// The effect of the line's error on `t` is the bound of a hit while it is less than this fraction of the interval of
/// `t` in which the line passes the triangle. So an event covers at most a small part of the face, and no thin sheet
/// behind it is lost.
pub(super) const RESOLVED: f64 = 1.0 / 65536.0;

/// A slope. If a bound is neither below [`RESOLVED`] nor below that of this slope, the line runs along the face within
/// its own error, and whether and where it passes through is undetermined. The crossings are then right for a mesh
/// moved by at most that error. A bound as long as the face would merge everything near it into one event, so the bound
/// is limited to that of this slope.
pub(super) const STEEPEST: f64 = 1024.0;

/// The power of two that scales a mesh to size 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct PowerOfTwoScale {
    exponent: i32,
}

impl PowerOfTwoScale {
    /// Returns the scale for the largest coordinate of the corners of a mesh's faces. Vertices that no face uses must not
    /// affect it.
    pub(super) fn of(largest: f64) -> PowerOfTwoScale {
        PowerOfTwoScale { exponent: exponent_within_range(largest) }
    }

    /// Whether scaling a vertex loses nothing, so that different ones stay different.
    pub(super) fn is_exact(&self, v: Vec3) -> bool {
        let smallest = f64::MIN_POSITIVE * power_of_two(self.exponent.max(0));
        v.to_array().into_iter().all(|x| x == 0.0 || x.abs() >= smallest)
    }

    /// Sizes are divided by two to this power.
    pub(super) fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Scales a vertex.
    pub(super) fn scale(&self, v: Vec3) -> Vec3 {
        v * power_of_two(-self.exponent)
    }

    /// Undoes the scaling of a point.
    pub(super) fn unscale(&self, v: Vec3) -> Vec3 {
        v * power_of_two(self.exponent)
    }

    /// Undoes the scaling of a volume.
    pub(super) fn volume(&self, scaled: f64) -> f64 {
        libm::ldexp(scaled, 3 * self.exponent)
    }
}

/// Returns the exponent of a number, clamped so that both it and its negative are exponents of normal numbers.
#[inline(always)]
pub(super) fn exponent_within_range(x: f64) -> i32 {
    binary_exponent(x).clamp(-1000, 1000)
}

/// A scaled triangle. It holds copies of its vertices, so that a test reads contiguous memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [Vec3; 3],
    /// Its index in the mesh.
    pub(super) face: u32,
}

impl Triangle {
    pub(super) fn bounds(&self) -> Aabb {
        Aabb::around(self.corners)
    }
}

/// The prepared line. Its methods take and return `t` as a parameter of the original line.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshLine {
    /// The line after scaling, with the error bounds from its transform.
    line: Line,
    /// Whether these bounds are zero.
    is_exact: bool,
    sheared: ShearedRay,
    /// Box tests for the whole line.
    box_ray: BoxRay,
    /// The same, padded by `near`, so that triangles whose planes are that near are visited.
    padded_box_ray: BoxRay,
    /// The largest distance from a plane at which the line counts as running in it: the error of the line within the
    /// mesh, times [`GROUPING`].
    near: f64,
    /// The largest distance from the origin to a point of the mesh's box, along any axis.
    reach: f64,
    /// The longest interval of `t` in which the line passes any triangle.
    longest_interval: f64,
    /// The original `t` is `2^exponent` times the `t` after scaling.
    exponent: i32,
}

impl MeshLine {
    /// Prepares a line for the triangles in a scaled box. Returns `None` if the line hits nothing because its origin is
    /// too far away or because, in an extreme frame, its coordinates have overflowed or its direction has become zero.
    pub(super) fn new(line: &Line, size: &PowerOfTwoScale, bounds: &Aabb) -> Option<MeshLine> {
        let exponents = (size.exponent, exponent_within_range(line.d.abs().max_element()));
        let (s, r) = (power_of_two(-exponents.0), power_of_two(-exponents.1));
        let line = Line { o: line.o * s, d: line.d * r, o_err: line.o_err * s, d_err: line.d_err * r };
        MeshLine::of_scaled(line, exponents.0 - exponents.1, bounds)
    }

    fn of_scaled(line: Line, exponent: i32, bounds: &Aabb) -> Option<MeshLine> {
        let far = line.o.abs().max_element();
        if far > FARTHEST || !line.o.is_finite() || !line.d.is_finite() || line.d == Vec3::ZERO {
            return None;
        }
        let reach = reach(line.o, bounds);
        let steps = reach / line.d.abs().max_element();
        let near = GROUPING * (line.o_err + line.d_err * steps).max_element();
        let sheared = ShearedRay::new(line.o, line.d, bounds, near);
        // The hits are those of the nominal line, so box tests use the nominal line too.
        let exact = Line::exact(line.o, line.d);
        let all = span(f64::NEG_INFINITY, f64::INFINITY);
        Some(MeshLine {
            line,
            is_exact: line == exact,
            sheared,
            box_ray: BoxRay::new(&exact, all),
            padded_box_ray: BoxRay::new(&Line { o_err: Vec3::splat(near), ..exact }, all),
            near,
            reach,
            longest_interval: bounds.size()[sheared.along()] / line.d[sheared.along()].abs(),
            exponent,
        })
    }

    /// Returns the line moved off the planes that it runs in: by an infinitesimal step for an exact line, by a little
    /// more than its error for any other. `direction` is perpendicular to the line and meets each of those planes at an
    /// angle whose sine is at least `sine`.
    pub(super) fn moved_aside(&self, direction: Vec3, sine: f64, bounds: &Aabb) -> Option<MeshLine> {
        if self.near == 0.0 {
            let perturbation = [direction, self.line.d.cross(direction)];
            return Some(MeshLine { sheared: self.sheared.moved_aside(perturbation), ..*self });
        }
        let by = 2.0 * self.near / sine;
        let (o, o_err) = (self.line.o + direction * by, self.line.o_err + by);
        MeshLine::of_scaled(Line { o, o_err, ..self.line }, self.exponent, bounds)
    }

    /// The line between two `t` for tests against the boxes of scaled triangles.
    pub(super) fn boxes(&self, from: f64, to: f64) -> BoxRay {
        self.padded_box_ray.over(span(-self.latest_scaled(-from), self.latest_scaled(to)))
    }

    /// An upper bound on the scaled `t` that become `t` when the scaling is undone: there they may underflow.
    pub(super) fn latest_scaled(&self, t: f64) -> f64 {
        self.scaled(t.next_up())
    }

    /// Scales a `t`.
    pub(super) fn scaled(&self, t: f64) -> f64 {
        libm::ldexp(t, -self.exponent)
    }

    /// An upper bound on [`Crossing::t_err`] of any hit near `t`.
    fn worst_err(&self, t: f64) -> f64 {
        let t = self.scaled(t);
        let of_line =
            if self.is_exact { 0.0 } else { self.steepest(t).max(RESOLVED * self.longest_interval) };
        libm::ldexp(worst_err(t, self.reach) + of_line, self.exponent)
    }

    /// The largest `t` of a hit that may belong to an event that reaches to `t`.
    pub(super) fn event_end(&self, t: f64) -> f64 {
        t + self.event_width(t)
    }

    /// The smallest `t` of a hit that may belong to an event that reaches to `t`.
    pub(super) fn event_start(&self, t: f64) -> f64 {
        t - self.event_width(t)
    }

    /// Bounds grow along the line. As long as they grow slowly, twice [`GROUPING`] times the bound at `t` is more than
    /// [`GROUPING`] times the bound at the other hit.
    pub(super) fn event_width(&self, t: f64) -> f64 {
        let growth = 2.0 * HALF_ULP + STEEPEST * 2.0 * self.line.d_err.max_element();
        if growth > 1.0 / 16.0 || t.is_infinite() {
            f64::INFINITY
        } else {
            2.0 * GROUPING * self.worst_err(t)
        }
    }

    fn steepest(&self, t: f64) -> f64 {
        STEEPEST * self.line.point_err(t).max_element() / self.line.d[self.sheared.along()].abs()
    }

    /// Returns the hit where the line passes through a triangle; it enters if the line sees the front. Calls `in_plane`
    /// if the line runs in the triangle's plane.
    #[inline]
    pub(super) fn hit(&self, triangle: &Triangle, in_plane: impl FnOnce()) -> Option<Crossing> {
        let edge_on = || {
            if self.is_in_plane(&triangle.corners) {
                in_plane();
            }
        };
        let facing = self.sheared.through(&triangle.corners, edge_on)?;
        self.crossing(triangle, facing)
    }

    /// Whether the line runs in the plane of a triangle: exactly for an exact line, within its error for any other. The
    /// rule is that of a face of a box, so that a box and a mesh agree.
    #[cold]
    fn is_in_plane(&self, corners: &[Vec3; 3]) -> bool {
        if self.is_exact {
            return self.sheared.is_in_plane(corners);
        }
        let normal = normal(*corners);
        let is_lost =
            |value: Vec3, doubt: Vec3| normal.dot(value).abs() <= GROUPING * normal.abs().dot(doubt);
        is_lost(self.line.d, self.line.d_err) && is_lost(self.line.o - corners[0], self.line.o_err)
    }

    fn crossing(&self, triangle: &Triangle, facing: Facing) -> Option<Crossing> {
        let plane_hit = PlaneHit::of(&triangle.corners, &self.line);
        // Keep `t` within the triangle's box. So a box that begins behind some `t` holds no triangle that is hit at
        // that `t`, and hits do not depend on the accelerator. The exact `t` is in this interval too.
        let (near, far) = self.box_ray.enter_exit(&triangle.bounds())?;
        let t = plane_hit.t.clamp(near, far);
        let of_line = if self.is_exact { 0.0 } else { self.t_err_of_line(triangle, t, &plane_hit) };
        Some(Crossing {
            t: libm::ldexp(t + 0.0, self.exponent),
            t_err: libm::ldexp(plane_hit.t_err + of_line, self.exponent),
            // A triangle that is counter-clockwise along the axis is seen from behind.
            entering: (facing == Facing::Clockwise) == (self.line.d[self.sheared.along()] > 0.0),
            primitive: triangle.face,
            ..Crossing::new(0.0, 0.0, false, 0)
        })
    }

    /// Returns the effect of the line's error on `t` in the plane of a triangle. Where the line passes an edge within
    /// its error and the face behind the edge is steeper, the error of `t` may be larger.
    fn t_err_of_line(&self, triangle: &Triangle, t: f64, plane_hit: &PlaneHit) -> f64 {
        let bound = plane_hit.t_err_of(self.line.point_err(t), self.line.d_err);
        let along = self.sheared.along();
        let depth = triangle.corners.map(|v| v[along]);
        let deep = depth[0].max(depth[1]).max(depth[2]) - depth[0].min(depth[1]).min(depth[2]);
        let longest_interval = deep / self.line.d[along].abs();
        // A NaN bound is not resolved, and f64::min drops it.
        if bound <= RESOLVED * longest_interval { bound } else { bound.min(self.steepest(t)) }
    }
}

/// The span between two `t`; the first may be `-inf`.
fn span(from: f64, to: f64) -> Span {
    let from = from.clamp(-f64::MAX, f64::MAX);
    Span::new(from, to.max(from)).unwrap_or(Span::FORWARD)
}
