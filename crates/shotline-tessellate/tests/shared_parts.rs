//! Parts that are placed several times become meshes once; what they are placed in stays.

use shotline::math::Lattice;
use shotline::prelude::*;
use shotline::query::batch::{self, Run};
use shotline::scene::{Node, NodeId, Scene};
use shotline::testkit::random::Random;
use shotline_tessellate::{Settings, Tessellation, tessellate};

const TOLERANCE: f64 = 0.02;

fn made(scene: &Scene) -> Tessellation {
    tessellate(scene, &Settings::new(TOLERANCE), Run::default(), &mut |_| {})
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The nodes below the roots that are meshes, each once.
fn meshes(scene: &Scene) -> Vec<NodeId> {
    let mut todo = scene.objects.clone();
    let mut found = Vec::new();
    while let Some(id) = todo.pop() {
        match scene.node(id) {
            Node::Mesh { .. } if !found.contains(&id) => found.push(id),
            node => todo.extend(node.children()),
        }
    }
    found
}

/// Whether points have the same owners, but for those within the tolerance of a surface. Names the worst point.
fn assert_same_owners(exact: &Scene, made: &Scene, reach: f64) {
    let mut random = Random::new(7);
    let points: Vec<Vec3> = (0..4000).map(|_| random.point(-reach, reach)).collect();
    let names = |scene: &Scene| {
        let world = scene.compile().unwrap();
        let caster = |point: &Vec3| {
            let owner = Caster::new(&world).owner_at(*point).unwrap();
            owner.map(|(number, _)| world.object_names()[number as usize].clone())
        };
        points.iter().map(caster).collect::<Vec<_>>()
    };
    let world = exact.compile().unwrap();
    let near = |point: &Vec3| {
        [Vec3::X, Vec3::Y, Vec3::Z].iter().any(|axis| {
            let ray = Ray::new(*point - *axis * (2.0 * TOLERANCE), *axis * (4.0 * TOLERANCE)).unwrap();
            let span = Span::new(0.0, 1.0).unwrap();
            let rows = batch::crossings(&world, &&[ray][..], span, Run::default()).unwrap();
            rows.kind.contains(&0)
        })
    };
    let differing = points.iter().zip(names(exact).into_iter().zip(names(made))).filter(|(_, (a, b))| a != b);
    for (point, (a, b)) in differing {
        assert!(near(point), "{point}: {a:?}, but {b:?}");
    }
}

fn pin() -> Shape {
    Shape::cylinder(0.2, 0.0, 1.0).unwrap() | Shape::sphere(0.35).unwrap()
}

#[test]
fn copies_that_are_apart_share_a_mesh_and_others_are_one() {
    let pin = pin();
    let placed = |x: f64| pin.rotate([0.0, 40.0, 0.0]).translate([x, 0.0, 0.0]);
    let plate = Shape::cuboid([-3.0, 1.0, -1.0], [3.0, 1.2, 1.0]).unwrap();
    let apart = Shape::group([placed(-2.0), placed(0.0), placed(2.0), plate]);
    let scene = Scene::of([Object::new("pins", apart)]);
    let found = made(&scene);
    assert_eq!(meshes(&found.scene).len(), 2);
    assert_eq!(found.parts.len(), 1);
    assert_same_owners(&scene, &found.scene, 3.0);

    // Two of the four touch each other.
    let some = Shape::group([placed(-2.0), placed(0.0), placed(0.3), placed(2.0)]);
    let scene = Scene::of([Object::new("pins", some)]);
    let found = made(&scene);
    assert_eq!(meshes(&found.scene).len(), 2);
    assert_same_owners(&scene, &found.scene, 3.0);

    // As far apart as the tolerance: one mesh, whose walls stay apart.
    let block = Shape::cuboid([0.0; 3], [1.0; 3]).unwrap();
    let near = |gap: f64| Shape::group([block.clone(), block.translate([1.0 + gap, 0.0, 0.0])]);
    let count = |shape: Shape| {
        let found = made(&Scene::of([Object::new("blocks", shape)]));
        (meshes(&found.scene).len(), found.parts[0].triangles)
    };
    let alone = count(block.clone());
    assert_eq!(count(near(3.0 * TOLERANCE)), alone);
    let (meshes, triangles) = count(near(TOLERANCE));
    assert!(meshes == 1 && triangles > alone.1);
}

#[test]
fn cells_of_lattices_share_a_mesh() {
    let lattice = Lattice::rectangular([100, 100, 100], [1.0, 1.0, 1.0]);
    let balls = Shape::sphere(0.4).unwrap().lattice(lattice);
    let scene = Scene::of([Object::new("balls", balls)]);
    let found = made(&scene);
    assert_eq!(meshes(&found.scene).len(), 1);
    assert_eq!(found.scene.compile().unwrap().path_count(), 1_000_000);
    assert_same_owners(&scene, &found.scene, 4.0);
}

#[test]
fn a_part_of_several_sizes_is_within_the_tolerance_where_it_is_largest() {
    let ball = Shape::sphere(1.0).unwrap();
    let of_size = |scale: f64, x: f64| ball.scale(scale).translate([x, 0.0, 0.0]);
    let scene = Scene::of([
        Object::new("small", of_size(0.1, 0.0)),
        Object::new("large", of_size(2.0, 4.0)),
        Object::new("flat", ball.scale_axes([1.0, 1.0, 0.2]).translate([-4.0, 0.0, 0.0])),
    ]);
    let found = made(&scene);
    // The flat one is no similar copy.
    assert_eq!(meshes(&found.scene).len(), 2);
    assert!(found.parts.iter().all(|part| part.deviation > 0.0 && part.deviation <= TOLERANCE));
    assert_same_owners(&scene, &found.scene, 6.0);
}

#[test]
fn objects_in_objects_and_groups_of_objects_stay() {
    let core = Object::new("core", Shape::sphere(0.5).unwrap());
    let shell = Object::new("shell", Shape::sphere(1.0).unwrap()).containing([core]).clip();
    let placed = |x: f64| shell.translate([x, 0.0, 0.0]);
    let tank = Shape::cuboid([-4.0, -2.0, -2.0], [4.0, 2.0, 2.0]).unwrap();
    let empty = Object::new("nothing", Shape::sphere(1.0).unwrap() - Shape::sphere(2.0).unwrap());
    let tank = Object::new("tank", tank).containing([placed(-2.0), placed(2.0), empty.clone()]);
    let scene = Scene::of([tank.translate([0.0, 0.5, 0.0]), empty.priority(3)]);
    let found = made(&scene);
    let names: Vec<&str> = found.parts.iter().map(|part| part.object.as_str()).collect();
    assert_eq!(names, ["tank", "shell", "core", "shell"]);
    assert_eq!(found.empty, ["nothing", "nothing"]);
    assert_eq!(found.scene.objects.len(), 1);
    assert!(!found.scene.compile().unwrap().object_names().contains(&"nothing".into()));
    assert_same_owners(&scene, &found.scene, 4.5);
}
