//! A radiograph.

use shotline::math::Vec3;
use shotline::query::batch::BatchError;

use super::{Look, Shader, ShaderContext};
use crate::background::Background;
use crate::exposure::Sample;
use crate::sampling::SampleNumbers;
use crate::surface_material;
use crate::tracer::{SampleRays, Tracer};

pub(super) static LOOK: Look = Look {
    name: "xray",
    summary: "a radiograph: the transmitted fraction of light, exp(-sum of mu times length)",
    background: Background::WHITE,
    is_local: true,
    shows_surfaces: false,
    blends: false,
    hatches: false,
    shader: |context| Ok(Box::new(Radiograph { mu: attenuations(context) })),
};

/// The transmission of a material without an attenuation is `exp(-DEFAULT)` over the longest side of the scene.
const DEFAULT: f64 = 3.0;

struct Radiograph {
    /// The attenuation of each object, per unit of length.
    mu: Vec<f64>,
}

impl Shader for Radiograph {
    /// Black, with the absorbed fraction as alpha: over white this shows the transmission.
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        _numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        tracer.segments(rays, |ray, segments| {
            // A segment of infinite length, as of an unbounded ground, transmits nothing and would hide the rest: left
            // out.
            let finite = segments.iter().filter(|s| s.length.is_finite());
            let depth: f64 = finite.map(|s| self.mu[s.object as usize] * s.length).sum();
            samples[ray] = Sample { color: Vec3::ZERO, alpha: -(-depth).exp_m1(), ink: 0.0 };
        })
    }
}

/// The attenuation of each object. A material without one gets the default times its density over the highest density
/// of the scene. A material without either, and an object without a material, gets the default.
fn attenuations(context: &ShaderContext) -> Vec<f64> {
    let default = DEFAULT / context.size;
    let densest = context.scene.materials.iter().filter_map(|(_, m)| m.density).fold(0.0, f64::max);
    let objects = 0..context.world.object_names().len() as u32;
    objects
        .map(|object| {
            let material = surface_material::material(context.world, context.scene, object).map(|(_, m)| m);
            let mu = material.and_then(|m| m.mu);
            let by_density = || material.and_then(|m| m.density).map(|d| default * d / densest);
            // Negative or NaN values would brighten the picture or make it NaN.
            mu.or_else(by_density).filter(|mu| *mu >= 0.0).unwrap_or(default)
        })
        .collect()
}
