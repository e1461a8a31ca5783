//! Depth as grey.

use shotline::math::Vec3;
use shotline::query::batch::BatchError;

use super::{Look, Shader};
use crate::background::Background;
use crate::color;
use crate::exposure::{Exposure, Sample};
use crate::sampling::SampleNumbers;
use crate::tracer::{SampleRays, Tracer};

pub(super) static LOOK: Look = Look {
    name: "depth",
    summary: "distance from the plane of the eye, from near (white) to far (dark grey)",
    background: Background::BLACK,
    is_local: true,
    shows_surfaces: true,
    blends: false,
    hatches: false,
    shader: |_| Ok(Box::new(Depth)),
};

/// The grey of the furthest surface, as sRGB: distinct from the background.
const FAR_GREY: f64 = 0.12;

struct Depth;

impl Shader for Depth {
    /// `t` of a camera ray is the depth, see [`View::ray`](crate::camera::View::ray).
    fn shade(
        &self,
        tracer: &mut Tracer,
        rays: &SampleRays,
        _numbers: &[SampleNumbers],
        samples: &mut [Sample],
    ) -> Result<(), BatchError> {
        for point in tracer.surfaces(rays)? {
            samples[point.ray] = Sample::opaque(Vec3::splat(point.t));
        }
        Ok(())
    }

    fn develop(&self, exposure: &mut Exposure) {
        let depths = || exposure.samples.iter().filter(|s| s.alpha > 0.0).map(|s| s.color.x / s.alpha);
        let (near, far) = depths().fold((f64::INFINITY, 0.0f64), |(n, f), d| (n.min(d), f.max(d)));
        for s in exposure.samples.iter_mut().filter(|s| s.alpha > 0.0) {
            let grey = grey(s.color.x / s.alpha, near, far);
            s.color = Vec3::splat(color::decode(grey)) * s.alpha;
        }
    }
}

/// The grey of a depth: 1 at the nearest, [`FAR_GREY`] at the furthest, and linear in 1 / depth between. So the shade
/// of a plane is linear across the picture, and the horizon of an unbounded ground does not use up all greys.
fn grey(depth: f64, near: f64, far: f64) -> f64 {
    // A camera that touches a surface has a nearest depth of zero, which would leave no greys for the rest.
    let near = near.max(far * 1e-3);
    if depth <= near || far <= near {
        return 1.0;
    }
    let closeness = (near / depth) * ((far - depth) / (far - near));
    FAR_GREY + (1.0 - FAR_GREY) * closeness.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_white_and_far_is_dark() {
        assert_eq!(grey(2.0, 2.0, 10.0), 1.0);
        assert_eq!(grey(10.0, 2.0, 10.0), FAR_GREY);
        assert!(grey(3.0, 2.0, 10.0) > grey(4.0, 2.0, 10.0));
        assert_eq!(grey(5.0, 5.0, 5.0), 1.0);
        assert!(grey(5.0, 0.0, 5.0).is_finite());
    }
}
