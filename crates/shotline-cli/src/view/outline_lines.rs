//! The outlines of what a ray meets, as lines in world coordinates.

use std::f64::consts::TAU;

use shotline::aabb::Aabb;
use shotline::math::{Affine, Vec3};
use shotline::outline::Outline;

/// The corners of the polygon that is drawn for a circle.
const CORNERS: u32 = 32;

/// A line through points.
pub type Polyline = Vec<Vec3>;

/// The lines that show an outline. A plane is shown where it cuts `bounds`, the box of the whole scene; an infinite box is cut off
/// there. No lines if nothing of it can be shown.
pub fn lines(outline: &Outline, world_from_frame: &Affine, bounds: &Aabb) -> Vec<Polyline> {
    let local = match (outline, bounds_in_frame(bounds, world_from_frame)) {
        (Outline::Box(b), around) => box_lines(b, around),
        (&Outline::Sphere { centre, radius }, _) => sphere_lines(centre, radius),
        (&Outline::Plane { normal, height }, Some(around)) => plane_lines(normal, height, &around),
        (Outline::Plane { .. }, None) => Vec::new(),
    };
    let to_world =
        |line: Polyline| -> Polyline { line.into_iter().map(|p| world_from_frame.point(p)).collect() };
    local.into_iter().map(to_world).filter(|line| line.iter().all(|p| p.is_finite())).collect()
}

/// A box around a box of the world, in a frame.
fn bounds_in_frame(bounds: &Aabb, world_from_frame: &Affine) -> Option<Aabb> {
    let frame_from_world = world_from_frame.inverse().ok()?;
    if bounds.is_empty() || !bounds.is_finite() {
        return None;
    }
    let corners = corners(bounds).map(|p| frame_from_world.point(p));
    Some(corners.iter().fold(Aabb::EMPTY, |all, &p| all.union(&Aabb::new(p, p))))
}

/// The corners; the number of each has a bit for each axis.
fn corners(b: &Aabb) -> [Vec3; 8] {
    let ends = [b.min, b.max];
    std::array::from_fn(|i| Vec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
}

fn box_lines(b: &Aabb, around: Option<Aabb>) -> Vec<Polyline> {
    let b = match around {
        Some(around) if !b.is_finite() => Aabb::new(b.min.max(around.min), b.max.min(around.max)),
        _ => *b,
    };
    if b.is_empty() {
        return Vec::new();
    }
    let corner = corners(&b);
    let ring = |numbers: [usize; 5]| numbers.map(|i| corner[i]).to_vec();
    let mut lines = vec![ring([0, 1, 3, 2, 0]), ring([4, 5, 7, 6, 4])];
    lines.extend((0..4).map(|i| vec![corner[i], corner[i + 4]]));
    lines
}

/// A circle about each axis.
fn sphere_lines(centre: Vec3, radius: f64) -> Vec<Polyline> {
    let circle = |u: Vec3, v: Vec3| {
        let at = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
            centre + (u * cos + v * sin) * radius
        };
        (0..=CORNERS).map(at).collect()
    };
    vec![circle(Vec3::X, Vec3::Y), circle(Vec3::Y, Vec3::Z), circle(Vec3::Z, Vec3::X)]
}

/// The polygon in which a plane cuts a box.
fn plane_lines(normal: Vec3, height: f64, b: &Aabb) -> Vec<Polyline> {
    let corner = corners(b);
    let mut points = Vec::new();
    for (i, &p) in corner.iter().enumerate() {
        for axis in [1, 2, 4] {
            let q = corner[i | axis];
            let (from, to) = (normal.dot(p) - height, normal.dot(q) - height);
            if i & axis == 0 && (from < 0.0) != (to < 0.0) {
                points.push(p + (q - p) * (from / (from - to)));
            }
        }
    }
    if points.len() < 3 {
        return Vec::new();
    }
    let middle = points.iter().sum::<Vec3>() / points.len() as f64;
    let u = normal.any_orthogonal_vector();
    let v = normal.cross(u);
    let angle = |p: &Vec3| (*p - middle).dot(v).atan2((*p - middle).dot(u) * normal.length());
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points.push(points[0]);
    vec![points]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Aabb = Aabb { min: Vec3::new(-1.0, -2.0, -3.0), max: Vec3::new(1.0, 2.0, 3.0) };

    #[test]
    fn a_box_has_twelve_edges() {
        let shift = Affine::translation(Vec3::X * 10.0);
        let lines = lines(&Outline::Box(BOUNDS), &shift, &BOUNDS);
        let edges: Vec<f64> =
            lines.iter().flat_map(|line| line.windows(2).map(|ends| (ends[1] - ends[0]).length())).collect();
        assert_eq!((edges.len(), edges.iter().sum::<f64>()), (12, 48.0));
        assert!(lines.iter().flatten().all(|p| p.x >= 9.0));
    }

    #[test]
    fn a_plane_is_the_polygon_in_which_it_cuts_the_scene() {
        let cut = |normal, height| lines(&Outline::Plane { normal, height }, &Affine::IDENTITY, &BOUNDS);
        let across = cut(Vec3::X, 0.5);
        assert_eq!(across[0].len(), 5);
        let sides: f64 = across[0].windows(2).map(|ends| (ends[1] - ends[0]).length()).sum();
        assert!((sides - 20.0).abs() < 1e-12 && across[0].iter().all(|p| p.x == 0.5));
        let oblique = &cut(Vec3::new(1.0, 1.0, 0.0), 0.0)[0];
        assert!(oblique.len() == 5 && oblique.iter().all(|p| (p.x + p.y).abs() < 1e-12));
        assert!(cut(Vec3::X, 2.0).is_empty());
    }

    #[test]
    fn what_is_infinite_is_cut_off_at_the_scene() {
        let slab = Aabb::new(Vec3::new(f64::NEG_INFINITY, 0.0, 0.0), Vec3::new(f64::INFINITY, 1.0, 1.0));
        let drawn = lines(&Outline::Box(slab), &Affine::IDENTITY, &BOUNDS);
        assert!(drawn.len() == 6 && drawn.iter().flatten().all(|p| p.x.abs() == 1.0));
        assert!(lines(&Outline::Box(slab), &Affine::IDENTITY, &Aabb::EVERYTHING).is_empty());
    }

    #[test]
    fn a_sphere_is_three_circles() {
        let centre = Vec3::new(1.0, 2.0, 3.0);
        let circles = lines(&Outline::Sphere { centre, radius: 2.0 }, &Affine::IDENTITY, &BOUNDS);
        assert_eq!(circles.len(), 3);
        assert!(circles.iter().flatten().all(|p| ((*p - centre).length() - 2.0).abs() < 1e-12));
    }
}
