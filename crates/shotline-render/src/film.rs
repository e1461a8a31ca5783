//! Exposing a picture: tiles over a pool of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use shotline::compile::World;
use shotline::pool;
use shotline::query::batch::Run;
use shotline::ray::Ray;

use crate::camera::View;
use crate::edges::{self, EdgesError};
use crate::error::RenderError;
use crate::exposure::{Exposure, Sample};
use crate::look::Shader;
use crate::sampling::{self, SampleNumbers};
use crate::settings::Settings;
use crate::temporal_cache::TemporalCache;
use crate::tile::{Tile, area, tiles};
use crate::tracer::{Identify, SampleRays, Tracer};
use crate::visible_part::VisiblePart;

/// The number of samples that are shaded together: some hundred kilobytes of rays and results.
const BLOCK: usize = 2048;

/// A picture to be exposed.
pub struct Film<'a> {
    pub world: &'a World,
    pub view: &'a View,
    pub shader: &'a dyn Shader,
    pub settings: &'a Settings,
    pub visible: &'a VisiblePart,
}

impl Film<'_> {
    /// Exposes rows of the picture. Each sample is computed by itself, and each pixel from its samples in a fixed order. So
    /// it does not depend on the threads, on the tiles, on the blocks, or on which rows are exposed together.
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
        let one = |tracer: &mut Tracer, (number, tile): (usize, &Tile)| {
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
            let identify = if self.settings.edges { Identify::Surfaces } else { Identify::Objects };
            let tracer =
                || Tracer::new(self.world, self.settings.coherence, swept, self.visible, identify, run);
            tiles.par_iter().enumerate().map_init(tracer, one).collect()
        };
        let exposed: Vec<_> = match run.pool {
            Some(pool) => pool.install(all),
            None => pool::on_threads(run.threads, |_| all()),
        };
        exposed.into_iter().collect()
    }

    fn expose_tile(
        &self,
        tile: &Tile,
        cached: &[Option<Sample>],
        tracer: &mut Tracer,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<Pixel>, RenderError> {
        let sample_of = |(column, row): (u32, u32)| {
            cached.get(area(self.settings.width, row) + column as usize).copied().flatten()
        };
        let missing = tile.positions().filter(|position| sample_of(*position).is_none());
        let mut exposed = self.expose_pixels(missing, tracer, cancelled)?.into_iter();
        let pixel = |position| match sample_of(position) {
            Some(sample) => Some(Pixel { sample, is_static: true }),
            None => exposed.next(),
        };
        let mut pixels: Vec<Pixel> = tile.positions().filter_map(pixel).collect();
        if self.settings.edges {
            // The lines of a pixel depend on what its neighbours see, so they are not kept for the next frame.
            for (pixel, ink) in pixels.iter_mut().zip(self.ink(tile, tracer)?) {
                pixel.sample.ink = ink;
            }
        }
        Ok(pixels)
    }

    fn ink(&self, tile: &Tile, tracer: &mut Tracer) -> Result<Vec<f64>, RenderError> {
        edges::coverage(tile, self.view, tracer).map_err(|error| match error {
            EdgesError::Camera(error) => error.into(),
            EdgesError::Cast(error) => RenderError::of(self.settings.look.name, error),
        })
    }

    /// The pixels at some positions, block by block of their samples.
    fn expose_pixels(
        &self,
        positions: impl Iterator<Item = (u32, u32)>,
        tracer: &mut Tracer,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<Pixel>, RenderError> {
        let count = self.settings.samples;
        let (mut pixels, mut block) = (Vec::new(), SampleBlock::default());
        for (column, row) in positions {
            pixels.push(Pixel { sample: Sample::NOTHING, is_static: true });
            for numbers in sampling::samples(column, row, count) {
                let [x, y] = numbers.position;
                let ray = self.view.ray(x, y)?;
                block.push(ray, numbers, pixels.len() - 1);
                if block.rays.len() == BLOCK {
                    self.add_block(&mut block, tracer, &mut pixels, cancelled)?;
                }
            }
        }
        self.add_block(&mut block, tracer, &mut pixels, cancelled)?;
        let scale = 1.0 / f64::from(count);
        for Pixel { sample, .. } in &mut pixels {
            sample.color *= scale;
            sample.alpha *= scale;
        }
        Ok(pixels)
    }

    /// Adds the samples of a block to their pixels, and empties the block.
    fn add_block(
        &self,
        block: &mut SampleBlock,
        tracer: &mut Tracer,
        pixels: &mut [Pixel],
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(), RenderError> {
        if cancelled() {
            return Err(RenderError::Cancelled);
        }
        let SampleBlock { rays, numbers, pixels: pixels_of, samples } = block;
        samples.clear();
        samples.resize(rays.len(), Sample::NOTHING);
        tracer.begin(rays.len());
        let shaded = self.shader.shade(tracer, rays, numbers, samples);
        shaded.map_err(|error| RenderError::of(self.settings.look.name, error))?;
        for (number, (sample, &pixel)) in (0..).zip(samples.iter().zip(&*pixels_of)) {
            let pixel = &mut pixels[pixel];
            pixel.sample.color += sample.color;
            pixel.sample.alpha += sample.alpha;
            pixel.is_static &= tracer.is_static(number);
        }
        rays.clear();
        numbers.clear();
        pixels_of.clear();
        Ok(())
    }
}

/// Samples that are shaded together.
#[derive(Default)]
struct SampleBlock {
    /// By sample: its ray from the camera, its random numbers and its pixel.
    rays: SampleRays,
    numbers: Vec<SampleNumbers>,
    pixels: Vec<usize>,
    samples: Vec<Sample>,
}

impl SampleBlock {
    fn push(&mut self, ray: Ray, numbers: SampleNumbers, pixel: usize) {
        self.rays.push(ray, self.rays.len() as u32);
        self.numbers.push(numbers);
        self.pixels.push(pixel);
    }
}

/// A pixel, and whether nothing that moves can ever change it.
struct Pixel {
    sample: Sample,
    is_static: bool,
}
