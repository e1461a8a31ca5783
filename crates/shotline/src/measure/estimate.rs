//! Values with their standard errors.

use crate::math::Affine;
use crate::solid::Moments;

/// A value with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error; 0 where it is exact but for rounding.
    pub std_error: f64,
}

impl Estimate {
    /// Multiplies the value and its error by a number.
    pub fn times(self, factor: f64) -> Estimate {
        Estimate { value: self.value * factor, std_error: self.std_error * factor.abs() }
    }
}

/// The number of randomised samples, whose spread gives the errors.
pub(super) const SHIFTS: usize = 16;

/// The length of the list of volume, centroid and inertia.
pub(super) const COUNT: usize = 13;

/// Returns that list, with NaN for what is undefined without a volume.
pub(super) fn numbers(m: &Moments) -> [f64; COUNT] {
    let [x, y, z] = m.inertia();
    let mut out = [f64::NAN; COUNT];
    out[0] = m.volume;
    if m.volume != 0.0 {
        let rest = m.centroid.to_array().into_iter().chain(x).chain(y).chain(z);
        out[1..].iter_mut().zip(rest).for_each(|(out, x)| *out = x);
    }
    out
}

/// The spread of the axes replaces that of the shifts if it is more than this many times as large. With two and fifteen
/// degrees of freedom that happens by chance for one object in twenty-five (the F distribution).
const AXIS_SPREAD_FACTOR: f64 = 2.0;

/// Estimates volume, centroid and inertia of a body from its integrals by several independent samples, in coordinates
/// that `world_from_box` maps to the world.
///
/// The values use all samples together. The errors are the spread of the values with one sample left out (the
/// jackknife); for the volume this is the standard error of a mean.
fn estimates<const SAMPLES: usize>(
    samples: &[[f64; 10]; SAMPLES],
    world_from_box: &Affine,
) -> [Estimate; COUNT] {
    let mean_of = |but: Option<usize>| {
        let kept = || (0..SAMPLES).filter(|i| Some(*i) != but);
        let mean = |term: usize| kept().map(|i| samples[i][term]).sum::<f64>() / kept().count() as f64;
        numbers(&Moments::from_integrals(std::array::from_fn(mean)).placed(world_from_box))
    };
    let values = mean_of(None);
    let without: [[f64; COUNT]; SAMPLES] = std::array::from_fn(|i| mean_of(Some(i)));
    std::array::from_fn(|k| {
        let n = SAMPLES as f64;
        // Relative to the value, so that no digits are lost where the samples are alike; NaN if nothing is left without
        // one.
        let away = without.map(|numbers| numbers[k] - values[k]);
        let mean = away.iter().sum::<f64>() / n;
        // In units of the largest deviation: squares of tiny and huge numbers would underflow and overflow.
        let most = away.iter().fold(0.0, |most: f64, x| most.max((x - mean).abs()));
        let unit = if most > 0.0 && most.is_finite() { most } else { 1.0 };
        let squares = away.iter().map(|x| ((x - mean) / unit).powi(2)).sum::<f64>();
        Estimate { value: values[k], std_error: unit * (squares * (n - 1.0) / n).sqrt() }
    })
}

/// Returns the values of the shifts with their errors, or the errors of the axes where these are much larger.
///
/// The rays along each axis alone estimate the same integrals. If the rays along one axis miss a part, all shifts agree
/// about it, and only the axes differ.
pub(super) fn by_shifts_and_axes(
    shifts: &[[f64; 10]; SHIFTS],
    axes: &[[f64; 10]; 3],
    world_from_box: &Affine,
) -> [Estimate; COUNT] {
    let mut found = estimates(shifts, world_from_box);
    for (estimate, other) in found.iter_mut().zip(estimates(axes, world_from_box)) {
        if other.std_error > AXIS_SPREAD_FACTOR * estimate.std_error {
            estimate.std_error = other.std_error;
        }
    }
    found
}
