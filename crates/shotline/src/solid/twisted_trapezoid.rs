//! A trapezoid twisted about the z axis: at each height its cross-section is turned by an angle that is proportional to z. Its
//! sides are helicoids.

use std::sync::Arc;

use super::helicoid::{Along, Side};
use super::interval::{End, Interval, Slab};
use super::trapezoid::Corners;
use super::{Build, Kind, Param, ParamError, Params, Solid, constructors};
use crate::aabb::Aabb;
use crate::contact::{Contact, Sector, Sheet};
use crate::crossing::Crossing;
use crate::math::{PowerOfTwo, Vec3, binary_exponent};
use crate::ray::Line;
use crate::scratch::Scratch;

pub(super) static KIND: Kind = Kind {
    name: "twisted_trapezoid",
    summary: "the solid between two quadrilaterals at -z and z with parallel edges, of which each cross-section is turned about the z axis in proportion to its height",
    interior: "at each height the quadrilateral between those of lower and upper, as in a trapezoid, turned by twist z' / (2 z) about the origin, then moved by (shift_x, shift_y) z' / (2 z), where z' is the height",
    params: &[
        Param::length("z", "half of the height"),
        Param::rows("lower", &["x", "y"], 4, "the corners at -z in order before they are turned; convex"),
        Param::rows(
            "upper",
            &["x", "y"],
            4,
            "those at z, each joined to that of the same row of lower; its edges are parallel to those of lower",
        ),
        Param::angle(
            "twist",
            "by how much the end at z is turned against that at -z, in degrees from -360 to 360",
        ),
        Param::length("shift_x", "by how much the axis of the twist is further along x at z than at -z")
            .or(&[0.0]),
        Param::length("shift_y", "the same along y").or(&[0.0]),
    ],
    build: Build::Solid(|p| Ok(Arc::new(TwistedTrapezoid::of(p)?))),
    examples: &[
        &[
            &[1.0],
            &[-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5],
            &[-1.0, -0.5, 1.0, -0.5, 1.0, 0.5, -1.0, 0.5],
            &[60.0],
        ],
        // Smaller at the top, leaning, and turned the other way.
        &[
            &[2.0],
            &[-1.5, -1.0, 1.5, -1.0, 1.0, 1.0, -1.0, 1.0],
            &[-0.75, -0.5, 0.75, -0.5, 0.5, 0.5, -0.5, 0.5],
            &[-80.0],
            &[1.0],
            &[-0.5],
        ],
        // A triangle beside the axis, turned by half a turn.
        &[
            &[1.5],
            &[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.5, 1.0],
            &[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.5, 1.0],
            &[180.0],
        ],
        &[
            &[0.5],
            &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0],
            &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0],
            &[0.0],
        ],
    ],
};

constructors! {
    twisted_trapezoid:
    /// The solid between two quadrilaterals at -z and z, of which each cross-section is turned about the z axis; the upper end
    /// by the angle twist, in degrees, against the lower one. Its corners are given before they are turned.
    fn twisted_trapezoid(z: number, lower: rows2, upper: rows2, twist: number);
    /// The same with an axis that leans: it is further by shift_x and shift_y at z than at -z.
    fn leaning_twisted_trapezoid(z: number, lower: rows2, upper: rows2, twist: number, shift_x: number, shift_y: number);
}

/// The surfaces: up to four sides, and the ends.
const SURFACES: &[&str] = &["side0", "side1", "side2", "side3", "bottom", "top"];
const BOTTOM: u32 = 4;

/// The numbers are in units of the size, a power of two.
#[derive(Debug)]
struct TwistedTrapezoid {
    sides: Vec<Side>,
    /// The exponent of the unit.
    exponent: i32,
    ends: Slab,
    bounds: Aabb,
    /// A box with room around the solid, so that it is left only through the ends.
    around: Aabb,
}

impl TwistedTrapezoid {
    fn of(p: &Params) -> Result<TwistedTrapezoid, ParamError> {
        let corners = Corners::of(p)?;
        if !(0..corners.lower.len()).all(|side| corners.is_flat(side)) {
            let why =
                "has an edge that is not parallel to that of lower, but each must be; the twist turns both"
                    .into();
            return Err(ParamError { param: "upper", why });
        }
        corners.check_convex()?;
        let twist = p.number("twist")?;
        if twist.abs() > 360.0 {
            return Err(ParamError {
                param: "twist",
                why: format!("is {twist}, but must be from -360 to 360"),
            });
        }
        let shift = [p.number("shift_x")?, p.number("shift_y")?];
        let reach =
            corners.lower.iter().chain(&corners.upper).map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max);
        let half = Vec3::new(reach + 0.5 * shift[0].abs(), reach + 0.5 * shift[1].abs(), corners.z);
        let bounds = Aabb::new(-half, half).widened(8.0);
        let wider = Vec3::new(1.0625 * half.x, 1.0625 * half.y, half.z);
        let exponent = binary_exponent(half.max_element());
        let unit = PowerOfTwo::new(-exponent);
        let scaled = |[x, y]: [f64; 2]| [unit.times(x), unit.times(y)];
        let sides = (0..corners.lower.len()).map(|side| {
            let [lower, upper] = [corners.lower[side], corners.upper[side]].map(scaled);
            Side::new([lower, upper], corners.longer_edge(side), unit.times(corners.z), twist, scaled(shift))
        });
        Ok(TwistedTrapezoid {
            sides: sides.collect(),
            exponent,
            ends: Slab { axis: 2, low: -corners.z, high: corners.z, surface: BOTTOM },
            bounds,
            around: Aabb::new(-wider, wider),
        })
    }

    /// The crossings of a line between two of its points.
    fn between(&self, line: &Line, ends: Interval, out: &mut Vec<Crossing>) {
        let [x, y] = [0, 1].map(|axis| Slab::of_box(&self.around.min, &self.around.max, axis).interval(line));
        let range = x.zip(y).and_then(|(x, y)| ends.clip(x)?.clip(y));
        let Some(range) = range.filter(|range| range.enter.t.is_finite() && range.exit.t.is_finite()) else {
            return;
        };
        let speed = binary_exponent(line.d.abs().max_element());
        // Lengths are in the unit, and directions about as long as it.
        let [into, back] = [speed - self.exponent, self.exponent - speed].map(PowerOfTwo::new);
        let along = Along::new(line, PowerOfTwo::new(-self.exponent), PowerOfTwo::new(-speed));
        let [from, to] = [range.enter.t, range.exit.t].map(|t| into.times(t));
        let mut events: Vec<(f64, f64, u32)> = Vec::new();
        let mut is_behind = [true; 4];
        for (number, side) in (0..).zip(&self.sides) {
            let course = along.course(side);
            if course.runs_within(from, to) {
                return;
            }
            is_behind[number as usize] = course.at(from)[0] < 0.0;
            course.roots(from, to, |t, t_err| events.push((t, t_err, number)));
        }
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let inside = |is_behind: [bool; 4]| is_behind == [true; 4];
        let mut enter = inside(is_behind).then_some(range.enter);
        for (t, t_err, side) in events {
            let was_inside = inside(is_behind);
            is_behind[side as usize] ^= true;
            if was_inside != inside(is_behind) {
                let end = End::new(back.times(t), back.times(t_err), side);
                match enter.take() {
                    Some(enter) => Interval { enter, exit: end }.push(out),
                    None => enter = Some(end),
                }
            }
        }
        if let Some(enter) = enter {
            Interval { enter, exit: range.exit }.push(out);
        }
    }

    /// A point in the unit of the sides.
    fn scaled(&self, p: Vec3) -> Vec3 {
        PowerOfTwo::new(-self.exponent).of(p)
    }
}

impl Solid for TwistedTrapezoid {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn crossings(&self, line: &Line, out: &mut Vec<Crossing>) {
        if let Some(ends) = self.ends.interval(line) {
            self.between(line, ends, out);
        }
    }

    /// Only of its flat ends.
    fn contacts(&self, line: &Line, out: &mut Vec<Contact>, _scratch: &mut Scratch) {
        let Some((ends, Some(normal))) = self.ends.closed_interval(line) else { return };
        let mut crossings = Vec::new();
        self.between(line, ends, &mut crossings);
        let sector = Sector::behind(&[Sheet::plane(normal)], line.d);
        for pair in crossings.chunks_exact(2) {
            out.extend(sector.map(|sector| Contact { enter: pair[0], exit: pair[1], sector }));
        }
    }

    fn implicit(&self, p: Vec3, surface: u32, _primitive: u32) -> f64 {
        match self.sides.get(surface as usize) {
            Some(side) => PowerOfTwo::new(self.exponent).times(side.value(self.scaled(p))),
            None if surface == BOTTOM => self.ends.low - p.z,
            None => p.z - self.ends.high,
        }
    }

    fn normal(&self, p: Vec3, surface: u32, _primitive: u32) -> Vec3 {
        match self.sides.get(surface as usize) {
            Some(side) => side.gradient(self.scaled(p)),
            None if surface == BOTTOM => Vec3::NEG_Z,
            None => Vec3::Z,
        }
    }

    fn contains(&self, p: Vec3) -> bool {
        self.ends.contains(p.z) && self.sides.iter().all(|side| side.value(self.scaled(p)) < 0.0)
    }

    fn surfaces(&self) -> &'static [&'static str] {
        SURFACES
    }

    fn memory(&self) -> usize {
        size_of_val(self.sides.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_within_sides_and_ends_are_not_inside() {
        let parts = KIND.build(&Params::of(&KIND, KIND.examples[0])).expect("an example");
        let solid = parts.single().expect("one solid");
        let (sin, cos) = (15f64.to_radians().sin(), 15f64.to_radians().cos());
        let within_side = Line::exact(Vec3::new(cos, sin, 0.5), Vec3::new(-sin, cos, 0.0));
        let within_end = Line::exact(Vec3::new(-3.0, 0.1, 1.0), Vec3::X);
        let (mut crossings, mut contacts) = (Vec::new(), Vec::new());
        for line in [within_side, within_end] {
            solid.crossings(&line, &mut crossings);
            assert_eq!(crossings, []);
        }
        solid.contacts(&within_end, &mut contacts, &mut Scratch::default());
        let [contact] = contacts[..] else { panic!("{contacts:?}") };
        // Turned by 30 degrees, the box begins at its long side and ends at its short one.
        let (sin, cos) = (0.5, 0.75f64.sqrt());
        let expected = [3.0 + (0.1 * cos - 0.5) / sin, 3.0 + (1.0 - 0.1 * sin) / cos];
        let found = [contact.enter.t, contact.exit.t];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?} {expected:?}");
        assert_eq!(contact.sector.to.sheet.normal, Vec3::Z);
    }
}
