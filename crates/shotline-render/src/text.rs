//! Text in pictures, in a bitmap font.

use font8x8::UnicodeFonts;

/// The side of a letter in pixels.
pub const SIDE: u32 = 8;

/// The width of a line of text in pixels.
pub fn width(text: &str) -> u32 {
    SIDE * text.chars().count() as u32
}

/// Draws white letters on black, the first with its upper left corner at a pixel. Calls `set` with the column, the row
/// and the brightness (0 or 1) of each pixel. Leaves out characters that are not ASCII.
pub fn draw(left: u32, top: u32, text: &str, mut set: impl FnMut(u32, u32, f64)) {
    for (i, letter) in (0..).zip(text.chars()) {
        let Some(rows) = font8x8::BASIC_FONTS.get(letter) else { continue };
        for (row, bits) in (0..).zip(rows) {
            for column in 0..SIDE {
                set(left + i * SIDE + column, top + row, f64::from(bits >> column & 1));
            }
        }
    }
}
