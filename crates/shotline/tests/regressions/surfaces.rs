//! Rays that lie in surfaces: in faces that solids share, along lines on quadrics, and where surfaces touch.

use super::*;

const UP: Vec3 = Vec3::Z;

fn quadric(coefficients: [f64; 10]) -> Shape {
    Shape::quadric(coefficients).unwrap()
}

/// `a x + b y + z (c x + d y) + e x^2 + f x y + g y^2 < 0`: a quadric that contains the z axis.
fn around_z([a, b, c, d, e, f, g]: [f64; 7]) -> Shape {
    quadric([e, g, 0.0, f, c, d, a, b, 0.0, 0.0])
}

fn cube(half: f64) -> Shape {
    Shape::cuboid([-half; 3], [half; 3]).unwrap()
}

fn slab(z0: f64, z1: f64) -> Shape {
    Shape::cuboid([-50.0, -50.0, z0], [50.0, 50.0, z1]).unwrap()
}

fn halfspace(normal: [f64; 3]) -> Shape {
    Shape::halfspace(normal, 0.0).unwrap()
}

/// The list of a ray from z = -3 along the z axis, which must be the same in a turned frame.
#[track_caller]
fn up_the_axis(shape: Shape) -> Vec<f64> {
    let list = seen(&shape, [0.0, 0.0, -3.0], UP);
    assert_near(&seen_turned(&shape, [0.0, 0.0, -3.0], UP), &list, 1e-8);
    list
}

/// A ray in the face that two boxes of a union share had no crossings.
#[test]
fn a_ray_in_a_shared_face_sees_no_seam() {
    let low = Shape::cuboid([0.0; 3], [1.0; 3]).unwrap();
    let high = Shape::cuboid([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]).unwrap();
    let (o, d) = ([-1.0, 0.5, 1.0], Vec3::X);
    assert_eq!(seen(&low | &high, o, d), [1.0, 2.0]);
    assert_near(&seen_turned(&(&low | &high), o, d), &[1.0, 2.0], 1e-8);
    // A face that one has alone is outside.
    assert!(seen(&low, o, d).is_empty() && seen(low & high, o, d).is_empty());
}

/// A ray along an edge where four boxes meet had none either.
#[test]
fn a_ray_along_a_shared_edge_sees_no_seam() {
    let part = |y: f64, z: f64| Shape::cuboid([0.0, y, z], [1.0, y + 1.0, z + 1.0]).unwrap();
    let parts = [part(0.0, 0.0), part(1.0, 0.0), part(0.0, 1.0), part(1.0, 1.0)];
    let (o, d) = ([-1.0, 1.0, 1.0], Vec3::X);
    assert_eq!(seen(Shape::union(parts.clone()), o, d), [1.0, 2.0]);
    assert!(seen(Shape::union(parts[..3].to_vec()), o, d).is_empty());
}

/// In a face that a mesh shares with a box or with its mirror image, a ray had no crossings in unions and false ones
/// elsewhere.
#[test]
fn a_mesh_has_no_seam_with_a_box_and_with_its_mirror_image() {
    let below = shape_of(brick([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0]));
    let above = Shape::cuboid([-1.0, -1.0, 0.0], [1.0; 3]).unwrap();
    let (o, d) = ([-3.0, 0.25, 0.0], Vec3::X);
    for other in [above, below.scale_axes([1.0, 1.0, -1.0])] {
        assert_eq!(seen(&below | &other, o, d), [2.0, 4.0]);
        assert!(seen(&below & &other, o, d).is_empty());
        assert!(seen(&below - &other, o, d).is_empty());
    }
}

/// A ray in the plane of a turned half-space, up to rounding, was taken to be certainly inside or certainly outside.
#[test]
fn a_ray_in_the_plane_of_a_turned_half_space_is_on_neither_side() {
    let turn = |shape: Shape| shape.rotate([0.0, 0.0, 30.0]);
    let (one, other) = (turn(halfspace([0.0, 1.0, 0.0])), turn(halfspace([0.0, -3.0, 0.0])));
    let ball = Shape::sphere(1.0).unwrap();
    let along = Affine::rotation_xyz(Vec3::new(0.0, 0.0, 30.0)).vector(Vec3::X);
    let from = along * -3.0;
    assert_near(&seen(&ball & (&one | &other), from, along), &[2.0, 4.0], 1e-14);
    assert!(seen(&ball & &one, from, along).is_empty());
    assert!(seen(&ball - one - other, from, along).is_empty());
}

/// Along the line where the two planes of `xy < 0` cross, the quadric has no tangent plane, and the sides of the ray
/// were judged wrongly.
#[test]
fn along_the_axis_of_two_planes_all_quarters_count() {
    let xy = |factor: f64| quadric([0.0, 0.0, 0.0, factor, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(up_the_axis(cube(1.0) & (xy(1.0) | xy(-2.0))), [2.0, 4.0]);
    assert!(up_the_axis(cube(1.0) & xy(1.0)).is_empty());
    assert!(up_the_axis(cube(1.0) - xy(1.0) - xy(-2.0)).is_empty());
}

/// A plane counted twice, `-x^2 < 0`, leaves out the plane alone; a ray in it was outside.
#[test]
fn a_plane_counted_twice_leaves_no_seam() {
    let twice = quadric([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(up_the_axis(cube(1.0) & &twice), [2.0, 4.0]);
    assert!(up_the_axis(cube(1.0) - &twice).is_empty());
}

/// At its apex a cone passes to the other side of a line on it. The whole ray was judged by one side.
#[test]
fn a_line_on_a_cone_changes_sides_at_the_apex() {
    let outside = quadric([-3.0, -3.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let beyond = halfspace([-1.0, 0.0, 1.0]);
    let (o, d) = ([-3.0, 0.0, -3.0], [1.0, 0.0, 1.0]);
    assert_eq!(seen(cube(1.0) & (outside | beyond), o, d), [2.0, 3.0]);
}

/// A rod on a plate touches it along a line, with a gap on both sides: the ray along it was inside.
#[test]
fn where_a_rod_rests_on_a_plate_there_is_a_gap() {
    let rod = Shape::cylinder(1.0, -1.0, 1.0).unwrap().translate([-1.0, 0.0, 0.0]);
    let wide = Shape::cylinder(2.0, -1.0, 1.0).unwrap().translate([-2.0, 0.0, 0.0]);
    let plate = Shape::cuboid([0.0, -3.0, -1.0], [1.0, 3.0, 1.0]).unwrap();
    let block = Shape::cuboid([-2.0, -3.0, -1.0], [0.0, 3.0, 1.0]).unwrap();
    assert!(up_the_axis(&rod | &plate).is_empty());
    // A bore that touches the face from inside leaves nothing there; a wider plug overlaps it.
    let hollow = block - &rod;
    assert!(up_the_axis(&hollow | &plate).is_empty());
    assert_eq!(up_the_axis(hollow | plate | wide), [2.0, 4.0]);
}

/// A saddle turns around a line on it. It was judged in the middle of the body, so a gap was closed or left for all of
/// it.
#[test]
fn a_saddle_closes_a_gap_until_it_has_turned_past_a_face() {
    let saddle = around_z([1.0, -3.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let (left, front) = (halfspace([0.0, 1.0, 0.0]), halfspace([-1.0, 0.0, 0.0]));
    assert_eq!(up_the_axis(slab(2.0, 5.0) & (left | &front | &saddle)), [5.0, 6.0]);
    assert!(up_the_axis(slab(2.0, 4.0) & (front | saddle)).is_empty());
}

/// A parabolic cylinder and a cone touch along a line, and the cone's curvature falls with the distance from its apex:
/// it was compared in one place only.
#[test]
fn curvatures_are_compared_where_the_ray_is() {
    let cylinder = around_z([3.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
    let cone = around_z([0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(up_the_axis(slab(1.0, 6.0) & (cylinder | cone)), [6.0, 9.0]);
}

/// In a placed quadric a coefficient that vanishes was taken for one that is zero by rounding, and a ray in its surface
/// was inside.
#[test]
fn a_ray_in_the_surface_of_a_placed_quadric_is_in_nothing() {
    let saddle = quadric([0.0, 2.0, 0.0, 0.0, -2.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    let map = Affine::from_row_major([3.0, 3.0, 0.0, -1.0, 3.0, 0.0, 3.0, 0.0, 0.0, 3.0, 3.0, 0.0]);
    let placed = saddle.transform(map);
    for t in [-4.0, 0.0, 0.5, 1.0, 2.0, 7.0] {
        let list = seen(&placed, map.point(Vec3::X * t), [3.0, 3.0, 0.0]);
        assert!(list.is_empty(), "from {t}: {list:?}");
    }
}
