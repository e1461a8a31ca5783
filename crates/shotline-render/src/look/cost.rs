//! What the closest crossing of each ray costs, as a heat map with a legend.

use shotline::accel::Counter;
use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader};
use crate::backdrop::Backdrop;
use crate::color::{self, Rgb};
use crate::film::{Exposure, Sample};
use crate::lettering;
use crate::sampling::Chance;
use crate::sight::Eye;

pub(super) static LOOK: Look = Look {
    name: "cost",
    summary: "a heat map of the work that each ray takes, with a legend",
    backdrop: Backdrop::BLACK,
    shader: |stage| Ok(Box::new(Cost { counter: stage.counter })),
};

/// From no work to the most in the picture, as sRGB: lightness grows evenly, so that it reads in grey too.
const HEAT: [[f64; 3]; 6] = [
    [0.00, 0.00, 0.02],
    [0.26, 0.04, 0.41],
    [0.58, 0.15, 0.40],
    [0.87, 0.32, 0.22],
    [0.99, 0.65, 0.04],
    [0.99, 1.00, 0.64],
];

struct Cost {
    counter: &'static Counter,
}

impl Shader for Cost {
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        Ok(Sample::opaque(Vec3::splat((self.counter.of)(&eye.work(ray)?) as f64)))
    }

    fn develop(&self, exposure: &mut Exposure) {
        let most = exposure.samples.iter().fold(0.0f64, |m, s| m.max(s.color.x));
        for s in &mut exposure.samples {
            s.color = heat(if most > 0.0 { s.color.x / most } else { 0.0 });
        }
        let mean = |n: f64| if n < 10.0 { format!("{n:.1}") } else { format!("{n:.0}") };
        legend(exposure, &format!("{} a ray: 0 to {}", self.counter.summary, mean(most)));
    }
}

/// Shades of the legend: more than an eye can tell, and few enough for the palette of a small PNG.
const SHADES: f64 = 200.0;

/// The colour of a share of the most work.
fn heat(share: f64) -> Rgb {
    let share = (share.clamp(0.0, 1.0) * SHADES).round() / SHADES;
    let place = share * (HEAT.len() - 1) as f64;
    let below = (place as usize).min(HEAT.len() - 2);
    let [low, high] = [below, below + 1].map(|i| Vec3::from(HEAT[i]));
    color::linear(low.lerp(high, place - below as f64).to_array())
}

/// A bar of all colours with a line of text, in the lower left corner of pictures that have room for it.
fn legend(exposure: &mut Exposure, text: &str) {
    let (margin, height) = (lettering::SIDE, lettering::SIDE);
    let width = lettering::width(text);
    if exposure.width < width + 2 * margin || exposure.height < 2 * height + 3 * margin {
        return;
    }
    let top = exposure.height - margin - height;
    for row in 0..height {
        for column in 0..width {
            let share = f64::from(column) / f64::from(width - 1);
            exposure.set(margin + column, top + row, heat(share));
        }
    }
    lettering::write(margin, top - height - margin / 2, text, |column, row, ink| {
        exposure.set(column, row, Vec3::splat(ink));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_work_is_lighter() {
        let light = |share: f64| heat(share).dot(Vec3::new(0.21, 0.72, 0.07));
        assert!((0..100).all(|i| light(f64::from(i) / 100.0) < light(f64::from(i + 1) / 100.0)));
        assert_eq!(heat(2.0), heat(1.0));
    }
}
