//! A line prepared to meet the triangles of one mesh.
//!
//! Which triangles it passes through is decided exactly (`sheared_ray`), and where it meets them is worked out in
//! double-double from exact differences (`plane`). So for a line that is exact the bound of `t` is half an ulp of `t`:
//! neither the place of the mesh nor other triangles add to it. A line that was brought into the mesh's frame is
//! in doubt, and that is what the bounds of its hits are then made of.
//!
//! All arithmetic is done with the mesh and the direction brought to size 1 by powers of two, which is
//! exact; so no product overflows, and sizes and lengths do not matter.

use super::plane::{PlaneHit, normal, worst_err};
use super::sheared_ray::{Facing, ShearedRay, reach};
use crate::aabb::{Aabb, BoxRay};
use crate::crossing::{Crossing, GROUPING};
use crate::math::{HALF_ULP, Vec3, binary_exponent, power_of_two};
use crate::ray::{Line, Span};

/// Origins farther away than so many sizes of the mesh meet nothing: not even the exponents of f64 would
/// do for the products, and half an ulp of such an origin is far more than the mesh.
const FARTHEST: f64 = 1e150;

/// What the doubt about a line does to `t` is the bound of a hit while it is less than this part of the stretch of
/// the line that runs past the triangle. So what makes one event with a hit is never much of the face, and no thin
/// sheet behind it is lost.
const RESOLVED: f64 = 1.0 / 65536.0;

/// Where a bound is neither that small nor one of a slope less than this, the line runs along the face as near
/// to it as its own doubt: whether and where it passes through is open. The list is right for a mesh moved by
/// no more than the doubt; a bound as long as the face would make one event of everything near it, so it is that of
/// this slope.
const STEEPEST: f64 = 1024.0;

/// The power of two that brings a mesh to size 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct PowerOfTwoScale {
    exponent: i32,
}

impl PowerOfTwoScale {
    /// Of the corners of a mesh's faces: vertices that no face uses must not matter.
    pub(super) fn of(corners: impl Iterator<Item = Vec3>) -> PowerOfTwoScale {
        PowerOfTwoScale {
            exponent: exponent_within_range(corners.fold(0.0, |m: f64, v| m.max(v.abs().max_element()))),
        }
    }

    /// A vertex after scaling.
    pub(super) fn scale(&self, v: Vec3) -> Vec3 {
        v * power_of_two(-self.exponent)
    }

    /// A point before scaling.
    pub(super) fn unscale(&self, v: Vec3) -> Vec3 {
        v * power_of_two(self.exponent)
    }

    /// A volume before scaling.
    pub(super) fn volume(&self, scaled: f64) -> f64 {
        libm::ldexp(scaled, 3 * self.exponent)
    }
}

/// The exponent of a number, kept where it and its negative are exponents of normal numbers.
fn exponent_within_range(x: f64) -> i32 {
    binary_exponent(x).clamp(-1000, 1000)
}

/// A triangle, scaled: its vertices are copied, so that a test reads one run of memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [Vec3; 3],
    /// Its number in the mesh.
    pub(super) face: u32,
}

impl Triangle {
    pub(super) fn bounds(&self) -> Aabb {
        Aabb::around(self.corners)
    }
}

/// The prepared line. Its methods take and give `t` as the line has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshLine {
    /// The line after scaling, with the bounds of its frame.
    line: Line,
    /// Whether these bounds are zero.
    is_exact: bool,
    sheared: ShearedRay,
    /// What box tests say of the whole line.
    whole: BoxRay,
    /// The same with room for planes that are `near`: their triangles must be met.
    roomy: BoxRay,
    /// The farthest that a plane can be from the line where the line counts as in it: what the doubt about the line may
    /// do, with the room in which crossings are one event.
    near: f64,
    /// The largest distance from the origin to a point of the mesh's box, along any axis.
    reach: f64,
    /// The longest stretch of `t` past any triangle.
    stretch: f64,
    /// `t` is `2^exponent` times the `t` after scaling.
    exponent: i32,
}

impl MeshLine {
    /// Prepares a line for the triangles in a box, which is scaled; `None` if it meets nothing because it begins
    /// too far away or, in an extreme frame, has overflowed or come to a stand.
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
        // The hits asked for are those of the line as it is given, so boxes are tested against that as well.
        let exact = Line::exact(line.o, line.d);
        let all = span(f64::NEG_INFINITY, f64::INFINITY);
        Some(MeshLine {
            line,
            is_exact: line == exact,
            sheared,
            whole: BoxRay::new(&exact, all),
            roomy: BoxRay::new(&Line { o_err: Vec3::splat(near), ..exact }, all),
            near,
            reach,
            stretch: bounds.size()[sheared.along()] / line.d[sheared.along()].abs(),
            exponent,
        })
    }

    /// The line moved off the planes that it runs in, by a step that is infinitely small for an exact line and just above
    /// the doubt for any other. The direction is across the line and meets all those planes at angles with at least the
    /// given sine.
    pub(super) fn beside(&self, direction: Vec3, sine: f64, bounds: &Aabb) -> Option<MeshLine> {
        if self.near == 0.0 {
            let moves = [direction, self.line.d.cross(direction)];
            return Some(MeshLine { sheared: self.sheared.beside(moves), ..*self });
        }
        let by = 2.0 * self.near / sine;
        let (o, o_err) = (self.line.o + direction * by, self.line.o_err + by);
        MeshLine::of_scaled(Line { o, o_err, ..self.line }, self.exponent, bounds)
    }

    /// The line for tests against the boxes of scaled triangles, over a part of it.
    pub(super) fn boxes(&self, from: f64, to: f64) -> BoxRay {
        self.roomy.over(span(self.scaled(from), self.scaled(to)))
    }

    /// A `t` after scaling.
    pub(super) fn scaled(&self, t: f64) -> f64 {
        libm::ldexp(t, -self.exponent)
    }

    /// At least [`Crossing::t_err`] of any hit near `t`.
    fn worst_err(&self, t: f64) -> f64 {
        let t = self.scaled(t);
        let of_line = if self.is_exact { 0.0 } else { self.steepest(t).max(RESOLVED * self.stretch) };
        libm::ldexp(worst_err(t, self.reach) + of_line, self.exponent)
    }

    /// How far behind an event that reaches to `t` a hit may lie and still be a part of it.
    pub(super) fn event_end(&self, t: f64) -> f64 {
        t + self.event_width(t)
    }

    /// How far before `t` a hit may lie and still be a part of an event that reaches to `t`.
    pub(super) fn event_start(&self, t: f64) -> f64 {
        t - self.event_width(t)
    }

    /// Bounds grow along the line; twice [`GROUPING`] times the bound here is more than [`GROUPING`] times the bound there, as long as they
    /// grow slowly.
    fn event_width(&self, t: f64) -> f64 {
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

    /// Where the line passes through a triangle, entering if it sees its front. Calls `in_plane` if the line runs in the
    /// triangle's plane.
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

    /// Whether the line runs in the plane of a triangle: exactly, or where the line is in doubt itself, up to that; the
    /// rule is that of a box's face, so that a box and a mesh agree.
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
        // No t outside of the triangle's box: so a box that begins behind a t holds no triangle hit there,
        // and what is hit does not depend on the accelerator. The exact t is in this interval too.
        let (near, far) = self.whole.enter_exit(&triangle.bounds())?;
        let t = plane_hit.t.clamp(near, far);
        let of_line = if self.is_exact { 0.0 } else { self.t_err_of_line(triangle, t, &plane_hit) };
        Some(Crossing {
            t: libm::ldexp(t + 0.0, self.exponent),
            t_err: libm::ldexp(plane_hit.t_err + of_line, self.exponent),
            // Seen counter-clockwise along the axis is seen from behind.
            entering: (facing == Facing::Clockwise) == (self.line.d[self.sheared.along()] > 0.0),
            primitive: triangle.face,
            ..Crossing::new(0.0, 0.0, false, 0)
        })
    }

    /// What the doubt about the line does to `t` in the plane of a triangle. Where the line passes an edge at no
    /// more than its doubt, and the face behind the edge is steeper, the `t` there may be off by more.
    fn t_err_of_line(&self, triangle: &Triangle, t: f64, plane_hit: &PlaneHit) -> f64 {
        let bound = plane_hit.t_err_of(self.line.point_err(t), self.line.d_err);
        let along = self.sheared.along();
        let depth = triangle.corners.map(|v| v[along]);
        let deep = depth[0].max(depth[1]).max(depth[2]) - depth[0].min(depth[1]).min(depth[2]);
        let stretch = deep / self.line.d[along].abs();
        // NaN is not resolved, and f64::min drops it.
        if bound <= RESOLVED * stretch { bound } else { bound.min(self.steepest(t)) }
    }
}

/// The span between two `t`, of which the first may be `-inf`.
fn span(from: f64, to: f64) -> Span {
    let from = from.clamp(-f64::MAX, f64::MAX);
    Span::new(from, to.max(from)).unwrap_or(Span::FORWARD)
}
