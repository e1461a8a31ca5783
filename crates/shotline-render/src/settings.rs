//! The settings of a picture.

use shotline::counters::{COUNTERS, Counter};
use shotline::scene::{Camera, HiddenObjects};

use crate::background::Background;
use crate::clip_plane::ClipPlane;
use crate::error::{MAX_PIXELS, MAX_SAMPLES, MAX_SIDE, RenderError};
use crate::light::Lighting;
use crate::look::{LOOKS, Look};
use crate::opacity::Opacities;
use crate::tracer::Coherence;
use crate::viewpoint::Viewpoint;

/// The settings of a picture. The number of threads, progress, cancelling and the sum of the work belong to
/// [`Run`](shotline::query::batch::Run).
#[derive(Clone, Debug)]
pub struct Settings {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples per pixel: more samples make smoother edges.
    pub samples: u32,
    /// The camera; `None` for the scene's camera, or for one that frames everything if the scene has none.
    pub camera: Option<Camera>,
    /// Changes to the camera.
    pub viewpoint: Viewpoint,
    /// What the picture shows.
    pub look: &'static Look,
    /// The background; `None` for the default of the look.
    pub background: Option<Background>,
    /// The lighting of the look `lit`.
    pub lighting: Lighting,
    /// What the look `cost` counts.
    pub counter: &'static Counter,
    /// Whether edges are drawn as dark lines, 1.5 pixels wide.
    pub edges: bool,
    /// What rays reuse from earlier rays.
    pub coherence: Coherence,
    /// The planes that cut the scene open.
    pub clip: Vec<ClipPlane>,
    /// Whether what planes cut through is hatched, in the look `lit`.
    pub hatch: bool,
    /// The objects that are not shown. They still displace the objects around them.
    pub hidden: HiddenObjects,
    /// The objects that are seen through, in the looks `lit` and `normal`. They cast no shadows.
    pub opacities: Opacities,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            width: 800,
            height: 600,
            samples: 4,
            camera: None,
            viewpoint: Viewpoint::default(),
            look: LOOKS[0],
            background: None,
            lighting: Lighting::Sharp,
            counter: &COUNTERS[0],
            edges: false,
            coherence: Coherence::default(),
            clip: Vec::new(),
            hatch: false,
            hidden: HiddenObjects::default(),
            opacities: Opacities::default(),
        }
    }
}

impl Settings {
    /// The background of the picture: that of the settings, or else that of the look.
    pub(crate) fn effective_background(&self) -> Background {
        self.background.unwrap_or(self.look.background)
    }

    /// Checks the size, the number of samples, and what the look can show.
    ///
    /// # Errors
    /// [`RenderError`].
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let &Settings { width, height, samples, .. } = self;
        let sides = 1..=MAX_SIDE;
        let pixels = u64::from(width) * u64::from(height);
        if !sides.contains(&width) || !sides.contains(&height) || pixels > MAX_PIXELS {
            return Err(RenderError::Size { width, height });
        }
        if !(1..=MAX_SAMPLES).contains(&samples) {
            return Err(RenderError::Samples(samples));
        }
        if self.edges && !self.look.shows_surfaces {
            return Err(RenderError::Edges(self.look.name));
        }
        if self.hatch && self.clip.is_empty() {
            return Err(RenderError::NothingToHatch);
        }
        if self.hatch && !self.look.hatches {
            return Err(RenderError::Hatch(self.look.name));
        }
        if !self.opacities.is_opaque() && !self.look.blends {
            return Err(RenderError::Opacity(self.look.name));
        }
        Ok(())
    }
}
