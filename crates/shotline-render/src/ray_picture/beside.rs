//! Where to stand to see a ray in full.

use shotline::aabb::Aabb;
use shotline::math::Vec3;
use shotline::ray::{Ray, Span};
use shotline::scene::{Camera, Lens};

use crate::camera::unit;
use crate::framing;

/// The direction from which a scene is seen if the ray allows it: in front, to the right and above.
const FROM: Vec3 = Vec3::new(1.0, -1.0, 1.0);

/// The camera beside a ray: it looks across the ray, as nearly as that allows from the direction of the isometric view, in parallel
/// projection, and holds a box. `None` if the box is empty, infinite or a point.
pub fn camera_beside(ray: &Ray, bounds: &Aabb, ratio: f64) -> Option<Camera> {
    let along = unit(ray.direction())?;
    let across = |from: Vec3| from - along * from.dot(along);
    // A ray towards the eye would be a point: then from the front.
    let from = Some(across(FROM.normalize())).filter(|from| from.length() > 0.1).unwrap_or(across(-Vec3::Y));
    let from = unit(from)?;
    let up = if from.z.abs() > 0.99 { Vec3::Y } else { Vec3::Z };
    framing::frame_from(bounds, ratio, from, up, None)
}

/// The part of a span in which a ray can be in the picture of a camera in parallel projection.
pub fn span_in_picture(ray: &Ray, span: Span, camera: &Camera, ratio: f64) -> Option<[f64; 2]> {
    let Lens::Orthographic { height } = camera.lens else { return None };
    let length = ray.direction().length();
    let nearest = (camera.target - ray.origin()).dot(ray.direction()) / length / length;
    let reach = height * (1.0 + ratio) / length;
    let (from, to) = (span.t_min().max(nearest - reach), span.t_max().min(nearest + reach));
    (from < to).then_some([from, to])
}
