//! Meshes: what their vertices, shells and thin walls once did to their lists, and what checking and welding missed.

use std::sync::Arc;

use shotline::query::batch::{self, Run};
use shotline::solid::mesh::{MeshSolid, Topology, Weld};

use super::*;

/// The size of a mesh was taken from all its vertices, so one far vertex made every triangle a sliver without hits.
#[test]
fn far_vertices_do_not_hide_a_mesh() {
    for odd in [Vec3::X * 1e16, Vec3::splat(1e30), Vec3::NAN, Vec3::INFINITY] {
        let mut mesh = tetrahedron();
        mesh.vertices.push(odd);
        assert_eq!(Topology::of(&mesh).unwrap().unused_vertices.count, 1);
        let list = seen(shape_of(mesh), [0.25, 0.25, -1.0], Vec3::Z);
        assert_eq!(list, [1.0, 1.5], "beside {odd}");
    }
}

/// A shell of size 1e14 in the same mesh hid a near one for the same reason.
#[test]
fn far_shells_do_not_hide_a_near_one() {
    let far = brick([1e15, -1e14, -1e14], [1.1e15, 1e14, 1e14]);
    let list = seen(shape_of(shells([tetrahedron(), far])), [0.25, 0.25, -1.0], Vec3::Z);
    assert_eq!(list, [1.0, 1.5]);
}

/// `closest` and `any` took a wall that lies wholly behind the ray for a solid in which the ray begins, and returned t
/// = 0.
#[test]
fn a_thin_wall_behind_the_ray_is_not_where_it_begins() {
    let floor = brick([0.0; 3], [1.0, 1.0, 1e-4]);
    let post = brick([0.0, 0.0, 0.25], [0.125, 0.125, 0.5]);
    let tray = shape_of(shells([floor, post]));
    assert!(seen(&tray, [0.5, 0.5, 1.5e-4], Vec3::Z).is_empty());
    assert_eq!(seen(&tray, [0.0625, 0.0625, 0.125], Vec3::Z), [0.125, 0.375]);
}

/// In a mesh far from the origin this happened in any gap, however thick the walls.
#[test]
fn walls_behind_the_ray_do_not_count_far_from_the_origin() {
    let wall = |x: f64| brick([1e4 + x, 1e4, 1e4], [1e4 + x + 0.5, 1e4 + 1.0, 1e4 + 1.0]);
    let walls = shape_of(shells([wall(0.0), wall(1.0)]));
    let middle = [1e4 + 0.75, 1e4 + 0.5, 1e4 + 0.25];
    assert_eq!(seen(&walls, middle, Vec3::X), [0.25, 0.75]);
    assert!(seen(&walls, [1e4 + 1.75, 1e4 + 0.5, 1e4 + 0.25], Vec3::X).is_empty());
}

/// The bounds of hits on a thin plate far from the origin were wider than the plate, and both hits vanished.
#[test]
fn thin_walls_far_from_the_origin_are_kept() {
    let far = f64::from(1 << 20);
    let plate = brick([far, far, far], [far + 1.0, far + 1.0, far + 1.0 / 1024.0 / 1024.0]);
    let list = seen(shape_of(plate), [far + 0.25, far + 0.5, far - 1.0], Vec3::Z);
    assert_eq!(list, [1.0, 1.0 + 1.0 / 1024.0 / 1024.0]);
}

/// The normal of a needle was computed from a product of its edges in which all digits cancel.
#[test]
fn normals_of_needles_are_accurate() {
    // In the plane x + 2 y + 3 z = 0, through the origin; 10^9 long and of twice the area sqrt(14) / 3 of a unit.
    let place = |a: f64, b: f64| Vec3::new(3.0 * a, 3.0 * b, -a - 2.0 * b);
    let n = f64::from(1 << 28);
    let corners = [Vec3::ZERO, place(n + 1.0, n), place(n, n - 1.0)];
    let world = world_of(Shape::mesh(corners, [[0, 1, 2]]).unwrap());
    let up = ray([2.0 * n + 1.0, 2.0 * n - 1.0, -4.0 * n], Vec3::Z);
    let hit = Caster::new(&world).closest(&up, Span::FORWARD).unwrap().unwrap();
    let truth = Vec3::new(1.0, 2.0, 3.0) / f64::sqrt(14.0);
    assert!((hit.normal.dot(truth).signum() * hit.normal - truth).length() < 1e-15, "{hit:?}");
}

/// Nothing reported that the faces of a sheet given from both sides cancel, and that no ray ever hits it.
#[test]
fn faces_that_cancel_are_reported() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y];
    let sheet = Arc::new(TriangleMesh::new(corners, vec![[0, 1, 2], [2, 1, 0]]));
    let winding = MeshSolid::new(sheet.clone(), "bvh").unwrap().winding().unwrap();
    assert_eq!((winding.cancelling.count, winding.can_be_hit), (2, false));
    assert!(seen(Shape::triangles(sheet).unwrap(), [0.75, 0.25, -1.0], Vec3::Z).is_empty());
    let solid = MeshSolid::new(Arc::new(tetrahedron()), "bvh").unwrap().winding().unwrap();
    assert_eq!((solid.cancelling.count, solid.can_be_hit), (0, true));
}

/// A mesh was reported as wound inward by the sign of its volume, even if only one of its shells is.
#[test]
fn a_mesh_with_one_shell_turned_is_not_wound_inward() {
    let mut turned = brick([5.0; 3], [8.0; 3]);
    turned.faces.iter_mut().for_each(|face| face.swap(1, 2));
    let both = shells([brick([0.0; 3], [1.0; 3]), turned]);
    assert_eq!(Topology::of(&both).unwrap().signed_volume, 1.0 - 27.0);
    let winding = MeshSolid::new(Arc::new(both), "bvh").unwrap().winding().unwrap();
    assert_eq!((winding.negative.count, winding.consistent), (12, false));
}

/// `auto` merged all vertices up to a part of the size of the mesh: thin plates far from the origin became flat.
#[test]
fn auto_welding_flattens_no_thin_plate() {
    let far = 1e5;
    let plate = brick([far; 3], [far + 1.0, far + 1.0, far + 1e-8]);
    let (welded, report) = plate.welded(Weld::Auto).unwrap();
    assert_eq!((report.merged, report.collapsed, welded), (0, 0, plate));
}

/// Vertices that CAD writes as 0 here and as 2.7e-17 there left the mesh open, and nothing could close it.
#[test]
fn auto_welding_closes_what_rounding_left_open() {
    let mut mesh = tetrahedron();
    mesh.vertices.push(Vec3::new(2.7e-17, 0.0, 1.0));
    mesh.faces[1] = [0, 1, 4];
    assert!(!Topology::of(&mesh).unwrap().is_closed());
    let (welded, report) = mesh.welded(Weld::Auto).unwrap();
    assert!(report.merged == 1 && Topology::of(&welded).unwrap().is_closed(), "{report:?}");
}

/// A vertex went to the first that stays within the distance, not to the nearest.
#[test]
fn welded_vertices_go_to_the_nearest_that_stays() {
    let corners = [[0.0, 0.0], [0.75, 0.0], [1.25, 0.0], [0.0, 9.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 3], [1, 2, 3]]);
    let (welded, report) = mesh.welded(Weld::Within(1.0)).unwrap();
    assert_eq!((report.merged, report.farthest, report.collapsed), (1, 0.5, 1));
    assert_eq!(welded.corners(0), [corners[0], corners[2], corners[3]]);
}

/// Corners that are closer than the least number times the size of the mesh become one when the mesh is scaled. A batch of
/// rays at a mesh of which no triangle is left panicked.
#[test]
fn a_mesh_whose_triangles_vanish_has_no_hits() {
    let vertices = vec![Vec3::ZERO, Vec3::X * f64::from_bits(1), Vec3::Y * 1e308];
    let mesh = TriangleMesh { vertices, faces: vec![[0, 1, 2]], ..TriangleMesh::default() };
    let world = world_of(shape_of(mesh));
    let rays = vec![[0.0, 0.0, -1.0, 0.0, 0.0, 1.0]; 5000];
    let rays = batch::RowsOfSix(&rays);
    assert!(
        batch::closest(&world, &rays, Span::FORWARD, Run::default())
            .unwrap()
            .t
            .iter()
            .all(|t| t.is_infinite())
    );
    assert!(batch::any(&world, &rays, Span::FORWARD, Run::default()).unwrap().iter().all(|is_hit| !is_hit));
    assert!(batch::crossings(&world, &rays, Span::FORWARD, Run::default()).unwrap().t.is_empty());
}
