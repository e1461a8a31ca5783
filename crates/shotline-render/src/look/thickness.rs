//! The length of each ray inside objects, as a heat map with a legend.

use shotline::math::Vec3;
use shotline::query::batch::BatchError;
use shotline::scene::Units;

use super::{Look, Shader, ShaderContext};
use crate::background::Background;
use crate::exposure::{Exposure, Sample};
use crate::heat_map::{self, three_digits};
use crate::sampling::SampleNumbers;
use crate::tracer::{SampleRays, Tracer};

pub(super) static LOOK: Look = Look {
    name: "thickness",
    summary: "the length of each ray inside objects, with a legend in the scene's units",
    background: Background::BLACK,
    is_local: true,
    shows_surfaces: false,
    blends: false,
    hatches: false,
    shader: |context: &ShaderContext| Ok(Box::new(Thickness { units: context.scene.units })),
};

struct Thickness {
    units: Option<Units>,
}

impl Shader for Thickness {
    /// Each pixel holds the mean length of its rays, in world units.
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        _numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        tracer.segments(rays, |ray, segments| {
            // No scale could show a segment of infinite length, and an unbounded ground has no others: left out.
            let lengths = segments.iter().map(|s| s.length).filter(|length| length.is_finite());
            samples[ray] = Sample::opaque(Vec3::splat(lengths.sum()));
        })
    }

    fn develop(&self, exposure: &mut Exposure) {
        let max = three_digits(heat_map::apply(exposure));
        let units = self.units.map_or_else(String::new, |units| format!(" {units}"));
        heat_map::draw_legend(exposure, &format!("thickness: 0 to {max}{units}"));
    }
}
