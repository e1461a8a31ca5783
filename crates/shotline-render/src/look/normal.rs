//! Normals as colours.

use shotline::math::Vec3;
use shotline::query::QueryError;
use shotline::ray::Ray;

use super::{Look, Shader};
use crate::backdrop::Backdrop;
use crate::color;
use crate::film::{Exposure, Sample};
use crate::sampling::Chance;
use crate::sight::Eye;

pub(super) static LOOK: Look = Look {
    name: "normal",
    summary: "the unit normal on the side that is seen, (n + 1) / 2 as red, green and blue",
    backdrop: Backdrop::plain([0.5; 3]),
    local: true,
    shader: |_| Ok(Box::new(Normals)),
};

struct Normals;

impl Shader for Normals {
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        Ok(eye.surface(ray)?.map_or(Sample::NOTHING, |place| Sample::opaque(place.normal)))
    }

    /// The numbers are meant for the file, not for light: undoing the film's curve beforehand keeps them.
    fn develop(&self, exposure: &mut Exposure) {
        for s in exposure.samples.iter_mut().filter(|s| s.alpha > 0.0) {
            let written = (s.color / s.alpha + Vec3::ONE) * 0.5;
            s.color = color::linear(written.to_array()) * s.alpha;
        }
    }
}
