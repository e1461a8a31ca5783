//! Text in pictures, in one font.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, PxScale, PxScaleFont, ScaleFont, point};

/// A part of DejaVu Sans: Latin and Greek letters and the signs of numbers. Its licence is beside it.
const FONT: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");

/// The steps between the background and a letter at its edges: few, so that a picture of a colour scale fits a palette.
const SHADES: f32 = 8.0;

fn font(size: f32) -> PxScaleFont<&'static FontRef<'static>> {
    static FONT_REF: OnceLock<FontRef> = OnceLock::new();
    // The bytes are part of the program, and a test reads them.
    let font =
        FONT_REF.get_or_init(|| FontRef::try_from_slice(FONT).expect("the font of the program is valid"));
    let units = font.units_per_em().unwrap_or(1000.0);
    font.as_scaled(PxScale::from(size * font.height_unscaled() / units))
}

/// The width in pixels of a line of text in letters of a size, the em of the font in pixels.
pub fn width(text: &str, size: f32) -> f32 {
    let font = font(size);
    text.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
}

/// Draws a line of text from a left end on a baseline. Calls `set` with the column, the row and the covered share of each pixel
/// that letters cover.
pub fn draw(left: f32, baseline: f32, size: f32, text: &str, mut set: impl FnMut(i64, i64, f64)) {
    let font = font(size);
    let mut x = left;
    for letter in text.chars() {
        let id = font.glyph_id(letter);
        let glyph = id.with_scale_and_position(font.scale(), point(x, baseline));
        x += font.h_advance(id);
        let Some(outline) = font.outline_glyph(glyph) else { continue };
        let corner = outline.px_bounds().min;
        outline.draw(|column, row, share| {
            let share = (share.clamp(0.0, 1.0) * SHADES).round() / SHADES;
            if share > 0.0 {
                let (column, row) = (i64::from(column), i64::from(row));
                set(corner.x as i64 + column, corner.y as i64 + row, f64::from(share));
            }
        });
    }
}

/// The letters of a caption on a picture.
pub const CAPTION: f32 = 13.0;

/// The height of the box of a caption.
pub const CAPTION_HEIGHT: u32 = 17;

/// Draws white letters in a black box, whose upper left corner is a pixel. Calls `set` with the column, the row and the
/// brightness (0 to 1) of each pixel.
pub fn caption(left: u32, top: u32, text: &str, mut set: impl FnMut(u32, u32, f64)) {
    for row in 0..CAPTION_HEIGHT {
        for column in 0..caption_width(text) {
            set(left + column, top + row, 0.0);
        }
    }
    let baseline = (top + CAPTION_HEIGHT) as f32 - 4.0;
    draw(left as f32 + 2.0, baseline, CAPTION, text, |column, row, white| {
        if let (Ok(column), Ok(row)) = (u32::try_from(column), u32::try_from(row)) {
            set(column, row, white);
        }
    });
}

/// The width of the box of a caption.
pub fn caption_width(text: &str) -> u32 {
    width(text, CAPTION).ceil() as u32 + 4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_cover_pixels_above_their_baseline() {
        let (mut covered, mut columns) = (0.0, [i64::MAX, i64::MIN]);
        draw(10.0, 30.0, 20.0, "HH", |column, row, share| {
            assert!((10..30).contains(&row), "{row}");
            covered += share;
            columns = [columns[0].min(column), columns[1].max(column)];
        });
        let right = 10.0 + f64::from(width("HH", 20.0));
        assert!(columns[0] >= 10 && columns[1] as f64 <= right, "{columns:?}");
        assert!((60.0..300.0).contains(&covered), "{covered}");
        assert_eq!(width("", 20.0), 0.0);
    }

    #[test]
    fn captions_have_few_shades_and_any_letters() {
        let mut shades = Vec::new();
        caption(3, 4, "µ = 0.5 … \u{4f60}", |_, _, white| {
            if !shades.contains(&white) {
                shades.push(white);
            }
        });
        assert!((3..=9).contains(&shades.len()), "{shades:?}");
    }
}
