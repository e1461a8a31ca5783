//! A radiograph.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader, Stage};
use crate::backdrop::Backdrop;
use crate::film::Sample;
use crate::finish;
use crate::sampling::Chance;
use crate::sight::Eye;

pub(super) static LOOK: Look = Look {
    name: "xray",
    summary: "a radiograph: the share of light that comes through, exp(-sum of mu times length)",
    backdrop: Backdrop::WHITE,
    local: true,
    shader: |stage| Ok(Box::new(Radiograph { mu: attenuations(stage) })),
};

/// Across the longest side of the scene, a material that does not say how much it attenuates lets
/// `exp(-DEFAULT)` through.
const DEFAULT: f64 = 3.0;

struct Radiograph {
    /// By object.
    mu: Vec<f64>,
}

impl Shader for Radiograph {
    /// Black that covers what does not come through: over white that is what does.
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        // A stretch without end lets nothing through and would hide the rest, as would a ground: left out.
        let ends = eye.segments(ray)?.iter().filter(|s| s.length.is_finite());
        let depth: f64 = ends.map(|s| self.mu[s.object as usize] * s.length).sum();
        Ok(Sample { color: Vec3::ZERO, alpha: -(-depth).exp_m1() })
    }
}

/// The attenuation of each object. Where no material of the scene has one, denser materials attenuate more;
/// what has neither gets the default.
fn attenuations(stage: &Stage) -> Vec<f64> {
    let default = DEFAULT / stage.size;
    let densest = stage.scene.materials.iter().filter_map(|(_, m)| m.density).fold(0.0, f64::max);
    let objects = 0..stage.world.object_names().len() as u32;
    objects
        .map(|object| {
            let material = finish::material(stage.world, stage.scene, object).map(|(_, m)| m);
            let mu = material.and_then(|m| m.mu);
            let by_density = || material.and_then(|m| m.density).map(|d| default * d / densest);
            // Negative or NaN numbers would brighten or blot out the picture.
            mu.or_else(by_density).filter(|mu| *mu >= 0.0).unwrap_or(default)
        })
        .collect()
}
