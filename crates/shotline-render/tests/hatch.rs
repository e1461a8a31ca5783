//! The hatching of cuts.

use shotline::compile::{Options, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens};
use shotline_render::{ClipPlane, Image, LOOKS, RenderError, Settings, render};

/// Two boxes beside each other, cut open, seen along y in a parallel picture: each fills half of it.
fn scene() -> Scene {
    let cuboid = |name: &str, min, max| Object::new(name, Shape::cuboid(min, max).expect("a box"));
    let mut scene = Scene::of([
        cuboid("left", [-3.0, -1.0, -3.0], [0.0, 1.0, 3.0]),
        cuboid("right", [0.0, -1.0, -3.0], [3.0, 1.0, 3.0]),
    ]);
    let lens = Lens::Orthographic { height: 4.0 };
    let (eye, target, up) = (Vec3::new(0.0, -10.0, 0.0), Vec3::ZERO, Vec3::Z);
    scene.camera = Some(Camera { eye, target, up, lens });
    scene
}

fn settings() -> Settings {
    let clip: Vec<ClipPlane> = vec!["0,-1,0,0".parse().expect("a plane")];
    Settings { width: 80, height: 40, samples: 1, clip, hatch: true, ..Settings::default() }
}

fn picture(settings: &Settings) -> Image {
    let scene = scene();
    let world = compile(&scene, Options::default()).expect("a world");
    render(&world, &scene, settings, Run::default()).expect("a picture")
}

/// The pitch is eight pixels across the lines, for any size of the picture.
#[test]
fn lines_have_a_constant_pitch_and_alternate_by_object() {
    let (image, flat) = (picture(&settings()), picture(&Settings { hatch: false, ..settings() }));
    let red = |image: &Image, column, row| image.pixel(column, row)[0];
    for (columns, falls) in [(11..38, false), (42..69, true)] {
        for (column, row) in columns.clone().flat_map(|column| (2..37).map(move |row| (column, row))) {
            let next = if falls { row + 1 } else { row - 1 };
            assert!((red(&image, column, row) - red(&image, column + 1, next)).abs() < 1e-6);
        }
        let is_dark = |column: u32| red(&image, column, 20) < 0.5 * red(&flat, column, 20);
        let lines = columns.clone().filter(|column| is_dark(*column) && !is_dark(column - 1)).count() as f64;
        assert!((lines - 27.0 / (8.0 * 2f64.sqrt())).abs() <= 1.0, "{lines}");
        assert!(columns.clone().any(|column| red(&image, column, 20) == red(&flat, column, 20)));
    }
    let larger = picture(&Settings { width: 160, height: 80, ..settings() });
    assert!((0..40).all(|row| (20..38).all(|column| larger.pixel(column, row) == image.pixel(column, row))));
}

#[test]
fn hatching_needs_a_cut_and_light() {
    let scene = scene();
    let world = compile(&scene, Options::default()).expect("a world");
    let error = |settings: &Settings| render(&world, &scene, settings, Run::default()).err();
    assert_eq!(error(&Settings { clip: Vec::new(), ..settings() }), Some(RenderError::NothingToHatch));
    for look in LOOKS.iter().copied().filter(|look| look.name != "lit") {
        assert_eq!(error(&Settings { look, ..settings() }), Some(RenderError::Hatch(look.name)));
    }
}
