use std::sync::Arc;

use crate::compile::{Options, compile};
use crate::math::{Affine, Vec3};
use crate::prelude::*;
use crate::scene::{LocalTransform, Node, NodeId, Op, Rotation};
use crate::solid::mesh::{MeshError, TriangleMesh};
use crate::solid::{InvalidSolid, Params, kind};

fn ball() -> Shape {
    Shape::sphere(1.0).unwrap()
}

fn scene_of(shape: impl Into<Shape>) -> Scene {
    Scene::of([Object::new("it", shape)])
}

/// The `t` of all crossings of a ray along x through the origin.
fn along_x(shape: impl Into<Shape>) -> Vec<f64> {
    let world = scene_of(shape).compile().unwrap();
    let ray = Ray::new(Vec3::new(-16.0, 0.0, 0.0), Vec3::X).unwrap();
    let mut hits = Vec::new();
    Caster::new(&world).crossings(&ray, Span::FORWARD, &mut hits).unwrap();
    hits.iter().map(|hit| hit.t - 16.0).collect()
}

fn children(scene: &Scene, id: NodeId) -> Vec<NodeId> {
    scene.node(id).children().collect()
}

#[test]
fn constructors_equal_construction_by_kind_name() {
    let same = |shape: Result<Shape, InvalidSolid>, name: &str, values: &[&[f64]]| {
        let scene = scene_of(shape.unwrap());
        let Node::Solid { kind, params } = &scene.nodes[0] else { panic!("{name}") };
        let mut by_name = Scene::default();
        by_name.add_solid(name, values).unwrap();
        let Node::Solid { kind: expected, params: numbers } = &by_name.nodes[0] else { panic!("{name}") };
        assert_eq!((kind.name, params), (expected.name, numbers));
    };
    same(Shape::sphere(2.0), "sphere", &[&[2.0]]);
    same(Shape::cuboid([0.0, 1.0, 2.0], Vec3::splat(3.0)), "box", &[&[0.0, 1.0, 2.0], &[3.0; 3]]);
    same(Shape::halfspace((0.0, 0.0, 1.0), 0.5), "halfspace", &[&[0.0, 0.0, 1.0], &[0.5]]);
    same(Shape::torus(2.0, 0.5), "torus", &[&[2.0], &[0.5]]);
    let coefficients = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0];
    same(Shape::quadric(coefficients), "quadric", &[&coefficients]);
    same(Shape::tube(0.5, 1.0, 0.0, 2.0), "tube", &[&[0.5], &[1.0], &[0.0], &[2.0], &[0.0], &[360.0]]);
    let sector: &[&[f64]] = &[&[0.5], &[1.0], &[0.0], &[2.0], &[30.0], &[60.0]];
    same(Shape::tube_sector(0.5, 1.0, 0.0, 2.0, 30.0, 60.0), "tube", sector);
    let sphere = kind("sphere").unwrap();
    same(Shape::solid(sphere, Params::of(sphere, &[&[2.0]])), "sphere", &[&[2.0]]);
}

#[test]
fn bad_parameters_are_errors_of_the_constructor() {
    let message = |shape: Result<Shape, InvalidSolid>| shape.unwrap_err().to_string();
    assert_eq!(message(Shape::sphere(-2.0)), "sphere: radius is -2, but must be positive");
    assert_eq!(message(Shape::sphere(f64::NAN)), "sphere: radius is NaN, but must be finite");
    let crossed = message(Shape::cylinder(1.0, 3.0, 2.0));
    assert_eq!(crossed, "cylinder: z1 is 2, but must be greater than z0 = 3");
    let error = Shape::torus(1.0, 0.0).unwrap_err();
    assert_eq!((error.kind, error.error.param), ("torus", "r"));
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let beyond = Shape::mesh(corners, [[0, 1, 3]]).unwrap_err();
    assert_eq!(beyond, MeshError::VertexOutOfRange { face: 0, vertex: 3, count: 3 });
    assert_eq!(Shape::mesh(corners, [[0, 1, 1]]).unwrap_err(), MeshError::Empty);
}

#[test]
fn operators_combine() {
    let (a, b) = (ball(), ball().translate([1.0, 0.0, 0.0]));
    assert_eq!(along_x(&a | &b), [-1.0, 2.0]);
    assert_eq!(along_x(&a & &b), [0.0, 1.0]);
    assert_eq!(along_x(&a - &b), [-1.0, 0.0]);
    assert_eq!(along_x(a.clone() | b.clone()), along_x(Shape::union([a.clone(), b.clone()])));
    assert_eq!(along_x(a.clone() & &b), along_x(Shape::intersection([a.clone(), b.clone()])));
    assert_eq!(along_x(&a - b.clone()), along_x(a.difference([b])));
    assert_eq!(along_x(&a - &a), []);
    assert_eq!(along_x(Shape::group([a.clone(), a])), [-1.0, -1.0, 1.0, 1.0]);
}

#[test]
fn chains_are_one_combination_unless_an_intermediate_shape_is_kept() {
    let ball_at = |x: f64| ball().translate([x, 0.0, 0.0]);
    let chain = ball_at(0.0) - ball_at(1.5) - ball_at(-1.5);
    let kept = ball_at(0.0) - ball_at(1.5);
    let nested = &kept - ball_at(-1.5);
    assert_eq!(along_x(&chain), along_x(&nested));
    assert_eq!(along_x(&kept), [-1.0, 0.5]);
    let combinations =
        |shape: &Shape| scene_of(shape).nodes.iter().filter(|node| matches!(node, Node::Csg { .. })).count();
    assert_eq!((combinations(&chain), combinations(&nested)), (1, 2));
    let own = (ball_at(0.0) - ball_at(1.5)).with_accel("grid") - ball_at(-1.5);
    assert_eq!(combinations(&own), 2);
}

#[test]
fn transforms_act_in_the_order_in_which_they_are_written() {
    assert_eq!(along_x(ball().translate([2.0, 0.0, 0.0]).scale(2.0)), [2.0, 6.0]);
    assert_eq!(along_x(ball().scale(2.0).translate([2.0, 0.0, 0.0])), [0.0, 4.0]);
    let turned = ball().translate([0.0, -3.0, 0.0]).rotate([0.0, 0.0, 90.0]);
    assert_eq!(along_x(turned), [2.0, 4.0]);
    assert_eq!(along_x(ball().translate([0.0, -3.0, 0.0]).rotate_about(Vec3::Z, 90.0)), [2.0, 4.0]);
    assert_eq!(along_x(ball().scale_axes([3.0, 1.0, 1.0])), [-3.0, 3.0]);
    let shift = Affine::translation(Vec3::X);
    assert_eq!(along_x(ball().transform(shift)), [0.0, 2.0]);
    let written = scene_of(ball().rotate([1.0, 2.0, 3.0]));
    let Node::Transform { transform, .. } = written.nodes[1] else { panic!() };
    assert_eq!(transform, LocalTransform::rotation(Rotation::Xyz(Vec3::new(1.0, 2.0, 3.0))));
}

#[test]
fn transforms_that_flatten_space_are_refused_when_compiling() {
    let message = refused(&scene_of(ball().scale(0.0)));
    assert!(message.contains("singular") && message.contains("must not flatten space"), "{message}");
    for not_finite in [ball().rotate_about(Vec3::ZERO, 10.0), ball().scale(f64::NAN)] {
        let message = refused(&scene_of(not_finite));
        assert!(message.contains("not finite") && message.contains("an axis of length 0"), "{message}");
    }
}

#[test]
fn clones_are_one_node() {
    let wheel = ball() - ball().scale(0.5);
    let axle = Shape::group([wheel.translate([0.0, 2.0, 0.0]), wheel.clone().translate([0.0, -2.0, 0.0])]);
    let cart = Shape::group([axle.clone(), axle.translate([5.0, 0.0, 0.0])]);
    let scene = Scene::of([Object::new("cart", &cart), Object::new("spare", wheel)]);
    // The ball, its transform, the second ball and the wheel; two transforms and the axle; one transform and the cart;
    // two objects.
    assert_eq!(scene.nodes.len(), 3 + 1 + 3 + 2 + 2);
    let world = scene.compile().unwrap();
    assert_eq!((world.path_count(), world.stats().virtual_leaves), (5, 10));
    assert_eq!(children(&scene, scene.objects[1]), [NodeId(3)]);
}

#[test]
fn nested_groups_of_shared_shapes_stay_small() {
    let mut flake = ball();
    for _ in 0..40 {
        flake =
            Shape::group([flake.translate([-1.0, 0.0, 0.0]), flake.translate([1.0, 0.0, 0.0])]).scale(0.4);
    }
    let world = scene_of(&flake).compile().unwrap();
    assert_eq!(world.path_count(), 1 << 40);
    assert!(scene_of(flake).nodes.len() < 200);
}

#[test]
fn objects_carry_names_materials_and_contents() {
    let core = Object::new("core", Shape::sphere(0.25).unwrap()).priority(2);
    let fuel = Object::new("fuel", Shape::sphere(0.5).unwrap()).material("uranium").containing([core]);
    let rod = Object::new("rod", ball()).containing([fuel.translate([0.25, 0.0, 0.0])]).priority(-1);
    let scene = Scene::of([rod.translate([2.0, 0.0, 0.0]), rod])
        .with_units(Units::Millimetres)
        .with_material("uranium", Material { density: Some(19.0), ..Material::default() });
    let world = scene.compile().unwrap();
    let mut names = world.object_names().to_vec();
    names.sort();
    names.dedup();
    assert_eq!(names, ["core", "fuel", "rod"]);
    let ray = Ray::new(Vec3::new(-16.0, 0.0, 0.0), Vec3::X).unwrap();
    let mut caster = Caster::new(&world);
    let mut segments = Vec::new();
    caster.segments(&ray, Span::FORWARD, Overlaps::All, &mut segments).unwrap();
    let of = |name: &str| {
        let is_it = |s: &&Segment| world.object_names()[s.object as usize] == name;
        segments.iter().filter(is_it).map(|s| [s.t_in - 16.0, s.t_out - 16.0]).collect::<Vec<_>>()
    };
    assert_eq!(of("rod"), [[-1.0, 1.0], [1.0, 3.0]]);
    assert_eq!(of("fuel"), [[-0.25, 0.75], [1.75, 2.75]]);
    assert_eq!(of("core"), [[0.0, 0.5], [2.0, 2.5]]);
    let materials = segments.iter().filter_map(|s| s.material).count();
    assert_eq!((materials, world.material_names()), (2, ["uranium".to_string()].as_slice()));
}

#[test]
fn all_errors_are_reported_together() {
    let objects = [
        Object::new("a", ball()).material("steel"),
        Object::new("b", Shape::union([])),
        Object::new("c", ball().with_accel("bhv")),
    ];
    let error = Scene::of(objects[..2].to_vec()).compile().unwrap_err();
    assert_eq!(error.errors.len(), 2);
    assert!(error.to_string().starts_with("object 'a' is made of 'steel'"), "{error}");
    let message = Scene::of(objects[2..].to_vec()).compile().unwrap_err().to_string();
    assert!(
        message.starts_with("object 'c': there is no accelerator named 'bhv'; known are brute"),
        "{message}"
    );
}

#[test]
fn meshes_are_solids_if_they_are_closed() {
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let closed = Shape::mesh(corners, faces).unwrap().translate([-1.0, -1.0, -1.0]);
    assert_eq!(along_x(&closed - ball().scale(0.5)), [-1.0, -0.5, 0.5, 1.0]);
    let shared = Arc::new(TriangleMesh::new(corners.map(Vec3::from).to_vec(), faces[..3].to_vec()));
    let open = Shape::triangles(shared).unwrap();
    assert!(scene_of(&open).compile().is_ok());
    let message = scene_of(open | ball()).compile().unwrap_err().to_string();
    assert!(message.contains("not closed cannot be combined"), "{message}");
}

#[test]
fn deep_chains_do_not_recurse() {
    const DEPTH: usize = 1_000_000;
    let (a, b) = (ball(), ball().scale(0.5));
    let mut nest = a.clone();
    for _ in 0..DEPTH / 2 {
        nest = (nest | &a) - &b;
    }
    let mut placed = a;
    for _ in 0..DEPTH / 5 {
        placed = placed.translate([0.0; 3]);
    }
    let mut boxes = Object::new("box", b);
    for _ in 0..DEPTH / 5 {
        boxes = Object::new("box", ball()).containing([boxes]);
    }
    let scene = Scene::of([Object::new("nest", &nest), Object::new("placed", &placed), boxes]);
    assert!(scene.nodes.len() > DEPTH + 3 * DEPTH / 5);
    assert!(format!("{nest:?} {placed:?}").len() < 100);
    let above = scene_of(nest & ball());
    drop((scene, placed));
    assert!(above.nodes.len() > DEPTH);
}

#[test]
fn deep_combinations_compile() {
    let mut nest = ball();
    for _ in 0..10_000 {
        nest = (nest | ball()) - ball().scale(0.5);
    }
    assert_eq!(along_x(nest), [-1.0, -0.5, 0.5, 1.0]);
}

#[test]
fn built_scenes_equal_scenes_made_node_by_node() {
    let plate = Shape::cuboid([-2.0, -2.0, 0.0], [2.0, 2.0, 1.0]).unwrap();
    let built = scene_of(plate - Shape::cylinder(0.5, 0.0, 1.0).unwrap());
    let mut written = Scene::default();
    let plate = written.add_solid("box", &[&[-2.0, -2.0, 0.0], &[2.0, 2.0, 1.0]]).unwrap();
    let bore = written.add_solid("cylinder", &[&[0.5], &[0.0], &[1.0]]).unwrap();
    let bored = written.add_csg(Op::Difference, vec![plate, bore]);
    written.add_object("it", None, bored);
    assert_eq!(format!("{built:?}"), format!("{written:?}"));
    let [a, b] = [built, written].map(|scene| compile(&scene, Options::default()).unwrap());
    assert_eq!(a.stats(), b.stats());
}

#[test]
fn shapes_can_be_sent_to_other_threads() {
    fn is_shared<T: Send + Sync + Clone>() {}
    is_shared::<Shape>();
    is_shared::<Object>();
}

/// The message of the error with which a scene is refused.
fn refused(scene: &Scene) -> String {
    scene.compile().unwrap_err().to_string()
}

#[test]
fn an_accelerator_belongs_to_the_shape_below_its_transforms() {
    let pair = ball() - Shape::sphere(0.5).unwrap();
    let scene = scene_of(pair.translate([1.0, 0.0, 0.0]).scale(2.0).with_accel("grid"));
    let (id, name) = scene.accels.iter().next().unwrap();
    assert!(matches!(scene.node(*id), Node::Csg { .. }) && *name == "grid");
    assert_eq!(along_x(pair.translate([1.0, 0.0, 0.0]).scale(2.0).with_accel("grid")), [0.0, 1.0, 3.0, 4.0]);
}

#[test]
fn a_combination_without_operands_is_refused_however_it_is_written() {
    let nothing = Shape::union([]);
    let kept = nothing.clone();
    for shape in [nothing | ball(), &kept | &ball(), Shape::intersection([]) & ball()] {
        assert!(refused(&scene_of(shape)).contains("at least one operand"));
    }
}

#[test]
fn materials_are_checked() {
    let scene =
        |material: Material| Scene::of([Object::new("a", ball()).material("m")]).with_material("m", material);
    assert!(scene(Material::default()).compile().is_ok());
    for (material, what) in [
        (Material { mu: Some(f64::NAN), ..Material::default() }, "the mu of the material 'm' is NaN"),
        (Material { density: Some(-1.0), ..Material::default() }, "the density of the material 'm' is -1"),
        (Material { mirror: Some(9.0), ..Material::default() }, "the mirror of the material 'm' is 9"),
        (
            Material { color: Some([0.0, 1.5, 0.0]), ..Material::default() },
            "the color of the material 'm' is 1.5",
        ),
    ] {
        let message = refused(&scene(material));
        assert!(message.starts_with(what), "{message}");
    }
    let twice = scene(Material::default()).with_material("m", Material::default());
    assert!(refused(&twice).contains("two materials are named 'm'"));
}

#[test]
fn errors_name_the_object_and_come_in_the_order_of_the_nodes() {
    let culprit =
        |shape: Shape| refused(&Scene::of([Object::new("fine", ball()), Object::new("culprit", shape)]));
    let singular = culprit(ball().scale(0.0));
    assert!(singular.starts_with("object 'culprit': the transform is singular"), "{singular}");
    let not_finite = culprit(ball().translate([f64::NAN, 0.0, 0.0]));
    assert!(
        not_finite.starts_with("object 'culprit': the transform has a number that is not finite"),
        "{not_finite}"
    );
    let names = ["p", "q", "r", "s", "t", "u", "v"];
    let pair = |name| Object::new("it", (ball() | ball().translate([1.0; 3])).with_accel(name));
    let message = refused(&Scene::of(names.map(pair)));
    let order: Vec<usize> = names.iter().map(|name| message.find(&format!("'{name}'")).unwrap()).collect();
    assert!(order.is_sorted(), "{message}");
}

#[test]
fn superfluous_parameters_are_refused() {
    let sphere = kind("sphere").unwrap();
    for name in ["radius", "bogus"] {
        let mut params = Params::of(sphere, &[&[1.0]]);
        params.entries.push((name, Arc::from([2.0])));
        assert_eq!(Shape::solid(sphere, params).unwrap_err().error.param, name);
    }
}
