//! Volume, centroid and second moments of bodies.

use std::f64::consts::PI;

use crate::math::{Affine, Vec3, sum};

/// Volume, centroid and second moments of a body of density 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// The volume, in cubed units of length.
    pub volume: f64,
    /// The centroid `c`. Any point if the volume is 0.
    pub centroid: Vec3,
    /// The integral of `(p - c) (p - c)^T` over the body: a symmetric matrix in units of length to the fifth
    /// power.
    pub second: [[f64; 3]; 3],
}

impl Moments {
    /// The moments of an empty body.
    pub const EMPTY: Moments = Moments { volume: 0.0, centroid: Vec3::ZERO, second: [[0.0; 3]; 3] };

    /// Moments from the volume, the centroid and the mean squared distances from the centroid along the axes. The
    /// axes must be the body's principal axes.
    pub fn along_axes(volume: f64, centroid: Vec3, mean_squares: Vec3) -> Moments {
        let mut second = [[0.0; 3]; 3];
        (0..3).for_each(|i| second[i][i] = volume * mean_squares[i]);
        Moments { volume, centroid, second }
    }

    /// Moments of a solid of revolution around the z axis between two heights, from its squared radius at a
    /// height.
    ///
    /// Exact, except for rounding, if the squared radius is a polynomial of degree at most 2, as for all
    /// quadrics. The integrands are then of degree 4, and the three-point Gauss-Legendre rule is exact up to
    /// degree 5.
    pub fn of_revolution(z0: f64, z1: f64, square_of_radius: impl Fn(f64) -> f64) -> Moments {
        let (middle, half) = (z0.midpoint(z1), 0.5 * z1 - 0.5 * z0);
        let reach = half * 0.6f64.sqrt();
        let points = [(-reach, 5.0 / 9.0), (0.0, 8.0 / 9.0), (reach, 5.0 / 9.0)];
        let area = points.map(|(z, weight)| (z, weight * half * square_of_radius(middle + z)));
        let over = |f: &dyn Fn(f64) -> f64| PI * area.iter().map(|&(z, area)| area * f(z)).sum::<f64>();
        let volume = over(&|_| 1.0);
        if volume == 0.0 {
            return Moments::EMPTY;
        }
        let up = over(&|z| z) / volume;
        let across = over(&|z| 0.25 * square_of_radius(middle + z)) / volume;
        let along = over(&|z| (z - up) * (z - up)) / volume;
        Moments::along_axes(volume, Vec3::new(0.0, 0.0, middle + up), Vec3::new(across, across, along))
    }

    /// Moments from the integrals of `1`, `x`, `y`, `z`, `x^2`, `y^2`, `z^2`, `yz`, `xz`, `xy`.
    pub fn from_integrals([volume, x, y, z, xx, yy, zz, yz, xz, xy]: [f64; 10]) -> Moments {
        if volume == 0.0 {
            return Moments::EMPTY;
        }
        let centroid = Vec3::new(x, y, z) / volume;
        let about_origin = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let entry = |i: usize, j: usize| about_origin[i][j] - volume * centroid[i] * centroid[j];
        Moments { volume, centroid, second: symmetric(entry) }
    }

    /// Returns the integrals that [`Moments::from_integrals`] takes, in coordinates relative to a point.
    pub fn integrals_from(&self, origin: Vec3) -> [f64; 10] {
        let (v, c) = (self.volume, self.centroid - origin);
        let second = |i: usize, j: usize| self.second[i][j] + v * c[i] * c[j];
        let pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)].map(|(i, j)| second(i, j));
        let [xx, yy, zz, yz, xz, xy] = pairs;
        [v, v * c.x, v * c.y, v * c.z, xx, yy, zz, yz, xz, xy]
    }

    /// Moments of the body after an affine map. The volume is multiplied by `|det S|`, and the mean of
    /// `(p - c) (p - c)^T` becomes `S M S^T`.
    pub fn placed(&self, map: &Affine) -> Moments {
        if map.is_identity() {
            return *self;
        }
        let growth = map.determinant().abs();
        let (s, m) = (&map.rows, &self.second);
        let entry = |i: usize, j: usize| {
            let row = |k: usize| (0..3).map(|l| m[k][l] * s[j][l]).sum::<f64>();
            growth * (0..3).map(|k| s[i][k] * row(k)).sum::<f64>()
        };
        Moments { volume: self.volume * growth, centroid: map.point(self.centroid), second: symmetric(entry) }
    }

    /// Moments of the union of disjoint bodies.
    pub fn total(parts: &[Moments]) -> Moments {
        let [first, _, ..] = parts else { return parts.first().copied().unwrap_or(Moments::EMPTY) };
        let volume = sum(parts.iter().map(|p| p.volume));
        if volume == 0.0 {
            return Moments::EMPTY;
        }
        // Relative to one of the centroids, so that no digits are lost to a large distance from the origin.
        let from = first.centroid;
        let shift = |i: usize| sum(parts.iter().map(|p| p.volume * (p.centroid - from)[i])) / volume;
        let centroid = from + Vec3::new(shift(0), shift(1), shift(2));
        let entry = |i: usize, j: usize| {
            sum(parts.iter().flat_map(|p| {
                let r = p.centroid - centroid;
                [p.second[i][j], p.volume * r[i] * r[j]]
            }))
        };
        Moments { volume, centroid, second: symmetric(entry) }
    }

    /// The inertia tensor about the centroid, at density 1.
    pub fn inertia(&self) -> [[f64; 3]; 3] {
        let m = &self.second;
        let around = |i: usize| m[(i + 1) % 3][(i + 1) % 3] + m[(i + 2) % 3][(i + 2) % 3];
        symmetric(|i, j| if i == j { around(i) } else { -m[i][j] })
    }
}

/// Builds a symmetric matrix from its entries on and above the diagonal.
fn symmetric(entry: impl Fn(usize, usize) -> f64) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i.min(j), i.max(j))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, size: f64) -> bool {
        (a - b).abs() <= 1e-14 * size
    }

    #[test]
    fn revolving_a_line_makes_a_cone() {
        // A cone of radius 2 and height 3 with its apex at z = 1. Expected values: textbooks and the parallel
        // axis theorem.
        let cone = Moments::of_revolution(1.0, 4.0, |z| (2.0 * (z - 1.0) / 3.0).powi(2));
        let volume = PI * 4.0;
        assert!(near(cone.volume, volume, volume) && near(cone.centroid.z, 3.25, 3.25));
        assert!(near(cone.second[2][2], volume * 9.0 * 3.0 / 80.0, volume));
        assert!(near(cone.second[0][0], volume * 4.0 * 3.0 / 20.0, volume));
        assert_eq!((cone.second[0][1], cone.second[0][0]), (0.0, cone.second[1][1]));
    }

    #[test]
    fn halves_make_a_whole_wherever_they_are() {
        let away = Affine::translation(Vec3::new(1e6, -2e6, 3e6));
        let brick = |z0: f64, z1: f64| {
            let h = z1 - z0;
            Moments::along_axes(h, Vec3::new(0.5, 0.5, z0.midpoint(z1)), Vec3::new(1.0, 1.0, h * h) / 12.0)
                .placed(&away)
        };
        let (whole, halves) = (brick(0.0, 1.0), Moments::total(&[brick(0.0, 0.25), brick(0.25, 1.0)]));
        assert!(near(whole.volume, halves.volume, 1.0));
        assert!((whole.centroid - halves.centroid).length() < 1e-9);
        assert!((0..3).all(|i| (whole.second[i][i] - halves.second[i][i]).abs() < 1e-9));
    }

    #[test]
    fn affine_maps_turn_and_stretch() {
        let cube = Moments::along_axes(8.0, Vec3::ZERO, Vec3::splat(1.0 / 3.0));
        let map = Affine::rotation_xyz(Vec3::new(0.0, 0.0, 90.0))
            .then_after(&Affine::scaling(Vec3::new(-2.0, 1.0, 3.0)));
        let brick = cube.placed(&map);
        assert_eq!(brick.volume, 48.0);
        for (i, square) in [1.0, 4.0, 9.0].into_iter().enumerate() {
            assert!(near(brick.second[i][i], 16.0 * square, 200.0), "{brick:?}");
        }
        assert!(near(brick.inertia()[2][2], 16.0 * 5.0, 200.0));
    }

    #[test]
    fn integrals_about_the_origin_are_moved_to_the_centroid() {
        // The unit cube with a corner at the origin.
        let cube = Moments::from_integrals([1.0, 0.5, 0.5, 0.5, 1. / 3., 1. / 3., 1. / 3., 0.25, 0.25, 0.25]);
        assert_eq!(cube.centroid, Vec3::splat(0.5));
        assert!(near(cube.second[0][0], 1.0 / 12.0, 1.0) && cube.second[0][1] == 0.0);
    }
}
