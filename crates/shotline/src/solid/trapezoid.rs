//! The solid between two quadrilaterals at -z and z whose corners are joined by straight lines. Where the edges of a side
//! are not parallel, the side is a ruled surface: a hyperbolic paraboloid.

use super::capped::{CAPPED, Capped};
use super::faces::Faces;
use super::form::Form;
use super::interval::Slab;
use super::parts::Parts;
use super::{Build, Kind, Param, ParamError, Params, Rows, constructors};
use crate::aabb::Aabb;
use crate::math::{Dd, Vec3, difference_of_products, power_of_two_below, two_sum};
use crate::polygon::{Ring, RingError};

pub(super) static KIND: Kind = Kind {
    name: "trapezoid",
    summary: "the solid between two quadrilaterals at -z and z, corner by corner joined by straight lines; its sides may be twisted",
    interior: "at each height between -z and z the quadrilateral whose corners are on the lines from the corners of lower to those of upper",
    params: &[
        Param::length("z", "half of the height"),
        Param::rows(
            "lower",
            &["x", "y"],
            4,
            "the four corners at -z in order, in either direction; some may coincide",
        ),
        Param::rows("upper", &["x", "y"], 4, "the corners at z, each above that of the same row of lower"),
    ],
    build: Build::Parts(parts),
    examples: &[
        &[
            &[1.0],
            &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0],
            &[-0.5, -0.5, 0.5, -0.5, 0.5, 0.5, -0.5, 0.5],
        ],
        // One corner moved, so that two sides are twisted; clockwise.
        &[
            &[1.5],
            &[-1.5, -1.5, -1.5, 1.5, 1.5, 1.5, 1.5, -1.5],
            &[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -0.5],
        ],
        // Turned by 30 degrees, and off the axis.
        &[&[1.0], &[0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 0.0, 1.0], &[0.5, -0.5, 2.25, 0.5, 1.75, 1.5, 0.0, 0.25]],
        // From a line to a triangle; between two lines across each other, a tetrahedron.
        &[&[2.0], &[-1.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0], &[-1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.0, 1.5]],
        &[&[1.0], &[-1.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0], &[0.0, -2.0, 0.0, -2.0, 0.0, 2.0, 0.0, 2.0]],
        // A side that narrows from an edge to a point, beside twisted ones.
        &[
            &[1.0],
            &[-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0],
            &[-1.0, -0.5, -1.0, -0.5, 0.5, 0.75, -0.5, 1.0],
        ],
    ],
};

constructors! {
    trapezoid:
    /// The solid between two quadrilaterals, at -z and z, each given by four corners in order. Each corner is joined to that of
    /// the same index; sides whose edges are not parallel are twisted.
    fn trapezoid(z: number, lower: rows2, upper: rows2);
}

/// A side counts as flat if its shorter edge leaves the direction of the longer one by at most this part of the size. Corners
/// that another program has computed are hardly more accurate.
const FLAT: f64 = 1e-12;

/// The corners, counter-clockwise. Those of which both ends coincide with those of the next are left out.
pub(super) struct Corners {
    pub z: f64,
    pub lower: Vec<[f64; 2]>,
    pub upper: Vec<[f64; 2]>,
    /// The greatest extent along x or y.
    size: f64,
}

fn parts(p: &Params) -> Result<Parts, ParamError> {
    let corners = Corners::of(p)?;
    let sides = 0..corners.lower.len();
    if sides.clone().all(|side| corners.is_flat(side)) {
        return corners.flat();
    }
    corners.check_convex()?;
    let mut sides: Vec<Capped> = sides.map(|side| corners.side(side)).collect();
    // The first also has the ends, and the bounds of the whole.
    sides[0].caps = Some(Slab { axis: 2, low: -corners.z, high: corners.z, surface: 1 });
    (sides[0].bounds, sides[0].surfaces) = (corners.bounds(), CAPPED);
    Ok(Parts::Intersection(sides.into_iter().map(Parts::of).collect()))
}

/// The four rows of a parameter.
fn four(rows: &Rows<2>) -> Result<(), ParamError> {
    let error = |why: String| Err(ParamError { param: rows.name, why });
    match (rows.rows.len(), Ring::of(&rows.rows)) {
        (4, Err(RingError::Crosses(_))) => error("cross: give the corners in their order around it".into()),
        (4, _) => Ok(()),
        (count, _) => error(format!("has {count} rows, but takes four")),
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    difference_of_products(a[0], b[1], a[1], b[0])
}

/// Twice the area.
fn area(corners: &[[f64; 2]]) -> f64 {
    let from = |p: [f64; 2]| [p[0] - corners[0][0], p[1] - corners[0][1]];
    corners.windows(2).map(|pair| cross(from(pair[0]), from(pair[1]))).sum()
}

impl Corners {
    pub fn of(p: &Params) -> Result<Corners, ParamError> {
        let z = p.positive("z")?;
        let (lower, upper) = (p.rows("lower")?, p.rows("upper")?);
        four(&lower)?;
        four(&upper)?;
        let mut pairs: Vec<_> = lower.rows.into_iter().zip(upper.rows).collect();
        pairs.dedup();
        while pairs.len() > 1 && pairs.first() == pairs.last() {
            pairs.pop();
        }
        let (lower, upper): (Vec<[f64; 2]>, Vec<[f64; 2]>) = pairs.into_iter().unzip();
        let all = || lower.iter().chain(&upper);
        let extent = |k: usize| {
            let least = all().map(|corner| corner[k]).fold(f64::INFINITY, f64::min);
            all().map(|corner| corner[k] - least).fold(0.0, f64::max)
        };
        let size = extent(0).max(extent(1));
        let middle: Vec<[f64; 2]> =
            lower.iter().zip(&upper).map(|(l, u)| [0.5 * (l[0] + u[0]), 0.5 * (l[1] + u[1])]).collect();
        let [at_lower, at_upper] = [area(&lower), area(&upper)];
        // The area is of the second degree in the height, for which Simpson's rule is exact.
        let volume = at_lower + 4.0 * area(&middle) + at_upper;
        let error = |why: &str| Err(ParamError { param: "upper", why: why.into() });
        let ends = [at_lower, at_upper].map(|area| if area == 0.0 { 0.0 } else { area.signum() });
        if (ends[0] - ends[1]).abs() == 2.0 || ends.iter().any(|end| end * volume < 0.0) {
            return error("runs round the other way than lower: give both in the same direction");
        }
        if volume == 0.0 {
            return error("encloses nothing together with lower");
        }
        let mut corners = Corners { z, lower, upper, size };
        if volume < 0.0 {
            corners.lower.reverse();
            corners.upper.reverse();
        }
        Ok(corners)
    }

    /// The edges of a side, at its lower and its upper end.
    fn edges(&self, side: usize) -> [[f64; 2]; 2] {
        let next = (side + 1) % self.lower.len();
        [&self.lower, &self.upper].map(|c| [c[next][0] - c[side][0], c[next][1] - c[side][1]])
    }

    pub fn is_flat(&self, side: usize) -> bool {
        let [lower, upper] = self.edges(side);
        let length = |edge: [f64; 2]| libm::hypot(edge[0], edge[1]);
        let longer = length(lower).max(length(upper));
        let is_along = lower[0] * upper[0] + lower[1] * upper[1] >= 0.0;
        is_along && cross(lower, upper).abs() <= FLAT * self.size * longer
    }

    /// The edge of a side at the end at which it is longer.
    pub fn longer_edge(&self, side: usize) -> [f64; 2] {
        let [lower, upper] = self.edges(side);
        if libm::hypot(upper[0], upper[1]) > libm::hypot(lower[0], lower[1]) { upper } else { lower }
    }

    /// The solid if all sides are flat.
    fn flat(&self) -> Result<Parts, ParamError> {
        let mut faces = Faces::default();
        let mut level = |corners: &[[f64; 2]], z: f64| {
            let points: Vec<Vec3> = corners.iter().map(|[x, y]| Vec3::new(*x, *y, z)).collect();
            faces.merged(&points)
        };
        let (lower, upper) = (level(&self.lower, -self.z), level(&self.upper, self.z));
        faces.add(&lower.iter().rev().copied().collect::<Vec<_>>());
        faces.add(&upper);
        for i in 0..lower.len() {
            let j = (i + 1) % lower.len();
            faces.add(&[lower[i], lower[j], upper[j], upper[i]]);
        }
        faces.finish("upper")
    }

    /// Refuses cross-sections that turn right at a corner. The sine of a turn, up to a positive factor, is of the second
    /// degree in the height.
    pub fn check_convex(&self) -> Result<(), ParamError> {
        let n = self.lower.len();
        for corner in 0..n {
            let ([l0, u0], [l1, u1]) = (self.edges((corner + n - 1) % n), self.edges(corner));
            let (at_lower, at_upper) = (cross(l0, l1), cross(u0, u1));
            let middle = 0.5 * (cross(l0, u1) + cross(u0, l1));
            let turn = |s: f64| (1.0 - s) * ((1.0 - s) * at_lower + 2.0 * s * middle) + s * s * at_upper;
            let extreme = ((at_lower - middle) / (at_lower - 2.0 * middle + at_upper)).clamp(0.0, 1.0);
            let extreme = if extreme.is_nan() { 0.0 } else { extreme };
            if [0.0, extreme, 1.0].iter().any(|s| turn(*s) < -FLAT * self.size * self.size) {
                let why = "makes twisted sides together with lower, and then each cross-section must be convex; \
                           cut the solid into convex ones";
                return Err(ParamError { param: "upper", why: why.into() });
            }
        }
        Ok(())
    }

    fn bounds(&self) -> Aabb {
        let corners = self.lower.iter().chain(&self.upper);
        let points = corners.map(|[x, y]| Aabb::new(Vec3::new(*x, *y, -self.z), Vec3::new(*x, *y, self.z)));
        points.fold(Aabb::EMPTY, |all, point| all.union(&point))
    }

    /// The points on the inner side of the line of an edge, at each height: `(p - e(z)) x a(z) < 0` for the corner `e(z)` and
    /// the direction `a(z)`, both linear in z. The direction is constant if the side is flat.
    fn side(&self, side: usize) -> Capped {
        let next = (side + 1) % self.lower.len();
        let (unit, unit_z) = (power_of_two_below(self.size), power_of_two_below(self.z));
        let h = Dd::from(self.z / unit_z);
        let centre: [f64; 2] = [0, 1].map(|k| 0.5 * (self.lower[side][k] + self.upper[side][k]));
        // Half the sum and half the difference of both ends, in units of the size.
        let wide = |a: f64, b: f64| two_sum(a, -b) * (1.0 / unit);
        let halves = |lower: Dd, upper: Dd| [(lower + upper) * 0.5, (upper - lower) * 0.5];
        let corner = [0, 1]
            .map(|k| halves(wide(self.lower[side][k], centre[k]), wide(self.upper[side][k], centre[k])));
        let [lower, upper] = [&self.lower, &self.upper].map(|c| [0, 1].map(|k| wide(c[next][k], c[side][k])));
        let direction = match self.is_flat(side) {
            true => {
                let length = |edge: [Dd; 2]| libm::hypot(edge[0].hi, edge[1].hi);
                let longer = if length(upper) > length(lower) { upper } else { lower };
                longer.map(|a| [a, Dd::ZERO])
            }
            false => [0, 1].map(|k| {
                let [mean, change] = halves(lower[k], upper[k]);
                [h * mean, change]
            }),
        };
        let [[mx, dx], [my, dy]] = corner;
        let [[ax, bx], [ay, by]] = direction;
        let is_twisted = bx.hi != 0.0 || by.hi != 0.0;
        let form = Form {
            centre: Vec3::new(centre[0], centre[1], 0.0),
            shrink: Vec3::new(1.0 / unit, 1.0 / unit, 1.0 / unit_z),
            square: [Dd::ZERO, Dd::ZERO, dy * bx - dx * by],
            cross: is_twisted.then(|| [-(h * bx) * 0.5, h * by * 0.5, Dd::ZERO]),
            linear: [h * ay * 0.5, -(h * ax) * 0.5, (h * (my * bx - mx * by) + dy * ax - dx * ay) * 0.5],
            constant: h * (my * ax - mx * ay),
        };
        Capped::whole(form, Aabb::EVERYTHING, &["side"])
    }
}
