//! Pictures of scenes that planes cut open, and of objects in objects.

use shotline::compile::{Options, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, HiddenObjects, Lens};
use shotline_render::{ClipPlane, Image, LOOKS, Lighting, RenderError, Settings, look, render};

const RED: [f64; 3] = [0.9, 0.1, 0.1];
const BLUE: [f64; 3] = [0.1, 0.1, 0.9];

fn cuboid(name: &str, min: [f64; 3], max: [f64; 3]) -> Object {
    Object::new(name, Shape::cuboid(min, max).expect("a box"))
}

/// A scene seen along y from y = -10, in a parallel picture of 4 by 4.
fn scene(objects: impl IntoIterator<Item = Object>) -> Scene {
    let material = |color| Material { color: Some(color), mu: Some(0.5), ..Material::default() };
    let mut scene =
        Scene::of(objects).with_material("red", material(RED)).with_material("blue", material(BLUE));
    let lens = Lens::Orthographic { height: 4.0 };
    let (eye, target, up) = (Vec3::new(0.0, -10.0, 0.0), Vec3::ZERO, Vec3::Z);
    scene.camera = Some(Camera { eye, target, up, lens });
    scene
}

fn settings(name: &str, clip: &[&str]) -> Settings {
    let clip = clip.iter().map(|text| text.parse::<ClipPlane>().expect("a plane")).collect();
    let look = look(name).expect("a look");
    Settings { width: 40, height: 40, samples: 1, look, clip, ..Settings::default() }
}

fn picture(scene: &Scene, settings: &Settings) -> Image {
    let world = compile(scene, Options::default()).expect("a world");
    render(&world, scene, settings, Run::default()).expect("a picture")
}

fn hiding(scene: &Scene, name: &str) -> HiddenObjects {
    scene.hiding(&[name]).expect("a known name")
}

fn is_color(image: &Image, column: u32, row: u32, color: [f64; 3]) -> bool {
    let linear = color.map(|channel| shotline_render::color::decode(channel) as f32);
    image.pixel(column, row)[..3].iter().zip(linear).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// The cap has the colour of the material, whatever the light.
#[test]
fn a_sphere_cut_in_half_shows_its_cap() {
    let scene = scene([Object::new("ball", Shape::sphere(1.5).expect("a ball")).material("red")]);
    let image = picture(&scene, &settings("lit", &["0,-1,0,0"]));
    for (column, row) in [(20, 20), (8, 20), (20, 31)] {
        assert!(is_color(&image, column, row, RED), "{:?}", image.pixel(column, row));
    }
    assert_eq!(image.pixel(2, 2), picture(&scene, &settings("lit", &[])).pixel(2, 2));
    // What is removed is behind: the picture is that of the whole.
    assert!(picture(&scene, &settings("lit", &["y=0"])) == picture(&scene, &settings("lit", &["y=9"])));
    assert!(!is_color(&picture(&scene, &settings("lit", &[])), 20, 20, RED));
}

/// In looks without light a cut is a surface as any other: the picture is that of an intersection.
#[test]
fn a_cut_is_the_intersection_with_half_spaces() {
    let ball = Shape::sphere(1.5).expect("a ball");
    let kept = Shape::halfspace([-1.0, -2.0, 0.5], 0.25).expect("a half-space")
        & Shape::halfspace([0.0, 0.0, 1.0], 0.5).expect("a half-space");
    let cut = scene([Object::new("ball", ball.clone()).material("red")]);
    let solid = scene([Object::new("ball", ball & kept).material("red")]);
    for name in ["normal", "depth", "thickness", "xray"] {
        let (a, b) = (
            picture(&cut, &settings(name, &["-1,-2,0.5,0.25", "z=0.5"])),
            picture(&solid, &settings(name, &[])),
        );
        let pixels = (0..40).flat_map(|x| (0..40).map(move |y| (x, y)));
        let differs = |&(x, y): &(u32, u32)| {
            let (a, b) = (a.pixel(x, y), b.pixel(x, y));
            a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-4)
        };
        assert_eq!(pixels.filter(differs).count(), 0, "{name}");
    }
}

/// A box whose front is filled by what it contains.
fn filled(clip: bool) -> Scene {
    let inner = cuboid("inner", [-1.0, -1.0, -1.0], [1.0, 0.5, 1.0]).material("blue");
    let outer = cuboid("outer", [-1.5, -1.0, -1.5], [1.5, 1.0, 1.5]).material("red").containing([inner]);
    scene([if clip { outer.clip() } else { outer }])
}

#[test]
fn contents_up_to_a_shared_face_show_their_own_colour() {
    let minus = Shape::cuboid([-1.0, -1.0, -1.0], [1.0, 0.5, 1.0]).expect("a box");
    let outer = Shape::cuboid([-1.5, -1.0, -1.5], [1.5, 1.0, 1.5]).expect("a box");
    let hole = Object::new("outer", outer - minus.clone()).material("red");
    let inner = Object::new("inner", minus).material("blue");
    let (with_hole, both) = (scene([hole.clone()]), scene([hole, inner]));
    for clip in [false, true] {
        let nest = filled(clip);
        let lit = settings("lit", &[]);
        assert!(picture(&nest, &lit) == picture(&both, &lit));
        // What is hidden leaves a hole.
        for name in ["lit", "depth", "normal", "thickness", "xray"] {
            let hidden = Settings { hidden: hiding(&nest, "inner"), ..settings(name, &[]) };
            assert!(picture(&nest, &hidden) == picture(&with_hole, &settings(name, &[])), "{name}");
        }
        // Cut through both.
        let image = picture(&nest, &settings("lit", &["0,-1,0,0"]));
        assert!(is_color(&image, 20, 20, BLUE) && is_color(&image, 8, 20, RED));
        let hidden = Settings { hidden: hiding(&nest, "inner"), ..settings("lit", &["0,-1,0,0"]) };
        assert!(!is_color(&picture(&nest, &hidden), 20, 20, BLUE));
        assert!(is_color(&picture(&nest, &hidden), 8, 20, RED));
    }
}

/// Faces that lie in the plane of the cut: what ends there is gone, and what begins there is cut.
#[test]
fn a_cut_along_faces_leaves_no_film() {
    let front = cuboid("front", [-1.0, -1.0, -1.0], [1.0, 0.1, 1.0]).material("blue");
    let back = cuboid("back", [-1.0, 0.1, -1.0], [1.0, 1.0, 1.0]).material("red");
    let flat = scene([front.clone(), back.clone()]);
    let around = |objects: [Object; 2]| cuboid("around", [-2.0; 3], [2.0; 3]).containing(objects).clip();
    let nest = scene([around([front, back])]);
    let hidden = hiding(&nest, "around");
    for (scene, hidden) in [(flat, HiddenObjects::default()), (nest, hidden)] {
        let tilted = Camera { eye: Vec3::new(3.0, -9.0, 2.0), ..scene.camera.expect("a camera") };
        let settings = Settings { hidden, camera: Some(tilted), ..settings("lit", &["0,-1,0,-0.1"]) };
        let image = picture(&scene, &settings);
        let [first, others @ ..] = [(20, 20), (14, 14), (24, 26), (17, 25)].map(|(x, y)| image.pixel(x, y));
        assert!(first[0] > 0.6 && first[2] < 0.01, "{first:?}");
        assert_eq!(others, [first; 3]);
    }
}

/// A lamp shines through what is removed.
#[test]
fn shadows_are_those_of_the_cut_scene() {
    let wall = cuboid("wall", [-2.0, 1.0, -2.0], [2.0, 2.0, 2.0]).material("red");
    let plate = cuboid("plate", [-2.0, -1.0, -2.0], [2.0, -0.9, 2.0]).material("blue");
    let alone = scene([wall.clone()]);
    let inner = cuboid("inner", [-1.0, 1.2, -1.0], [1.0, 1.4, 1.0]);
    let nested = scene([wall.clone().containing([inner]), plate.clone()]);
    let flat = scene([wall, plate]);
    for lighting in [Lighting::Sharp, Lighting::Soft] {
        let of = |scene: &Scene, clip: &[&str]| {
            picture(scene, &Settings { lighting, samples: 4, ..settings("lit", clip) })
        };
        let expected = of(&alone, &[]);
        assert!(of(&flat, &["0,-1,0,0"]) == expected && of(&nested, &["0,-1,0,0"]) == expected);
        assert!(of(&flat, &[]) != expected);
    }
}

#[test]
fn every_look_shows_a_cut_nest() {
    let nest = filled(true);
    for look in LOOKS {
        let hidden = hiding(&nest, "outer");
        let cut = picture(&nest, &Settings { hidden, ..settings(look.name, &["x=0.3"]) });
        let whole = picture(&nest, &Settings { hidden: hiding(&nest, "outer"), ..settings(look.name, &[]) });
        assert!(cut != whole, "{}", look.name);
        if look.name != "cost" {
            assert_eq!(cut.pixel(27, 20), cut.pixel(2, 20), "{}", look.name);
            assert_ne!(whole.pixel(27, 20), whole.pixel(2, 20), "{}", look.name);
        }
    }
}

/// Without a camera the picture frames what is visible.
#[test]
fn a_picture_frames_what_is_visible() {
    let inner = cuboid("inner", [-1.0; 3], [1.0; 3]);
    let alone = scene([inner.clone()]);
    let nest = scene([cuboid("world", [-90.0; 3], [90.0; 3]).containing([inner]).clip()]);
    let [alone, nest] = [alone, nest].map(|scene| Scene { camera: None, ..scene });
    let settings = settings("depth", &[]);
    let hidden = Settings { hidden: hiding(&nest, "world"), ..settings.clone() };
    assert!(picture(&nest, &hidden) == picture(&alone, &settings));
}

#[test]
fn open_meshes_in_nests_are_refused_by_looks_that_need_an_inside() {
    use shotline::scene::Node;
    use shotline::solid::mesh::TriangleMesh;
    let mut nest = filled(true);
    let vertices = [[-1.0, -2.0, -1.0], [1.0, -2.0, -1.0], [0.0, -2.0, 1.0]].map(Vec3::from).to_vec();
    let node = nest.add(Node::Mesh { mesh: TriangleMesh::new(vertices, vec![[0, 1, 2]]).into(), file: None });
    nest.add_object("sheet", None, node);
    let world = compile(&nest, Options::default()).expect("a world");
    let refused = render(&world, &nest, &settings("thickness", &[]), Run::default());
    assert!(matches!(refused, Err(RenderError::NotSolid { look: "thickness", .. })), "{refused:?}");
    assert!(render(&world, &nest, &settings("lit", &[]), Run::default()).is_ok());
}
