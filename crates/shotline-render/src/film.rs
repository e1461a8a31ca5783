//! Exposing a picture: tiles over a pool of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use shotline::compile::World;
use shotline::math::Vec3;
use shotline::query::batch::Run;

use crate::camera::View;
use crate::color::Rgb;
use crate::error::RenderError;
use crate::look::Shader;
use crate::render::Settings;
use crate::sampling;
use crate::sight::Eye;
use crate::still::Kept;

/// The side of a tile in pixels: neighbouring rays meet the same things.
const TILE: u32 = 32;

/// What one pixel has seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// What the look makes of it, mostly a linear colour, already multiplied by `alpha`.
    pub color: Rgb,
    /// The part of the backdrop that is covered.
    pub alpha: f64,
}

impl Sample {
    /// The backdrop alone.
    pub const NOTHING: Sample = Sample { color: Vec3::ZERO, alpha: 0.0 };

    /// Something that covers the backdrop.
    pub fn opaque(color: Rgb) -> Sample {
        Sample { color, alpha: 1.0 }
    }
}

/// Exposed rows of a film: the mean of each pixel's samples, row by row from the top.
#[derive(Clone, Debug)]
pub struct Exposure {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What each pixel has seen.
    pub samples: Vec<Sample>,
}

impl Exposure {
    /// Paints a pixel, if it is in the picture.
    pub fn set(&mut self, column: u32, row: u32, color: Rgb) {
        if column < self.width && row < self.height {
            self.samples[area(self.width, row) + column as usize] = Sample::opaque(color);
        }
    }
}

/// Exposes rows of a picture. Each pixel is worked out by itself, in the same order of samples, so the threads and
/// the tiles leave no trace in it, nor does what rows are exposed together.
pub fn expose(
    world: &World,
    view: &View,
    shader: &dyn Shader,
    settings: &Settings,
    rows: Range<u32>,
    run: Run,
    kept: &mut Kept,
) -> Result<Exposure, RenderError> {
    let &Settings { width, samples, .. } = settings;
    let (top, height) = (rows.start, rows.end - rows.start);
    let tiles = tiles(width, rows);
    let cancelled = || run.cancel.is_some_and(|c| c.load(Ordering::Relaxed));
    let failed = AtomicUsize::new(usize::MAX);
    let before: &Kept = kept;
    let one = |eye: &mut Eye, (number, tile): (usize, &Tile)| {
        // Tiles behind the first failure are not wanted; the ones before it decide which error is told.
        if failed.load(Ordering::Relaxed) < number {
            return Err(RenderError::Cancelled);
        }
        let done = tile.expose(view, shader, settings, &before.pixels, eye, &cancelled);
        let work = eye.take_counters();
        if let Some(mut all) = run.counters.and_then(|all| all.lock().ok()) {
            *all += work;
        }
        match (&done, run.progress) {
            (Err(_), _) => _ = failed.fetch_min(number, Ordering::Relaxed),
            (Ok(pixels), Some(progress)) => progress(pixels.len() as u64 * u64::from(samples)),
            (Ok(_), None) => {}
        }
        done
    };
    let all = || {
        let eye = || Eye::new(world, settings.coherence, before.swept.as_ref(), run.watch());
        tiles.par_iter().enumerate().map_init(eye, one).collect()
    };
    let done: Vec<_> = match run.pool {
        Some(pool) => pool.install(all),
        None => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(run.pool_threads()).build();
            let pool = pool.map_err(|e| RenderError::Threads { threads: run.threads, why: e.to_string() })?;
            pool.install(all)
        }
    };
    // Before a film is made: it may be large.
    let done: Vec<Vec<Pixel>> = done.into_iter().collect::<Result<_, _>>()?;
    let mut exposure = Exposure { width, height, samples: vec![Sample::NOTHING; area(width, height)] };
    let mut still = vec![None; if kept.swept.is_some() { area(width, height) } else { 0 }];
    for (tile, pixels) in tiles.iter().zip(done) {
        tile.paste(pixels.iter().map(|p| p.sample), width, top, &mut exposure.samples);
        if kept.swept.is_some() {
            tile.paste(pixels.iter().map(|p| p.still.then_some(p.sample)), width, top, &mut still);
        }
    }
    kept.pixels = still;
    Ok(exposure)
}

fn area(width: u32, height: u32) -> usize {
    width as usize * height as usize
}

/// A pixel, and whether nothing that moves can ever change it.
struct Pixel {
    sample: Sample,
    still: bool,
}

/// A rectangle of pixels.
struct Tile {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
}

/// All tiles of some rows, row by row.
fn tiles(width: u32, rows: Range<u32>) -> Vec<Tile> {
    let end = rows.end;
    rows.step_by(TILE as usize)
        .flat_map(|top| (0..width).step_by(TILE as usize).map(move |left| (left, top)))
        .map(|(left, top)| Tile { left, top, width: TILE.min(width - left), height: TILE.min(end - top) })
        .collect()
}

impl Tile {
    fn expose(
        &self,
        view: &View,
        shader: &dyn Shader,
        settings: &Settings,
        kept: &[Option<Sample>],
        eye: &mut Eye,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<Pixel>, RenderError> {
        let &Settings { width, samples: count, look, .. } = settings;
        let mut pixels = Vec::with_capacity(area(self.width, self.height));
        for row in self.top..self.top + self.height {
            for column in self.left..self.left + self.width {
                let place = area(width, row) + column as usize;
                if let Some(sample) = kept.get(place).copied().flatten() {
                    pixels.push(Pixel { sample, still: true });
                    continue;
                }
                eye.begin_pixel();
                let mut sum = Sample::NOTHING;
                for chance in sampling::samples(column, row, count) {
                    // With soft light a sample is many rays.
                    if cancelled() {
                        return Err(RenderError::Cancelled);
                    }
                    let [x, y] = chance.place;
                    let ray = view.ray(f64::from(column) + x, f64::from(row) + y)?;
                    let seen = shader.sample(eye, &ray, &chance);
                    let seen = seen.map_err(|error| RenderError::of(look.name, error))?;
                    sum.color += seen.color;
                    sum.alpha += seen.alpha;
                }
                let share = 1.0 / f64::from(count);
                let sample = Sample { color: sum.color * share, alpha: sum.alpha * share };
                pixels.push(Pixel { sample, still: eye.is_still() });
            }
        }
        Ok(pixels)
    }

    /// Puts what belongs to the tile's pixels where it belongs in rows of a picture, of a width and from a top on.
    fn paste<T>(&self, pixels: impl Iterator<Item = T>, width: u32, top: u32, picture: &mut [T]) {
        for (i, pixel) in (0..).zip(pixels) {
            let (column, row) = (self.left + i % self.width, self.top - top + i / self.width);
            picture[area(width, row) + column as usize] = pixel;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
