//! What a solid answers: the crossings of a whole line with its surface, and its contacts.

use std::cmp::Ordering;

use crate::math::Vec3;

/// The number of a crossing's triangle where there is none.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A place where a line passes the surface of one solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The parameter on the line; infinite where the interior has no end.
    pub t: f64,
    /// A bound on the error of `t`, from the rounding of the inputs and of the arithmetic.
    pub t_err: f64,
    /// Whether the line passes into the interior.
    pub entering: bool,
    /// Which surface of the solid: an index into [`crate::solid::Solid::surfaces`].
    pub surface: u32,
    /// The triangle of a mesh, else [`NO_PRIMITIVE`].
    pub primitive: u32,
    /// The crossing is one event with others within this many times its bound: [`GROUPING`], or less where the
    /// sign of the surface is certain nearer to `t` than that. A root near infinity has a bound as large as its own
    /// distance, and must not reach back to where the line certainly is inside or outside.
    pub reach: f32,
}

impl Crossing {
    /// A crossing with a surface that has no triangles.
    pub fn new(t: f64, t_err: f64, entering: bool, surface: u32) -> Crossing {
        Crossing { t, t_err, entering, surface, primitive: NO_PRIMITIVE, reach: GROUPING as f32 }
    }

    /// The lower end of the interval in which the crossing is one event with others.
    pub fn low(&self) -> f64 {
        self.t - f64::from(self.reach) * self.t_err
    }

    /// The upper end of that interval.
    pub fn high(&self) -> f64 {
        self.t + f64::from(self.reach) * self.t_err
    }
}

/// Crossings are one event where their `t` agree within so many times the sum of their bounds.
pub const GROUPING: f64 = 8.0;

/// Whether two crossings, the first not after the second, are one event.
pub fn together(a: &Crossing, b: &Crossing) -> bool {
    b.t == a.t || b.low() <= a.high()
}

/// A stretch on which a line that runs within the surface of a solid, up to rounding, has the interior beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Where the stretch begins: the crossing of a surface that bounds it.
    pub enter: Crossing,
    /// Where it ends.
    pub exit: Crossing,
    /// The sector in which the interior is.
    pub sector: Sector,
}

/// A sector around a line, of half a turn at most: between two borders, from the first to the last counter-clockwise,
/// seen with the line coming towards the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// Where it begins.
    pub from: Border,
    /// Where it ends.
    pub to: Border,
}

/// How the border of a sector leaves the line: as `r direction + r^2 bend`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Border {
    /// Across the line, of any length.
    pub direction: Vec3,
    /// Zero for a plane.
    pub bend: Vec3,
}

/// A surface that contains a line, to second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Normal to the tangent plane, outward, of any length.
    pub normal: Vec3,
    /// The [`Border::bend`] of the surface for steps across the line of the length of [`Sector::behind`]'s
    /// `line x normal`.
    pub bend: Vec3,
}

impl Sheet {
    /// A plane, by its outward normal.
    pub fn plane(normal: Vec3) -> Sheet {
        Sheet { normal, bend: Vec3::ZERO }
    }
}

impl Sector {
    /// What lies behind one surface or behind two, around a line that they contain; `None` if nothing does.
    pub fn behind(sheets: &[Sheet], line: Vec3) -> Option<Sector> {
        let between = |first: Sheet, last: Sheet| Sector {
            from: Border { direction: line.cross(last.normal), bend: last.bend },
            to: Border { direction: first.normal.cross(line), bend: first.bend },
        };
        match *sheets {
            [a] => Some(between(a, a)),
            [a, b] => match line.dot(a.normal.cross(b.normal)).total_cmp(&0.0) {
                Ordering::Greater => Some(between(a, b)),
                Ordering::Less => Some(between(b, a)),
                Ordering::Equal => (a.normal.dot(b.normal) > 0.0).then(|| between(a, a)),
            },
            _ => None,
        }
    }
}

/// Whether a list is what a solid may answer: ascending, alternating from an entry, and even.
pub fn is_alternating(list: &[Crossing]) -> bool {
    list.len().is_multiple_of(2)
        && list.iter().enumerate().all(|(i, c)| c.entering == (i % 2 == 0))
        && list.windows(2).all(|w| w[0].t <= w[1].t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sectors_lie_behind_planes() {
        let line = Vec3::Z * 3.0;
        let (x, y) = (Vec3::X, Vec3::Y);
        let plane = Sheet::plane;
        let half = |n: Vec3| Sector::behind(&[plane(n)], line).unwrap();
        // The interior of x < 0 begins on the y axis and goes on counter-clockwise.
        assert_eq!((half(x).from.direction.dot(x), half(x).to.direction.dot(x)), (0.0, 0.0));
        assert!(half(x).from.direction.dot(y) > 0.0 && half(x).to.direction.dot(y) < 0.0);
        for (a, b) in [(x, y), (y, x)] {
            let quarter = Sector::behind(&[plane(a), plane(b)], line).unwrap();
            assert_eq!((quarter.from.direction.dot(y), quarter.to.direction.dot(x)), (0.0, 0.0));
            assert!(quarter.from.direction.dot(x) < 0.0 && quarter.to.direction.dot(y) < 0.0);
        }
        assert_eq!(Sector::behind(&[plane(x), plane(x)], line), Some(half(x)));
        assert_eq!(Sector::behind(&[plane(x), plane(-x)], line), None);
    }

    #[test]
    fn odd_and_unsorted_lists_are_seen() {
        let (a, b) = (Crossing::new(1.0, 0.0, true, 0), Crossing::new(2.0, 0.0, false, 0));
        assert!(is_alternating(&[]));
        assert!(is_alternating(&[a, b]));
        assert!(!is_alternating(&[a]));
        assert!(!is_alternating(&[b, a]));
        assert!(!is_alternating(&[Crossing { t: 3.0, ..a }, b]));
    }
}
