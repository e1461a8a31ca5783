//! The one way in.

use std::ops::Range;

use shotline::compile::World;
use shotline::counters::{COUNTERS, Counter};
use shotline::query::batch::Run;
use shotline::scene::{Camera, Scene};

use crate::backdrop::Backdrop;
use crate::camera::View;
use crate::error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE, RenderError};
use crate::film::{self, Exposure};
use crate::framing;
use crate::image::Image;
use crate::light::Lighting;
use crate::look::{LOOKS, Look, Shader, Stage};
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
        let size = framing::subject(world).map_or(1.0, |b| b.size().max_element());
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
    with_shader(world, scene, setup, settings, |view, shader| {
        let rows = 0..settings.height;
        let exposure = film::expose(world, view, shader, settings, rows, run, kept)?;
        Ok(finish(shader, settings, exposure))
    })
}

/// What the rays of some rows of a picture have seen: so that its rows can be exposed in different places, and
/// [developed](develop) in one.
///
/// # Errors
/// [`RenderError`]; [`RenderError::Size`] for rows that are not in the picture.
pub fn expose(
    world: &World,
    scene: &Scene,
    settings: &Settings,
    rows: Range<u32>,
    run: Run,
) -> Result<Exposure, RenderError> {
    check(settings)?;
    let &Settings { width, height, .. } = settings;
    if rows.start >= rows.end || rows.end > height {
        return Err(RenderError::Size { width, height: rows.end.saturating_sub(rows.start) });
    }
    with_shader(world, scene, &Setup::new(world, scene, settings)?, settings, |view, shader| {
        film::expose(world, view, shader, settings, rows, run, &mut Kept::default())
    })
}

/// The picture of all its exposed rows: the same as [`render`] makes.
///
/// # Errors
/// [`RenderError`]; [`RenderError::Size`] for an exposure of another size than the settings'.
pub fn develop(
    world: &World,
    scene: &Scene,
    settings: &Settings,
    exposure: Exposure,
) -> Result<Image, RenderError> {
    check(settings)?;
    let Exposure { width, height, ref samples } = exposure;
    let all = width as usize * height as usize;
    if (width, height, samples.len()) != (settings.width, settings.height, all) {
        return Err(RenderError::Size { width, height });
    }
    with_shader(world, scene, &Setup::new(world, scene, settings)?, settings, |_, shader| {
        Ok(finish(shader, settings, exposure))
    })
}

/// Hands on what a look needs.
fn with_shader<T>(
    world: &World,
    scene: &Scene,
    setup: &Setup,
    settings: &Settings,
    then: impl FnOnce(&View, &dyn Shader) -> Result<T, RenderError>,
) -> Result<T, RenderError> {
    let &Settings { width, height, look, lighting, counter, .. } = settings;
    let view = View::new(&setup.camera, width, height)?;
    let (size, backdrop) = (setup.size, backdrop(settings));
    let shader = (look.shader)(&Stage { world, scene, size, view: &view, backdrop, lighting, counter })?;
    then(&view, &*shader)
}

fn finish(shader: &dyn Shader, settings: &Settings, mut exposure: Exposure) -> Image {
    shader.develop(&mut exposure);
    Image::compose(&exposure, backdrop(settings))
}

fn backdrop(settings: &Settings) -> Backdrop {
    settings.backdrop.unwrap_or(settings.look.backdrop)
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
    let framed = || framing::subject(world).and_then(|bounds| framing::frame(&bounds, aspect));
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

#[cfg(test)]
mod tests {
    use shotline::compile::{Options, compile};

    use super::*;

    /// Exposed in bands, a picture is the same, whatever the look.
    #[test]
    fn bands_make_the_same_picture() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
        scene.add_object("ball", None, ball);
        let world = compile(&scene, Options::default()).expect("a world");
        for look in LOOKS.iter().copied() {
            let settings = Settings { width: 50, height: 45, samples: 2, look, ..Settings::default() };
            let whole = render(&world, &scene, &settings, Run::default()).expect("a picture");
            let mut samples = Vec::new();
            for rows in [0..7, 7..40, 40..45] {
                let exposure = expose(&world, &scene, &settings, rows, Run::default()).expect("an exposure");
                samples.extend(exposure.samples);
            }
            let exposure = Exposure { width: 50, height: 45, samples };
            let other = develop(&world, &scene, &settings, exposure.clone()).expect("a picture");
            assert_eq!(other, whole, "{}", look.name);
            let smaller = Settings { height: 44, ..settings };
            assert!(develop(&world, &scene, &smaller, exposure).is_err());
            assert!(expose(&world, &scene, &settings, 40..46, Run::default()).is_err());
        }
    }
}
