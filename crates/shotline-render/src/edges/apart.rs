//! Whether an edge runs between two rays that are close together.

use shotline::ray::Ray;

use crate::tracer::SurfacePoint;

/// The cosine of the angle between the normals of one surface from which on there is an edge: 20 degrees.
const CREASE: f64 = 0.939_692_620_785_908_4;
/// The same for two surfaces: 4 degrees. Where surfaces go on in each other, as a box stacked on a box or a rod in its
/// fillet, there is no edge.
const SEAM: f64 = 0.997_564_050_259_824_2;
/// By how many times a step in depth must exceed what the slope of the surface explains. Where a quadric begins to be seen, its
/// slope explains half of the step.
const STEP: f64 = 4.0;

/// What a ray of the picture sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub ray: Ray,
    pub point: Option<SurfacePoint>,
}

/// Whether an edge is between two rays. Curved surfaces are apart only if the rays are: the nearer the rays are, the less the
/// normal and the depth of a surface change between them, but what changes at an edge stays.
pub(super) fn are_apart(a: &Sight, b: &Sight) -> bool {
    let (Some(p), Some(q)) = (&a.point, &b.point) else { return a.point.is_some() != b.point.is_some() };
    if (p.object, p.path, p.is_cut) != (q.object, q.path, q.is_cut) {
        return true;
    }
    let limit = if p.surface == q.surface { CREASE } else { SEAM };
    p.normal.dot(q.normal) < limit || is_step(a, p, b, q)
}

/// Whether the depth changes by more than the slope at either point explains.
fn is_step(a: &Sight, p: &SurfacePoint, b: &Sight, q: &SurfacePoint) -> bool {
    let near = p.t.min(q.t);
    let spacing = a.ray.at(near).distance(b.ray.at(near));
    let explained = change_in_plane(a, p, &b.ray).min(change_in_plane(b, q, &a.ray));
    (p.t - q.t).abs() > STEP * (explained + spacing)
}

/// By how much the depth of the tangent plane at a point changes from its ray to another one.
fn change_in_plane(sight: &Sight, point: &SurfacePoint, other: &Ray) -> f64 {
    let height = point.normal.dot(other.at(point.t) - sight.ray.at(point.t));
    (height / point.normal.dot(other.direction())).abs()
}
