//! Text in pictures, in a bitmap font.

use font8x8::UnicodeFonts;
use shotline::math::Vec3;

use crate::film::Exposure;

/// The side of a letter in pixels.
pub const SIDE: u32 = 8;

/// How wide a line of text is, in pixels.
pub fn width(text: &str) -> u32 {
    SIDE * text.chars().count() as u32
}

/// Writes white letters on black, the first with its upper left corner at a pixel. What does not fit is left out, and
/// so is what is not ASCII.
pub fn write(exposure: &mut Exposure, left: u32, top: u32, text: &str) {
    for (i, letter) in (0..).zip(text.chars()) {
        let Some(rows) = font8x8::BASIC_FONTS.get(letter) else { continue };
        for (row, bits) in (0..).zip(rows) {
            for column in 0..SIDE {
                let ink = f64::from(bits >> column & 1);
                exposure.set(left + i * SIDE + column, top + row, Vec3::splat(ink));
            }
        }
    }
}
