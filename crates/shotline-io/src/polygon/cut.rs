//! Cuts polygons into triangles by clipping ears (G. H. Meisters 1975, "Polygons have ears").
//!
//! A corner is an ear if its triangle turns left and nothing of the polygon lies in the way of its third side. All signs
//! are exact, so a polygon that does not cross itself is cut within its outline: every triangle has an area, and corners
//! on a straight edge stay corners of triangles. A corner that is not an ear waits for the corner in its way to be clipped,
//! so the work is about n log n. Each clip takes one corner out of the ring, so any polygon of n corners gives n - 2
//! triangles that have its outline, edge by edge; a mesh that is closed stays closed.
//!
//! Our own: of `earcutr`, `earcut` and `lyon_tessellation` none decides its signs exactly, and the last adds vertices.

use std::collections::{HashMap, VecDeque};

use shotline::math::Vec3;

use super::blockers::Blockers;
use super::plane::{Point, axes, folds_back, is_clockwise, scaled, seen_along, turn, turning_number};

/// A polygon cut into triangles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cut {
    /// Corners of the polygon by their numbers, in its direction; two triangles less than it has corners.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether the triangles cover the polygon as seen along an axis, none over another. No polygon that crosses itself
    /// has such a cut, and few that are far from flat.
    pub(crate) is_proper: bool,
}

/// Cuts a polygon of at least three corners. Seen along the axis along which it has the largest area, where it is
/// flat, or nearly so; if it crosses itself there, along another axis, and if it does everywhere, as well as may be.
pub(crate) fn cut(corners: &[Vec3]) -> Cut {
    let corners = scaled(corners);
    let mut first = None;
    let mut has_area = false;
    for axis in axes(&corners) {
        let (cut, has) = cut_along(&corners, axis);
        if cut.is_proper {
            return cut;
        }
        has_area |= has;
        first.get_or_insert(cut);
    }
    // Triangles without area cover nothing.
    let triangles = first.map_or_else(Vec::new, |cut| cut.triangles);
    Cut { triangles, is_proper: !has_area }
}

/// A cut as seen along an axis, and whether the polygon has an area there.
fn cut_along(corners: &[Vec3], axis: usize) -> (Cut, bool) {
    let points = seen_along(corners, axis);
    if let Some(triangles) = quad(&points) {
        return (Cut { triangles, is_proper: true }, true);
    }
    let mut clipper = Clipper::new(points);
    clipper.clean();
    let ring = clipper.ring();
    if is_clockwise(&clipper.points, &ring) {
        // Mirrored, so that inside is to the left; the numbers of the corners keep their direction.
        clipper.points.iter_mut().for_each(|p| p.swap(0, 1));
    }
    let turns = turning_number(&clipper.points, &ring);
    clipper.clip_ears();
    let points = &clipper.points;
    let corner = |i: u32| points[i as usize];
    let is_left = |[a, b, c]: &[u32; 3]| turn(corner(*a), corner(*b), corner(*c)) >= 0.0;
    let is_proper = turns == 1 && clipper.triangles.iter().all(is_left);
    (Cut { is_proper, triangles: clipper.triangles }, ring.len() > 2)
}

/// The usual case of four corners that turn the same way, cut from the first to the third.
fn quad(points: &[Point]) -> Option<Vec<[u32; 3]>> {
    let [a, b, c, d] = *points else { return None };
    let turns = [turn(a, b, c), turn(b, c, d), turn(c, d, a), turn(d, a, b)];
    let same = turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0);
    (same && !is_thin(a, b, c) && !is_thin(a, c, d)).then(|| vec![[0, 1, 2], [0, 2, 3]])
}

/// Whether a triangle is so thin that others are cut first: less than 2^-12 as high as long.
fn is_thin(a: Point, b: Point, c: Point) -> bool {
    let squared = |p: Point, q: Point| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
    turn(a, b, c).abs() < squared(a, b).max(squared(b, c)).max(squared(c, a)) / 4096.0
}

/// What a corner of the ring is to its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// It turns left.
    Convex,
    /// It turns right, or goes straight on.
    NotConvex,
    /// It goes back on itself, or is in the place of a neighbour.
    Spike,
}

/// A polygon that is being cut.
struct Clipper {
    points: Vec<Point>,
    before: Vec<u32>,
    after: Vec<u32>,
    left: usize,
    triangles: Vec<[u32; 3]>,
    blockers: Blockers,
    /// By a corner, those that cannot be clipped as long as it is in their way.
    waiting: HashMap<u32, Vec<u32>>,
    /// The same for those that are in the way only as long as they have their neighbours.
    touched: HashMap<u32, Vec<u32>>,
    /// Corners to try, with the number of their turn: of several the last counts.
    good: VecDeque<(u32, u32)>,
    thin: VecDeque<(u32, u32)>,
    tries: Vec<u32>,
    /// No corner turned left when last looked at. Looking each time would take n^2.
    none_convex: bool,
}

/// In the place of its neighbours: the corner has been clipped.
const CLIPPED: u32 = u32::MAX;

impl Clipper {
    fn new(points: Vec<Point>) -> Clipper {
        let n = points.len() as u32;
        Clipper {
            before: (0..n).map(|i| (i + n - 1) % n).collect(),
            after: (0..n).map(|i| (i + 1) % n).collect(),
            left: points.len(),
            triangles: Vec::with_capacity(points.len()),
            blockers: Blockers::of(&points, Vec::new()),
            waiting: HashMap::new(),
            touched: HashMap::new(),
            good: VecDeque::new(),
            thin: VecDeque::new(),
            tries: vec![0; points.len()],
            none_convex: false,
            points,
        }
    }

    fn point(&self, corner: u32) -> Point {
        self.points[corner as usize]
    }

    /// A corner between its neighbours.
    fn triangle(&self, corner: u32) -> [u32; 3] {
        [self.before[corner as usize], corner, self.after[corner as usize]]
    }

    fn is_left(&self, corner: u32) -> bool {
        self.before[corner as usize] != CLIPPED
    }

    fn shape(&self, corner: u32) -> Shape {
        let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
        match turn(a, b, c) {
            turn if turn > 0.0 => Shape::Convex,
            0.0 if folds_back(a, b, c) => Shape::Spike,
            _ => Shape::NotConvex,
        }
    }

    /// The corners that are left, in their order.
    fn ring(&self) -> Vec<u32> {
        (0..self.points.len() as u32).filter(|i| self.is_left(*i)).collect()
    }

    /// Takes a corner out of the ring as a triangle.
    fn take(&mut self, corner: u32) {
        let [a, b, c] = self.triangle(corner);
        self.triangles.push([a, b, c]);
        self.after[a as usize] = c;
        self.before[c as usize] = a;
        self.before[b as usize] = CLIPPED;
        self.left -= 1;
    }

    /// Takes out all spikes. They have no area, and without them a ring that does not cross itself turns round once.
    fn clean(&mut self) {
        let mut corner = 0;
        let mut unseen = self.left;
        while unseen > 0 && self.left > 2 {
            let [a, _, c] = self.triangle(corner);
            if self.shape(corner) == Shape::Spike {
                self.take(corner);
                // The neighbours have changed.
                corner = a;
                unseen = (unseen + 1).min(self.left);
            } else {
                corner = c;
                unseen -= 1;
            }
        }
    }

    /// Clips ear after ear, and where there is none, as in a ring that crosses itself, another corner.
    fn clip_ears(&mut self) {
        let ring = self.ring();
        let shapes: Vec<Shape> = ring.iter().map(|i| self.shape(*i)).collect();
        let not_convex = ring.iter().zip(&shapes).filter(|(_, shape)| **shape == Shape::NotConvex);
        self.blockers = Blockers::of(&self.points, not_convex.map(|(i, _)| *i).collect());
        // The second is tried first, so that a convex polygon is cut from its first corner.
        for corner in ring.iter().skip(1).chain(ring.first()) {
            self.enqueue(*corner);
        }
        let mut cursor = ring.first().copied().unwrap_or(0);
        while self.left > 3 {
            let corner = self.next_ear().unwrap_or_else(|| self.any_convex(&mut cursor));
            self.clip(corner);
        }
        if self.left == 3 {
            let rest = (0..self.points.len() as u32).find(|i| self.is_left(*i)).unwrap_or(0);
            self.triangles.push([rest, self.after[rest as usize], self.before[rest as usize]]);
        }
    }

    /// Has a corner tried, if it may be an ear, after those that wait already.
    fn enqueue(&mut self, corner: u32) {
        self.tries[corner as usize] += 1;
        let shape = self.shape(corner);
        if shape == Shape::NotConvex {
            return;
        }
        self.unblock(corner);
        let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
        let turn = (corner, self.tries[corner as usize]);
        if shape == Shape::Spike {
            // At once: next to a spike a corner may turn left though it is outside.
            self.good.push_front(turn);
        } else if shape == Shape::Convex && is_thin(a, b, c) {
            self.thin.push_back(turn);
        } else {
            self.good.push_back(turn);
        }
    }

    /// A corner is in no one's way any more.
    fn unblock(&mut self, corner: u32) {
        if self.blockers.remove(corner) {
            for waiting in self.waiting.remove(&corner).unwrap_or_default() {
                if self.is_left(waiting) {
                    self.enqueue(waiting);
                }
            }
        }
    }

    /// The next ear, if there is one.
    fn next_ear(&mut self) -> Option<u32> {
        loop {
            let (corner, tried) = self.good.pop_front().or_else(|| self.thin.pop_front())?;
            if !self.is_left(corner) || self.tries[corner as usize] != tried {
                continue;
            }
            match self.blocker(corner) {
                None => return Some(corner),
                Some(blocker) => {
                    let [a, b, c] = self.triangle(corner).map(|i| self.point(i));
                    let place = self.point(blocker);
                    let touches = place == b || turn(a, b, place) == 0.0 || turn(b, c, place) == 0.0;
                    let waiting = if touches { &mut self.touched } else { &mut self.waiting };
                    waiting.entry(blocker).or_default().push(corner);
                }
            }
        }
    }

    /// What keeps a corner from being an ear.
    fn blocker(&self, corner: u32) -> Option<u32> {
        if self.shape(corner) == Shape::Spike {
            return None;
        }
        let triangle = self.triangle(corner).map(|i| self.point(i));
        self.blockers.find(&self.points, triangle, |other| self.is_in_way(other, triangle))
    }

    /// Whether a corner in a triangle, or on its sides, is in the way of clipping that. One that only touches a side
    /// from outside is not, and no more one in the place of a neighbour: where a ring touches itself without crossing,
    /// what goes into the triangle from there has a corner in it. What goes into it from the place of the corner itself
    /// may pass through the third side.
    fn is_in_way(&self, other: u32, [a, b, c]: [Point; 3]) -> bool {
        let place = self.point(other);
        if place == a || place == c {
            return false;
        }
        let [before, _, after] = self.triangle(other).map(|i| self.point(i));
        if place == b {
            return [before, after].into_iter().any(|p| turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0);
        }
        let enters = |from: Point, to: Point| turn(from, to, before) > 0.0 || turn(from, to, after) > 0.0;
        if turn(a, b, place) == 0.0 {
            enters(a, b)
        } else if turn(b, c, place) == 0.0 {
            enters(b, c)
        } else {
            true
        }
    }

    /// The next corner that turns left, or any: where no corner is an ear, the ring crosses itself.
    fn any_convex(&mut self, cursor: &mut u32) -> u32 {
        while !self.is_left(*cursor) {
            *cursor = (*cursor + 1) % self.points.len() as u32;
        }
        for _ in 0..self.left {
            if self.none_convex || self.shape(*cursor) == Shape::Convex {
                return *cursor;
            }
            *cursor = self.after[*cursor as usize];
        }
        self.none_convex = true;
        *cursor
    }

    fn clip(&mut self, corner: u32) {
        let [a, _, c] = self.triangle(corner);
        self.take(corner);
        self.unblock(corner);
        self.enqueue(a);
        self.enqueue(c);
        // Their neighbours have changed, so they may not be in the way of what they touch.
        for changed in [a, corner, c] {
            for waiting in self.touched.remove(&changed).unwrap_or_default() {
                if self.is_left(waiting) {
                    self.enqueue(waiting);
                }
            }
        }
    }
}
