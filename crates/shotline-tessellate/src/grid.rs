//! A grid of equal cells around an object, and the rays along its lines.

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::query::batch::Rays;
use shotline::ray::{InvalidRay, Ray};

/// How far the grid reaches beyond the bounds, in cells. The fractions differ, so that faces of usual models lie on no line.
const MARGIN: [f64; 3] = [1.41, 1.618, 1.26];

/// A grid of cubes. A point of it has an index along each axis, from 0 to `cells`.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    pub origin: Vec3,
    /// The side of a cell.
    pub step: f64,
    /// How many cells there are along each axis.
    pub cells: [usize; 3],
}

impl Grid {
    /// A grid around a box, with so many cells along its longest side.
    pub fn around(bounds: &Aabb, along_longest: usize) -> Grid {
        let size = bounds.max - bounds.min;
        let step = size.max_element() / along_longest as f64;
        let margin = Vec3::from_array(MARGIN) * step;
        let cells = ((size + 2.0 * margin) / step).ceil().to_array().map(|count| count as usize + 1);
        Grid { origin: bounds.min - margin, step, cells }
    }

    /// How many points there are along an axis.
    pub fn points(&self, axis: usize) -> usize {
        self.cells[axis] + 1
    }

    /// The position of a point that may lie between those of the grid.
    pub fn position(&self, index: Vec3) -> Vec3 {
        self.origin + index * self.step
    }

    /// The number of a point or of a cell.
    pub fn number(&self, index: [usize; 3]) -> usize {
        (index[2] * self.points(1) + index[1]) * self.points(0) + index[0]
    }
}

/// The rays along all lines of a grid in the direction of one axis: their parameter counts cells.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'g> {
    pub grid: &'g Grid,
    pub axis: usize,
}

impl Lines<'_> {
    /// The other axes, in right-handed order.
    pub fn across(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// The index of the first point of a line.
    pub fn start(&self, line: usize) -> [usize; 3] {
        let [b, c] = self.across();
        let mut index = [0; 3];
        index[b] = line % self.grid.points(b);
        index[c] = line / self.grid.points(b);
        index
    }

    /// The position on the line through a point, at the parameter of its ray.
    pub fn position(&self, point: [usize; 3], t: f64) -> Vec3 {
        let mut index = Vec3::from_array(point.map(|i| i as f64));
        index[self.axis] = t;
        self.grid.position(index)
    }
}

impl Rays for Lines<'_> {
    fn len(&self) -> usize {
        let [b, c] = self.across();
        self.grid.points(b) * self.grid.points(c)
    }

    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        let mut direction = Vec3::ZERO;
        direction[self.axis] = self.grid.step;
        Ray::new(self.position(self.start(row), 0.0), direction)
    }
}
