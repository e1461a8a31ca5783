//! A finished picture.

use crate::background::Background;
use crate::color;
use crate::exposure::{Exposure, Sample};
use crate::text;

/// The pixels beside and above the caption of a picture on a contact sheet.
const CAPTION_MARGIN: u32 = 6;

/// A finished picture: linear light, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    transparent: bool,
    pixels: Vec<[f32; 4]>,
}

impl Image {
    /// Puts an exposure in front of a background.
    pub(crate) fn compose(exposure: &Exposure, background: Background) -> Image {
        let Exposure { width, height, ref samples } = *exposure;
        let over = |(i, s): (usize, &Sample)| {
            let row = i / width as usize;
            let height = 1.0 - (row as f64 + 0.5) / f64::from(height);
            let [r, g, b, a] = match background.color(height) {
                Some(background) => {
                    let c = s.color + background * (1.0 - s.alpha);
                    [c.x, c.y, c.z, 1.0]
                }
                None if s.alpha > 0.0 => {
                    let c = s.color / s.alpha;
                    [c.x, c.y, c.z, s.alpha]
                }
                None => [0.0; 4],
            };
            [r as f32, g as f32, b as f32, a as f32]
        };
        let pixels = samples.iter().enumerate().map(over).collect();
        Image { width, height, transparent: background == Background::Transparent, pixels }
    }

    /// A contact sheet: pictures of one size in rows, each with a caption in its upper left corner. `None` without
    /// pictures or with pictures of different sizes.
    pub fn contact_sheet(pictures: &[(&str, Image)], columns: u32) -> Option<Image> {
        let (_, first) = pictures.first()?;
        let &Image { width, height, .. } = first;
        if columns == 0 || pictures.iter().any(|(_, p)| (p.width, p.height) != (width, height)) {
            return None;
        }
        let rows = (pictures.len() as u32).div_ceil(columns);
        let black = [0.0, 0.0, 0.0, 1.0];
        let mut sheet = Image {
            width: width * columns,
            height: height * rows,
            transparent: false,
            pixels: vec![black; (width * columns) as usize * (height * rows) as usize],
        };
        for (i, (caption, picture)) in (0..).zip(pictures) {
            let (left, top) = (i % columns * width, i / columns * height);
            for (row, line) in (0..).zip(picture.pixels.chunks_exact(width as usize)) {
                let start = (top + row) as usize * sheet.width as usize + left as usize;
                sheet.pixels[start..start + line.len()].copy_from_slice(line);
            }
            text::caption(left + CAPTION_MARGIN, top + CAPTION_MARGIN, caption, |column, row, white| {
                if column < left + width && row < top + height {
                    let white = color::decode(white) as f32;
                    sheet.pixels[row as usize * sheet.width as usize + column as usize] =
                        [white, white, white, 1.0];
                }
            });
        }
        Some(sheet)
    }

    /// Pixels in a row, at least one.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows, at least one.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Bytes per pixel in [`Image::to_bytes`]: 3, or 4 with a transparent background.
    pub fn channels(&self) -> usize {
        if self.transparent { 4 } else { 3 }
    }

    /// Linear red, green, blue, not multiplied by the alpha that follows them; row by row from the top.
    /// Colours are not clamped to 1. Without a transparent background alpha is 1.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// The pixel in a column and a row, counted from the upper left corner from 0.
    ///
    /// # Panics
    /// If it is outside the picture.
    pub fn pixel(&self, column: u32, row: u32) -> [f32; 4] {
        assert!(column < self.width && row < self.height, "pixel {column}, {row} is outside the picture");
        self.pixels[row as usize * self.width as usize + column as usize]
    }

    /// The picture with more columns of one colour at its right side.
    pub(crate) fn with_columns(&self, count: u32, color: [f32; 4]) -> Image {
        let width = self.width + count;
        let row = |row: &[[f32; 4]]| [row, &vec![color; count as usize]].concat();
        let pixels = self.pixels.chunks_exact(self.width as usize).flat_map(row).collect();
        Image { width, pixels, ..*self }
    }

    /// That pixel, if it is in the picture.
    pub(crate) fn pixel_mut(&mut self, column: u32, row: u32) -> Option<&mut [f32; 4]> {
        let is_inside = column < self.width && row < self.height;
        is_inside.then(|| &mut self.pixels[row as usize * self.width as usize + column as usize])
    }

    /// Eight-bit sRGB, row by row from the top: red, green, blue and, with a transparent background, alpha.
    pub fn to_bytes(&self) -> Vec<u8> {
        let byte = |x: f64| (x * 255.0).round() as u8;
        let channels = self.channels();
        let mut out = Vec::with_capacity(self.pixels.len() * channels);
        for &[r, g, b, a] in &self.pixels {
            let [r, g, b] = [r, g, b].map(|x| byte(color::encode(f64::from(x))));
            out.extend_from_slice(&[r, g, b, byte(f64::from(a).clamp(0.0, 1.0))][..channels]);
        }
        out
    }
}
