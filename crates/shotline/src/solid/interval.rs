//! Intervals of a line inside a convex piece of a solid, with the surface and the error bound at each end.

use crate::contact::{Contact, Sector};
use crate::crossing::{Crossing, GROUPING};
use crate::math::{HALF_ULP, Vec3};
use crate::ray::Line;

/// The point where a line enters or leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    pub t: f64,
    pub t_err: f64,
    pub surface: u32,
    /// See [`Crossing::reach`].
    pub reach: f32,
}

impl End {
    /// An end at infinity, where there is no surface.
    const BEFORE_ALL: End = End::new(f64::NEG_INFINITY, 0.0, 0);
    const AFTER_ALL: End = End::new(f64::INFINITY, 0.0, 0);

    pub const fn new(t: f64, t_err: f64, surface: u32) -> End {
        End { t, t_err, surface, reach: GROUPING as f32 }
    }

    fn crossing(self, entering: bool) -> Crossing {
        Crossing { reach: self.reach, ..Crossing::new(self.t, self.t_err, entering, self.surface) }
    }
}

/// An open interval of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub enter: End,
    pub exit: End,
}

impl Interval {
    /// The whole line.
    pub const ALL: Interval = Interval { enter: End::BEFORE_ALL, exit: End::AFTER_ALL };

    /// From a given end to infinity.
    pub fn after(enter: End) -> Interval {
        Interval { enter, ..Interval::ALL }
    }

    /// From minus infinity to a given end.
    pub fn before(exit: End) -> Interval {
        Interval { exit, ..Interval::ALL }
    }

    /// Returns the intersection of both. `None` if they share only an end.
    pub fn clip(self, other: Interval) -> Option<Interval> {
        let enter = if other.enter.t > self.enter.t { other.enter } else { self.enter };
        let exit = if other.exit.t < self.exit.t { other.exit } else { self.exit };
        (enter.t < exit.t).then_some(Interval { enter, exit })
    }

    /// The same interval with both ends on a given surface.
    pub fn on(mut self, surface: u32) -> Interval {
        (self.enter.surface, self.exit.surface) = (surface, surface);
        self
    }

    /// Appends the entry and the exit.
    pub fn push(self, out: &mut Vec<Crossing>) {
        out.push(self.enter.crossing(true));
        out.push(self.exit.crossing(false));
    }

    /// Returns the contact for an interval on which the line lies in a surface, with the sector of the interior.
    pub fn contact(self, sector: Sector) -> Contact {
        Contact { enter: self.enter.crossing(true), exit: self.exit.crossing(false), sector }
    }
}

/// The space between two planes perpendicular to an axis, `low < p[axis] < high` (Kay and Kajiya 1986).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slab {
    pub axis: usize,
    pub low: f64,
    pub high: f64,
    /// The index of the surface at `low`. The surface at `high` has the next index.
    pub surface: u32,
}

impl Slab {
    /// The slab of the box between two corners across an axis.
    #[inline(always)]
    pub fn of_box(min: &Vec3, max: &Vec3, axis: usize) -> Slab {
        Slab { axis, low: min[axis], high: max[axis], surface: 2 * axis as u32 }
    }

    /// Whether a line cannot be distinguished from one parallel to the planes.
    pub fn is_parallel(&self, line: &Line) -> bool {
        line.d[self.axis].abs() <= GROUPING * line.d_err[self.axis]
    }

    /// The outward normals of the planes in which the line lies, up to its errors. Neither if the line certainly
    /// crosses or misses the planes; both in a slab of zero thickness.
    fn containing_planes(&self, line: &Line) -> [Option<Vec3>; 2] {
        let doubt = GROUPING * line.o_err[self.axis];
        let touches = |z: f64| self.is_parallel(line) && (line.o[self.axis] - z).abs() <= doubt;
        let normal = Vec3::AXES[self.axis];
        [touches(self.low).then_some(-normal), touches(self.high).then_some(normal)]
    }

    /// Returns the interval of a line between the planes. A line in one of the planes is not between them.
    pub fn interval(&self, line: &Line) -> Option<Interval> {
        if self.is_parallel(line) && self.containing_planes(line) != [None, None] {
            return None;
        }
        self.between(line)
    }

    /// Like [`Slab::interval`], but a line in one of the planes counts as between them, and that plane's outward
    /// normal is returned.
    pub fn closed_interval(&self, line: &Line) -> Option<(Interval, Option<Vec3>)> {
        match self.containing_planes(line) {
            [None, None] => Some((self.between(line)?, None)),
            [Some(_), Some(_)] => None,
            [low, high] => Some((Interval::ALL, low.or(high))),
        }
    }

    fn between(&self, line: &Line) -> Option<Interval> {
        let (o, d) = (line.o[self.axis], line.d[self.axis]);
        if d == 0.0 {
            return (self.low < o && o < self.high).then_some(Interval::ALL);
        }
        let end = |z: f64, surface: u32| {
            let t = (z - o) / d;
            let moved = line.o_err[self.axis] + line.d_err[self.axis] * t.abs();
            if !t.is_finite() {
                return End::new(t, 0.0, surface);
            }
            // One subtraction and one division round. Lines in world coordinates have no frame errors.
            let of_frame = if moved > 0.0 { moved / d.abs() } else { 0.0 };
            End::new(t, 2.0 * HALF_ULP * t.abs() + of_frame, surface)
        };
        let (low, high) = (end(self.low, self.surface), end(self.high, self.surface + 1));
        let (enter, exit) = if d > 0.0 { (low, high) } else { (high, low) };
        Interval::ALL.clip(Interval { enter, exit })
    }

    /// Whether a point lies strictly between the planes.
    pub fn contains(&self, x: f64) -> bool {
        self.low < x && x < self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    const UNIT: Slab = Slab { axis: 2, low: 0.0, high: 1.0, surface: 0 };

    #[test]
    fn lines_in_a_face_are_outside() {
        for (z, inside) in [(0.0, false), (0.5, true), (1.0, false)] {
            for zero in [0.0, -0.0] {
                let line = Line::exact(Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, zero));
                assert_eq!(UNIT.interval(&line), inside.then_some(Interval::ALL));
                let face = match z {
                    0.0 => Some(Vec3::NEG_Z),
                    1.0 => Some(Vec3::Z),
                    _ => None,
                };
                assert_eq!(UNIT.closed_interval(&line), Some((Interval::ALL, face)));
            }
        }
    }

    #[test]
    fn lines_along_a_face_up_to_rounding_touch_it() {
        let mut line = Line::exact(Vec3::new(0.0, 0.0, 1.0 + 3e-16), Vec3::new(1.0, 0.0, 1e-16));
        assert_eq!(UNIT.closed_interval(&line).map(|c| c.1), Some(None));
        line = Line { o_err: Vec3::splat(1e-16), d_err: Vec3::splat(1e-16), ..line };
        assert_eq!(
            (UNIT.interval(&line), UNIT.closed_interval(&line)),
            (None, Some((Interval::ALL, Some(Vec3::Z))))
        );
        line.d.z = 1e-15;
        assert_eq!(UNIT.containing_planes(&line), [None, None]);
    }

    #[test]
    fn intervals_that_touch_have_nothing_in_common() {
        let end = |t: f64| End::new(t, 0.0, 0);
        assert_eq!(Interval::before(end(1.0)).clip(Interval::after(end(1.0))), None);
        let both = Interval::before(end(1.0)).clip(Interval::after(end(0.5))).unwrap();
        assert_eq!((both.enter.t, both.exit.t), (0.5, 1.0));
    }
}
