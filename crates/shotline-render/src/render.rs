//! The one way in.

use shotline::accel::{COUNTERS, Counter};
use shotline::compile::World;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Scene};

use crate::backdrop::Backdrop;
use crate::camera::View;
use crate::error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE, RenderError};
use crate::film;
use crate::framing;
use crate::image::Image;
use crate::light::Lighting;
use crate::look::{LOOKS, Look, Stage};
use crate::sight::Coherence;
use crate::still::Kept;

/// What picture is wanted. Threads, progress, cancelling and where work is added up are [`Run`]'s.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel: more make smoother edges.
    pub samples: u32,
    /// From where; `None` for the scene's camera, or one that frames everything.
    pub camera: Option<Camera>,
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
            camera: None,
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
    let setup = Setup::new(world, scene, settings)?;
    frame(world, scene, &setup, settings, run, &mut Kept::default())
}

/// What all frames of an animation have from the first.
pub(crate) struct Setup {
    pub camera: Camera,
    size: f64,
}

impl Setup {
    pub fn new(world: &World, scene: &Scene, settings: &Settings) -> Result<Setup, RenderError> {
        let size = framing::subject(world, scene).map_or(1.0, |b| b.size().max_element());
        let camera = match settings.camera {
            Some(camera) => camera,
            None => camera(world, scene, settings.width, settings.height)?,
        };
        Ok(Setup { camera, size })
    }
}

/// A picture of what a camera sees, with what is kept of the one before.
pub(crate) fn frame(
    world: &World,
    scene: &Scene,
    setup: &Setup,
    settings: &Settings,
    run: Run,
    kept: &mut Kept,
) -> Result<Image, RenderError> {
    let &Settings { width, height, look, .. } = settings;
    let view = View::new(&setup.camera, width, height)?;
    let backdrop = settings.backdrop.unwrap_or(look.backdrop);
    let &Settings { lighting, counter, .. } = settings;
    let shader =
        (look.shader)(&Stage { world, scene, size: setup.size, view: &view, backdrop, lighting, counter })?;
    let mut exposure = film::expose(world, &view, look, &*shader, settings, run, kept)?;
    shader.develop(&mut exposure);
    Ok(Image::compose(&exposure, backdrop))
}

/// The view of a picture: of the scene's camera, or of one that frames everything.
///
/// # Errors
/// [`RenderError`] for a camera that sees nothing, or for nothing to see.
pub fn view(world: &World, scene: &Scene, width: u32, height: u32) -> Result<View, RenderError> {
    Ok(View::new(&camera(world, scene, width, height)?, width, height)?)
}

/// The scene's camera, or one that frames everything.
fn camera(world: &World, scene: &Scene, width: u32, height: u32) -> Result<Camera, RenderError> {
    let aspect = f64::from(width) / f64::from(height);
    let framed = || framing::subject(world, scene).and_then(|bounds| framing::frame(&bounds, aspect));
    scene.camera.or_else(framed).ok_or(RenderError::NothingToFrame)
}

pub(crate) fn check(settings: &Settings) -> Result<(), RenderError> {
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
