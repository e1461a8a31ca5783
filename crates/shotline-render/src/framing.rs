//! Pointing a camera at a scene that has none.

use shotline::aabb::Aabb;
use shotline::compile::World;
use shotline::math::Vec3;
use shotline::scene::{Camera, HiddenObjects, Lens, Scene};

/// The direction from the scene to the eye: in front, to the right and above, with z up.
const FROM: Vec3 = Vec3::new(0.45, -0.8, 0.5);
/// The vertical angle of view in degrees: narrow, so that perspective distorts little.
const FOV: f64 = 30.0;
/// The fraction of the picture, from its middle to its edge, that the bounds may fill.
const FILL: f64 = 0.92;

/// The box that a picture frames: the bounds of everything of finite size. `None` if there is nothing of finite size.
pub fn subject(world: &World) -> Option<Aabb> {
    Some(world.finite_bounds()).filter(|bounds| bounds.is_finite() && !bounds.is_empty())
}

/// The box that a picture frames where some objects are hidden.
pub(crate) fn visible_subject(world: &World, scene: &Scene, hidden: &HiddenObjects) -> Option<Aabb> {
    if hidden.is_empty() {
        return subject(world);
    }
    // A world without the hidden objects knows the bounds of the others. It fails to compile only if the scene does.
    subject(scene.without(hidden).compile().as_ref().unwrap_or(world))
}

/// A three-quarter view from above, z up, that holds all of a box with a small margin. The ratio is
/// the picture's width over its height. `None` if the box is empty, infinite or a point.
pub fn frame(bounds: &Aabb, ratio: f64) -> Option<Camera> {
    frame_from(bounds, ratio, FROM, Vec3::Z, Some(FOV))
}

/// A view from a direction that holds all of a box with a small margin: in perspective with an angle of view in degrees, or else in
/// parallel projection. `None` if the box is empty, infinite or a point.
pub(crate) fn frame_from(
    bounds: &Aabb,
    ratio: f64,
    from: Vec3,
    upward: Vec3,
    fov: Option<f64>,
) -> Option<Camera> {
    if !bounds.is_finite() || bounds.is_empty() || bounds.size() == Vec3::ZERO {
        return None;
    }
    let centre = bounds.centre();
    let forward = -from.normalize();
    let right = forward.cross(upward).normalize();
    let up = right.cross(forward);
    let Some(fov) = fov else {
        let half = |axis: Vec3| (bounds.size() / 2.0).dot(axis.abs());
        let height = 2.0 * half(up).max(half(right) / ratio) / FILL;
        let eye = centre - forward * bounds.size().length();
        return Some(Camera { eye, target: centre, up: upward, lens: Lens::Orthographic { height } });
    };
    let slope = (fov / 2.0).to_radians().tan() * FILL;
    let offsets = |axis: Vec3, slope: f64| eye_offsets(bounds, centre, axis, forward, slope);
    let (across, across_back) = offsets(right, slope * ratio);
    let (along, along_back) = offsets(up, slope);
    let back = across_back.max(along_back);
    let target = centre + right * across + up * along;
    Some(Camera { eye: target - forward * back, target, up: upward, lens: Lens::Pinhole { fov } })
}

/// How far along an axis the eye must move, and how far back, so that all corners are between the two opposite sides
/// of the picture along that axis.
///
/// A corner at `x` along the axis and `z` into the picture is visible from `e` along the axis and `D` back if
/// `x - slope z <= e + slope D` and `-x - slope z <= -e + slope D`: two bounds, both met with equality at once.
fn eye_offsets(bounds: &Aabb, centre: Vec3, axis: Vec3, forward: Vec3, slope: f64) -> (f64, f64) {
    let (mut high, mut low) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for corner in corners(bounds) {
        let (x, z) = ((corner - centre).dot(axis), (corner - centre).dot(forward));
        high = high.max(x - slope * z);
        low = low.max(-x - slope * z);
    }
    ((high - low) / 2.0, (high + low) / 2.0 / slope)
}

fn corners(b: &Aabb) -> impl Iterator<Item = Vec3> + use<> {
    let ends = [b.min, b.max];
    (0..8).map(move |i| Vec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::View;

    /// The position of a point in the picture: from -1 to 1 across and along it.
    fn project(view: &View, eye: Vec3, ratio: f64, p: Vec3) -> [f64; 2] {
        let half = (FOV / 2.0).to_radians().tan();
        let depth = (p - eye).dot(view.forward());
        assert!(depth > 0.0);
        [(p - eye).dot(view.right()) / depth / half / ratio, (p - eye).dot(view.up()) / depth / half]
    }

    #[test]
    fn the_whole_box_is_in_the_picture_and_fills_it() {
        let boxes = [
            Aabb::new(Vec3::ZERO, Vec3::ONE),
            Aabb::new(Vec3::new(1e6, 1e6, 1e6), Vec3::new(1e6 + 40.0, 1e6 + 1.0, 1e6 + 0.5)),
            Aabb::new(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 90.0)),
            Aabb::new(Vec3::splat(-1e-9), Vec3::splat(1e-9)),
        ];
        for bounds in boxes {
            for (width, height) in [(800, 600), (300, 900), (64, 64)] {
                let ratio = f64::from(width) / f64::from(height);
                let camera = frame(&bounds, ratio).unwrap();
                let view = View::new(&camera, width, height).unwrap();
                let projected: Vec<_> =
                    corners(&bounds).map(|p| project(&view, camera.eye, ratio, p)).collect();
                let furthest = projected.iter().flatten().fold(0.0f64, |a, x| a.max(x.abs()));
                assert!((furthest - FILL).abs() < 1e-6, "{furthest}");
            }
        }
    }

    #[test]
    fn bounds_without_a_size_have_no_camera() {
        for bounds in [Aabb::EMPTY, Aabb::EVERYTHING, Aabb::new(Vec3::ONE, Vec3::ONE)] {
            assert_eq!(frame(&bounds, 1.0), None);
        }
    }
}
