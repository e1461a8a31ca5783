//! A line prepared to meet the triangles of one mesh.
//!
//! The watertight test of Woop, Benthin and Wald (2013, "Watertight ray/triangle intersection", JCGT 2(1)),
//! in f64 and with exact signs. The mesh is sheared so that the ray becomes an axis. A vertex is sheared by
//! the same arithmetic for every triangle that has it, so what the ray sees, though rounded, is one
//! consistent drawing of the mesh in a plane, and `side` decides where in that drawing the ray is.
//! Unlike there, the two axes of the drawing do not change places with the sign of the direction: a ray and
//! its reverse resolve ties alike.
//!
//! All arithmetic is done with the mesh and the direction brought to size 1 by powers of two, which is
//! exact; so no product overflows, and sizes and lengths do not matter.

use super::side::{Seen, Turn, edge, through};
use crate::aabb::{Aabb, BoxRay};
use crate::crossing::Crossing;
use crate::math::{Dd, HALF_ULP, Vec3, two_sum};
use crate::ray::{Line, Span};

/// Origins farther away than so many sizes of the mesh meet nothing: not even the exponents of f64 would
/// do for the products, and half an ulp of such an origin is far more than the mesh.
const FARTHEST: f64 = 1e150;

/// A bound is told as it is while it is less than this part of the stretch of the line that runs past the
/// triangle. So what makes one event with a hit is never much of the face, and no thin sheet behind it is lost.
const RESOLVED: f64 = 1.0 / 65536.0;

/// Where a bound is neither that small nor one of a slope less than this, the line runs along the face as near
/// to it as its own doubt: whether and where it passes through is anyone's choice. The list is right for a
/// mesh moved by no more than the doubt; a bound as long as the face would make one event of everything near
/// it, so it is that of this slope.
const STEEPEST: f64 = 1024.0;

/// The power of two that brings a mesh to size 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    exponent: i32,
    /// The greatest coordinate after that.
    reach: f64,
}

impl Size {
    pub(super) fn of(vertices: &[Vec3]) -> Size {
        let reach = vertices.iter().fold(0.0, |m: f64, v| m.max(v.abs().max_element()));
        let exponent = exponent(reach);
        Size { exponent, reach: reach * power_of_two(-exponent) }
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

/// The exponent of a number, within what [`power_of_two`] can give.
fn exponent(x: f64) -> i32 {
    libm::frexp(x).1.clamp(-1000, 1000)
}

/// `2^e` for `e` within -1000 and 1000.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((1023 + e) as u64) << 52)
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
pub(super) struct Probe {
    /// The line after scaling, with the bounds of its frame.
    line: Line,
    /// The axis along which the ray runs most, and the two others in cyclic order.
    along: usize,
    across: [usize; 2],
    /// Steps across for a step along.
    slope: [f64; 2],
    /// How far from its place shearing can move a vertex, each axis.
    shift: f64,
    /// The greatest coordinate of the mesh.
    reach: f64,
    /// The line for box tests, and what these tests say of the whole line.
    box_line: Line,
    whole: BoxRay,
    /// `t` is `2^exponent` times the `t` after scaling.
    exponent: i32,
}

impl Probe {
    /// Prepares a line; `None` if it meets nothing because it begins too far away or, in an extreme frame,
    /// has overflowed or come to a stand.
    pub(super) fn new(line: &Line, size: &Size) -> Option<Probe> {
        let exponents = (size.exponent, exponent(line.d.abs().max_element()));
        let (s, r) = (power_of_two(-exponents.0), power_of_two(-exponents.1));
        let line = Line { o: line.o * s, d: line.d * r, o_err: line.o_err * s, d_err: line.d_err * r };
        let far = line.o.abs().max_element();
        if far > FARTHEST || !line.o.is_finite() || !line.d.is_finite() || line.d == Vec3::ZERO {
            return None;
        }
        let d = line.d.abs();
        let along = if d.z >= d.x && d.z >= d.y { 2 } else { usize::from(d.y >= d.x) };
        let across = [(along + 1) % 3, (along + 2) % 3];
        let shift = 8.0 * HALF_ULP * (far + size.reach);
        let box_line = line_for_boxes(&line, shift);
        Some(Probe {
            line,
            along,
            across,
            slope: across.map(|axis| line.d[axis] / line.d[along]),
            shift,
            reach: size.reach,
            box_line,
            whole: BoxRay::new(&box_line, span(f64::NEG_INFINITY, f64::INFINITY)),
            exponent: exponents.0 - exponents.1,
        })
    }

    /// The line for tests against the boxes of scaled triangles, over a part of it.
    pub(super) fn boxes(&self, from: f64, to: f64) -> BoxRay {
        BoxRay::new(&self.box_line, span(self.scaled(from), self.scaled(to)))
    }

    /// A `t` after scaling.
    pub(super) fn scaled(&self, t: f64) -> f64 {
        libm::ldexp(t, -self.exponent)
    }

    /// The bound of [`Crossing::t_err`] for hits near `t`.
    pub(super) fn worst_err(&self, t: f64) -> f64 {
        let t = self.scaled(t);
        let resolved = RESOLVED * 2.0 * self.reach / self.line.d[self.along].abs();
        libm::ldexp(rounding(t) + self.steepest(t).max(resolved), self.exponent)
    }

    /// How far behind an event that reaches to `t` a hit may lie and still be a part of it.
    pub(super) fn event_end(&self, t: f64) -> f64 {
        // Bounds grow along the line; 16 times the bound here is more than 8 times the bound there, as
        // long as they grow slowly.
        let growth = 2.0 * HALF_ULP + STEEPEST * 2.0 * self.line.d_err.max_element();
        if growth > 1.0 / 16.0 || t.is_infinite() { f64::INFINITY } else { t + 16.0 * self.worst_err(t) }
    }

    fn steepest(&self, t: f64) -> f64 {
        STEEPEST * (self.shift + self.line.point_err(t).max_element()) / self.line.d[self.along].abs()
    }

    #[inline]
    fn see(&self, v: Vec3) -> Seen {
        let p = v - self.line.o;
        let depth = p[self.along];
        Seen { x: p[self.across[0]] - self.slope[0] * depth, y: p[self.across[1]] - self.slope[1] * depth }
    }

    /// Where the line passes through a triangle, entering if it sees its front.
    #[inline]
    pub(super) fn hit(&self, triangle: &Triangle) -> Option<Crossing> {
        let seen = triangle.corners.map(|v| self.see(v));
        let turn = through(seen[0], seen[1], seen[2])?;
        self.crossing(triangle, seen, turn)
    }

    fn crossing(&self, triangle: &Triangle, seen: [Seen; 3], turn: Turn) -> Option<Crossing> {
        let plane = Plane::of(triangle, &self.line);
        // A triangle that looks no wider than the doubt about its corners hardly has a plane.
        let sliver = plane.t.is_nan() || width(seen) <= 4.0 * self.shift;
        let t = if sliver { self.on_longest_edge(triangle, seen) } else { plane.t };
        // No t outside of the triangle's box: so a box that begins behind a t holds no triangle hit there,
        // and what is hit does not depend on the accelerator. The exact t is in this interval too.
        let (near, far) = self.whole.enter_exit(&triangle.bounds())?;
        let t = t.clamp(near, far);
        let mut doubt = self.line.point_err(t);
        if near_an_edge(seen, 2.0 * self.shift) {
            // The exact ray may pass through the neighbour instead.
            doubt += Vec3::splat(2.0 * self.shift);
        }
        let err = rounding(t) + self.bound(triangle, t, doubt, plane.steps);
        Some(Crossing {
            t: libm::ldexp(t + 0.0, self.exponent),
            t_err: libm::ldexp(err, self.exponent),
            // Seen counter-clockwise along the axis is seen from behind.
            entering: (turn == Turn::Clockwise) == (self.line.d[self.along] > 0.0),
            primitive: triangle.face,
            ..Crossing::new(0.0, 0.0, false, 0)
        })
    }

    /// What doubt about a point of the line does to `t` in the plane of a triangle.
    ///
    /// A line that is off by `e` at `t` meets the plane with normal `n` where `t` is less by
    /// `n.e / n.(d + d_err)`. It is told for the triangle hit: where the line passes an edge at no more than
    /// its doubt, and the face behind the edge is steeper, the `t` there may be off by more.
    fn bound(&self, triangle: &Triangle, t: f64, doubt: Vec3, steps: Vec3) -> f64 {
        let bound = doubt.dot(steps) / (1.0 - self.line.d_err.dot(steps)).max(0.0);
        let depth = triangle.corners.map(|v| v[self.along]);
        let deep = depth[0].max(depth[1]).max(depth[2]) - depth[0].min(depth[1]).min(depth[2]);
        let stretch = deep / self.line.d[self.along].abs();
        // NaN is not resolved, and f64::min drops it.
        if bound <= RESOLVED * stretch { bound } else { bound.min(self.steepest(t)) }
    }

    /// Where the line is nearest to the edge that looks longest.
    fn on_longest_edge(&self, triangle: &Triangle, seen: [Seen; 3]) -> f64 {
        let depth = triangle.corners.map(|v| v[self.along] - self.line.o[self.along]);
        let step = |i: usize, j: usize| Seen { x: seen[j].x - seen[i].x, y: seen[j].y - seen[i].y };
        let length = |s: Seen| s.x * s.x + s.y * s.y;
        let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (i, j, step(i, j)));
        let (i, j, s) =
            edges.into_iter().fold(edges[0], |a, b| if length(b.2) > length(a.2) { b } else { a });
        let part = -(seen[i].x * s.x + seen[i].y * s.y) / length(s);
        // An edge too short to square is a point.
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        (depth[i] + part * (depth[j] - depth[i])) / self.line.d[self.along]
    }
}

/// Where a line meets the plane of a triangle.
struct Plane {
    /// The parameter, correctly rounded. Not a number if the triangle lies on a line or the line in the plane.
    t: f64,
    /// How much `t` changes where a coordinate of the line changes by one.
    steps: Vec3,
}

impl Plane {
    fn of(triangle: &Triangle, line: &Line) -> Plane {
        let [a, b, c] = triangle.corners;
        let normal = cross(&minus(b, a), &minus(c, a));
        let height = dot(&normal, &minus(a, line.o));
        let descent = dot(&normal, &line.d.to_array().map(Dd::from)).recip();
        let steps = Vec3::from(normal.map(|n| (n.hi * descent.hi).abs()));
        Plane { t: (height * descent).hi, steps }
    }
}

/// The line for box tests: its origin is in doubt by as much as shearing may move vertices. Then a box is
/// never missed if the sheared triangle in it is hit.
///
/// For if the ray is in the drawing of a triangle, then weights of the drawn corners sum to the ray; the
/// point of the true triangle with these weights has its `t` along the main axis, and there it is off the
/// line by no more than the corners are off their place. A corner is off by the rounding of `v - o` along
/// and across, of the slope, of its product and of the difference: less than 6 half-ulps of `|o| + |v|`,
/// and `shift` is 8. The errors of the frame do not matter here: the hits asked for are those of the line
/// as it is given.
fn line_for_boxes(line: &Line, shift: f64) -> Line {
    Line { o_err: Vec3::splat(shift), ..Line::exact(line.o, line.d) }
}

/// The span between two `t`, of which the first may be `-inf`.
fn span(from: f64, to: f64) -> Span {
    let from = from.clamp(-f64::MAX, f64::MAX);
    Span::new(from, to.max(from)).unwrap_or(Span::FORWARD)
}

/// The rounding of a `t`, with what little the arithmetic before it adds.
fn rounding(t: f64) -> f64 {
    1.001 * HALF_ULP * t.abs()
}

/// Whether the ray passes an edge of a triangle at a distance up to `reach`.
fn near_an_edge([a, b, c]: [Seen; 3], reach: f64) -> bool {
    [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| edge(p, q).abs() <= reach * extent(p, q))
}

/// How wide a triangle looks across its longest edge, at least.
fn width([a, b, c]: [Seen; 3]) -> f64 {
    let area = edge(a, b) + edge(b, c) + edge(c, a);
    area.abs() / extent(a, b).max(extent(b, c)).max(extent(c, a))
}

/// How long an edge looks, at most.
fn extent(a: Seen, b: Seen) -> f64 {
    (b.x - a.x).abs() + (b.y - a.y).abs()
}

/// A vector of double-doubles.
type Wide = [Dd; 3];

fn minus(a: Vec3, b: Vec3) -> Wide {
    std::array::from_fn(|i| two_sum(a[i], -b[i]))
}

fn cross(a: &Wide, b: &Wide) -> Wide {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &Wide, b: &Wide) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
