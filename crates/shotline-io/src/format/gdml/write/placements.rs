//! Transforms as GDML places things: a position, a rotation about x, y and z, a mirror and a scale.

use shotline::math::{Affine, Vec3};

/// Entries of a matrix that differ by less than this from those of a rotation are those of one.
const TOLERANCE: f64 = 1e-9;

/// How far the rotation of a file may be from that of the scene before it is worth a note.
pub(super) const NOTABLE: f64 = 1e-14;

/// A transform in parts: first the scale, then the mirror, the rotation and the translation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    /// The rotation and the translation.
    pub(super) rigid: Affine,
    /// Each 1 or -1, and at most one of them -1.
    pub(super) mirror: Vec3,
    /// Positive factors.
    pub(super) scale: Vec3,
    /// By how much the matrix differs from that of the parts, relatively.
    pub(super) error: f64,
}

impl Placement {
    /// `None` for a transform that shears.
    pub(super) fn of(matrix: &Affine) -> Option<Placement> {
        let column = |j: usize| Vec3::from(matrix.rows.map(|row| row[j]));
        let lengths = [0, 1, 2].map(|j| column(j).length());
        let scale = Vec3::from(lengths.map(simplified));
        let mut error = 0.0_f64;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            error = error.max((column(i).dot(column(j)) / (lengths[i] * lengths[j])).abs());
        }
        for (length, factor) in lengths.iter().zip(scale.to_array()) {
            error = error.max((length / factor - 1.0).abs());
        }
        if error.is_nan() || error > TOLERANCE {
            return None;
        }
        let without_scale = times_diagonal(matrix, scale.recip());
        let mirrors: &[Vec3] = match matrix.determinant() < 0.0 {
            false => &[Vec3::ONE],
            true => &[Vec3::new(-1.0, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(1.0, 1.0, -1.0)],
        };
        // Of the three mirrors, the one that leaves the simplest rotation.
        let candidates = mirrors.iter().map(|mirror| (times_diagonal(&without_scale, *mirror), *mirror));
        let zeros = |rigid: &Affine| degrees_of(rigid).to_array().iter().filter(|x| **x == 0.0).count();
        let (rigid, mirror) = candidates.max_by_key(|(rigid, _)| zeros(rigid))?;
        Some(Placement { rigid, mirror, scale, error })
    }

    pub(super) fn is_mirrored(&self) -> bool {
        self.mirror != Vec3::ONE
    }

    pub(super) fn is_scaled(&self) -> bool {
        self.scale != Vec3::ONE
    }

    /// The transform without the scale.
    pub(super) fn isometry(&self) -> Affine {
        times_diagonal(&self.rigid, self.mirror)
    }

    pub(super) fn position(&self) -> Vec3 {
        position_of(&self.rigid)
    }

    /// The angles with which an operand is turned.
    pub(super) fn degrees_of_operand(&self) -> Vec3 {
        degrees_of(&self.rigid)
    }

    /// The angles with which the frame of the mother is turned.
    pub(super) fn degrees_of_volume(&self) -> Vec3 {
        degrees_of(&transposed(&self.rigid))
    }
}

/// The translation of a transform.
pub(super) fn position_of(matrix: &Affine) -> Vec3 {
    Vec3::from(matrix.rows.map(|row| row[3]))
}

/// The transform behind a scale along the axes.
fn times_diagonal(matrix: &Affine, factors: Vec3) -> Affine {
    let mut out = *matrix;
    for row in &mut out.rows {
        for (x, factor) in row[..3].iter_mut().zip(factors.to_array()) {
            *x *= factor;
        }
    }
    out
}

fn transposed(matrix: &Affine) -> Affine {
    let mut out = *matrix;
    for (i, row) in out.rows.iter_mut().enumerate() {
        for (j, x) in row[..3].iter_mut().enumerate() {
            *x = matrix.rows[j][i];
        }
    }
    out
}

/// A factor without what rounding has added to it: 1 within the tolerance, otherwise with up to 14 digits if they suffice.
fn simplified(x: f64) -> f64 {
    if (x - 1.0).abs() <= TOLERANCE {
        return 1.0;
    }
    let short: f64 = format!("{x:.13e}").parse().unwrap_or(x);
    if (x - short).abs() <= 4.0 * f64::EPSILON * x { short } else { x }
}

/// The angles in degrees about x, then y, then z of a rotation.
///
/// Where the turn about y is near a quarter, those about x and z are nearly about one axis, and each alone is badly determined.
/// The turn about x is computed from what the one about z leaves, so that both together are right (Day, Extracting Euler Angles from a Rotation Matrix, 2012).
fn degrees_of(rotation: &Affine) -> Vec3 {
    let r = &rotation.rows;
    let across = libm::hypot(r[0][0], r[1][0]);
    let y = libm::atan2(-r[2][0], across);
    let z = if across > f64::EPSILON { libm::atan2(r[1][0], r[0][0]) } else { 0.0 };
    let (sin, cos) = (libm::sin(z), libm::cos(z));
    let x = libm::atan2(sin * r[0][2] - cos * r[1][2], cos * r[1][1] - sin * r[0][1]);
    refined(rotation, Vec3::new(x, y, z) * (180.0 / std::f64::consts::PI))
}

/// The angles with as few decimals as give the same rotation; else with the last digits changed so that they give it best.
fn refined(rotation: &Affine, degrees: Vec3) -> Vec3 {
    let exact = distance(rotation, degrees);
    for decimals in 0..13 {
        let unit = 10f64.powi(decimals);
        let short = (degrees * unit).round() / unit + Vec3::ZERO;
        if distance(rotation, short) <= exact.max(f64::EPSILON * 0.5) {
            return short;
        }
    }
    let (mut best, mut least) = (degrees, exact);
    for axis in [0, 1, 2, 0, 1, 2, 0, 1, 2] {
        for step in [f64::next_up, f64::next_down] {
            let mut other = best;
            other[axis] = step(best[axis]);
            let off = distance(rotation, other);
            if off < least {
                (best, least) = (other, off);
            }
        }
    }
    best
}

/// The largest difference between an entry of a rotation and that of the rotation by some angles.
fn distance(rotation: &Affine, degrees: Vec3) -> f64 {
    let turned = Affine::rotation_xyz(degrees);
    let entries = rotation.rows.iter().zip(&turned.rows).flat_map(|(a, b)| a[..3].iter().zip(&b[..3]));
    entries.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shotline::testkit::random::Random;

    fn assert_same(rotation: &Affine) {
        let degrees = degrees_of(rotation);
        assert!(
            distance(rotation, degrees) <= 1e-15,
            "{rotation:?}: {degrees}: {}",
            distance(rotation, degrees)
        );
    }

    #[test]
    fn angles_give_the_same_rotation() {
        let mut random = Random::new(5);
        for case in 0..5000 {
            let mut degrees = [0; 3].map(|_| random.number(-180.0, 180.0));
            // At and near a quarter turn about y.
            if case % 3 == 0 {
                let off = [0.0, 1e-14, 1e-9, 1e-5][case % 4];
                degrees[1] = 90.0 * if case % 2 == 0 { 1.0 } else { -1.0 } + off;
            }
            let rotation = Affine::rotation_xyz(Vec3::from(degrees));
            assert_same(&rotation);
            assert_same(&transposed(&rotation));
            assert_same(&Affine::rotation_about(Vec3::from(degrees), degrees[0]));
        }
    }

    #[test]
    fn angles_of_few_digits_are_found() {
        for degrees in
            [[90.0, 0.0, 0.0], [0.0, 0.0, -37.5], [10.0, 20.0, 30.0], [0.0, 45.25, 0.0], [180.0, 0.0, 90.0]]
        {
            assert_eq!(degrees_of(&Affine::rotation_xyz(Vec3::from(degrees))).to_array(), degrees);
        }
    }

    #[test]
    fn transforms_fall_into_parts() {
        let turn = Affine::rotation_xyz(Vec3::new(10.0, 20.0, 30.0));
        let scale = Vec3::new(2.0, 0.1, 3.0);
        let at = Vec3::new(1.0, 2.0, 3.0);
        let place =
            |scale: Vec3| Affine::translation(at).then_after(&turn.then_after(&Affine::scaling(scale)));
        let placement = Placement::of(&place(scale)).expect("no shear");
        assert_eq!((placement.scale, placement.mirror, placement.position()), (scale, Vec3::ONE, at));
        let mirrored = Placement::of(&place(Vec3::new(1.0, -1.0, 1.0))).expect("no shear");
        assert!(mirrored.is_mirrored() && !mirrored.is_scaled());
        let back = mirrored.isometry();
        for (a, b) in back.rows.iter().flatten().zip(place(Vec3::new(1.0, -1.0, 1.0)).rows.iter().flatten()) {
            assert!((a - b).abs() < 1e-15);
        }
        let mut shear = Affine::IDENTITY;
        shear.rows[0][1] = 1e-6;
        assert!(Placement::of(&shear).is_none());
    }
}
