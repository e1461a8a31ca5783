//! Normals as colours.

use shotline::math::Vec3;
use shotline::query::batch::BatchError;

use super::{Look, Shader};
use crate::background::Background;
use crate::color;
use crate::exposure::{Exposure, Sample};
use crate::sampling::SampleNumbers;
use crate::tracer::{SampleRays, Tracer};

pub(super) static LOOK: Look = Look {
    name: "normal",
    summary: "the unit normal on the visible side, (n + 1) / 2 as red, green and blue",
    background: Background::plain([0.5; 3]),
    is_local: true,
    shows_surfaces: true,
    blends: true,
    hatches: false,
    shader: |_| Ok(Box::new(Normals)),
};

struct Normals;

impl Shader for Normals {
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        _numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        for point in tracer.layers(rays)? {
            samples[point.ray].add(point.normal, point.weight);
        }
        Ok(())
    }

    /// The values are meant for the file and not for light: decoding sRGB here undoes the encoding of the image.
    fn develop(&self, exposure: &mut Exposure) {
        for s in exposure.samples.iter_mut().filter(|s| s.alpha > 0.0) {
            let encoded = (s.color / s.alpha + Vec3::ONE) * 0.5;
            s.color = color::linear(encoded.to_array()) * s.alpha;
        }
    }
}
