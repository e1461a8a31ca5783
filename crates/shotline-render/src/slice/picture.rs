//! The picture of a slice in pixels.

use shotline::compile::World;
use shotline::scene::Scene;

use super::coloring::{ColorBy, regions};
use super::figure::{Anchor, Conflicts, Figure, Fill, Mark};
use super::owners::Slice;
use crate::jpeg::{JpegError, encode_jpeg_bytes};
use crate::png::encode_bytes;
use crate::text;

const INK: [u8; 3] = [0x20, 0x20, 0x20];
const PAPER: [u8; 3] = [0xFF; 3];

/// The colours of the hatch of conflicts.
pub const HATCH: [[u8; 3]; 2] = [[0xE0, 0x10, 0x20], [0xFF, 0xE0, 0xE0]];

/// The width of a stripe of the hatch, in pixels.
const STRIPE: u32 = 4;

/// How much darker the boundary of two regions is.
const BOUNDARY: f64 = 0.45;

/// The PNG of a slice: the pixels of its owners, axes in the units of the scene, and a legend.
pub fn slice_png(slice: &Slice, world: &World, scene: &Scene, by: ColorBy, conflicts: Conflicts) -> Vec<u8> {
    let canvas = Canvas::of(slice, world, scene, by, conflicts);
    let bytes = canvas.pixels.as_flattened().to_vec();
    // A canvas has as many bytes as its size needs.
    encode_bytes(canvas.width, canvas.height, bytes).expect("a canvas has the bytes of its size")
}

/// The same picture as JPEG.
///
/// # Errors
/// If it is wider or higher than a JPEG can be.
pub fn slice_jpeg(
    slice: &Slice,
    world: &World,
    scene: &Scene,
    by: ColorBy,
    conflicts: Conflicts,
) -> Result<Vec<u8>, JpegError> {
    let canvas = Canvas::of(slice, world, scene, by, conflicts);
    encode_jpeg_bytes(canvas.width, canvas.height, canvas.pixels.as_flattened())
}

struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    /// The picture of a slice.
    fn of(slice: &Slice, world: &World, scene: &Scene, by: ColorBy, conflicts: Conflicts) -> Canvas {
        let regions = regions(slice, world, scene, by);
        let figure = Figure::new(slice, world, scene, (by, &regions), conflicts);
        let mut canvas = Canvas::new(figure.width, figure.height);
        canvas.draw_slice(slice, &figure, by);
        if figure.marks_conflicts {
            canvas.draw_conflicts(slice, &figure);
        }
        figure.marks.iter().for_each(|mark| canvas.draw(mark, figure.font));
        canvas
    }

    fn new(width: u32, height: u32) -> Canvas {
        Canvas { width, height, pixels: vec![PAPER; width as usize * height as usize] }
    }

    fn pixel(&mut self, column: i64, row: i64) -> Option<&mut [u8; 3]> {
        let (column, row) = (u32::try_from(column).ok()?, u32::try_from(row).ok()?);
        let is_inside = column < self.width && row < self.height;
        is_inside.then(|| &mut self.pixels[row as usize * self.width as usize + column as usize])
    }

    fn draw_slice(&mut self, slice: &Slice, figure: &Figure, by: ColorBy) {
        let width = slice.width as usize;
        let none = i64::MIN;
        let mut above = vec![none; width];
        for (row, parts) in (0..).zip(&slice.rows) {
            let mut owners = vec![none; width];
            for part in parts {
                owners[super::owners::pixels(part.columns, width)].fill(by.number(part));
            }
            for (column, &owner) in (0..).zip(&owners) {
                let beside = if column > 0 { owners[column - 1] } else { owner };
                let is_boundary = owner != beside || (row > 0 && owner != above[column]);
                let color = if owner == none { PAPER } else { figure.color(owner) };
                let share = if is_boundary { BOUNDARY } else { 0.0 };
                let place = (i64::from(figure.left) + column as i64, i64::from(figure.top) + row);
                if let Some(pixel) = self.pixel(place.0, place.1) {
                    *pixel = mixed(color, INK, share);
                }
            }
            above = owners;
        }
    }

    /// Hatches every pixel that a conflict touches, so that a thin one is seen too.
    fn draw_conflicts(&mut self, slice: &Slice, figure: &Figure) {
        for (row, parts) in (0..).zip(&slice.conflicts) {
            for part in parts {
                let from = part.columns[0].max(0.0).floor() as u32;
                let to = part.columns[1].min(f64::from(slice.width)).ceil() as u32;
                for column in from..to {
                    let (x, y) = (figure.left + column, figure.top + row);
                    if let Some(pixel) = self.pixel(x.into(), y.into()) {
                        *pixel = hatch(x, y);
                    }
                }
            }
        }
    }

    fn draw(&mut self, mark: &Mark, font: f32) {
        match mark {
            &Mark::Swatch { left, top, width, height, fill } => {
                let [x0, y0] = [left, top].map(|x| x.round() as i64);
                let [x1, y1] = [left + width, top + height].map(|x| x.round() as i64);
                for (row, column) in (y0..y1).flat_map(|row| (x0..x1).map(move |column| (row, column))) {
                    let is_edge = row == y0 || row == y1 - 1 || column == x0 || column == x1 - 1;
                    let color = match fill {
                        Fill::Color(color) => color,
                        Fill::Hatch => hatch(column as u32, row as u32),
                    };
                    if let Some(pixel) = self.pixel(column, row) {
                        *pixel = mixed(color, INK, if is_edge { 2.0 * BOUNDARY } else { 0.0 });
                    }
                }
            }
            Mark::Line { from, to } => {
                // Lines are along the sides of the picture, just outside of the slice.
                let low = [0, 1].map(|i| from[i].min(to[i]).round() as i64);
                let high = [0, 1].map(|i| from[i].max(to[i]).round() as i64);
                for row in low[1]..=high[1] {
                    for column in low[0]..=high[0] {
                        if let Some(pixel) = self.pixel(column, row) {
                            *pixel = INK;
                        }
                    }
                }
            }
            Mark::Text { at, anchor, text, .. } => {
                let width = text::width(text, font);
                let left = match anchor {
                    Anchor::Start => at[0],
                    Anchor::Middle => at[0] - width / 2.0,
                    Anchor::End => at[0] - width,
                };
                text::draw(left, at[1].round(), font, text, |column, row, share| {
                    if let Some(pixel) = self.pixel(column, row) {
                        *pixel = mixed(*pixel, INK, share);
                    }
                });
            }
        }
    }
}

fn hatch(x: u32, y: u32) -> [u8; 3] {
    HATCH[((x + y) / STRIPE % 2) as usize]
}

fn mixed(a: [u8; 3], b: [u8; 3], share: f64) -> [u8; 3] {
    [0, 1, 2].map(|i| (f64::from(a[i]) * (1.0 - share) + f64::from(b[i]) * share).round() as u8)
}
