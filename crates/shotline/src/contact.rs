//! Contacts: intervals on which a line lies in the surface of a solid, with the sector around the line that contains
//! the interior.

use std::cmp::Ordering;

use crate::crossing::Crossing;
use crate::math::{Affine, HALF_ULP, Vec3, power_of_two_near, unit};

/// An interval on which a line lies in the surface of a solid, up to rounding, and has the interior beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The start of the interval: the crossing of a surface that bounds it.
    pub enter: Crossing,
    /// The end of the interval.
    pub exit: Crossing,
    /// The sector around the line that contains the interior.
    pub sector: Sector,
}

/// A sector around a line, of at most half a turn. It runs counter-clockwise from its first border to its last, seen
/// with the line pointing towards the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// The first border.
    pub from: Border,
    /// The last border.
    pub to: Border,
}

/// The border of a sector: the half of a sheet on one side of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Border {
    /// The surface.
    pub sheet: Sheet,
    /// 1 if the border leaves the line along `line x normal`, -1 if it leaves the other way.
    pub side: f64,
}

/// A surface that contains a line, to second order: at the displacement `v` from the line's point at `t`, its
/// implicit function is `2 (normal + (t - at) turn) v + v form v`, up to a positive factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Half the gradient at the line's point at `t = at`, scaled to length 1. It points outward.
    pub normal: Vec3,
    /// Its change for one unit of `t`. Not zero on a cone, whose gradient grows with the distance from the apex, and
    /// where the tangent plane turns around the line.
    pub turn: Vec3,
    /// The `t` to which `normal` belongs.
    pub at: f64,
    /// The rows of a symmetric matrix; zero for a plane.
    pub form: [Vec3; 3],
    /// A bound on the error of `normal` and of `turn`, relative to their lengths.
    pub doubt: f64,
}

impl Sheet {
    /// A plane, by its outward normal of any length.
    pub fn plane(normal: Vec3) -> Sheet {
        Sheet {
            normal: unit(normal),
            turn: Vec3::ZERO,
            at: 0.0,
            form: [Vec3::ZERO; 3],
            doubt: 4.0 * HALF_ULP,
        }
    }

    /// The same surface with inside and outside exchanged.
    pub fn turned_over(self) -> Sheet {
        Sheet { normal: -self.normal, turn: -self.turn, form: self.form.map(|row| -row), ..self }
    }

    /// The same surface in another frame, given the map from that frame to this one.
    fn in_frame(&self, this_from_that: &Affine) -> Sheet {
        let columns = Vec3::AXES.map(|axis| this_from_that.vector(axis));
        // Scaled to a size of about 1, so that the products are in range.
        let size = power_of_two_near(columns.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max));
        let columns = columns.map(|column| column / size);
        let along_columns = |v: Vec3| Vec3::from(columns.map(|column| v.dot(column)));
        let normal = along_columns(self.normal);
        let length = normal.length();
        let times = |v: Vec3| Vec3::from(self.form.map(|row| row.dot(v)));
        Sheet {
            normal: normal / length,
            turn: along_columns(self.turn) / length,
            form: columns.map(|column| along_columns(times(column)) * (size / length)),
            ..*self
        }
    }
}

impl Border {
    /// The border in the plane through a line and a direction across it, on the side of the line to which the
    /// direction points.
    pub fn straight(direction: Vec3, line: Vec3) -> Border {
        Border { sheet: Sheet::plane(unit(direction).cross(unit(line))), side: 1.0 }
    }
}

impl Sector {
    /// The sector behind one surface, or behind two whose `turn` is zero, around a line that they contain; `None` if
    /// the sector is empty.
    pub fn behind(sheets: &[Sheet], line: Vec3) -> Option<Sector> {
        let between = |first: Sheet, last: Sheet| Sector {
            from: Border { sheet: last, side: 1.0 },
            to: Border { sheet: first, side: -1.0 },
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

    /// The same sector in another frame, given the map from that frame to this one. A reflection exchanges its
    /// borders.
    pub fn in_frame(&self, this_from_that: &Affine) -> Sector {
        if this_from_that.is_identity() {
            return *self;
        }
        let [x, y, z] = Vec3::AXES.map(|axis| unit(this_from_that.vector(axis)));
        let mirror = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
        let border = |b: Border| Border { sheet: b.sheet.in_frame(this_from_that), side: mirror * b.side };
        let [from, to] = [self.from, self.to].map(border);
        if mirror < 0.0 { Sector { from: to, to: from } } else { Sector { from, to } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(border: Border, line: Vec3) -> Vec3 {
        line.cross(border.sheet.normal) * border.side
    }

    #[test]
    fn sectors_lie_behind_planes() {
        let line = Vec3::Z * 3.0;
        let (x, y) = (Vec3::X, Vec3::Y);
        let plane = Sheet::plane;
        let half = |n: Vec3| Sector::behind(&[plane(n)], line).unwrap();
        // The sector of x < 0 begins on the y axis and continues counter-clockwise.
        assert_eq!((direction(half(x).from, line).dot(x), direction(half(x).to, line).dot(x)), (0.0, 0.0));
        assert!(direction(half(x).from, line).dot(y) > 0.0 && direction(half(x).to, line).dot(y) < 0.0);
        for (a, b) in [(x, y), (y, x)] {
            let quarter = Sector::behind(&[plane(a), plane(b)], line).unwrap();
            assert_eq!(
                (direction(quarter.from, line).dot(y), direction(quarter.to, line).dot(x)),
                (0.0, 0.0)
            );
            assert!(direction(quarter.from, line).dot(x) < 0.0 && direction(quarter.to, line).dot(y) < 0.0);
        }
        assert_eq!(Sector::behind(&[plane(x), plane(x)], line), Some(half(x)));
        assert_eq!(Sector::behind(&[plane(x), plane(-x)], line), None);
    }

    #[test]
    fn a_border_across_the_line_is_kept_by_a_turn_and_a_mirror() {
        let line = Vec3::new(0.5, 1.0, -2.0);
        let sector = Sector {
            from: Border::straight(Vec3::new(2.0, -1.0, 0.0), line),
            to: Border::straight(Vec3::new(0.0, 2.0, 1.0), line),
        };
        for (x, mirrors) in [(3.0, false), (-3.0, true)] {
            let map = Affine::rotation_about(Vec3::new(1.0, 2.0, 3.0), 40.0)
                .then_after(&Affine::scaling(Vec3::new(x, 0.5, 1.0)));
            let inverse = map.inverse().unwrap();
            let there = sector.in_frame(&inverse);
            let pairs = if mirrors {
                [(there.to, sector.from), (there.from, sector.to)]
            } else {
                [(there.from, sector.from), (there.to, sector.to)]
            };
            for (moved, border) in pairs {
                let line = map.vector(line);
                let across = |v: Vec3| unit(v - line * (v.dot(line) / line.length_squared()));
                let expected = across(map.vector(direction(border, inverse.vector(line))));
                assert!(unit(direction(moved, line)).distance(expected) < 1e-12, "{moved:?}");
            }
        }
    }
}
