//! Meshes of solids: closed, within the tolerance, with the right volume.

use std::sync::Arc;

use shotline::accel::DEFAULT;
use shotline::compile::World;
use shotline::prelude::*;
use shotline::query::batch::{self, Run};
use shotline::scene::Node;
use shotline::solid::mesh::{MeshSolid, Topology, TriangleMesh};
use shotline::testkit::random::Random;
use shotline_tessellate::{Settings, TessellateError, Tessellation, tessellate};

fn made(scene: &Scene, tolerance: f64) -> Tessellation {
    tessellate(scene, &Settings::new(tolerance), Run::default(), &mut |_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

fn mesh<'s>(scene: &'s Scene, name: &str) -> &'s TriangleMesh {
    let found = scene.nodes.iter().rev().find_map(|node| match node {
        Node::Object { name: of_node, node, .. } if of_node == name => match scene.node(*node) {
            Node::Mesh { mesh, .. } => Some(&**mesh),
            _ => None,
        },
        _ => None,
    });
    found.unwrap_or_else(|| panic!("no mesh {name}"))
}

fn volume(mesh: &TriangleMesh) -> f64 {
    (0..mesh.faces.len() as u32).map(|face| mesh.corners(face)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Rays in random directions through a ball.
fn rays(random: &mut Random, count: usize, radius: f64) -> Vec<Ray> {
    (0..count)
        .map(|_| Ray::new(random.direction() * 3.0 * radius, random.point(-radius, radius)).unwrap())
        .collect()
}

/// Whether two lists are the same but for crossings that are in one only because they graze the surface.
fn differing(exact: &World, meshes: &World, rays: &[Ray], tolerance: f64) -> usize {
    let cast = |world| batch::crossings(world, &rays, Span::FORWARD, Run::default()).unwrap();
    let (a, b) = (cast(exact), cast(meshes));
    let differs = |i: usize| {
        let rows = |splits: &[i64]| splits[i] as usize..splits[i + 1] as usize;
        let (of_a, of_b) = (rows(&a.ray_splits), rows(&b.ray_splits));
        let length = rays[i].direction().length();
        of_a.len() != of_b.len()
            || of_a.zip(of_b).any(|(x, y)| {
                let cosine = Vec3::from(a.normal[x]).dot(rays[i].direction() / length).abs();
                (a.t[x] - b.t[y]).abs() * length * cosine > 1.5 * tolerance
            })
    };
    (0..rays.len()).filter(|i| differs(*i)).count()
}

fn turned(shape: Shape) -> Shape {
    shape.rotate([20.0, 35.0, 50.0])
}

/// The same shape as a combination, so that its mesh is made of cells.
fn in_cells(shape: Shape) -> Shape {
    shape & Shape::cuboid([-50.0; 3], [50.0; 3]).unwrap()
}

fn parts() -> Vec<(&'static str, Shape)> {
    let ball = |radius| Shape::sphere(radius).unwrap();
    let block = Shape::cuboid([-1.0, -1.0, -0.5], [1.0, 1.0, 0.5]).unwrap();
    let bore = Shape::cylinder(0.4, -2.0, 2.0).unwrap();
    let ring = Shape::torus(0.9, 0.3).unwrap();
    vec![
        ("ball", in_cells(ball(1.0))),
        ("block", in_cells(turned(block.clone()))),
        ("drilled", turned(&block - &bore)),
        ("ring", in_cells(turned(ring))),
        ("lens", ball(1.2).translate([0.0, 0.0, 0.7]) & ball(1.2).translate([0.0, 0.0, -0.7])),
        ("pair", Shape::group([ball(0.5).translate([-0.3, 0.0, 0.0]), ball(0.5).translate([0.3, 0.0, 0.0])])),
    ]
}

#[test]
fn meshes_are_closed_and_within_the_tolerance() {
    let mut random = Random::new(3);
    for (name, shape) in parts() {
        let scene = Scene::of([Object::new(name, shape)]);
        let exact = scene.compile().unwrap();
        let tolerance = 0.02;
        let found = made(&scene, tolerance);
        let [part] = &found.parts[..] else { panic!("{name}") };
        assert!(part.object == name && part.deviation <= tolerance);
        let mesh = mesh(&found.scene, name);
        assert_eq!(mesh.faces.len(), part.triangles);
        assert!(Topology::of(mesh).unwrap().is_closed(), "{name}");
        let meshes = found.scene.compile().unwrap();
        // Of the union, where instances overlap.
        if name != "pair" {
            let rays = rays(&mut random, 2000, 1.0);
            let wrong = differing(&exact, &meshes, &rays, tolerance);
            assert!(
                wrong <= 40,
                "{name}: {wrong} of {} rays differ, {} triangles",
                rays.len(),
                part.triangles
            );
        }
    }
}

#[test]
fn volumes_are_those_of_the_solids() {
    let pi = std::f64::consts::PI;
    let exact =
        [("ball", 4.0 / 3.0 * pi, 4.0 * pi), ("block", 4.0, 16.0), ("drilled", 4.0 - 0.16 * pi, 18.0)];
    let shapes = parts();
    for (name, volume_of_solid, area) in exact {
        let shape = shapes.iter().find(|(of_part, _)| *of_part == name).unwrap().1.clone();
        let found = made(&Scene::of([Object::new(name, shape)]), 0.01);
        let error = (volume(mesh(&found.scene, name)) - volume_of_solid).abs();
        assert!(error < 0.01 * area, "{name}: {error}");
    }
}

#[test]
fn corners_and_edges_of_planes_are_exact() {
    let (_, block) = parts().swap_remove(1);
    let found = made(&Scene::of([Object::new("block", block.clone())]), 0.02);
    let error = (volume(mesh(&found.scene, "block")) - 4.0).abs();
    assert!(error < 1e-9, "{error}, {:?}", found.parts);
}

#[test]
fn objects_keep_their_names_materials_and_meshes() {
    let sheet = Shape::mesh([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]).unwrap();
    let scene = Scene::of([
        Object::new("ball", Shape::sphere(1.0).unwrap()).material("steel"),
        Object::new("sheet", sheet.translate([5.0, 0.0, 0.0])),
        Object::new("nothing", Shape::sphere(1.0).unwrap() - Shape::sphere(2.0).unwrap()),
    ])
    .with_material("steel", Material::default());
    let found = made(&scene, 0.1);
    let world = found.scene.compile().unwrap();
    assert_eq!(world.object_names(), ["ball", "sheet"]);
    assert_eq!(world.object_material(0), Some(0));
    assert_eq!(found.parts.len(), 1);
}

#[test]
fn what_cannot_be_a_mesh_is_told() {
    let refused = |scene: &Scene, tolerance| {
        tessellate(scene, &Settings::new(tolerance), Run::default(), &mut |_| {}).unwrap_err()
    };
    let ball = Scene::of([Object::new("ball", Shape::sphere(1.0).unwrap())]);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&ball, tolerance), TessellateError::Tolerance(_)));
    }
    let ground = Shape::halfspace([0.0, 0.0, 1.0], 0.0).unwrap();
    let unbounded = refused(&Scene::of([Object::new("ground", ground)]), 0.1).to_string();
    assert_eq!(unbounded, "object 'ground' has no bounds, so no mesh can hold it; intersect it with a box");
}

/// An object without bounds because nothing is in it was said to be unbounded, and an open mesh beside a solid gave a wrong mesh.
#[test]
fn empty_objects_are_left_out_and_open_meshes_refused() {
    let ball = |x: f64| Shape::sphere(1.0).unwrap().translate([x, 0.0, 0.0]);
    let scene = Scene::of([Object::new("nothing", ball(0.0) & ball(9.0)), Object::new("ball", ball(0.0))]);
    let found = made(&scene, 0.1);
    assert_eq!(found.parts.iter().map(|part| part.object.as_str()).collect::<Vec<_>>(), ["ball"]);
    let sheet = Shape::mesh([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]).unwrap();
    let mixed = Scene::of([Object::new("mixed", Shape::group([sheet, ball(9.0)]))]);
    let refused =
        tessellate(&mixed, &Settings::new(0.1), Run::default(), &mut |_| {}).unwrap_err().to_string();
    assert!(refused.contains("mixed") && refused.contains("open edge"), "{refused}");
}

fn ball(radius: f64, x: f64) -> Shape {
    Shape::sphere(radius).unwrap().translate([x, 0.0, 0.0])
}

/// Shapes at which meshes of cells are hard: walls, bars and gaps that are thinner than a cell and than the tolerance, surfaces
/// that touch, needles.
fn hard() -> Vec<(&'static str, Shape, f64)> {
    let pi = std::f64::consts::PI;
    let bar = Shape::cylinder(0.02, 0.0, 2.0).unwrap();
    vec![
        ("thin wall", ball(1.0, 0.0) - ball(0.97, 0.0), 4.0 / 3.0 * pi * (1.0 - 0.97_f64.powi(3))),
        ("thinner wall", ball(1.0, 0.0) - ball(0.999, 0.0), 4.0 / 3.0 * pi * (1.0 - 0.999_f64.powi(3))),
        ("touching from within", ball(1.0, 0.0) - ball(0.5, 0.5), 4.0 / 3.0 * pi * 0.875),
        ("touching", ball(1.0, 0.0) | ball(1.0, 2.0), 8.0 / 3.0 * pi),
        ("plate", in_cells(turned(Shape::cuboid([-1.0, -1.0, -0.002], [1.0, 1.0, 0.002]).unwrap())), 0.016),
        ("needle", in_cells(turned(Shape::cone(0.05, 0.0, 0.0, 1.0).unwrap())), pi * 0.0025 / 3.0),
        ("bar", in_cells(turned(bar)), pi * 0.0004 * 2.0),
    ]
}

/// The greatest distance of the surface from a mesh, by points of rays that have nothing to do with cells.
fn farthest(exact: &World, mesh: &TriangleMesh, random: &mut Random) -> f64 {
    let near = |i: usize| mesh.vertices[i % mesh.vertices.len()] + 0.03 * random.direction();
    let targets: Vec<Vec3> = (0..5000).map(near).collect();
    let ray = |target| {
        let from = random.direction();
        Ray::new(target + 5.0 * from, -from).unwrap()
    };
    let rays: Vec<Ray> = targets.into_iter().map(ray).collect();
    let found = batch::crossings(exact, &rays, Span::FORWARD, Run::default()).unwrap();
    let ray = |row: usize| found.ray_splits.partition_point(|split| *split as usize <= row) - 1;
    let points: Vec<[f64; 3]> =
        found.t.iter().enumerate().map(|(row, t)| rays[ray(row)].at(*t).to_array()).collect();
    assert!(points.len() > 50, "{}", points.len());
    let solid = MeshSolid::new(Arc::new(mesh.clone()), DEFAULT).unwrap();
    let near = solid.closest_points(&points, 1, None, &|_| {}).unwrap();
    near.into_iter().map(|near| near.unwrap().distance).fold(0.0, f64::max)
}

/// The number of triangles at each edge is two, which is what other programs call watertight.
fn has_two_triangles_an_edge(mesh: &TriangleMesh) -> bool {
    let mut edges: Vec<[u32; 2]> = mesh
        .faces
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}

/// Thin walls had holes, or took gigabytes until they were refused; surfaces that touch were refused always.
#[test]
fn what_is_thin_or_touches_is_kept() {
    let mut random = Random::new(11);
    for (name, shape, volume_of_solid) in hard() {
        let scene = Scene::of([Object::new(name, shape)]);
        let tolerance = 0.01;
        let found = made(&scene, tolerance);
        let [part] = &found.parts[..] else { panic!("{name}") };
        assert!(part.triangles < 20_000, "{name}: {}", part.triangles);
        let mesh = mesh(&found.scene, name);
        assert!(Topology::of(mesh).unwrap().is_closed() && has_two_triangles_an_edge(mesh), "{name}");
        let distance = farthest(&scene.compile().unwrap(), mesh, &mut random);
        assert!(distance <= tolerance, "{name}: {distance}");
        let error = (volume(mesh) / volume_of_solid - 1.0).abs();
        assert!(error < 0.06, "{name}: {error}");
    }
}

/// A slender cone was refused at every tolerance, because nothing but its tip was known to be missing.
#[test]
fn needles_reach_their_tips() {
    for tolerance in [0.4, 0.1, 0.02] {
        let needle = in_cells(Shape::cone(0.2, 0.0, 0.0, 10.0).unwrap());
        let found = made(&Scene::of([Object::new("needle", needle)]), tolerance);
        let mesh = mesh(&found.scene, "needle");
        let top = mesh.vertices.iter().map(|vertex| vertex.z).fold(0.0, f64::max);
        assert!((top - 10.0).abs() <= tolerance && has_two_triangles_an_edge(mesh), "{tolerance}: {top}");
        assert!(found.parts[0].triangles < 20_000, "{:?}", found.parts);
    }
}

/// Vertices of one position made edges of four triangles where a reader takes them as one, as in an STL file.
#[test]
fn no_two_vertices_are_at_one_position() {
    for tolerance in [0.02, 0.01, 0.007, 0.005, 0.003] {
        let found = made(&Scene::of([Object::new("ball", ball(1.0, 0.0))]), tolerance);
        let mesh = mesh(&found.scene, "ball");
        let mut positions: Vec<[u64; 3]> =
            mesh.vertices.iter().map(|v| v.to_array().map(f64::to_bits)).collect();
        positions.sort_unstable();
        positions.dedup();
        assert_eq!(positions.len(), mesh.vertices.len());
        assert!(
            has_two_triangles_an_edge(mesh)
                && mesh.faces.iter().flatten().max() == Some(&(positions.len() as u32 - 1))
        );
    }
}

/// A bore of a thousandth of the size lies between the lines of the first cells.
#[test]
fn small_bores_are_found() {
    let block = Shape::cuboid([-1.0; 3], [1.0; 3]).unwrap();
    let bore = Shape::cylinder(0.002, -2.0, 2.0).unwrap().translate([0.1234, -0.4321, 0.0]);
    let found = made(&Scene::of([Object::new("block", block - bore)]), 0.001);
    let down = Ray::new(Vec3::new(0.1234, -0.4321, 5.0), -Vec3::Z).unwrap();
    let world = found.scene.compile().unwrap();
    assert_eq!(batch::crossings(&world, &[down], Span::FORWARD, Run::default()).unwrap().t.len(), 0);
}

/// A tolerance that is out of reach is refused before memory is used for it.
#[test]
fn tolerances_out_of_reach_are_refused_at_once() {
    for (tolerance, most) in [(1e-12, 1000), (1e-5, 100_000)] {
        let mut cells = 0;
        let scene = Scene::of([Object::new("ball", in_cells(ball(1.0, 0.0)))]);
        let refused = tessellate(&scene, &Settings::new(tolerance), Run::default(), &mut |progress| {
            assert_eq!(progress.object, "ball");
            cells = progress.cells;
        });
        let Err(TessellateError::TooFine { object, place, .. }) = refused else { panic!("{refused:?}") };
        assert!(object == "ball" && (place.length() - 1.0).abs() < 1e-3 && cells < most, "{cells}");
    }
}

#[test]
fn a_tiny_tolerance_is_short_in_messages() {
    let error =
        TessellateError::TooFine { object: "a".into(), tolerance: 1e-320, distance: 1e-5, place: Vec3::ZERO };
    assert!(error.to_string().contains("within 1e-320 needs"), "{error}");
    assert!(TessellateError::Tolerance(-1e300).to_string().contains("is -1e300, but"));
    assert!(TessellateError::Tolerance(0.0).to_string().contains("is 0, but"));
}
