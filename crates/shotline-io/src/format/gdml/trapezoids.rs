//! Solids of eight corners or four: trapezoids between two planes, and tetrahedra.

use shotline::math::{Vec3, sin_cos_degrees_wide};
use shotline::scene::NodeId;

use super::attributes::Found;
use super::definitions::Vector;
use super::units::Measure;
use super::{Element, Module, tag};

impl Module<'_> {
    /// Full lengths: a box with its widths at both ends.
    pub(super) fn trd(&mut self, element: Element) -> Found<NodeId> {
        let mut half = [0.0; 4];
        for (half, key) in half.iter_mut().zip(["x1", "y1", "x2", "y2"]) {
            *half = self.radius(element, key)? * 0.5;
        }
        let z = self.half(element, "z")?;
        let rectangle = |x: f64, y: f64| [-x, -y, x, -y, x, y, -x, y];
        self.trapezoid(element, z, &rectangle(half[0], half[1]), &rectangle(half[2], half[3]))
    }

    /// Full lengths. The middles of the faces are on a line at the angles theta and phi; alpha shears a face along x.
    pub(super) fn trap(&mut self, element: Element) -> Found<NodeId> {
        let z = self.half(element, "z")?;
        let shift = self.shift(element, z, ["theta", "phi"])?;
        let mut faces = [[0.0; 8]; 2];
        let keys = [["y1", "x1", "x2", "alpha1"], ["y2", "x3", "x4", "alpha2"]];
        for ((face, keys), side) in faces.iter_mut().zip(keys).zip([-1.0, 1.0]) {
            let y = self.half(element, keys[0])?;
            let [low, high] = [self.half(element, keys[1])?, self.half(element, keys[2])?];
            let alpha = self.angle_or(element, keys[3], 0.0)?;
            *face = sheared(shift.map(|x| x * side), y, [low, high], alpha);
        }
        self.trapezoid(element, z, &faces[0], &faces[1])
    }

    /// Full lengths.
    pub(super) fn para(&mut self, element: Element) -> Found<NodeId> {
        let [x, y, z] = [self.half(element, "x")?, self.half(element, "y")?, self.half(element, "z")?];
        let alpha = self.angle_or(element, "alpha", 0.0)?;
        let shift = self.shift(element, z, ["theta", "phi"])?;
        let face = |side: f64| sheared(shift.map(|x| x * side), y, [x; 2], alpha);
        self.trapezoid(element, z, &face(-1.0), &face(1.0))
    }

    /// How far the line between the middles of the faces is shifted along z by the angles theta and phi.
    fn shift(&mut self, element: Element, z: f64, [theta, phi]: [&str; 2]) -> Found<[f64; 2]> {
        let [theta, phi] = [self.angle_or(element, theta, 0.0)?, self.angle_or(element, phi, 0.0)?];
        let (sin, cos) = sin_cos_degrees_wide(phi);
        let r = z * tangent(theta);
        Ok([r * cos.hi, r * sin.hi])
    }

    /// A half length. Corners 1 to 4 are of the lower face, 5 to 8 of the upper.
    pub(super) fn arb8(&mut self, element: Element) -> Found<NodeId> {
        let z = self.positive(element, "dz")?;
        let mut corners = [[0.0; 8]; 2];
        for (i, x) in corners.as_flattened_mut().iter_mut().enumerate() {
            let key = format!("v{}{}", i / 2 + 1, ["x", "y"][i % 2]);
            *x = self.length_or_zero(element, &key)?;
        }
        self.trapezoid(element, z, &corners[0], &corners[1])
    }

    fn trapezoid(&mut self, element: Element, z: f64, lower: &[f64; 8], upper: &[f64; 8]) -> Found<NodeId> {
        self.of_kind(element, "trapezoid", &[&[z], lower, upper])
    }

    /// Its corners are defined positions.
    pub(super) fn tetrahedron(&mut self, element: Element) -> Found<NodeId> {
        let corners = self.corners(element, &["vertex1", "vertex2", "vertex3", "vertex4"])?;
        let unit = self.factor(element, "lunit", Measure::Length)?;
        let corners: Vec<f64> = corners.iter().flat_map(|corner| (*corner * unit).to_array()).collect();
        self.of_kind(element, "tetrahedron", &[&corners])
    }

    /// The positions that attributes name.
    pub(super) fn corners(&mut self, element: Element, keys: &[&str]) -> Found<Vec<Vec3>> {
        let mut corners = Vec::with_capacity(keys.len());
        for key in keys {
            let name = self.reference(element, key)?;
            corners.push(self.defined_vector(element, key, Vector::Position, &name)?);
        }
        Ok(corners)
    }

    /// Given by the radii at the ends and a full length, or by those in the middle and the ends; by the angle of the part, or by
    /// that of several parts and their number. The middle of the part is at the x axis.
    pub(super) fn twisted_tube(&mut self, element: Element) -> Found<NodeId> {
        let twist = self.angle(element, "twistedangle")?;
        let by_ends = element.has_attribute("zlen") && self.number(element, "zlen")? != 0.0;
        let ([rmin, rmax], z) = if by_ends {
            let half = self.half(element, "zlen")?;
            let (_, cos) = sin_cos_degrees_wide(twist * 0.5);
            (self.radii(element, "endinnerrad", "endouterrad")?.map(|r| r * cos.hi), [-half, half])
        } else {
            let z = [self.length(element, "negativeEndz")?, self.length(element, "positiveEndz")?];
            (self.radii(element, "midinnerrad", "midouterrad")?, z)
        };
        let parts = self.number_or(element, "nseg", 0.0)?;
        let dphi = match parts == 0.0 {
            true => self.angle(element, "phi")?,
            false => self.angle(element, "totphi")? / parts,
        };
        let values: &[&[f64]] = &[&[rmin], &[rmax], &[z[0]], &[z[1]], &[twist], &[-0.5 * dphi], &[dphi]];
        self.of_kind(element, "twisted_tube", values)
    }

    /// Full lengths. The angle of the cross-section grows with z.
    pub(super) fn twisted_trap(&mut self, element: Element) -> Found<NodeId> {
        let z = self.half(element, "z")?;
        let keys: [[&str; 3]; 2] = match tag(element) {
            "twistedbox" => [["y", "x", "x"]; 2],
            "twistedtrd" => [["y1", "x1", "x1"], ["y2", "x2", "x2"]],
            _ => [["y1", "x1", "x2"], ["y2", "x3", "x4"]],
        };
        let (alpha, twist) = (self.angle_or(element, "Alph", 0.0)?, self.angle(element, "PhiTwist")?);
        let mut faces = [[0.0; 8]; 2];
        for (face, [y, low, high]) in faces.iter_mut().zip(keys) {
            let widths = [self.half(element, low)?, self.half(element, high)?];
            *face = sheared([0.0; 2], self.half(element, y)?, widths, alpha);
        }
        let [x, y] = self.shift(element, 2.0 * z, ["Theta", "Phi"])?;
        self.of_kind(element, "twisted_trapezoid", &[&[z], &faces[0], &faces[1], &[twist], &[x], &[y]])
    }
}

/// The corners of a face: half its height, half its widths at the bottom and the top, and the angle of its middle line.
fn sheared(middle: [f64; 2], y: f64, [low, high]: [f64; 2], alpha: f64) -> [f64; 8] {
    let shear = y * tangent(alpha);
    let [left, right] = [middle[0] - shear, middle[0] + shear];
    let [bottom, top] = [middle[1] - y, middle[1] + y];
    [left - low, bottom, left + low, bottom, right + high, top, right - high, top]
}

/// The tangent of an angle in degrees.
fn tangent(degrees: f64) -> f64 {
    let (sin, cos) = sin_cos_degrees_wide(degrees);
    sin.hi / cos.hi
}
