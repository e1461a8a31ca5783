//! Exposing a picture: tiles over a pool of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use shotline::compile::World;
use shotline::query::batch::Run;

use crate::camera::View;
use crate::error::RenderError;
use crate::exposure::{Exposure, Sample};
use crate::look::Shader;
use crate::sampling;
use crate::settings::Settings;
use crate::temporal_cache::TemporalCache;
use crate::tracer::PixelTracer;

/// The side of a tile in pixels: small enough that rays of one tile mostly meet the same objects.
const TILE: u32 = 32;

/// A picture to be exposed.
pub struct Film<'a> {
    pub world: &'a World,
    pub view: &'a View,
    pub shader: &'a dyn Shader,
    pub settings: &'a Settings,
}

impl Film<'_> {
    /// Exposes rows of the picture. Each pixel is computed by itself, from its samples in a fixed order. So it does
    /// not depend on the threads, on the tiles, or on which rows are exposed together.
    pub fn expose(
        &self,
        rows: Range<u32>,
        run: Run,
        cache: &mut TemporalCache,
    ) -> Result<Exposure, RenderError> {
        let width = self.settings.width;
        let (top, height) = (rows.start, rows.end - rows.start);
        let tiles = tiles(width, rows);
        let exposed = self.expose_tiles(&tiles, run, cache)?;
        let mut exposure = Exposure { width, height, samples: vec![Sample::NOTHING; area(width, height)] };
        let mut unchanging = vec![None; if cache.swept.is_some() { area(width, height) } else { 0 }];
        for (tile, pixels) in tiles.iter().zip(exposed) {
            tile.paste(pixels.iter().map(|p| p.sample), width, top, &mut exposure.samples);
            if cache.swept.is_some() {
                let kept = pixels.iter().map(|p| p.is_static.then_some(p.sample));
                tile.paste(kept, width, top, &mut unchanging);
            }
        }
        cache.pixels = unchanging;
        Ok(exposure)
    }

    /// The pixels of each tile. The error is that of the first tile that fails.
    fn expose_tiles(
        &self,
        tiles: &[Tile],
        run: Run,
        cache: &TemporalCache,
    ) -> Result<Vec<Vec<Pixel>>, RenderError> {
        let samples = u64::from(self.settings.samples);
        let cancelled = || run.cancel.is_some_and(|c| c.load(Ordering::Relaxed));
        let failed = AtomicUsize::new(usize::MAX);
        let one = |tracer: &mut PixelTracer, (number, tile): (usize, &Tile)| {
            // Tiles after the first failure are not needed; the tiles before it decide which error is reported.
            if failed.load(Ordering::Relaxed) < number {
                return Err(RenderError::Cancelled);
            }
            let exposed = self.expose_tile(tile, &cache.pixels, tracer, &cancelled);
            let work = tracer.take_counters();
            if let Some(mut all) = run.counters.and_then(|all| all.lock().ok()) {
                *all += work;
            }
            match (&exposed, run.progress) {
                (Err(_), _) => _ = failed.fetch_min(number, Ordering::Relaxed),
                (Ok(pixels), Some(progress)) => progress(pixels.len() as u64 * samples),
                (Ok(_), None) => {}
            }
            exposed
        };
        let all = || {
            let swept = cache.swept.as_ref();
            let tracer = || PixelTracer::new(self.world, self.settings.coherence, swept, run.watch());
            tiles.par_iter().enumerate().map_init(tracer, one).collect()
        };
        let exposed: Vec<_> = match run.pool {
            Some(pool) => pool.install(all),
            None => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(run.pool_threads()).build();
                let pool =
                    pool.map_err(|e| RenderError::Threads { threads: run.threads, why: e.to_string() })?;
                pool.install(all)
            }
        };
        exposed.into_iter().collect()
    }

    fn expose_tile(
        &self,
        tile: &Tile,
        cached: &[Option<Sample>],
        tracer: &mut PixelTracer,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<Pixel>, RenderError> {
        let mut pixels = Vec::with_capacity(area(tile.width, tile.height));
        for row in tile.top..tile.top + tile.height {
            for column in tile.left..tile.left + tile.width {
                let index = area(self.settings.width, row) + column as usize;
                if let Some(sample) = cached.get(index).copied().flatten() {
                    pixels.push(Pixel { sample, is_static: true });
                    continue;
                }
                tracer.begin_pixel();
                let sample = self.mean_of_samples(column, row, tracer, cancelled)?;
                pixels.push(Pixel { sample, is_static: tracer.is_static() });
            }
        }
        Ok(pixels)
    }

    fn mean_of_samples(
        &self,
        column: u32,
        row: u32,
        tracer: &mut PixelTracer,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Sample, RenderError> {
        let &Settings { samples: count, look, .. } = self.settings;
        let mut sum = Sample::NOTHING;
        for numbers in sampling::samples(column, row, count) {
            // Tested for every sample, which is many rays with soft light.
            if cancelled() {
                return Err(RenderError::Cancelled);
            }
            let [x, y] = numbers.pixel;
            let ray = self.view.ray(f64::from(column) + x, f64::from(row) + y)?;
            let sample = self.shader.sample(tracer, &ray, &numbers);
            let sample = sample.map_err(|error| RenderError::of(look.name, error))?;
            sum.color += sample.color;
            sum.alpha += sample.alpha;
        }
        let scale = 1.0 / f64::from(count);
        Ok(Sample { color: sum.color * scale, alpha: sum.alpha * scale })
    }
}

fn area(width: u32, height: u32) -> usize {
    width as usize * height as usize
}

/// A pixel, and whether nothing that moves can ever change it.
struct Pixel {
    sample: Sample,
    is_static: bool,
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
    /// Copies a value for each pixel of the tile into rows of a picture of a width, the first of which is row `top`.
    fn paste<T>(&self, pixels: impl Iterator<Item = T>, width: u32, top: u32, picture: &mut [T]) {
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
