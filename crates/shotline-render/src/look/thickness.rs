//! How far each ray goes through objects, as a heat map with a legend.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;
use shotline::scene::Units;

use super::{Look, Shader, Stage};
use crate::backdrop::Backdrop;
use crate::film::{Exposure, Sample};
use crate::heat::{self, three_digits};
use crate::sampling::Chance;
use crate::sight::Eye;

pub(super) static LOOK: Look = Look {
    name: "thickness",
    summary: "how far each ray goes through objects, with a legend in the scene's units",
    backdrop: Backdrop::BLACK,
    local: true,
    shader: |stage: &Stage| Ok(Box::new(Thickness { units: stage.scene.units })),
};

struct Thickness {
    units: Option<Units>,
}

impl Shader for Thickness {
    /// Each pixel holds the mean length of its rays, in world units.
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        // A stretch without end has no length that a scale could show, and a ground has nothing else: left out.
        let lengths = eye.segments(ray)?.iter().map(|s| s.length).filter(|length| length.is_finite());
        Ok(Sample::opaque(Vec3::splat(lengths.sum())))
    }

    fn develop(&self, exposure: &mut Exposure) {
        let most = three_digits(heat::colour(exposure));
        let units = self.units.map_or_else(String::new, |units| format!(" {units}"));
        heat::legend(exposure, &format!("thickness: 0 to {most}{units}"));
    }
}
