//! Lines, discs and letters on a finished picture. Positions are in pixels from its upper left corner.

use crate::color::{self, Rgb};
use crate::image::Image;
use crate::text;

impl Image {
    /// Covers a share of a pixel with a colour, if it is in the picture.
    fn blend(&mut self, column: i64, row: i64, color: Rgb, share: f64) {
        let (Ok(column), Ok(row)) = (u32::try_from(column), u32::try_from(row)) else { return };
        if let Some([r, g, b, a]) = self.pixel_mut(column, row) {
            for (channel, value) in [(r, color.x), (g, color.y), (b, color.z), (a, 1.0)] {
                *channel = (f64::from(*channel) * (1.0 - share) + value * share) as f32;
            }
        }
    }

    /// Draws a line with round ends. Both ends should be near the picture.
    pub(super) fn line(&mut self, [from, to]: [[f64; 2]; 2], width: f64, color: Rgb) {
        let reach = width / 2.0 + 1.0;
        let bounds = |axis: usize, end: u32| {
            let (low, high) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
            // A line may leave the picture on any side.
            let clamp = |x: f64| x.clamp(-1.0, f64::from(end)) as i64;
            clamp((low - reach).floor())..clamp((high + reach).ceil())
        };
        let (columns, rows) = (bounds(0, self.width()), bounds(1, self.height()));
        let along = [to[0] - from[0], to[1] - from[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        for row in rows {
            for column in columns.clone() {
                let [x, y] = [column as f64 + 0.5 - from[0], row as f64 + 0.5 - from[1]];
                let share = ((x * along[0] + y * along[1]) / squared).clamp(0.0, 1.0);
                let share = if squared > 0.0 { share } else { 0.0 };
                let distance = (x - share * along[0]).hypot(y - share * along[1]);
                let covered = ((width + 1.0) / 2.0 - distance).clamp(0.0, 1.0);
                if covered > 0.0 {
                    self.blend(column, row, color, covered);
                }
            }
        }
    }

    /// Draws a disc.
    pub(super) fn disc(&mut self, at: [f64; 2], radius: f64, color: Rgb) {
        self.line([at, at], 2.0 * radius, color);
    }

    /// Draws a line of text from a left end on a baseline.
    pub(super) fn write(&mut self, [left, baseline]: [f64; 2], size: f32, color: Rgb, letters: &str) {
        text::draw(left as f32, baseline as f32, size, letters, |column, row, share| {
            self.blend(column, row, color, share);
        });
    }

    /// The picture with more room to its right.
    pub(super) fn widened(&self, by: u32, color: Rgb) -> Image {
        let filling = [color.x, color.y, color.z, 1.0].map(|channel| channel as f32);
        self.with_columns(by, filling)
    }
}

/// A grey, as sRGB from 0 to 1.
pub(super) fn grey(value: f64) -> Rgb {
    color::linear([value; 3])
}
