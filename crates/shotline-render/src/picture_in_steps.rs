//! A picture that is made some rows at a time, for programs that show it while it is made.

use std::ops::Range;

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::query::batch::Run;
use shotline::scene::{Camera, HiddenObjects, Scene};

use crate::error::RenderError;
use crate::exposure::{Exposure, Sample};
use crate::framing;
use crate::image::Image;
use crate::render::{Setup, compose, expose_rows, with_shader};
use crate::settings::Settings;

/// The box around what a picture shows, which sets its scale: the bounds of everything of finite size that is not hidden.
/// `None` if there is nothing of finite size.
pub fn visible_subject(world: &World, scene: &Scene, hidden: &HiddenObjects) -> Option<Aabb> {
    framing::visible_subject(world, scene, hidden)
}

/// The camera of a picture: that of the settings or of the scene, changed by their viewpoint, or one that frames the subject.
///
/// # Errors
/// [`RenderError::NothingToFrame`] without a camera and a subject, [`RenderError::Zoom`].
pub fn camera_of(subject: Option<Aabb>, scene: &Scene, settings: &Settings) -> Result<Camera, RenderError> {
    Ok(Setup::of(subject, scene, settings)?.camera)
}

/// A picture, the upper rows of which are exposed. When all are, it is the picture that [`render`](crate::render()) makes.
pub struct PictureInSteps {
    settings: Settings,
    setup: Setup,
    /// The mean sample of each exposed pixel, row by row from the top.
    samples: Vec<Sample>,
}

impl PictureInSteps {
    /// Begins a picture of a scene, of which the [`visible_subject`] is given.
    ///
    /// # Errors
    /// [`RenderError`]: a size, a number of samples or a camera that is not valid.
    pub fn new(
        subject: Option<Aabb>,
        scene: &Scene,
        settings: Settings,
    ) -> Result<PictureInSteps, RenderError> {
        settings.check()?;
        let setup = Setup::of(subject, scene, &settings)?;
        Ok(PictureInSteps { settings, setup, samples: Vec::new() })
    }

    /// The number of rows that are exposed.
    pub fn rows(&self) -> u32 {
        (self.samples.len() / self.settings.width as usize) as u32
    }

    /// Whether all rows are exposed.
    pub fn is_complete(&self) -> bool {
        self.rows() == self.settings.height
    }

    /// Exposes the next rows, at most `count` of them. The world and the scene are the same for all rows.
    ///
    /// # Errors
    /// [`RenderError`]. Then no row is added.
    pub fn expose(&mut self, world: &World, scene: &Scene, count: u32, run: Run) -> Result<(), RenderError> {
        let first = self.rows();
        let rows: Range<u32> = first..first.saturating_add(count).min(self.settings.height);
        if rows.is_empty() {
            return Ok(());
        }
        let exposure = expose_rows(world, scene, &self.setup, &self.settings, rows, run)?;
        self.samples.extend(exposure.samples);
        Ok(())
    }

    /// The picture, with the background where it is not exposed yet.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn develop(&self, world: &World, scene: &Scene) -> Result<Image, RenderError> {
        let Settings { width, height, .. } = self.settings;
        let mut samples = self.samples.clone();
        samples.resize(width as usize * height as usize, Sample::NOTHING);
        let exposure = Exposure { width, height, samples };
        with_shader(world, scene, &self.setup, &self.settings, |_, shader| {
            Ok(compose(shader, &self.settings, exposure))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::LOOKS;

    #[test]
    fn steps_make_the_picture_that_is_rendered_at_once() {
        let mut scene = Scene::default();
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
        scene.add_object("ball", None, ball);
        let world = scene.compile().expect("a world");
        let subject = visible_subject(&world, &scene, &HiddenObjects::default());
        for look in LOOKS.iter().copied() {
            let settings = Settings { width: 40, height: 35, samples: 2, look, ..Settings::default() };
            let expected = crate::render(&world, &scene, &settings, Run::default()).expect("a picture");
            let mut picture = PictureInSteps::new(subject, &scene, settings).expect("settings");
            for (count, rows) in [(3, 3), (0, 3), (20, 23), (u32::MAX, 35), (5, 35)] {
                assert!(!picture.is_complete() || count == 5);
                picture.expose(&world, &scene, count, Run::default()).expect("rows");
                assert_eq!(picture.rows(), rows);
            }
            assert_eq!(picture.develop(&world, &scene).expect("a picture"), expected, "{}", look.name);
        }
    }
}
