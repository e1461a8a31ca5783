//! Meshes with moved vertices have the bits of new meshes.

use std::sync::Arc;

use super::kernel::{BlockQuery, KernelMemory, Lines, RayBlock};
use super::shapes::{ball, ring};
use super::{MeshHit, MeshSolid, TriangleMesh};
use crate::accel::NAMES;
use crate::math::{Affine, Vec3};
use crate::ray::{Line, Ray, Span};
use crate::scratch::Scratch;
use crate::solid::{Solid, Wanted};
use crate::testkit::meshes::{Thin, rays_at};
use crate::testkit::random::Random;

const QUERIES: [BlockQuery; 5] =
    [BlockQuery::Nearest, BlockQuery::Any, BlockQuery::All, BlockQuery::First, BlockQuery::Within];

fn solid(mesh: &TriangleMesh, accel: &str) -> MeshSolid {
    MeshSolid::new(Arc::new(mesh.clone()), accel).expect("a mesh")
}

/// Whether two solids have trees of the same structure.
fn have_same_structure(a: &MeshSolid, b: &MeshSolid) -> bool {
    let children = |solid: &MeshSolid| {
        let nodes = &solid.index.as_wide().expect("the default index").tree.nodes;
        nodes.iter().map(|node| node.children).collect::<Vec<_>>()
    };
    children(a) == children(b)
}

/// The results of the plain path, with all their bits.
fn plain(solid: &MeshSolid, ray: &Ray) -> String {
    let (line, span, mut scratch) = (Line::of(ray), Span::FORWARD, Scratch::default());
    let (mut hits, mut all, mut first) = (Vec::new(), Vec::new(), Vec::new());
    solid.hits(&line, span, &mut hits, &mut scratch);
    solid.crossings_within(&line, span, Wanted::All, &mut all, &mut scratch);
    solid.crossings_within(&line, span, Wanted::First, &mut first, &mut scratch);
    format!("{hits:?} {:?} {all:?} {first:?}", solid.nearest(&line, span, &mut scratch))
}

/// The hits of a block, each as its row and its bits, the rows that hit something, and the rows that are left to the
/// plain path.
fn cast(solid: &MeshSolid, rays: &[Ray], query: BlockQuery) -> (Vec<(u32, String)>, Vec<u32>, Vec<u32>) {
    let row = |ray: &Ray| {
        let (o, d) = (Line::of(ray).o, Line::of(ray).d);
        [o.x, o.y, o.z, d.x, d.y, d.z]
    };
    let rows: Vec<[f64; 6]> = rays.iter().map(row).collect();
    let block = RayBlock {
        rays: &rows,
        frames: [&Affine::IDENTITY; 2],
        wants_normals: true,
        lines: Lines { rows: &rows, errors: None },
        span: Span::FORWARD,
        ends: None,
        cancel: None,
    };
    let mut memory = KernelMemory::default();
    solid.cast_block(&block, query, &mut memory);
    let hits = memory.hits().iter().map(|hit: &MeshHit| (hit.row, format!("{hit:?}"))).collect();
    let rows_hit = memory.rows_hit().map(|row| row as u32).collect();
    (hits, rows_hit, [memory.plain_rows(), memory.inside_rows()].concat())
}

/// Compares all queries. Which rays a block leaves to the plain path may depend on the tree.
fn assert_same(a: &MeshSolid, b: &MeshSolid, rays: &[Ray]) {
    assert_eq!(a.topology(), b.topology());
    assert_eq!(a.bounds(), b.bounds());
    for ray in rays {
        assert_eq!(plain(a, ray), plain(b, ray));
    }
    for query in QUERIES {
        let (of_a, of_b) = (cast(a, rays, query), cast(b, rays, query));
        let is_left = |row: u32| of_a.2.contains(&row) || of_b.2.contains(&row);
        let comparable = |(hits, rows, _): &(Vec<(u32, String)>, Vec<u32>, Vec<u32>)| {
            let mut hits: Vec<_> = hits.iter().filter(|hit| !is_left(hit.0)).cloned().collect();
            let mut rows: Vec<u32> = rows.iter().copied().filter(|row| !is_left(*row)).collect();
            hits.sort_unstable();
            rows.sort_unstable();
            (hits, rows)
        };
        assert_eq!(comparable(&of_a), comparable(&of_b), "{query:?}");
    }
}

/// Rays at vertices, edges and faces of a mesh.
fn aimed(random: &mut Random, mesh: &TriangleMesh, count: usize) -> Vec<Ray> {
    let ray = |random: &mut Random| {
        let [a, b, c] = mesh.corners(random.below(mesh.faces.len()) as u32);
        let target = [a, a * 0.5 + b * 0.5, a * 0.25 + b * 0.25 + c * 0.5][random.below(3)];
        let origin = random.point(-4.0, 4.0);
        Ray::new(origin, target - origin).expect("a ray")
    };
    (0..count).map(|_| ray(random)).collect()
}

fn moved(mesh: &TriangleMesh, by: impl FnMut(Vec3) -> Vec3) -> TriangleMesh {
    TriangleMesh { vertices: mesh.vertices.iter().copied().map(by).collect(), ..mesh.clone() }
}

#[test]
fn a_mesh_that_bends_a_little_keeps_its_tree_and_all_bits() {
    let mut random = Random::new(11);
    let bend = |v: Vec3| (v + Vec3::new(0.1 * libm::sin(3.0 * v.y), 0.0, 0.05 * v.x)) * 2.0;
    let single = |v: Vec3| Vec3::from(v.to_array().map(|x| f64::from(x as f32)));
    for mesh in [ball(4), ring(40, 30), moved(&ball(3), single)] {
        let before = solid(&mesh, "bvh");
        let mesh = moved(&mesh, bend);
        let refitted = before.with_vertices(mesh.vertices.clone()).expect("a mesh");
        assert!(have_same_structure(&before, &refitted));
        assert_same(&refitted, &solid(&mesh, "bvh"), &aimed(&mut random, &mesh, 300));
        // A second motion, back to float32.
        let mesh = moved(&mesh, single);
        let refitted = refitted.with_vertices(mesh.vertices.clone()).expect("a mesh");
        assert_same(&refitted, &solid(&mesh, "bvh"), &aimed(&mut random, &mesh, 300));
    }
}

#[test]
fn a_mesh_that_changes_beyond_recognition_is_rebuilt() {
    let mut random = Random::new(12);
    let mesh = ball(4);
    let before = solid(&mesh, "bvh");
    let torn = moved(&mesh, |_| random.point(-1.0, 1.0));
    let after = before.with_vertices(torn.vertices.clone()).expect("a mesh");
    assert!(!have_same_structure(&before, &after));
    assert_same(&after, &solid(&torn, "bvh"), &aimed(&mut random, &torn, 100));
    // Faces collapse, so there are fewer triangles.
    let flat = moved(&mesh, |v| if v.z > 0.9 { Vec3::Z } else { v });
    let after = before.with_vertices(flat.vertices.clone()).expect("a mesh");
    assert_same(&after, &solid(&flat, "bvh"), &aimed(&mut random, &flat, 100));
}

#[test]
fn every_accelerator_keeps_all_bits() {
    let mut random = Random::new(13);
    for _ in 0..20 {
        let thin = Thin::near(&mut random);
        let mesh = thin.mesh(&mut random);
        let turn = Affine::rotation_xyz(random.point(-5.0, 5.0));
        let after = moved(&mesh, |v| turn.point(v) * 1.1);
        let rays = rays_at(&mut random, &after, &thin, 40);
        let expected = solid(&after, "bvh");
        for accel in NAMES {
            let found = solid(&mesh, accel).with_vertices(after.vertices.clone()).expect("a mesh");
            for ray in &rays {
                assert_eq!(plain(&found, ray), plain(&expected, ray), "{accel}");
            }
        }
        assert_same(&solid(&mesh, "bvh").with_vertices(after.vertices).expect("a mesh"), &expected, &rays);
    }
}

#[test]
fn vertices_must_fit_the_faces() {
    let before = solid(&ball(1), "bvh");
    assert!(before.with_vertices(vec![Vec3::ZERO; 3]).is_err());
    let mut vertices = ball(1).vertices;
    vertices[0].x = f64::NAN;
    assert!(before.with_vertices(vertices).is_err());
}
