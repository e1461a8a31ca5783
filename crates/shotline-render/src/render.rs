//! The one way in.

use shotline::accel::{COUNTERS, Counter};
use shotline::compile::World;
use shotline::query::batch::Run;
use shotline::scene::Scene;

use crate::backdrop::Backdrop;
use crate::camera::View;
use crate::error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE, RenderError};
use crate::film;
use crate::framing;
use crate::image::Image;
use crate::light::Lighting;
use crate::look::{LOOKS, Look, Stage};
use crate::sight::Coherence;

/// What picture is wanted. Threads, progress, cancelling and where work is added up are [`Run`]'s.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel: more make smoother edges.
    pub samples: u32,
    /// What it shows.
    pub look: &'static Look,
    /// What is behind everything; `None` for the look's own.
    pub backdrop: Option<Backdrop>,
    /// How light falls in the look `lit`.
    pub lighting: Lighting,
    /// What the look `cost` counts.
    pub counter: &'static Counter,
    /// What rays take over from those before them.
    pub coherence: Coherence,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            width: 800,
            height: 600,
            samples: 4,
            look: LOOKS[0],
            backdrop: None,
            lighting: Lighting::Sharp,
            counter: &COUNTERS[0],
            coherence: Coherence::default(),
        }
    }
}

/// Makes a picture of a world, with the materials, camera and lights of the scene it was compiled from.
/// A scene without a camera is framed, one without lights is lit.
///
/// # Errors
/// [`RenderError`].
pub fn render(world: &World, scene: &Scene, settings: &Settings, run: Run) -> Result<Image, RenderError> {
    check(settings)?;
    let &Settings { width, height, look, .. } = settings;
    let view = view(world, scene, width, height)?;
    let backdrop = settings.backdrop.unwrap_or(look.backdrop);
    let &Settings { lighting, counter, .. } = settings;
    let shader = (look.shader)(&Stage { world, scene, view: &view, backdrop, lighting, counter })?;
    let mut exposure = film::expose(world, &view, look, &*shader, settings, run)?;
    shader.develop(&mut exposure);
    Ok(Image::compose(&exposure, backdrop))
}

/// The view of a picture: of the scene's camera, or of one that frames everything.
///
/// # Errors
/// [`RenderError`] for a camera that sees nothing, or for nothing to see.
pub fn view(world: &World, scene: &Scene, width: u32, height: u32) -> Result<View, RenderError> {
    let camera = match &scene.camera {
        Some(camera) => camera.clone(),
        None => framing::subject(world, scene)
            .and_then(|bounds| framing::frame(&bounds, f64::from(width) / f64::from(height)))
            .ok_or(RenderError::NothingToFrame)?,
    };
    Ok(View::new(&camera, width, height)?)
}

fn check(settings: &Settings) -> Result<(), RenderError> {
    let &Settings { width, height, samples, .. } = settings;
    let side = 1..=MAX_SIDE;
    if !side.contains(&width) || !side.contains(&height) || u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        return Err(RenderError::Size { width, height });
    }
    if !(1..=MAX_SAMPLES).contains(&samples) {
        return Err(RenderError::Samples(samples));
    }
    Ok(())
}
