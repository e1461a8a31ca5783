//! Rays along the axes, evenly spread over a box.

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::ray::Ray;

/// The i-th ray along an axis through a box. The points follow the additive sequence of the plastic number
/// (M. Roberts, 2018). It has no rows, which could coincide with rows of a model.
pub fn axis_ray(bounds: &Aabb, axis: usize, i: u32) -> Option<Ray> {
    const STEPS: [f64; 2] = [0.7548776662466927, 0.5698402909980532];
    let size = bounds.size();
    let mut origin = bounds.min;
    for (k, step) in STEPS.iter().enumerate() {
        let across = (axis + 1 + k) % 3;
        origin[across] += size[across] * (0.5 + step * f64::from(i)).fract();
    }
    origin[axis] -= size[axis].max(f64::MIN_POSITIVE);
    let mut direction = Vec3::ZERO;
    direction[axis] = 1.0;
    Ray::new(origin, direction).ok()
}
