//! A picture on a page, which becomes finer while nothing about it changes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use shotline::query::batch::Run;
use shotline_render::{Image, Lighting, PictureInSteps, Settings};

use super::answer::Answer;
use super::question::PictureOf;
use super::viewed_scene::ShownScene;

/// How long one answer may take. The page asks nothing else meanwhile.
const STEP: Duration = Duration::from_millis(40);
/// The same for the first pass: while a view is turned, the page never asks for the rest of it.
const FIRST_STEP: Duration = Duration::from_millis(120);
/// The rows that are exposed at first, without a measurement: enough for all threads, of a small picture.
const FIRST_ROWS: u32 = 64;
/// How often an unfinished pass is shown.
const SHOW_AFTER: Duration = Duration::from_millis(250);
/// The side of a pixel in a pass between a very coarse first one and those at full size.
const BETWEEN: u32 = 3;
/// The samples of the passes at full size.
const SAMPLES: [u32; 3] = [1, 4, 16];

/// A picture in the making.
pub struct Pane {
    of: PictureOf,
    version: u64,
    shown: Arc<ShownScene>,
    settings: Settings,
    passes: Vec<Pass>,
    /// The index of the pass that is exposed.
    pass: usize,
    picture: PictureInSteps,
    begun: Instant,
    shown_at: Instant,
    /// Rows that take about a quarter of a step.
    rows_at_a_time: u32,
}

/// One exposure of a picture.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// The side of a pixel, in pixels of the finished picture.
    coarse: u32,
    samples: u32,
    lighting: Lighting,
}

impl Pane {
    /// Begins a picture with pixels of a coarse size.
    ///
    /// # Errors
    /// What is not valid about it.
    pub fn new(of: PictureOf, version: u64, shown: Arc<ShownScene>, coarse: u32) -> Result<Pane, String> {
        let settings = Settings {
            width: of.size[0],
            height: of.size[1],
            camera: Some(of.camera.camera()),
            look: of.look()?,
            counter: of.counter()?,
            clip: of.clip_planes()?,
            hidden: shown.hidden.clone(),
            ..Settings::default()
        };
        // Without shadows and reflections more of the view is seen while it is turned.
        let first = Pass { coarse: coarse.clamp(1, 16), samples: 1, lighting: Lighting::Plain };
        let lit = |coarse, samples| Pass { coarse, samples, lighting: Lighting::Sharp };
        let between = (coarse > 2 * BETWEEN).then(|| lit(BETWEEN, 1));
        let full = SAMPLES.map(|samples| lit(1, samples));
        let passes: Vec<Pass> = std::iter::once(first).chain(between).chain(full).collect();
        let picture = begin(&settings, passes[0], &shown)?;
        let now = Instant::now();
        Ok(Pane {
            of,
            version,
            shown,
            settings,
            passes,
            pass: 0,
            picture,
            begun: now,
            shown_at: now,
            rows_at_a_time: FIRST_ROWS,
        })
    }

    /// Whether it is the picture that a page asks for.
    pub fn is_of(&self, of: &PictureOf, version: u64) -> bool {
        self.of == *of && self.version == version
    }

    /// Works for one step, and answers with the picture if a pass is complete, or has taken long.
    ///
    /// # Errors
    /// Why there is no picture.
    pub fn advance(&mut self, mut head: Value) -> Result<Answer, String> {
        let begin_of_step = Instant::now();
        let ShownScene { scene, world, .. } = &*self.shown;
        let limit = if self.pass == 0 { FIRST_STEP } else { STEP };
        while !self.picture.is_complete() && begin_of_step.elapsed() < limit {
            let begin_of_rows = Instant::now();
            self.picture
                .expose(world, scene, self.rows_at_a_time, Run::default())
                .map_err(|error| error.to_string())?;
            let quarters = begin_of_rows.elapsed().as_secs_f64() / (STEP.as_secs_f64() / 4.0);
            self.rows_at_a_time =
                (f64::from(self.rows_at_a_time) / quarters.clamp(0.25, 4.0)).clamp(1.0, 4096.0) as u32;
        }
        let pass = self.passes[self.pass];
        let is_complete = self.picture.is_complete();
        let is_last = self.pass + 1 == self.passes.len();
        head["pass"] = json!(self.pass);
        head["coarse"] = json!(pass.coarse);
        head["samples"] = json!(pass.samples);
        head["ms"] = json!(self.begun.elapsed().as_secs_f64() * 1e3);
        let rows = self.settings.height.div_ceil(pass.coarse);
        head["done"] = json!(f64::from(self.picture.rows()) / f64::from(rows));
        head["is_final"] = json!(is_complete && is_last);
        if !is_complete && self.shown_at.elapsed() < SHOW_AFTER {
            return Ok(Answer::Text(head));
        }
        let image = self.picture.develop(world, scene).map_err(|error| error.to_string())?;
        head["size"] = json!([image.width(), image.height()]);
        head["rows"] = json!(self.picture.rows());
        self.shown_at = Instant::now();
        if is_complete && !is_last {
            self.pass += 1;
            self.begun = Instant::now();
            self.picture = begin(&self.settings, self.passes[self.pass], &self.shown)?;
        }
        Ok(Answer::Pixels { head, bytes: rgba(&image) })
    }
}

fn begin(settings: &Settings, pass: Pass, shown: &ShownScene) -> Result<PictureInSteps, String> {
    let settings = Settings {
        width: settings.width.div_ceil(pass.coarse),
        height: settings.height.div_ceil(pass.coarse),
        samples: pass.samples,
        lighting: pass.lighting,
        ..settings.clone()
    };
    PictureInSteps::new(shown.subject, &shown.scene, settings).map_err(|error| error.to_string())
}

/// Four bytes a pixel, as canvases take them.
fn rgba(image: &Image) -> Vec<u8> {
    let bytes = image.to_bytes();
    match image.channels() {
        4 => bytes,
        _ => bytes.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect(),
    }
}
