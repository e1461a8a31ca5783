//! Objects that are seen through.

use shotline::compile::{Options, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens, Light, LightSource};
use shotline_render::{
    Background, ClipPlane, Image, InvalidOpacity, LOOKS, Lighting, Opacities, RenderError, Settings, expose,
    look, render,
};

const RED: [f64; 3] = [0.9, 0.1, 0.1];
const BLUE: [f64; 3] = [0.1, 0.1, 0.9];

fn cuboid(name: &str, min: [f64; 3], max: [f64; 3]) -> Object {
    Object::new(name, Shape::cuboid(min, max).expect("a box"))
}

/// Seen along y in parallel, with ambient light alone: what faces the eye has the colour of its material.
fn scene(objects: impl IntoIterator<Item = Object>) -> Scene {
    let material = |color| Material { color: Some(color), ..Material::default() };
    let mut scene =
        Scene::of(objects).with_material("red", material(RED)).with_material("blue", material(BLUE));
    let lens = Lens::Orthographic { height: 4.0 };
    let (eye, target, up) = (Vec3::new(0.0, -10.0, 0.0), Vec3::ZERO, Vec3::Z);
    scene.camera = Some(Camera { eye, target, up, lens });
    scene.lights = vec![Light { source: LightSource::Ambient, color: None, intensity: Some(1.0) }];
    scene
}

fn settings(scene: &Scene, opacities: &[(&str, f64)]) -> Settings {
    let opacities = Opacities::new(scene, opacities).expect("opacities");
    let background = Some(Background::BLACK);
    Settings { width: 20, height: 20, samples: 1, opacities, background, ..Settings::default() }
}

fn picture(scene: &Scene, settings: &Settings) -> Image {
    let world = compile(scene, Options::default()).expect("a world");
    render(&world, scene, settings, Run::default()).expect("a picture")
}

/// The red and the blue light in the middle of a picture, in units of those of the materials.
fn middle(image: &Image) -> [f64; 2] {
    let linear = |color: f64| shotline_render::color::decode(color);
    let (high, low) = (linear(0.9), linear(0.1));
    let [red, _, blue, _] = image.pixel(10, 10).map(f64::from);
    let of = high * high - low * low;
    [(red * high - blue * low) / of, (blue * high - red * low) / of]
}

fn assert_light(image: &Image, expected: [f64; 2]) {
    let found = middle(image);
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
}

#[test]
fn the_colours_behind_are_blended_nearest_first() {
    let front = cuboid("front", [-1.0, -2.0, -1.0], [1.0, -1.0, 1.0]).material("red");
    let back = cuboid("back", [-1.0, 1.0, -1.0], [1.0, 2.0, 1.0]).material("blue");
    let both = scene([front, back]);
    // Front and back of the first box are both seen, then the second box.
    assert_light(&picture(&both, &settings(&both, &[("front", 0.25)])), [0.25 + 0.75 * 0.25, 0.5625]);
    assert_light(&picture(&both, &settings(&both, &[("*", 0.5), ("back", 1.0)])), [0.75, 0.25]);
    assert_light(&picture(&both, &settings(&both, &[("*", 0.5)])), [0.75, 0.1875]);
    assert_light(&picture(&both, &settings(&both, &[("front", 0.0)])), [0.0, 1.0]);
    // What is left is background.
    let clear = Settings { background: Some(Background::Transparent), ..settings(&both, &[("*", 0.5)]) };
    assert!((picture(&both, &clear).pixel(10, 10)[3] - 0.9375).abs() < 1e-6);
}

/// Objects that abut, and one in another: at the face between them only what begins there is seen.
#[test]
fn a_face_between_two_objects_is_seen_once() {
    let (front, back) = ([[-1.0, -1.0, -1.0], [1.0, 0.1, 1.0]], [[-1.0, 0.1, -1.0], [1.0, 1.0, 1.0]]);
    let abutting = scene([
        cuboid("front", front[0], front[1]).material("red"),
        cuboid("back", back[0], back[1]).material("blue"),
    ]);
    assert_light(&picture(&abutting, &settings(&abutting, &[("front", 0.5)])), [0.5, 0.5]);
    let inner = cuboid("back", [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]).material("blue");
    let nest = scene([cuboid("front", [-1.0; 3], [1.0; 3]).material("red").containing([inner])]);
    assert_light(&picture(&nest, &settings(&nest, &[("front", 0.5)])), [0.5, 0.5]);
    assert_light(&picture(&nest, &settings(&nest, &[("*", 0.5)])), [0.5 + 0.125 + 0.0625, 0.25]);
}

#[test]
fn opaque_scenes_have_the_pictures_they_had() {
    let ball =
        |name: &str, y: f64| Object::new(name, Shape::sphere(1.0).expect("a ball").translate([0.0, y, 0.2]));
    let mut both = scene([ball("near", -1.0).material("red"), ball("far", 3.0).material("blue")]);
    both.lights = Vec::new();
    both.materials[0].1.mirror = Some(0.5);
    for lighting in [Lighting::Sharp, Lighting::Soft] {
        let plain = Settings { lighting, samples: 3, ..settings(&both, &[]) };
        let opaque = Settings { opacities: settings(&both, &[("*", 1.0)]).opacities, ..plain.clone() };
        assert!(picture(&both, &plain) == picture(&both, &opaque));
    }
}

#[test]
fn what_is_seen_through_has_no_shadow() {
    let wall = cuboid("wall", [-3.0, 1.0, -3.0], [3.0, 2.0, 3.0]).material("blue");
    let plate = cuboid("plate", [-3.0, -3.0, -0.5], [-2.5, 0.0, 0.5]).material("red");
    let mut lit = scene([wall.clone(), plate]);
    let mut alone = scene([wall]);
    for scene in [&mut lit, &mut alone] {
        let source = LightSource::Directional(Vec3::new(1.0, 1.0, 0.0));
        scene.lights = vec![Light { source, color: None, intensity: None }];
    }
    let expected = picture(&alone, &settings(&alone, &[]));
    let shadowed = picture(&lit, &settings(&lit, &[]));
    let through = picture(&lit, &settings(&lit, &[("plate", 0.5)]));
    assert!((0..20).any(|x| shadowed.pixel(x, 10) != expected.pixel(x, 10)));
    assert!((0..20).all(|x| through.pixel(x, 10) == expected.pixel(x, 10)));
}

#[test]
fn caps_are_seen_through() {
    let block = cuboid("block", [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]).material("red");
    let behind = cuboid("behind", [-1.0, 2.0, -1.0], [1.0, 3.0, 1.0]).material("blue");
    let both = scene([block, behind]);
    let clip: Vec<ClipPlane> = vec!["0,-1,0,0".parse().expect("a plane")];
    let cut = Settings { clip, ..settings(&both, &[("block", 0.5)]) };
    assert_light(&picture(&both, &cut), [0.75, 0.25]);
}

/// Lines behind what is seen through are half as dark, and lines of what is in front are as ever.
#[test]
fn lines_are_seen_through_objects() {
    let ball = Object::new("ball", Shape::sphere(1.0).expect("a ball").translate([0.0, 3.0, 0.0]));
    let both = scene([cuboid("glass", [-1.5, -2.0, -1.5], [1.5, -1.0, 1.5]), ball]);
    let world = compile(&both, Options::default()).expect("a world");
    let darkest = |opacities: &[(&str, f64)], rows: std::ops::Range<u32>| {
        let settings = Settings { edges: true, ..settings(&both, opacities) };
        let exposure = expose(&world, &both, &settings, rows, Run::default()).expect("rows");
        exposure.samples.iter().map(|sample| sample.ink).fold(0.0, f64::max)
    };
    // The outline of the ball begins in the sixth row, that of the glass in the third.
    assert_eq!(darkest(&[], 2..3), 1.0);
    assert_eq!(darkest(&[("glass", 0.3)], 2..3), 1.0);
    let inner = |opacities: &[(&str, f64)]| {
        let settings = Settings { edges: true, ..settings(&both, opacities) };
        let exposure = expose(&world, &both, &settings, 5..6, Run::default()).expect("rows");
        exposure.samples[5..15].iter().map(|sample| sample.ink).fold(0.0, f64::max)
    };
    assert_eq!(inner(&[]), 0.0);
    assert!((0.4..=0.5).contains(&inner(&[("glass", 0.3)])), "{}", inner(&[("glass", 0.3)]));
}

#[test]
fn no_more_than_sixteen_surfaces_are_blended() {
    let sheet = |i: u32| {
        let y = f64::from(i) * 0.1;
        cuboid(&format!("sheet{i}"), [-1.0, y, -1.0], [1.0, y + 0.05, 1.0]).material("red")
    };
    let stack = scene((0..20).map(sheet));
    let found = middle(&picture(&stack, &settings(&stack, &[("*", 0.01)])));
    assert!((found[0] - (1.0 - 0.99f64.powi(16))).abs() < 1e-6, "{found:?}");
}

#[test]
fn wrong_opacities_are_errors() {
    let ball = scene([Object::new("ball", Shape::sphere(1.0).expect("a ball"))]);
    assert!(matches!(Opacities::new(&ball, &[("bal", 0.5)]), Err(InvalidOpacity::Unknown(_))));
    for opacity in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(Opacities::new(&ball, &[("ball", opacity)]), Err(InvalidOpacity::Range { .. })));
    }
    let world = compile(&ball, Options::default()).expect("a world");
    for look in LOOKS {
        let result =
            render(&world, &ball, &Settings { look, ..settings(&ball, &[("b*", 0.5)]) }, Run::default());
        match look.name {
            "lit" | "normal" => assert!(result.is_ok()),
            name => assert_eq!(result.err(), Some(RenderError::Opacity(name))),
        }
    }
    assert!(look("normal").is_some());
}
