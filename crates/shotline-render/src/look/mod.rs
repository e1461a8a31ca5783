//! Looks, that is render modes: what a picture shows of what its rays meet.
//!
//! Adding a look is one file and one line in the registry at the end of this one.

mod cost;
mod depth;
mod lit;
mod normal;
mod thickness;
mod xray;

use std::fmt;

use shotline::compile::World;
use shotline::counters::Counter;
use shotline::query::batch::BatchError;
use shotline::scene::Scene;

use crate::background::Background;
use crate::camera::View;
use crate::error::RenderError;
use crate::exposure::{Exposure, Sample};
use crate::light::Lighting;
use crate::sampling::SampleNumbers;
use crate::tracer::{SampleRays, Tracer};

/// A look, that is a render mode.
pub struct Look {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line of documentation.
    pub summary: &'static str,
    /// The background if the settings do not give one.
    pub background: Background,
    /// Whether a pixel depends only on what its rays meet. The look `cost` is not local: the cost of a ray depends on
    /// the whole accelerator, and so on everything that moves.
    pub(crate) is_local: bool,
    /// Whether a pixel shows the first surfaces that its rays meet, so that there are edges between them.
    pub shows_surfaces: bool,
    /// Whether it blends what is seen through surfaces.
    pub blends: bool,
    /// Whether it can hatch cuts.
    pub hatches: bool,
    /// Computes once what all rays need.
    pub(crate) shader: fn(&ShaderContext) -> Result<Box<dyn Shader>, RenderError>,
}

impl fmt::Debug for Look {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Look({})", self.name)
    }
}

/// The data of a picture from which a look makes its shader.
pub(crate) struct ShaderContext<'a> {
    pub world: &'a World,
    pub scene: &'a Scene,
    /// The longest side of what the picture frames; in an animation, of the first frame.
    pub size: f64,
    pub view: &'a View,
    pub background: Background,
    pub lighting: Lighting,
    /// Whether cuts are hatched.
    pub hatch: bool,
    pub counter: &'static Counter,
}

/// The shader of a look for one picture; all threads share it.
pub(crate) trait Shader: Send + Sync {
    /// Sets the sample of each ray from the camera; those that nothing is set for show the background. Ray `i` is for
    /// sample `i`, which has the random numbers `numbers[i]`.
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError>;

    /// Turns the samples into linear colours, for looks that need the whole picture for that.
    fn develop(&self, _exposure: &mut Exposure) {}
}

/// Declares the registry.
macro_rules! registry {
    ($($module:ident),* $(,)?) => {
        /// Every look, the default first.
        pub static LOOKS: &[&Look] = &[$(&$module::LOOK),*];
    };
}

registry!(lit, normal, depth, thickness, xray, cost);

/// The look with a name.
pub fn look(name: &str) -> Option<&'static Look> {
    LOOKS.iter().find(|l| l.name == name).copied()
}
