//! Triangulates polygons by ear clipping (G. H. Meisters 1975, "Polygons have ears").
//!
//! A corner is an ear if its triangle turns left and no part of the polygon blocks its third side. All signs are exact,
//! so the triangles of a polygon that does not cross itself lie within its outline: every triangle has an area, and
//! corners on a straight edge stay corners of triangles. A corner that is not an ear is tried again when the corner
//! that blocks it has been clipped, so the work is about n log n. Each clip removes one corner from the ring, so any
//! polygon of n corners gives n - 2 triangles that have its outline, edge by edge; a closed mesh stays closed.
//!
//! This crate has its own implementation, because none of `earcutr`, `earcut` and `lyon_tessellation` computes exact
//! signs, and the last adds vertices.

use std::collections::{HashMap, VecDeque};

use crate::math::Vec3;

use super::projection::{
    Point, is_clockwise, is_spike, orientation, project, projection_axes, scaled, turning_number,
};
use super::reflex_vertices::ReflexVertices;

/// The triangles of a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulation {
    /// Indices of corners, in the direction of the polygon; two triangles fewer than it has corners.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the triangles, projected along an axis, cover the polygon without overlap. No polygon that crosses
    /// itself has such a triangulation, and few that are far from flat have one.
    pub is_proper: bool,
}

/// Triangulates a polygon of at least three corners. It is projected along the axis along which its area is largest. If
/// the projection crosses itself, another axis is tried. If every projection does, the first triangulation is returned.
pub fn triangulate(corners: &[Vec3]) -> Triangulation {
    let corners = scaled(corners);
    let mut first = None;
    let mut has_area = false;
    for axis in projection_axes(&corners) {
        let (cut, has) = triangulate_along(&corners, axis);
        if cut.is_proper {
            return cut;
        }
        has_area |= has;
        first.get_or_insert(cut);
    }
    // Triangles without area cannot overlap.
    let triangles = first.map_or_else(Vec::new, |cut| cut.triangles);
    Triangulation { triangles, is_proper: !has_area }
}

/// The triangulation of the projection along an axis, and whether the projection has an area.
fn triangulate_along(corners: &[Vec3], axis: usize) -> (Triangulation, bool) {
    let points = project(corners, axis);
    if let Some(triangles) = quad(&points) {
        return (Triangulation { triangles, is_proper: true }, true);
    }
    let mut clipper = Clipper::new(points);
    clipper.remove_spikes();
    let ring = clipper.ring();
    if is_clockwise(&clipper.points, &ring) {
        // Mirrored, so that the inside is to the left; the order of the corners is kept.
        clipper.points.iter_mut().for_each(|p| p.swap(0, 1));
    }
    let turns = turning_number(&clipper.points, &ring);
    clipper.clip_ears();
    let points = &clipper.points;
    let corner = |i: u32| points[i as usize];
    let turns_left = |[a, b, c]: &[u32; 3]| orientation(corner(*a), corner(*b), corner(*c)) >= 0.0;
    let is_proper = turns == 1 && clipper.triangles.iter().all(turns_left);
    (Triangulation { is_proper, triangles: clipper.triangles }, ring.len() > 2)
}

/// The common case of a convex quadrilateral, split from the first to the third corner.
fn quad(points: &[Point]) -> Option<Vec<[u32; 3]>> {
    let [a, b, c, d] = *points else { return None };
    let turns = [orientation(a, b, c), orientation(b, c, d), orientation(c, d, a), orientation(d, a, b)];
    let same = turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0);
    (same && !is_sliver(a, b, c) && !is_sliver(a, c, d)).then(|| vec![[0, 1, 2], [0, 2, 3]])
}

/// Whether a triangle is so thin that others are clipped first: its height is less than 2^-12 of its length.
fn is_sliver(a: Point, b: Point, c: Point) -> bool {
    let squared = |p: Point, q: Point| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    orientation(a, b, c).abs() < squared(a, b).max(squared(b, c)).max(squared(c, a)) / 4096.0
}

/// The shape of a corner of the ring between its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// It turns left.
    Convex,
    /// It turns right or is straight.
    Reflex,
    /// It folds back on itself, or equals a neighbour.
    Spike,
}

/// A polygon during ear clipping.
struct Clipper {
    points: Vec<Point>,
    previous: Vec<u32>,
    next: Vec<u32>,
    remaining: usize,
    triangles: Vec<[u32; 3]>,
    reflex: ReflexVertices,
    /// For each corner, those that cannot be clipped while it blocks them.
    blocked: HashMap<u32, Vec<u32>>,
    /// The same for corners that block only while they have their present neighbours.
    blocked_by_touch: HashMap<u32, Vec<u32>>,
    /// Corners to try, each with its version when it was queued. Entries of older versions are stale.
    candidates: VecDeque<(u32, u32)>,
    sliver_candidates: VecDeque<(u32, u32)>,
    versions: Vec<u32>,
    /// The last search found no convex corner. Searching each time would take n^2.
    none_convex: bool,
}

/// The `previous` of a corner that has been clipped.
const CLIPPED: u32 = u32::MAX;

impl Clipper {
    fn new(points: Vec<Point>) -> Clipper {
        let n = points.len() as u32;
        Clipper {
            previous: (0..n).map(|i| (i + n - 1) % n).collect(),
            next: (0..n).map(|i| (i + 1) % n).collect(),
            remaining: points.len(),
            triangles: Vec::with_capacity(points.len()),
            reflex: ReflexVertices::of(&points, Vec::new()),
            blocked: HashMap::new(),
            blocked_by_touch: HashMap::new(),
            candidates: VecDeque::new(),
            sliver_candidates: VecDeque::new(),
            versions: vec![0; points.len()],
            none_convex: false,
            points,
        }
    }

    fn point(&self, corner: u32) -> Point {
        self.points[corner as usize]
    }

    /// The triangle of a corner and its neighbours.
    fn triangle(&self, corner: u32) -> [u32; 3] {
        [self.previous[corner as usize], corner, self.next[corner as usize]]
    }

    fn is_in_ring(&self, corner: u32) -> bool {
        self.previous[corner as usize] != CLIPPED
    }

    fn shape(&self, corner: u32) -> Shape {
        let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
        match orientation(a, b, c) {
            sign if sign > 0.0 => Shape::Convex,
            0.0 if is_spike(a, b, c) => Shape::Spike,
            _ => Shape::Reflex,
        }
    }

    /// The corners in the ring, in order.
    fn ring(&self) -> Vec<u32> {
        (0..self.points.len() as u32).filter(|i| self.is_in_ring(*i)).collect()
    }

    /// Removes a corner from the ring and emits its triangle.
    fn remove(&mut self, corner: u32) {
        let [a, b, c] = self.triangle(corner);
        self.triangles.push([a, b, c]);
        self.next[a as usize] = c;
        self.previous[c as usize] = a;
        self.previous[b as usize] = CLIPPED;
        self.remaining -= 1;
    }

    /// Removes all spikes. They have no area, and without them the turning number of a ring that does not cross itself
    /// is 1.
    fn remove_spikes(&mut self) {
        let mut corner = 0;
        let mut unchecked = self.remaining;
        while unchecked > 0 && self.remaining > 2 {
            let [a, _, c] = self.triangle(corner);
            if self.shape(corner) == Shape::Spike {
                self.remove(corner);
                // The neighbours have changed.
                corner = a;
                unchecked = (unchecked + 1).min(self.remaining);
            } else {
                corner = c;
                unchecked -= 1;
            }
        }
    }

    /// Clips ear after ear. Where there is none, as in a ring that crosses itself, it clips another corner.
    fn clip_ears(&mut self) {
        let ring = self.ring();
        let shapes: Vec<Shape> = ring.iter().map(|i| self.shape(*i)).collect();
        let reflex = ring.iter().zip(&shapes).filter(|(_, shape)| **shape == Shape::Reflex);
        self.reflex = ReflexVertices::of(&self.points, reflex.map(|(i, _)| *i).collect());
        // The second corner is tried first, so that a convex polygon becomes a fan about its first corner.
        for corner in ring.iter().skip(1).chain(ring.first()) {
            self.enqueue(*corner);
        }
        let mut cursor = ring.first().copied().unwrap_or(0);
        while self.remaining > 3 {
            let corner = self.next_ear().unwrap_or_else(|| self.fallback_corner(&mut cursor));
            self.clip(corner);
        }
        if self.remaining == 3 {
            let rest = (0..self.points.len() as u32).find(|i| self.is_in_ring(*i)).unwrap_or(0);
            self.triangles.push([rest, self.next[rest as usize], self.previous[rest as usize]]);
        }
    }

    /// Queues a corner to be tried, if it may be an ear.
    fn enqueue(&mut self, corner: u32) {
        self.versions[corner as usize] += 1;
        let shape = self.shape(corner);
        if shape == Shape::Reflex {
            return;
        }
        self.unblock(corner);
        let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
        let entry = (corner, self.versions[corner as usize]);
        if shape == Shape::Spike {
            // Tried at once: a neighbour of a spike may turn left although it lies outside.
            self.candidates.push_front(entry);
        } else if shape == Shape::Convex && is_sliver(a, b, c) {
            self.sliver_candidates.push_back(entry);
        } else {
            self.candidates.push_back(entry);
        }
    }

    /// Queues the corners that a corner blocked, now that it blocks none.
    fn unblock(&mut self, corner: u32) {
        if self.reflex.remove(corner) {
            for blocked in self.blocked.remove(&corner).unwrap_or_default() {
                if self.is_in_ring(blocked) {
                    self.enqueue(blocked);
                }
            }
        }
    }

    /// The next ear, if there is one.
    fn next_ear(&mut self) -> Option<u32> {
        loop {
            let (corner, version) =
                self.candidates.pop_front().or_else(|| self.sliver_candidates.pop_front())?;
            if !self.is_in_ring(corner) || self.versions[corner as usize] != version {
                continue;
            }
            match self.blocker(corner) {
                None => return Some(corner),
                Some(blocker) => {
                    let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
                    let point = self.point(blocker);
                    let touches =
                        point == b || orientation(a, b, point) == 0.0 || orientation(b, c, point) == 0.0;
                    let blocked = if touches { &mut self.blocked_by_touch } else { &mut self.blocked };
                    blocked.entry(blocker).or_default().push(corner);
                }
            }
        }
    }

    /// A corner that prevents another from being an ear.
    fn blocker(&self, corner: u32) -> Option<u32> {
        if self.shape(corner) == Shape::Spike {
            return None;
        }
        let triangle = self.triangle(corner).map(|i| self.point(i));
        self.reflex.find(&self.points, triangle, |other| self.blocks(other, triangle))
    }

    /// Whether a corner in a triangle, or on its sides, prevents the triangle from being clipped. A corner that only
    /// touches a side from outside does not. A corner at the position of a neighbour does not either: where a ring
    /// touches itself without crossing, an edge that enters the triangle from there has another corner inside it. An
    /// edge that enters from the position of the clipped corner itself may pass through the third side.
    fn blocks(&self, other: u32, [a, b, c]: [Point; 3]) -> bool {
        let point = self.point(other);
        if point == a || point == c {
            return false;
        }
        let [previous, _, next] = self.triangle(other).map(|i| self.point(i));
        if point == b {
            return [previous, next]
                .into_iter()
                .any(|p| orientation(a, b, p) > 0.0 && orientation(b, c, p) > 0.0);
        }
        let enters = |from: Point, to: Point| {
            orientation(from, to, previous) > 0.0 || orientation(from, to, next) > 0.0
        };
        if orientation(a, b, point) == 0.0 {
            enters(a, b)
        } else if orientation(b, c, point) == 0.0 {
            enters(b, c)
        } else {
            true
        }
    }

    /// The next convex corner, or else any. Needed only where no corner is an ear, so that the ring crosses itself.
    fn fallback_corner(&mut self, cursor: &mut u32) -> u32 {
        while !self.is_in_ring(*cursor) {
            *cursor = (*cursor + 1) % self.points.len() as u32;
        }
        for _ in 0..self.remaining {
            if self.none_convex || self.shape(*cursor) == Shape::Convex {
                return *cursor;
            }
            *cursor = self.next[*cursor as usize];
        }
        self.none_convex = true;
        *cursor
    }

    fn clip(&mut self, corner: u32) {
        let [a, _, c] = self.triangle(corner);
        self.remove(corner);
        self.unblock(corner);
        self.enqueue(a);
        self.enqueue(c);
        // Their neighbours have changed, so they may no longer block the triangles that they touch.
        for changed in [a, corner, c] {
            for blocked in self.blocked_by_touch.remove(&changed).unwrap_or_default() {
                if self.is_in_ring(blocked) {
                    self.enqueue(blocked);
                }
            }
        }
    }
}
