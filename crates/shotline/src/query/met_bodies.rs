//! The bodies that a ray has met, with the intervals of the ray in them.

use super::interval_ends::Interval;
use super::traversal::BodyEntry;
use crate::csg::Boundary;

/// The memory of one ray is kept for the next up to this many bodies and intervals.
const RETAINED: usize = 4096;

/// The bodies that a ray has met, with their intervals; reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct MetBodies {
    pub bodies: Vec<BodyEntry>,
    pub intervals: Vec<Interval>,
    /// For each interval its body and its two ends.
    pub of_intervals: Vec<(u32, [Boundary; 2])>,
    /// The nearest hit at a visible surface that has no inside.
    pub surface: Option<(u32, Boundary)>,
}

impl MetBodies {
    pub fn begin(&mut self) {
        self.bodies.clear();
        self.intervals.clear();
        self.of_intervals.clear();
        self.bodies.shrink_to(RETAINED);
        self.intervals.shrink_to(RETAINED);
        self.of_intervals.shrink_to(RETAINED);
        self.surface = None;
    }
}

impl MetBodies {
    pub fn add(&mut self, body: u32, entry: &BodyEntry, ends: [Boundary; 2]) {
        let [start, end] = ends.map(|boundary| boundary.crossing);
        let (object, path) = (entry.placed.object, entry.placed.path);
        self.intervals.push(Interval { start, end, object, path });
        self.of_intervals.push((body, ends));
    }

    /// Notes a hit at a surface that has no inside. Of several at the same `t`, the one of the lowest path is kept.
    pub fn add_surface(&mut self, body: u32, boundary: Boundary) {
        let key =
            |(body, boundary): (u32, Boundary)| (boundary.crossing.t, self.bodies[body as usize].placed.path);
        if self.surface.is_none_or(|other| key((body, boundary)) < key(other)) {
            self.surface = Some((body, boundary));
        }
    }
}
