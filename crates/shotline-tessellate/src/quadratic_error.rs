//! The point that fits planes best: the quadratic error function of dual contouring (T. Ju, F. Losasso, S. Schaefer and J. Warren,
//! "Dual Contouring of Hermite Data", SIGGRAPH 2002).

use shotline::math::Vec3;

/// Directions in which the planes hold a point less than this, relative to the direction in which they hold it most, are left at
/// the mean of the points: the square of the sine of an angle of about 3 degrees.
const WEAK: f64 = 0.0025;

/// The sum of the squared distances to planes, each given by a point and a normal.
#[derive(Clone, Copy, Debug, Default)]
pub struct QuadraticError {
    /// Upper triangle of the sum of the products of normals.
    products: [f64; 6],
    /// The sum of the normals times the distances of their planes from the first point.
    offsets: Vec3,
    first: Vec3,
    sum: Vec3,
    count: u32,
    /// The sum of the normals.
    pub normals: Vec3,
}

impl QuadraticError {
    /// Adds a plane. Of a normal that is NaN only the point counts.
    pub fn add(&mut self, point: Vec3, normal: Vec3) {
        if self.count == 0 {
            self.first = point;
        }
        let from_first = point - self.first;
        self.sum += from_first;
        self.count += 1;
        if normal.is_finite() {
            let n = normal;
            let products = [n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z];
            self.products.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
            self.offsets += n * n.dot(from_first);
            self.normals += n;
        }
    }

    /// The point of least error that is nearest to the mean of the points.
    pub fn minimum(&self) -> Vec3 {
        let mean = self.sum / f64::from(self.count.max(1));
        let [xx, xy, xz, yy, yz, zz] = self.products;
        let (values, vectors) = eigen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let at_mean = Vec3::new(
            xx * mean.x + xy * mean.y + xz * mean.z,
            xy * mean.x + yy * mean.y + yz * mean.z,
            xz * mean.x + yz * mean.y + zz * mean.z,
        );
        let rest = self.offsets - at_mean;
        let strongest = values.into_iter().fold(0.0, f64::max);
        let steps = values.into_iter().zip(vectors).filter(|(value, _)| *value > WEAK * strongest);
        let offset: Vec3 = steps.map(|(value, vector)| vector * (vector.dot(rest) / value)).sum();
        self.first + mean + offset
    }
}

/// The eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen(mut a: [[f64; 3]; 3]) -> ([f64; 3], [Vec3; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Each sweep squares what is left beside the diagonal; a handful reaches the rounding.
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            for row in &mut a {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
            let (first, second) = (a[p], a[q]);
            a[p] = std::array::from_fn(|i| cosine * first[i] - sine * second[i]);
            a[q] = std::array::from_fn(|i| sine * first[i] + cosine * second[i]);
            for row in &mut vectors {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
        }
    }
    let column = |i: usize| Vec3::new(vectors[0][i], vectors[1][i], vectors[2][i]);
    ([a[0][0], a[1][1], a[2][2]], [column(0), column(1), column(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_in_their_corner_and_their_edge() {
        let corner = Vec3::new(3.0, -2.0, 5.0);
        let mut error = QuadraticError::default();
        for (normal, along) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::new(0.6, 0.0, 0.8), Vec3::Y)] {
            error.add(corner + along, normal);
        }
        assert!((error.minimum() - corner).length() < 1e-12);
        // Along an edge the point is at the mean.
        let mut error = QuadraticError::default();
        error.add(Vec3::new(0.0, 1.0, 2.0), Vec3::X);
        error.add(Vec3::new(1.0, 0.0, 4.0), Vec3::Y);
        assert!((error.minimum() - Vec3::new(0.0, 0.0, 3.0)).length() < 1e-12);
        // Nearly parallel planes fix only their own direction.
        let mut error = QuadraticError::default();
        error.add(Vec3::ZERO, Vec3::Z);
        error.add(Vec3::X, Vec3::new(1e-3, 0.0, 1.0).normalize());
        error.add(Vec3::Y, Vec3::NAN);
        assert!((error.minimum() - Vec3::new(1.0 / 3.0, 1.0 / 3.0, 0.0)).length() < 1e-3);
    }
}
