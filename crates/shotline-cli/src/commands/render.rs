//! `shotline render`: a picture.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Mutex;
use std::time::Instant;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use serde_json::json;
use shotline::counters::{COUNTERS, Counter, Counters};
use shotline::query::batch::Run;

use shotline::scene::{HiddenObjects, Scene};
use shotline_io::Document;
use shotline_render::animation::MAX_FRAMES;
use shotline_render::{
    Animation, AnimationError, Background, ClipPlane, Coherence, Image, JpegError, LOOKS, Lighting, Look,
    Movie, Opacities, RenderError, Settings, animate,
};

use crate::failure::Failure;
use crate::flags::{Build, Model, Threads, parse_size, parse_whole_number};
use crate::number::parse_finite;
use crate::opacity::OpacityFlags;
use crate::picture_file::{self, PictureFormat};
use crate::progress::{self, Quiet};
use crate::shown::Shown;
use crate::viewpoint::ViewpointFlags;
use crate::{input, interrupt, output};

/// Make a picture
///
/// The camera and the lights are those of the scene. A scene without a camera gets one that frames it, and a scene
/// without lights gets automatic ones. --view, --eye, --target, --up, --fov and --zoom show it from elsewhere. The picture is bit-identical for every accelerator and number of threads.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Command {
    #[command(flatten)]
    model: Model,
    /// The picture, as PNG or JPEG, by the extension of the name; - for a PNG on standard output
    #[arg(short, long, value_name = "FILE.png|.jpg")]
    output: PathBuf,
    /// Pixels across and down
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size, allow_hyphen_values = true)]
    size: (u32, u32),
    /// What the picture shows
    #[arg(long, default_value = LOOKS[0].name, value_parser = look_names())]
    look: &'static Look,
    /// Samples per pixel; more make smoother edges
    #[arg(long, value_name = "N", default_value_t = Settings::default().samples, value_parser = parse_whole_number::<u32>, allow_negative_numbers = true)]
    samples: u32,
    /// The lighting of the look `lit`; default: sharp
    #[arg(long, value_enum)]
    lighting: Option<LightingChoice>,
    /// What the look `cost` counts; default: boxes
    #[arg(long, value_name = "NAME", value_parser = counter_names())]
    counter: Option<&'static Counter>,
    /// The background: studio, white, black, transparent or a colour #RRGGBB; default: that of the look
    #[arg(long, value_name = "COLOUR", value_parser = Background::from_str)]
    background: Option<Background>,
    /// Draw dark lines where the object, its instance, the surface, the normal or the depth changes, as in a technical
    /// drawing; for the looks lit, normal and depth
    #[arg(long)]
    edges: bool,
    /// Render this number of frames into an animated PNG: objects move as the scene's "motions" say
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)), allow_negative_numbers = true)]
    frames: Option<u32>,
    /// Frames per second
    #[arg(long, value_name = "N", default_value_t = 24, requires = "frames", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    fps: u16,
    /// Degrees by which the camera orbits its target over all frames; default: 360 if no object moves, else 0
    #[arg(long, value_name = "DEGREES", requires = "frames", value_parser = parse_finite, allow_negative_numbers = true)]
    orbit: Option<f64>,
    #[command(flatten)]
    viewpoint: ViewpointFlags,
    /// What rays reuse from earlier rays; the picture is the same
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',', default_values = ["shadows", "frames"])]
    coherence: Vec<CoherenceChoice>,
    #[command(flatten)]
    shown: Shown,
    #[command(flatten)]
    opacity: OpacityFlags,
    /// Cut the scene open: remove the points beyond a plane, x=1, y=-2, z=0, or NX,NY,NZ,D for those with N.p > D. What is cut
    /// through is drawn flat. May be given several times; what is beyond any of the planes is removed
    #[arg(long, value_name = "PLANE", value_parser = ClipPlane::from_str, allow_hyphen_values = true)]
    clip: Vec<ClipPlane>,
    /// Hatch what --clip cuts through, in the look lit: lines 8 pixels apart, which rise and fall in turn from object to object
    #[arg(long, requires = "clip")]
    hatch: bool,
    /// Print times and work as one line of JSON; rays are then cast one by one, which is slower for meshes
    #[arg(long)]
    stats: bool,
    #[command(flatten)]
    build: Build,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    quiet: Quiet,
}

const EXAMPLES: &str = "\
Examples:
  shotline render engine.json -o engine.png
  shotline render bunny.ply -o bunny.png --look xray --background white
  shotline render engine.json -o soft.png --lighting soft --samples 64
  shotline render engine.json -o top.png --view top
  shotline render engine.json -o drawing.png --view iso --edges --background white
  shotline render engine.json -o near.png --eye 3,-8,4 --target 0,0,1 --zoom 2
  shotline render bunny.ply -o turning.png --frames 72
  shotline render engine.json -o through.png --opacity 'housing*=0.3'
  shotline render detector.gdml -o inside.png --hide 'World*' --hide 'Hall*'
  shotline render detector.gdml -o cut.png --clip x=0 --clip 0,-1,0,100
  shotline render engine.json -o section.jpg --clip y=0 --hatch --edges";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LightingChoice {
    /// Sharp shadows, no noise
    Sharp,
    /// No shadows and no reflections: fast
    Plain,
    /// Lamps and sky have a size: soft shadows. Needs 32 samples or more
    Soft,
}

impl From<LightingChoice> for Lighting {
    fn from(choice: LightingChoice) -> Lighting {
        match choice {
            LightingChoice::Sharp => Lighting::Sharp,
            LightingChoice::Plain => Lighting::Plain,
            LightingChoice::Soft => Lighting::Soft,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum CoherenceChoice {
    /// Rays to a lamp first test what occluded the previous ray to it
    Shadows,
    /// Rays from the camera first test what the ray before them met; measurements show no gain
    Neighbours,
    /// Pixels that nothing moving can change are rendered once for all frames
    Frames,
    /// Rays reuse nothing
    None,
}

fn look_names() -> impl TypedValueParser<Value = &'static Look> {
    PossibleValuesParser::new(LOOKS.iter().map(|look| look.name))
        .try_map(|name| shotline_render::look(&name).ok_or("there is no such look"))
}

fn counter_names() -> impl TypedValueParser<Value = &'static Counter> {
    PossibleValuesParser::new(COUNTERS.iter().map(|counter| counter.name)).try_map(|name| {
        COUNTERS.iter().find(|counter| counter.name == name).ok_or("there is no such counter")
    })
}

impl Command {
    /// Returns an error for an option that has no effect on the look.
    fn expect_options_of_look(&self) -> Result<(), Failure> {
        let given =
            [("--lighting", self.lighting.is_some(), "lit"), ("--counter", self.counter.is_some(), "cost")];
        match given.iter().find(|(_, is_given, look)| *is_given && self.look.name != *look) {
            Some((option, _, look)) => {
                Err(Failure::new(format!("{option} is for --look {look}, not for {}", self.look.name)))
            }
            None => Ok(()),
        }
    }

    /// Returns an error for what JPEG cannot hold, before long work is done for it.
    fn expect_options_of_format(&self) -> Result<(), Failure> {
        if PictureFormat::of(&self.output) == PictureFormat::Png {
            return Ok(());
        }
        if self.frames.is_some() {
            let why = "JPEG holds a single picture, and no frames: write a PNG (.png or .apng)";
            return Err(Failure::of_file(&self.output, format!("cannot be written: {why}")));
        }
        match self.background {
            Some(Background::Transparent) => Err(picture_file::failure(&self.output, JpegError::Transparent)),
            _ => Ok(()),
        }
    }

    /// Runs the command.
    pub fn run(&self) -> Result<u8, Failure> {
        interrupt::catch();
        self.expect_options_of_look()?;
        self.expect_options_of_format()?;
        output::expect_writable(&self.output, output::PICTURE, std::slice::from_ref(&self.model.path))?;
        let mut document = input::load_with_notes(&self.model, self.quiet)?;
        let mut hidden = self.shown.hidden(&document.scene, self.quiet)?;
        if !document.scene.has_owners() {
            // No object displaces another: without the hidden ones, rays are cast in batches.
            document.scene = document.scene.without(&std::mem::take(&mut hidden));
        }
        let opacities = self.opacity.opacities(&document.scene)?;
        let settings = Settings { hidden, opacities, ..self.settings() };
        input::note_meshes_never_hit(&document, self.quiet);
        let work = Mutex::default();
        let started = Instant::now();
        interrupt::cancellable(|cancel| {
            let (width, height) = self.size;
            let pixels = u64::from(width) * u64::from(height) * u64::from(self.frames.unwrap_or(1));
            let bar = progress::bar(pixels * u64::from(self.samples), "rendering", self.quiet);
            let progress = |rays| bar.inc(rays);
            let run = Run {
                threads: self.threads.threads,
                progress: Some(&progress),
                cancel: Some(cancel),
                counters: self.stats.then_some(&work),
                ..Run::default()
            };
            match self.frames {
                None => {
                    let picture = self.picture(&document, &settings, run);
                    bar.finish_and_clear();
                    picture_file::write(&self.output, &picture?)
                }
                Some(frames) => {
                    let png = self.movie(&document, &settings, frames, run);
                    bar.finish_and_clear();
                    output::write(&self.output, &png?)
                }
            }
        })?;
        if self.stats {
            let work = work.into_inner().unwrap_or_default();
            let report = self.report(&document.scene, work, started.elapsed().as_secs_f64());
            output::print_with(&self.output, &report)?;
        }
        progress::written(&self.output, started, self.quiet);
        Ok(0)
    }

    fn picture(&self, document: &Document, settings: &Settings, run: Run) -> Result<Image, Failure> {
        let world = input::compile(document, &self.build)?;
        let picture = shotline_render::render(&world, &document.scene, settings, run);
        picture.map_err(|e| self.failure(e))
    }

    fn movie(
        &self,
        document: &Document,
        settings: &Settings,
        frames: u32,
        run: Run,
    ) -> Result<Vec<u8>, Failure> {
        let scene = document.scene.clone();
        let orbit = self.orbit.unwrap_or(if scene.motions.is_empty() { 360.0 } else { 0.0 });
        let animation = Animation { frames, orbit };
        let mut png = Vec::new();
        let (mut sink, mut movie) = (Some(&mut png), None);
        let take = |image: Image| {
            if let Some(sink) = sink.take() {
                movie = Some(Movie::new(sink, &image, frames, self.fps)?);
            }
            movie.as_mut().map_or(Ok(()), |movie| movie.add(&image))
        };
        animate(scene, self.build.options(), settings, animation, run, take)
            .and_then(|()| movie.map_or(Ok(()), Movie::finish).map_err(AnimationError::Rejected))
            .map_err(|error| match error {
                AnimationError::Render(error) => self.failure(error),
                AnimationError::Scene(errors) => Failure::new(document.diagnostics(&errors).to_string()),
                AnimationError::Frames(_) => Failure::new(error.to_string()),
                AnimationError::Rejected(error) => Failure::of_file(&self.output, error),
            })?;
        Ok(png)
    }

    fn settings(&self) -> Settings {
        let has = |choice| self.coherence.contains(&choice);
        Settings {
            width: self.size.0,
            height: self.size.1,
            samples: self.samples,
            look: self.look,
            background: self.background,
            lighting: self.lighting.unwrap_or(LightingChoice::Sharp).into(),
            counter: self.counter.unwrap_or(&COUNTERS[0]),
            edges: self.edges,
            camera: None,
            viewpoint: self.viewpoint.viewpoint(),
            coherence: Coherence {
                shadows: has(CoherenceChoice::Shadows),
                neighbours: has(CoherenceChoice::Neighbours),
                frames: has(CoherenceChoice::Frames),
            },
            clip: self.clip.clone(),
            hatch: self.hatch,
            hidden: HiddenObjects::default(),
            opacities: Opacities::default(),
        }
    }

    fn report(&self, scene: &Scene, work: Counters, seconds: f64) -> String {
        let mut line = json!({
            "threads": self.threads.count(),
            "accel": self.build.scene_accel(scene),
            "frames": self.frames.unwrap_or(1),
            "render_s": seconds,
            "seeded": work.hinted,
            "seeded_right": work.hint_hits,
        });
        for counter in COUNTERS {
            line[counter.name] = json!((counter.of)(&work));
        }
        format!("{line}\n")
    }

    fn failure(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Cancelled => Failure::Interrupted,
            RenderError::Size { .. } => Failure::new(format!("--size: {error}")),
            RenderError::Samples(_) => Failure::new(format!("--samples: {error}")),
            RenderError::Edges(_) => Failure::new(format!("--edges: {error}")),
            RenderError::Opacity(_) => Failure::new(format!("--opacity: {error}")),
            RenderError::Hatch(_) => Failure::new(format!("--hatch: {error}")),
            RenderError::Zoom(_) | RenderError::ZoomBeyondLens(_) => Failure::new(format!("--zoom: {error}")),
            error => Failure::of_input(&self.model.path, error),
        }
    }
}
