//! A picture whose rays are cast at meshes in blocks is the one whose rays are cast one by one, as they are where
//! counters are requested: over meshes alone, in combinations and among instances, with shadows, mirrors and motion.

use std::f64::consts::{PI, TAU};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use shotline::compile::{Options, World, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens, Light, LightSource, Motion, Rotation};
use shotline_render::{
    Animation, Image, LOOKS, Lighting, RenderError, Settings, animate, expose, look, render,
};

/// A ball of radius 1 of about `2 n^2` triangles, in whose plane z = 0 are vertices.
fn ball(n: u32) -> Shape {
    let angle = |i: u32, all: u32| f64::from(i) / f64::from(all);
    let mut vertices = vec![Vec3::Z, -Vec3::Z];
    let mut faces = Vec::new();
    let ring = |i: u32, j: u32| 2 + (i - 1) * n + j % n;
    for i in 1..n {
        for j in 0..n {
            let (height, turn) = (PI * angle(i, n), TAU * angle(j, n));
            vertices.push(Vec3::new(height.sin() * turn.cos(), height.sin() * turn.sin(), height.cos()));
            if i == 1 {
                faces.push([0, ring(1, j), ring(1, j + 1)]);
            } else {
                let [a, b, c, d] = [ring(i - 1, j), ring(i, j), ring(i, j + 1), ring(i - 1, j + 1)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
            if i == n - 1 {
                faces.push([1, ring(i, j + 1), ring(i, j)]);
            }
        }
    }
    Shape::mesh(vertices, faces).unwrap()
}

/// An open sheet in the plane z = 0.
fn sheet() -> Shape {
    let corners = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]];
    Shape::mesh(corners.map(Vec3::from), vec![[0, 1, 2], [0, 2, 3]]).unwrap()
}

/// With a camera, a point light, a directional one and ambient light.
fn scene(objects: impl IntoIterator<Item = Object>) -> Scene {
    let mut scene = Scene::of(objects);
    let light =
        |source, intensity| Light { source, color: Some([1.0, 0.9, 0.8]), intensity: Some(intensity) };
    scene.lights = vec![
        light(LightSource::Point(Vec3::new(3.0, -5.0, 4.0)), 0.7),
        light(LightSource::Directional(Vec3::new(0.3, 0.5, -1.0)), 0.5),
        light(LightSource::Ambient, 0.2),
    ];
    scene.camera = Some(Camera {
        eye: Vec3::new(1.0, -7.0, 3.0),
        target: Vec3::ZERO,
        up: Vec3::Z,
        lens: Lens::Pinhole { fov: 40.0 },
    });
    let mirror = Material { mirror: Some(0.6), specular: Some(0.4), mu: Some(0.3), ..Material::default() };
    scene.materials = vec![("mirror".into(), mirror)];
    scene
}

/// Solid scenes, and at the end one with an open mesh.
fn scenes() -> Vec<(&'static str, Scene)> {
    let (mesh, cube) = (ball(24), Shape::cuboid([-0.7; 3], [0.7; 3]).unwrap());
    let ground = Object::new("ground", Shape::halfspace([0.0, 0.0, 1.0], -1.2).unwrap()).material("mirror");
    let spots = [[-1.5, 0.0, 0.0], [1.5, 1.0, 0.4], [0.0, 2.0, 0.8], [0.3, -0.8, -0.4]];
    let copies: Vec<Shape> =
        spots.iter().map(|at| mesh.scale(0.6).rotate([20.0, 30.0, at[0]]).translate(*at)).collect();
    let group = || Shape::group(copies.clone());
    vec![
        ("a mesh", scene([Object::new("ball", mesh.clone()).material("mirror")])),
        ("two meshes", scene(copies[..2].iter().map(|copy| Object::new("ball", copy.clone())))),
        (
            "combinations",
            scene([
                Object::new("moving", (mesh.clone() - cube.clone()).translate([-1.1, 0.0, 0.0])),
                Object::new("still", (mesh.scale(0.9) & cube).translate([1.1, 0.0, 0.0])).material("mirror"),
                ground.clone(),
            ]),
        ),
        (
            "instances",
            scene([
                Object::new("moving", group()).material("mirror"),
                Object::new("still", Shape::group([group().scale(0.5), group().translate([0.0, 4.0, 0.0])])),
                ground,
            ]),
        ),
        (
            "a sheet",
            scene([Object::new("sheet", sheet()), Object::new("moving", mesh.translate([0.0, 0.0, 0.5]))]),
        ),
    ]
}

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).unwrap()
}

/// In blocks and one by one.
fn both<T>(picture: impl Fn(Run) -> T) -> [T; 2] {
    let counters = Mutex::default();
    [picture(Run::default()), picture(Run { counters: Some(&counters), ..Run::default() })]
}

#[test]
fn every_look_is_the_same() {
    for (name, scene) in scenes() {
        let world = world(&scene);
        for look in LOOKS.iter().copied() {
            for (lighting, samples, width) in [
                (Lighting::Sharp, 1, 100),
                (Lighting::Sharp, 3, 60),
                (Lighting::Plain, 1, 70),
                (Lighting::Soft, 4, 50),
            ] {
                let settings = Settings { width, height: 50, samples, look, lighting, ..Settings::default() };
                let [found, expected] = both(|run| render(&world, &scene, &settings, run));
                assert!(found == expected, "{name}, {}, {samples} samples", look.name);
                let needs_solids = name == "a sheet" && ["thickness", "xray"].contains(&look.name);
                assert_eq!(matches!(found, Err(RenderError::NotSolid { .. })), needs_solids);
                assert!(needs_solids || found.is_ok());
            }
        }
    }
}

/// The samples of a pixel may fill several blocks.
#[test]
fn pixels_of_many_samples_are_the_same() {
    for (name, scene) in scenes() {
        let world = world(&scene);
        let settings = Settings { width: 3, height: 2, samples: 3000, ..Settings::default() };
        let [found, expected] = both(|run| expose(&world, &scene, &settings, 0..2, run).unwrap().samples);
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn movies_are_the_same_with_and_without_pixels_of_the_frame_before() {
    for (name, mut scene) in scenes() {
        let (rotate, translate) = (Some(Rotation::Xyz(Vec3::Y * 90.0)), Some(Vec3::new(0.2, 0.0, 0.3)));
        if !name.contains("mesh") {
            scene.motions = vec![Motion { object: "moving".into(), rotate, translate, ..Motion::default() }];
        }
        let movie = |run: Run, frames: bool| {
            let mut settings = Settings { width: 60, height: 45, samples: 2, ..Settings::default() };
            settings.coherence.frames = frames;
            let (mut images, animation) = (Vec::new(), Animation { frames: 3, orbit: 0.0 });
            animate(scene.clone(), Options::default(), &settings, animation, run, |image: Image| {
                images.push(image);
                Ok::<(), ()>(())
            })
            .unwrap();
            images
        };
        for frames in [true, false] {
            let [found, expected] = both(|run| movie(run, frames));
            assert!(found == expected, "{name}, {frames}");
            assert!(found == movie(Run::default(), !frames), "{name}");
        }
    }
}

#[test]
fn a_cancelled_picture_has_no_result() {
    let stop = AtomicBool::new(true);
    for (name, scene) in scenes() {
        let settings = Settings { look: look("normal").unwrap(), ..Settings::default() };
        let run = Run { cancel: Some(&stop), ..Run::default() };
        assert_eq!(render(&world(&scene), &scene, &settings, run), Err(RenderError::Cancelled), "{name}");
    }
}

/// The pictures compared above show something.
#[test]
fn the_scenes_are_seen() {
    for (name, scene) in scenes() {
        let settings = Settings { width: 60, height: 45, samples: 1, ..Settings::default() };
        let image = render(&world(&scene), &scene, &settings, Run::default()).unwrap();
        let nothing = image.pixel(0, 0);
        let seen = image.pixels().iter().filter(|pixel| **pixel != nothing).count();
        assert!(seen > 200, "{name}: {seen}");
    }
}
