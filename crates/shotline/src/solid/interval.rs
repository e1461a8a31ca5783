//! Stretches of a line inside a convex piece of a solid, with the surface and the bound at either end.

use crate::crossing::Crossing;
use crate::math::HALF_ULP;
use crate::ray::Line;

/// Where a line enters or leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    pub t: f64,
    pub t_err: f64,
    pub surface: u32,
}

impl End {
    /// An end at infinity: no surface is there.
    const BEFORE_ALL: End = End { t: f64::NEG_INFINITY, t_err: 0.0, surface: 0 };
    const AFTER_ALL: End = End { t: f64::INFINITY, t_err: 0.0, surface: 0 };
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

    /// From an end to infinity.
    pub fn after(enter: End) -> Interval {
        Interval { enter, ..Interval::ALL }
    }

    /// From minus infinity to an end.
    pub fn before(exit: End) -> Interval {
        Interval { exit, ..Interval::ALL }
    }

    /// What lies in both; nothing where they only touch.
    pub fn clip(self, other: Interval) -> Option<Interval> {
        let enter = if other.enter.t > self.enter.t { other.enter } else { self.enter };
        let exit = if other.exit.t < self.exit.t { other.exit } else { self.exit };
        (enter.t < exit.t).then_some(Interval { enter, exit })
    }

    /// Appends the entry and the exit.
    pub fn push(self, out: &mut Vec<Crossing>) {
        let Interval { enter, exit } = self;
        out.push(Crossing::new(enter.t, enter.t_err, true, enter.surface));
        out.push(Crossing::new(exit.t, exit.t_err, false, exit.surface));
    }
}

/// The space between two planes perpendicular to an axis, `low < p[axis] < high` (Kay and Kajiya 1986).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slab {
    pub axis: usize,
    pub low: f64,
    pub high: f64,
    /// The number of the surface at `low`; the one at `high` follows it.
    pub surface: u32,
}

impl Slab {
    /// The part of a line between the planes.
    pub fn interval(&self, line: &Line) -> Option<Interval> {
        let (o, d) = (line.o[self.axis], line.d[self.axis]);
        if d == 0.0 {
            // In a face plane is not between the planes.
            return (self.low < o && o < self.high).then_some(Interval::ALL);
        }
        let end = |z: f64, surface: u32| {
            let t = (z - o) / d;
            let moved = line.o_err[self.axis] + line.d_err[self.axis] * t.abs();
            if !t.is_finite() {
                return End { t, t_err: 0.0, surface };
            }
            // One subtraction and one division; a line of the world is exact.
            let of_frame = if moved > 0.0 { moved / d.abs() } else { 0.0 };
            End { t, t_err: 2.0 * HALF_ULP * t.abs() + of_frame, surface }
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
            }
        }
    }

    #[test]
    fn intervals_that_touch_have_nothing_in_common() {
        let end = |t: f64| End { t, t_err: 0.0, surface: 0 };
        assert_eq!(Interval::before(end(1.0)).clip(Interval::after(end(1.0))), None);
        let both = Interval::before(end(1.0)).clip(Interval::after(end(0.5))).unwrap();
        assert_eq!((both.enter.t, both.exit.t), (0.5, 1.0));
    }
}
