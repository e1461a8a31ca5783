//! Heat maps: a colour scale for numbers, and a legend with the values of its ends.

use shotline::math::Vec3;

use crate::color::{self, Rgb};
use crate::exposure::Exposure;
use crate::text;

/// From zero to the maximum of the picture, as sRGB. Lightness grows evenly, so that the scale is readable in grey too.
const HEAT: [[f64; 3]; 6] = [
    [0.00, 0.00, 0.02],
    [0.26, 0.04, 0.41],
    [0.58, 0.15, 0.40],
    [0.87, 0.32, 0.22],
    [0.99, 0.65, 0.04],
    [0.99, 1.00, 0.64],
];

/// Shades of the scale: more than an eye can distinguish, and few enough for the palette of a small PNG.
const SHADES: f64 = 200.0;

/// The colour of a fraction of the maximum.
pub fn heat_color(fraction: f64) -> Rgb {
    let fraction = (fraction.clamp(0.0, 1.0) * SHADES).round() / SHADES;
    let position = fraction * (HEAT.len() - 1) as f64;
    let below = (position as usize).min(HEAT.len() - 2);
    let [low, high] = [below, below + 1].map(|i| Vec3::from(HEAT[i]));
    color::linear(low.lerp(high, position - below as f64).to_array())
}

/// Replaces the numbers of a picture, in the red of its samples, by colours. The scale is from 0 to their maximum.
/// Returns the maximum.
pub fn apply(exposure: &mut Exposure) -> f64 {
    let max = exposure.samples.iter().fold(0.0f64, |m, s| m.max(s.color.x));
    for s in &mut exposure.samples {
        s.color = heat_color(if max > 0.0 { s.color.x / max } else { 0.0 });
    }
    max
}

/// Draws a bar of all colours with a line of text in the lower left corner, if the picture has room for it.
pub fn draw_legend(exposure: &mut Exposure, text: &str) {
    const MARGIN: u32 = 8;
    const BAR: u32 = 10;
    let width = text::caption_width(text);
    if exposure.width < width + 2 * MARGIN || exposure.height < BAR + text::CAPTION_HEIGHT + 2 * MARGIN {
        return;
    }
    let top = exposure.height - MARGIN - BAR;
    for row in 0..BAR {
        for column in 0..width {
            let fraction = f64::from(column) / f64::from(width - 1);
            exposure.set(MARGIN + column, top + row, heat_color(fraction));
        }
    }
    text::caption(MARGIN, top - text::CAPTION_HEIGHT, text, |column, row, white| {
        exposure.set(column, row, color::linear([white; 3]));
    });
}

/// A number with three significant digits, as legends show it.
pub fn three_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let magnitude = x.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{x:.2e}");
    }
    let decimals = (2.0 - magnitude).max(0.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_lighter() {
        let light = |fraction: f64| heat_color(fraction).dot(Vec3::new(0.21, 0.72, 0.07));
        assert!((0..100).all(|i| light(f64::from(i) / 100.0) < light(f64::from(i + 1) / 100.0)));
        assert_eq!(heat_color(2.0), heat_color(1.0));
    }

    #[test]
    fn numbers_have_three_digits() {
        let texts = [0.0, 2.0, 2.346, 12.34, 1234.5, 0.012_34, 1.5e-9, 2.5e8].map(three_digits);
        assert_eq!(texts, ["0", "2", "2.35", "12.3", "1234", "0.0123", "1.50e-9", "2.50e8"]);
    }
}
