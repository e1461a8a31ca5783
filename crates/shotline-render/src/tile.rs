//! The tiles of a picture.

use std::ops::Range;

/// The side of a tile in pixels: small enough that rays of one tile mostly meet the same objects.
const TILE: u32 = 32;

/// A rectangle of pixels.
pub(crate) struct Tile {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

/// All tiles of some rows, row by row.
pub(crate) fn tiles(width: u32, rows: Range<u32>) -> Vec<Tile> {
    let end = rows.end;
    rows.step_by(TILE as usize)
        .flat_map(|top| (0..width).step_by(TILE as usize).map(move |left| (left, top)))
        .map(|(left, top)| Tile { left, top, width: TILE.min(width - left), height: TILE.min(end - top) })
        .collect()
}

/// The number of pixels of some rows.
pub(crate) fn area(width: u32, height: u32) -> usize {
    width as usize * height as usize
}

impl Tile {
    /// The columns and rows of its pixels, row by row.
    pub fn positions(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let &Tile { left, top, width, height } = self;
        (top..top + height).flat_map(move |row| (left..left + width).map(move |column| (column, row)))
    }

    /// Copies a value for each pixel of the tile into rows of a picture of a width, the first of which is row `top`.
    pub fn paste<T>(&self, pixels: impl Iterator<Item = T>, width: u32, top: u32, picture: &mut [T]) {
        for (i, pixel) in (0..).zip(pixels) {
            let (column, row) = (self.left + i % self.width, self.top - top + i / self.width);
            picture[area(width, row) + column as usize] = pixel;
        }
    }
}

#[cfg(test)]
mod tests {
    use shotline::math::Vec3;

    use super::*;
    use crate::exposure::{Exposure, Sample};

    #[test]
    fn tiles_cover_each_pixel_once() {
        let (width, height) = (2 * TILE + 5, TILE + 1);
        let mut exposure = Exposure { width, height, samples: vec![Sample::NOTHING; area(width, height)] };
        for tile in tiles(width, 0..height) {
            let pixel = |i: usize| {
                let (column, row) = (tile.left + i as u32 % tile.width, tile.top + i as u32 / tile.width);
                Sample::opaque(Vec3::new(f64::from(column), f64::from(row), 0.0))
            };
            let pixels: Vec<_> = (0..area(tile.width, tile.height)).map(pixel).collect();
            tile.paste(pixels.into_iter(), width, 0, &mut exposure.samples);
        }
        for (i, s) in exposure.samples.iter().enumerate() {
            let (column, row) = (i as u32 % width, i as u32 / width);
            assert_eq!(s.color, Vec3::new(f64::from(column), f64::from(row), 0.0));
        }
    }
}
