//! The hatching of cuts, as in technical drawings.

use crate::color::Rgb;

/// The distance of the lines in pixels.
const PITCH: f64 = 8.0;
/// The width of a line in pixels.
const WIDTH: f64 = 1.2;
/// What is left of the light of a cut where there is a line.
const LINE: f64 = 0.2;

/// The colour of a cut through an object at a position in the picture, in pixels. Lines rise to the right for objects of even
/// numbers, and fall for the others.
pub fn hatched(color: Rgb, object: u32, [x, y]: [f64; 2]) -> Rgb {
    let across = if object.is_multiple_of(2) { x + y } else { x - y } * std::f64::consts::FRAC_1_SQRT_2;
    let distance = (across / PITCH - (across / PITCH).round()).abs() * PITCH;
    // A line is smooth over one pixel, also where a pixel has one sample.
    let covered = ((WIDTH + 1.0) / 2.0 - distance).clamp(0.0, 1.0);
    color * (1.0 - (1.0 - LINE) * covered)
}
