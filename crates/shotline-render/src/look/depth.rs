//! Depth as grey.

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
    name: "depth",
    summary: "distance from the plane of the eye, from near (white) to far (dark grey)",
    backdrop: Backdrop::BLACK,
    local: true,
    shader: |_| Ok(Box::new(Depth)),
};

/// The grey of the furthest surface, as sRGB: apart from the backdrop.
const FAR_GREY: f64 = 0.12;

struct Depth;

impl Shader for Depth {
    /// The camera's rays go one unit deep each step of `t`.
    fn sample(&self, eye: &mut Eye, ray: &Ray, _chance: &Chance) -> Result<Sample, QueryError> {
        Ok(eye.surface(ray)?.map_or(Sample::NOTHING, |place| Sample::opaque(Vec3::splat(place.hit.t))))
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

/// 1 at the nearest depth, dark at the furthest, and even in 1 / depth between: a plane then shades evenly
/// across the picture, and a ground without end does not take all the greys for its horizon.
fn grey(depth: f64, near: f64, far: f64) -> f64 {
    // An eye that touches something has a near depth of zero, which would leave no grey for the rest.
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
