//! Meshes of single solids, straight from their parameters.

use std::collections::HashSet;
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use shotline::accel::DEFAULT;
use shotline::compile::World;
use shotline::prelude::*;
use shotline::query::batch::{self, BatchError, Run};
use shotline::scene::Node;
use shotline::solid::mesh::{MeshSolid, Topology, TriangleMesh};
use shotline::testkit::random::Random;
use shotline_tessellate::{Settings, TessellateError, Tessellation, tessellate};

fn made(shape: &Shape, tolerance: f64) -> Tessellation {
    let scene = Scene::of([Object::new("part", shape.clone())]);
    tessellate(&scene, &Settings::new(tolerance), Run::default(), &mut |_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

fn mesh(found: &Tessellation) -> &TriangleMesh {
    let Node::Object { node, .. } = found.scene.node(found.scene.objects[0]) else { panic!("no object") };
    let Node::Mesh { mesh, .. } = found.scene.node(*node) else { panic!("no mesh") };
    mesh
}

/// Solids of all kinds that have such meshes, with their volumes.
fn solids() -> Vec<(&'static str, Shape, f64)> {
    let cone = |r0: f64, r1: f64| PI / 3.0 * (r0 * r0 + r0 * r1 + r1 * r1);
    let walls = [[-1.0, 0.2, 1.0], [0.0, 0.2, 1.0], [0.0, 0.5, 0.8], [1.0, 0.0, 0.8]];
    let of_walls = PI * 0.96 + PI * 0.64 - cone(0.5, 0.0);
    let diamond = [[0.0, 0.0], [0.5, -0.5], [1.0, 0.0], [0.5, 0.5]];
    // By the theorem of Pappus: the area times the way of its middle.
    let of_diamond = 0.5 * 2.0 * PI * 0.5;
    vec![
        ("box", Shape::cuboid([-1.0, -0.5, 0.0], [1.0, 0.5, 0.25]).unwrap(), 0.5),
        ("sphere", Shape::sphere(1.0).unwrap(), 4.0 / 3.0 * PI),
        ("cylinder", Shape::cylinder(0.5, -1.0, 1.0).unwrap(), 0.5 * PI),
        ("cone", Shape::cone(1.0, 0.4, 0.0, 1.0).unwrap(), cone(1.0, 0.4)),
        ("apex", Shape::cone(0.0, 0.7, 0.0, 1.0).unwrap(), cone(0.0, 0.7)),
        ("torus", Shape::torus(0.8, 0.3).unwrap(), 2.0 * PI * PI * 0.8 * 0.09),
        ("tube", Shape::tube(0.4, 0.9, -0.5, 0.5).unwrap(), PI * 0.65),
        (
            "tube of an angle",
            Shape::tube_sector(0.4, 0.9, -0.5, 0.5, 30.0, 250.0).unwrap(),
            PI * 0.65 * 250.0 / 360.0,
        ),
        ("wedge", Shape::tube_sector(0.0, 0.9, -0.5, 0.5, -20.0, 40.0).unwrap(), PI * 0.81 / 9.0),
        (
            "hollow cone",
            Shape::cone_section(0.2, 0.9, 0.4, 0.4, 0.0, 1.0, 0.0, 360.0).unwrap(),
            cone(0.9, 0.4) - cone(0.2, 0.4),
        ),
        ("polycone", Shape::polycone(walls).unwrap(), of_walls),
        (
            "polycone of an angle",
            Shape::polycone_section(walls, 10.0, 200.0).unwrap(),
            of_walls * 200.0 / 360.0,
        ),
        ("revolved", Shape::revolved(diamond).unwrap(), of_diamond),
        ("revolved by an angle", Shape::revolved_section(diamond, 0.0, 90.0).unwrap(), of_diamond / 4.0),
        (
            "tetrahedron",
            Shape::tetrahedron([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).unwrap(),
            1.0 / 6.0,
        ),
    ]
}

fn two_triangles_an_edge(mesh: &TriangleMesh) -> bool {
    let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}

fn volume(mesh: &TriangleMesh) -> f64 {
    (0..mesh.faces.len() as u32).map(|face| mesh.corners(face)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// The greatest distance from a mesh of where rays cross a surface.
fn farthest(from: &World, mesh: &TriangleMesh, random: &mut Random) -> f64 {
    let rays: Vec<Ray> = (0..2000)
        .map(|_| {
            Ray::new(random.direction() * 9.0, random.point(-1.0, 1.0) - random.direction() * 9.0).unwrap()
        })
        .collect();
    let found = batch::crossings(from, &rays, Span::FORWARD, Run::default()).unwrap();
    let ray = |row: usize| found.ray_splits.partition_point(|split| *split as usize <= row) - 1;
    let rows = found.t.iter().enumerate();
    let points: Vec<[f64; 3]> = rows.map(|(row, t)| rays[ray(row)].at(*t).to_array()).collect();
    let solid = MeshSolid::new(Arc::new(mesh.clone()), DEFAULT).unwrap();
    let near = solid.closest_points(&points, 1, None, &|_| {}).unwrap();
    near.into_iter().map(|near| near.unwrap().distance).fold(0.0, f64::max)
}

#[test]
fn meshes_are_closed_within_the_tolerance_and_small() {
    let mut random = Random::new(3);
    for (name, solid, exact) in solids() {
        let turned = solid.rotate([20.0, 35.0, 50.0]).scale(2.0).scale_axes([1.0, -1.0, 1.0]);
        for (shape, volume_of_solid) in [(&solid, exact), (&turned, 8.0 * exact)] {
            for tolerance in [0.3, 0.01, 1e-4] {
                let found = made(shape, tolerance);
                let [part] = &found.parts[..] else { panic!("{name}") };
                assert!(part.deviation <= tolerance, "{name}: {}", part.deviation);
                let mesh = mesh(&found);
                // Cells would give more.
                assert!((part.triangles as f64) < 550.0 + 60.0 / tolerance, "{name}: {}", part.triangles);
                let places: HashSet<_> =
                    mesh.vertices.iter().map(|v| v.to_array().map(|x| (x + 0.0).to_bits())).collect();
                assert!(places.len() == mesh.vertices.len() && two_triangles_an_edge(mesh), "{name}");
                assert!(Topology::of(mesh).unwrap().is_closed(), "{name}");
                let error = volume(mesh) / volume_of_solid - 1.0;
                assert!(error.abs() < (20.0 * tolerance).min(0.08), "{name} within {tolerance}: {error}");
                let exact = Scene::of([Object::new("part", shape.clone())]).compile().unwrap();
                let distance = farthest(&exact, mesh, &mut random);
                assert!(distance <= part.deviation + 1e-12, "{name} within {tolerance}: {distance}");
            }
        }
    }
}

/// A wire of a detector took a second and 1,590 triangles, and a fine tolerance a minute.
#[test]
fn a_wire_has_few_triangles() {
    let wire = Shape::cylinder(0.076, -3000.0, 3000.0).unwrap();
    assert_eq!(made(&wire, 5.0).parts[0].triangles, 64);
    assert!(made(&wire, 1e-5).parts[0].triangles < 2000);
}

/// A profile that is at the axis in several places gave edges of four triangles.
#[test]
fn sectors_that_touch_the_axis_are_closed() {
    let corners = [[0.0, -1.0], [2.0, -0.2], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let found = made(&Shape::revolved_section(corners, 20.0, 250.0).unwrap(), 0.05);
    assert!(two_triangles_an_edge(mesh(&found)));
}

/// Far from the origin vertices would be rounded to one position.
#[test]
fn what_is_rounded_away_is_made_of_cells_or_refused() {
    let shape = Shape::cylinder(1e-9, 0.0, 1.0).unwrap().translate([1e8, 0.0, 0.0]);
    let scene = Scene::of([Object::new("part", shape)]);
    if let Ok(found) = tessellate(&scene, &Settings::new(1e-3), Run::default(), &mut |_| {}) {
        assert!(found.scene.objects.is_empty() || two_triangles_an_edge(mesh(&found)));
    }
}

#[test]
fn single_solids_are_cancelled() {
    let cancel = AtomicBool::new(true);
    let scene = Scene::of([Object::new("ball", Shape::sphere(1.0).unwrap())]);
    let run = Run { cancel: Some(&cancel), ..Run::default() };
    let found = tessellate(&scene, &Settings::new(0.1), run, &mut |_| {});
    assert!(matches!(found, Err(TessellateError::Batch(BatchError::Cancelled))));
}
