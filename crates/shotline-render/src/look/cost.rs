//! The cost of the closest crossing of each ray, as a heat map with a legend.

use shotline::counters::Counter;
use shotline::math::Vec3;
use shotline::query::batch::BatchError;

use super::{Look, Shader};
use crate::background::Background;
use crate::exposure::{Exposure, Sample};
use crate::heat_map;
use crate::sampling::SampleNumbers;
use crate::tracer::{SampleRays, Tracer};

pub(super) static LOOK: Look = Look {
    name: "cost",
    summary: "a heat map of the work of each ray, with a legend",
    background: Background::BLACK,
    is_local: false,
    shows_surfaces: false,
    blends: false,
    hatches: false,
    shader: |context| Ok(Box::new(Cost { counter: context.counter })),
};

struct Cost {
    counter: &'static Counter,
}

impl Shader for Cost {
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        _numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        tracer.cost(rays, |ray, work| {
            samples[ray] = Sample::opaque(Vec3::splat((self.counter.of)(&work) as f64));
        })
    }

    fn develop(&self, exposure: &mut Exposure) {
        let max = heat_map::apply(exposure);
        let max = if max < 10.0 { format!("{max:.1}") } else { format!("{max:.0}") };
        heat_map::draw_legend(exposure, &format!("{} a ray: 0 to {max}", self.counter.summary));
    }
}
