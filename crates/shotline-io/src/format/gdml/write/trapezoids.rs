//! Solids of eight corners or four, and those that are twisted.

use shotline::math::{Affine, Vec3};
use shotline::solid::{ParamError, Params};

use super::Writer;
use super::kinds::{Made, between, sector};
use super::xml::Xml;

/// Corners that are so near to those of a shape, relative to its size, are those of the shape.
const TOLERANCE: f64 = 1e-13;

/// The widest angle in degrees by which Geant4 twists a trapezoid.
const MOST_TWIST: f64 = 90.0;

type Face = [[f64; 2]; 4];

impl Writer<'_> {
    /// The corners of a face.
    fn face(&self, p: &Params, name: &'static str) -> Result<Face, ParamError> {
        let rows = p.rows::<2>(name)?.rows;
        Ok(std::array::from_fn(|i| rows.get(i).copied().unwrap_or_default()))
    }

    pub(super) fn trapezoid(&self, p: &Params) -> Result<Made, ParamError> {
        let faces = [self.face(p, "lower")?, self.face(p, "upper")?];
        Ok(Made::centred(self.corners(p.number("z")?, faces)))
    }

    /// A solid of eight corners: with full lengths between two rectangles, otherwise with a half length.
    fn corners(&self, z: f64, faces: [Face; 2]) -> Xml {
        if let [Some([x1, y1]), Some([x2, y2])] = faces.map(rectangle) {
            let element = self.element("trd").length("x1", 2.0 * x1).length("x2", 2.0 * x2);
            let element = element.length("y1", 2.0 * y1).length("y2", 2.0 * y2);
            return element.length("z", 2.0 * z).in_millimetres();
        }
        let mut element = self.element("arb8");
        // Geant4 wants the corners clockwise.
        let order = if area(&faces[0]) + area(&faces[1]) > 0.0 { [0, 3, 2, 1] } else { [0, 1, 2, 3] };
        for (face, corners) in faces.iter().enumerate() {
            for (number, corner) in order.iter().enumerate() {
                let number = 4 * face + number + 1;
                let [x, y] = corners[*corner];
                element = element.length(&format!("v{number}x"), x).length(&format!("v{number}y"), y);
            }
        }
        element.length("dz", z).in_millimetres()
    }

    /// Its corners are defined positions.
    pub(super) fn tetrahedron(&mut self, p: &Params) -> Result<Made, ParamError> {
        let corners: Vec<Vec3> = p.rows::<3>("corners")?.rows.iter().map(|row| Vec3::from(*row)).collect();
        let names = self.positions(&corners);
        let mut element = self.element("tet");
        for (key, name) in ["vertex1", "vertex2", "vertex3", "vertex4"].iter().zip(&names) {
            element = element.text(key, name);
        }
        Ok(Made::centred(element.in_millimetres()))
    }

    /// Defines positions, and returns their names.
    pub(super) fn positions(&mut self, points: &[Vec3]) -> Vec<String> {
        let base = self.free_name("v");
        let mut names = Vec::with_capacity(points.len());
        for (number, p) in points.iter().enumerate() {
            let name = format!("{base}-{number}");
            let element = self.element("position").text("name", &name);
            let element = element.length("x", p.x).length("y", p.y).length("z", p.z).text("unit", "mm");
            self.check(&element);
            element.write(&mut self.define);
            names.push(name);
        }
        names
    }

    /// The middle of the part is at the x axis.
    pub(super) fn twisted_tube(&self, p: &Params) -> Result<Made, ParamError> {
        let ([rmin, rmax], z) = ([p.number("rmin")?, p.number("rmax")?], between(p)?);
        let ([phi0, dphi], twist) = (sector(p)?, p.number("twist")?);
        if rmin == 0.0 {
            return Ok(Made::Refused("GDML has no twisted tube without a hole"));
        }
        let element = self.element("twistedtubs").number("twistedangle", twist);
        let element = element.length("midinnerrad", rmin).length("midouterrad", rmax);
        let element = element.length("negativeEndz", z.low).length("positiveEndz", z.high);
        let element = element.number("phi", dphi).in_millimetres_and_degrees();
        Ok(Made::Element(element, Affine::rotation_xyz(Vec3::new(0.0, 0.0, phi0 + 0.5 * dphi))))
    }

    /// Full lengths. Without a twist it is a solid of eight corners.
    pub(super) fn twisted_trapezoid(&self, p: &Params) -> Result<Made, ParamError> {
        let (z, twist) = (p.number("z")?, p.number("twist")?);
        let shift = [p.number("shift_x")?, p.number("shift_y")?];
        let faces = [self.face(p, "lower")?, self.face(p, "upper")?];
        if twist == 0.0 {
            let shifted =
                |face: Face, side: f64| face.map(|[x, y]| [x + side * shift[0], y + side * shift[1]]);
            return Ok(Made::centred(self.corners(z, [shifted(faces[0], -0.5), shifted(faces[1], 0.5)])));
        }
        if twist.abs() >= MOST_TWIST {
            return Ok(Made::Refused("Geant4 refuses a twist of 90 degrees or more"));
        }
        let [Some(lower), Some(upper)] = faces.map(Trapezium::of) else {
            return Ok(Made::Refused(
                "GDML has only twisted trapezoids around the z axis with edges along x",
            ));
        };
        let size = faces.as_flattened().as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if ((lower.slope - upper.slope) * upper.y).abs() > TOLERANCE * size {
            return Ok(Made::Refused("GDML has only twisted trapezoids of one angle alpha"));
        }
        let element = self.element("twistedtrap").number("PhiTwist", twist).length("z", 2.0 * z);
        let theta = libm::atan(libm::hypot(shift[0], shift[1]) / (2.0 * z)).to_degrees();
        let phi = libm::atan2(shift[1], shift[0]).to_degrees();
        let element = element.number("Theta", theta).number("Phi", phi);
        let element = element.length("y1", 2.0 * lower.y);
        let element = element.length("x1", 2.0 * lower.bottom).length("x2", 2.0 * lower.top);
        let element = element.length("y2", 2.0 * upper.y);
        let element = element.length("x3", 2.0 * upper.bottom).length("x4", 2.0 * upper.top);
        let element = element.number("Alph", libm::atan(lower.slope).to_degrees());
        Ok(Made::centred(element.in_millimetres_and_degrees()))
    }
}

/// A face with two sides along x, halved, around the origin.
struct Trapezium {
    y: f64,
    bottom: f64,
    top: f64,
    /// How far the middles of these sides are moved along x, per length along y.
    slope: f64,
}

impl Trapezium {
    /// The corners are in the order bottom left, bottom right, top right, top left.
    fn of([a, b, c, d]: Face) -> Option<Trapezium> {
        let size = [a, b, c, d].as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let same = |x: f64, y: f64| (x - y).abs() <= TOLERANCE * size;
        let (y, middles) = (c[1], [(a[0] + b[0]) * 0.5, (c[0] + d[0]) * 0.5]);
        let is_one = same(a[1], b[1]) && same(c[1], d[1]) && same(a[1], -y) && same(middles[0], -middles[1]);
        let (bottom, top) = ((b[0] - a[0]) * 0.5, (c[0] - d[0]) * 0.5);
        let is_wide = y > 0.0 && bottom > 0.0 && top > 0.0;
        (is_one && is_wide).then_some(Trapezium { y, bottom, top, slope: middles[1] / y })
    }
}

/// Half the sides of a rectangle around the origin, counter-clockwise from the lower left.
fn rectangle([a, b, c, d]: Face) -> Option<[f64; 2]> {
    let [x, y] = c;
    (a == [-x, -y] && b == [x, -y] && d == [-x, y] && x > 0.0 && y > 0.0).then_some([x, y])
}

/// Twice the area of a face; negative if it is clockwise.
fn area(face: &Face) -> f64 {
    (0..4).map(|i| face[i][0] * face[(i + 1) % 4][1] - face[(i + 1) % 4][0] * face[i][1]).sum()
}
