//! Looks: what a picture shows of what its rays meet.
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
use shotline::query::QueryError;
use shotline::ray::Ray;
use shotline::scene::Scene;

use crate::backdrop::Backdrop;
use crate::camera::View;
use crate::error::RenderError;
use crate::film::{Exposure, Sample};
use crate::light::Lighting;
use crate::sampling::Chance;
use crate::sight::Eye;

/// A look.
pub struct Look {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line of documentation.
    pub summary: &'static str,
    /// What is behind everything if the settings do not say.
    pub backdrop: Backdrop,
    /// Whether a pixel depends on nothing but what its rays meet. What a ray costs depends on the whole accelerator, and
    /// so on everything that moves.
    pub(crate) local: bool,
    /// Works out once what all rays need.
    pub(crate) shader: fn(&Stage) -> Result<Box<dyn Shader>, RenderError>,
}

impl fmt::Debug for Look {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Look({})", self.name)
    }
}

/// What a look is told about the picture.
pub(crate) struct Stage<'a> {
    pub world: &'a World,
    pub scene: &'a Scene,
    /// How large what is seen is: in an animation, at its beginning.
    pub size: f64,
    pub view: &'a View,
    pub backdrop: Backdrop,
    pub lighting: Lighting,
    pub counter: &'static Counter,
}

/// A look at work on one picture; shared by all threads.
pub(crate) trait Shader: Send + Sync {
    /// What a ray sees.
    fn sample(&self, eye: &mut Eye, ray: &Ray, chance: &Chance) -> Result<Sample, QueryError>;

    /// Turns what has been seen into linear colours, where that takes the whole picture.
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

/// The look of a name.
pub fn look(name: &str) -> Option<&'static Look> {
    LOOKS.iter().find(|l| l.name == name).copied()
}
