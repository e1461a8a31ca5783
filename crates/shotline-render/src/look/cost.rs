//! What the closest crossing of each ray costs, as a heat map with a legend.

use shotline::counters::Counter;
use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader};
use crate::backdrop::Backdrop;
use crate::film::{Exposure, Sample};
use crate::heat;
use crate::sampling::Chance;
use crate::sight::Eye;

pub(super) static LOOK: Look = Look {
    name: "cost",
    summary: "a heat map of the work that each ray takes, with a legend",
    backdrop: Backdrop::BLACK,
    local: false,
    shader: |stage| Ok(Box::new(Cost { counter: stage.counter })),
};

struct Cost {
    counter: &'static Counter,
}

impl Shader for Cost {
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        Ok(Sample::opaque(Vec3::splat((self.counter.of)(&eye.work(ray)?) as f64)))
    }

    fn develop(&self, exposure: &mut Exposure) {
        let most = heat::colour(exposure);
        let most = if most < 10.0 { format!("{most:.1}") } else { format!("{most:.0}") };
        heat::legend(exposure, &format!("{} a ray: 0 to {most}", self.counter.summary));
    }
}
