//! The cost of the closest crossing of each ray, as a heat map with a legend.

use shotline::counters::Counter;
use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader};
use crate::background::Background;
use crate::exposure::{Exposure, Sample};
use crate::heat_map;
use crate::sampling::SampleNumbers;
use crate::tracer::PixelTracer;

pub(super) static LOOK: Look = Look {
    name: "cost",
    summary: "a heat map of the work of each ray, with a legend",
    background: Background::BLACK,
    is_local: false,
    shader: |context| Ok(Box::new(Cost { counter: context.counter })),
};

struct Cost {
    counter: &'static Counter,
}

impl Shader for Cost {
    fn sample(
        &self,
        tracer: &mut PixelTracer,
        ray: &Ray,
        _numbers: &SampleNumbers,
    ) -> Result<Sample, QueryError> {
        Ok(Sample::opaque(Vec3::splat((self.counter.of)(&tracer.closest_work(ray)?) as f64)))
    }

    fn develop(&self, exposure: &mut Exposure) {
        let max = heat_map::apply(exposure);
        let max = if max < 10.0 { format!("{max:.1}") } else { format!("{max:.0}") };
        heat_map::draw_legend(exposure, &format!("{} a ray: 0 to {max}", self.counter.summary));
    }
}
