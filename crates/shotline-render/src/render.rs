//! Making a picture: [`render`], or [`expose`] and [`develop`] for its two steps.

use std::ops::Range;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Scene};

use crate::camera::View;
use crate::edges;
use crate::error::RenderError;
use crate::exposure::Exposure;
use crate::film::Film;
use crate::framing;
use crate::image::Image;
use crate::look::{Shader, ShaderContext};
use crate::settings::Settings;
use crate::temporal_cache::TemporalCache;
use crate::viewpoint::Viewpoint;
use crate::visible_part::VisiblePart;

/// Makes a picture of a world, with the materials, camera and lights of the scene it was compiled from.
/// A scene without a camera gets one that frames it, and a scene without lights gets automatic ones.
///
/// # Errors
/// [`RenderError`].
pub fn render(world: &World, scene: &Scene, settings: &Settings, run: Run) -> Result<Image, RenderError> {
    settings.check()?;
    let setup = Setup::new(world, scene, settings)?;
    render_frame(world, scene, &setup, settings, run, &mut TemporalCache::default())
}

/// What is computed once for all frames of an animation, or for all steps of a picture.
pub(crate) struct Setup {
    pub camera: Camera,
    size: f64,
    visible: VisiblePart,
}

impl Setup {
    pub fn new(world: &World, scene: &Scene, settings: &Settings) -> Result<Setup, RenderError> {
        Setup::of(framing::visible_subject(world, scene, &settings.hidden), scene, settings)
    }

    /// The setup of a picture of a box.
    pub fn of(subject: Option<Aabb>, scene: &Scene, settings: &Settings) -> Result<Setup, RenderError> {
        let size = subject.map_or(1.0, |b| b.size().max_element());
        let ratio = f64::from(settings.width) / f64::from(settings.height);
        let camera = settings.viewpoint.camera(settings.camera.or(scene.camera), subject, ratio)?;
        Ok(Setup {
            camera,
            size,
            visible: VisiblePart::new(scene, &settings.hidden, &settings.clip, &settings.opacities),
        })
    }
}

/// Renders a frame and reuses what the cache has of the frame before.
pub(crate) fn render_frame(
    world: &World,
    scene: &Scene,
    setup: &Setup,
    settings: &Settings,
    run: Run,
    cache: &mut TemporalCache,
) -> Result<Image, RenderError> {
    with_shader(world, scene, setup, settings, |view, shader| {
        let exposure = Film { world, view, shader, settings, visible: &setup.visible }.expose(
            0..settings.height,
            run,
            cache,
        )?;
        Ok(compose(shader, settings, exposure))
    })
}

/// Exposes some rows of a picture. So its rows can be exposed on different machines and [developed](develop) on one.
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
    settings.check()?;
    let &Settings { width, height, .. } = settings;
    if rows.start >= rows.end || rows.end > height {
        return Err(RenderError::Size { width, height: rows.end.saturating_sub(rows.start) });
    }
    expose_rows(world, scene, &Setup::new(world, scene, settings)?, settings, rows, run)
}

/// Exposes some rows of a picture that has been set up.
pub(crate) fn expose_rows(
    world: &World,
    scene: &Scene,
    setup: &Setup,
    settings: &Settings,
    rows: Range<u32>,
    run: Run,
) -> Result<Exposure, RenderError> {
    with_shader(world, scene, setup, settings, |view, shader| {
        Film { world, view, shader, settings, visible: &setup.visible }.expose(
            rows,
            run,
            &mut TemporalCache::default(),
        )
    })
}

/// Makes the picture from all its exposed rows: the same picture as [`render`] makes.
///
/// # Errors
/// [`RenderError`]; [`RenderError::Size`] for an exposure of another size than the settings'.
pub fn develop(
    world: &World,
    scene: &Scene,
    settings: &Settings,
    exposure: Exposure,
) -> Result<Image, RenderError> {
    settings.check()?;
    let Exposure { width, height, ref samples } = exposure;
    let pixels = width as usize * height as usize;
    if (width, height, samples.len()) != (settings.width, settings.height, pixels) {
        return Err(RenderError::Size { width, height });
    }
    with_shader(world, scene, &Setup::new(world, scene, settings)?, settings, |_, shader| {
        Ok(compose(shader, settings, exposure))
    })
}

/// Calls a function with the view and the shader of a picture.
pub(crate) fn with_shader<T>(
    world: &World,
    scene: &Scene,
    setup: &Setup,
    settings: &Settings,
    then: impl FnOnce(&View, &dyn Shader) -> Result<T, RenderError>,
) -> Result<T, RenderError> {
    let &Settings { width, height, look, lighting, counter, hatch, .. } = settings;
    let view = View::new(&setup.camera, width, height)?;
    let (size, background) = (setup.size, settings.effective_background());
    let context = ShaderContext { world, scene, size, view: &view, background, lighting, hatch, counter };
    let shader = (look.shader)(&context)?;
    then(&view, &*shader)
}

/// Turns an exposure into a picture.
pub(crate) fn compose(shader: &dyn Shader, settings: &Settings, mut exposure: Exposure) -> Image {
    shader.develop(&mut exposure);
    edges::draw(&mut exposure);
    Image::compose(&exposure, settings.effective_background())
}

/// The view of a picture: that of the scene's camera, or of a camera that frames everything.
///
/// # Errors
/// [`RenderError`] if the camera is not valid, or if there is neither a camera nor anything to frame.
pub fn view(world: &World, scene: &Scene, width: u32, height: u32) -> Result<View, RenderError> {
    let ratio = f64::from(width) / f64::from(height);
    let camera = Viewpoint::default().camera(scene.camera, framing::subject(world), ratio)?;
    Ok(View::new(&camera, width, height)?)
}

#[cfg(test)]
mod tests {
    use shotline::compile::{Options, compile};

    use super::*;
    use crate::look::LOOKS;

    /// In every look, a picture that is exposed in bands is the same as one exposed at once.
    #[test]
    fn bands_make_the_same_picture() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
        scene.add_object("ball", None, ball);
        let world = compile(&scene, Options::default()).expect("a world");
        for look in LOOKS.iter().copied() {
            let settings = Settings { width: 50, height: 45, samples: 2, look, ..Settings::default() };
            let expected = render(&world, &scene, &settings, Run::default()).expect("a picture");
            let mut samples = Vec::new();
            for rows in [0..7, 7..40, 40..45] {
                let exposure = expose(&world, &scene, &settings, rows, Run::default()).expect("an exposure");
                samples.extend(exposure.samples);
            }
            let exposure = Exposure { width: 50, height: 45, samples };
            let developed = develop(&world, &scene, &settings, exposure.clone()).expect("a picture");
            assert_eq!(developed, expected, "{}", look.name);
            let smaller = Settings { height: 44, ..settings.clone() };
            assert!(develop(&world, &scene, &smaller, exposure).is_err());
            assert!(expose(&world, &scene, &settings, 40..46, Run::default()).is_err());
        }
    }
}
