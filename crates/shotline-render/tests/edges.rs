//! Dark lines along edges.

use shotline::compile::{Options, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens, Motion};
use shotline_render::{
    Animation, Background, ClipPlane, Coherence, Exposure, Image, LOOKS, RenderError, Settings, animate,
    expose, look, render,
};

const SIDE: u32 = 64;

/// A scene seen along y, in a parallel picture of 8 by 8: 8 pixels are one unit.
fn scene(objects: impl IntoIterator<Item = Object>) -> Scene {
    let mut scene = Scene::of(objects);
    let lens = Lens::Orthographic { height: 8.0 };
    let (eye, target, up) = (Vec3::new(0.0, -20.0, 0.0), Vec3::ZERO, Vec3::Z);
    scene.camera = Some(Camera { eye, target, up, lens });
    scene
}

fn cuboid(min: [f64; 3], max: [f64; 3]) -> Shape {
    Shape::cuboid(min, max).expect("a box")
}

fn settings(samples: u32) -> Settings {
    Settings { width: SIDE, height: SIDE, samples, edges: true, ..Settings::default() }
}

fn exposed(scene: &Scene, settings: &Settings, threads: usize) -> Exposure {
    let world = compile(scene, Options::default()).expect("a world");
    let run = Run { threads, ..Run::default() };
    expose(&world, scene, settings, 0..settings.height, run).expect("an exposure")
}

/// How much of each pixel lines cover.
fn ink(scene: &Scene, settings: &Settings) -> Vec<f64> {
    exposed(scene, settings, 1).samples.iter().map(|sample| sample.ink).collect()
}

/// The width of all lines that cross some pixels of a row, in pixels.
fn width(ink: &[f64], row: u32, columns: std::ops::Range<u32>) -> f64 {
    columns.map(|column| ink[(row * SIDE + column) as usize]).sum()
}

fn picture(scene: &Scene, settings: &Settings) -> Image {
    let world = compile(scene, Options::default()).expect("a world");
    render(&world, scene, settings, Run::default()).expect("a picture")
}

#[test]
fn lines_are_one_and_a_half_pixels_wide_for_any_number_of_samples() {
    let boxes = scene([Object::new("box", cuboid([-2.03, -1.0, -2.0], [2.41, 1.0, 2.0]))]);
    let once = ink(&boxes, &settings(1));
    for row in [20, 32, 40] {
        for columns in [10..25, 40..60] {
            let width = width(&once, row, columns);
            assert!((width - 1.5).abs() < 0.13, "{width}");
        }
        assert_eq!(width(&once, row, 25..40), 0.0);
    }
    assert_eq!(ink(&boxes, &settings(9)), once);
}

#[test]
fn a_curved_surface_has_its_outline_only() {
    for shape in [Shape::sphere(3.0).expect("a ball"), Shape::torus(2.4, 0.6).expect("a ring")] {
        let ink = ink(&scene([Object::new("round", shape.rotate([90.0, 0.0, 0.0]))]), &settings(1));
        // From the centre out: the hole of the ring, then its outer outline at 24 pixels.
        let total: f64 = ink.iter().sum();
        let inner = ink[(32 * SIDE + 32 - 15) as usize] > 0.0 || ink[(32 * SIDE + 32 - 14) as usize] > 0.0;
        let outlines = std::f64::consts::TAU * 24.0 + if inner { std::f64::consts::TAU * 14.4 } else { 0.0 };
        assert!((total / 1.5 / outlines - 1.0).abs() < 0.05, "{total} {outlines}");
        assert_eq!(width(&ink, 32, 18..32), if inner { width(&ink, 32, 18..19) } else { 0.0 });
    }
}

/// A plane that reaches the horizon is seen ever more from the side, and has no steps.
#[test]
fn a_plane_has_no_edge_but_its_horizon() {
    let mut plain = scene([Object::new("ground", Shape::halfspace([0.0, 0.0, 1.0], 0.0).expect("a ground"))]);
    let lens = Lens::Pinhole { fov: 50.0 };
    let (eye, target) = (Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.3, 9.0, 0.9));
    plain.camera = Some(Camera { eye, target, up: Vec3::Z, lens });
    let ink = ink(&plain, &settings(1));
    for column in [0, 17, 40, 63] {
        let of_column: Vec<u32> = (0..SIDE).filter(|row| ink[(row * SIDE + column) as usize] > 0.0).collect();
        assert!((1..=3).contains(&of_column.len()), "{of_column:?}");
        assert!((30..34).contains(&of_column[0]), "{of_column:?}");
    }
}

/// What is one surface to the eye has no edge: boxes that abut, the same for a rod between its round ends.
#[test]
fn surfaces_that_go_on_in_each_other_have_no_edge_and_objects_do() {
    let (left, right) =
        (cuboid([-3.0, 0.0, -2.0], [0.05, 1.0, 2.0]), cuboid([0.05, 0.0, -2.0], [3.0, 1.0, 2.0]));
    let one = scene([Object::new("one", left.clone() | right.clone())]);
    let two = scene([Object::new("left", left), Object::new("right", right.clone())]);
    assert_eq!(width(&ink(&one, &settings(1)), 32, 20..45), 0.0);
    assert!((width(&ink(&two, &settings(1)), 32, 20..45) - 1.5).abs() < 0.13);
    // A step towards the eye, without any change of the normal.
    let step = scene([Object::new("step", cuboid([-3.0, -0.3, -2.0], [0.05, 1.0, 2.0]) | right)]);
    assert!((width(&ink(&step, &settings(1)), 32, 20..45) - 1.5).abs() < 0.13);
}

/// Two placements of one part that abut are two instances.
#[test]
fn instances_have_edges_between_them() {
    let tile = cuboid([-3.0, 0.0, -2.0], [0.05, 1.0, 2.0]);
    let tiles = Shape::group([tile.clone(), tile.translate([3.05, 0.0, 0.0])]);
    assert!(
        (width(&ink(&scene([Object::new("tiles", tiles)]), &settings(1)), 32, 20..45) - 1.5).abs() < 0.13
    );
}

#[test]
fn caps_of_cuts_have_outlines() {
    let ball = scene([Object::new("ball", Shape::sphere(3.0).expect("a ball"))]);
    let mut tilted = ball.clone();
    tilted.camera = tilted.camera.map(|camera| Camera { eye: Vec3::new(0.0, -20.0, 12.0), ..camera });
    let clip: Vec<ClipPlane> = vec!["z=0.3".parse().expect("a plane")];
    let whole = ink(&tilted, &settings(1));
    let cut = ink(&tilted, &Settings { clip, ..settings(1) });
    let column = |ink: &[f64], rows: std::ops::Range<u32>| -> f64 {
        rows.map(|row| ink[(row * SIDE + 32) as usize]).sum()
    };
    // The near border of the cap runs across the ball.
    assert_eq!(column(&whole, 20..50), 0.0);
    assert!((column(&cut, 20..50) - 1.5).abs() < 0.2, "{}", column(&cut, 20..50));
}

#[test]
fn the_lines_are_the_same_for_all_threads_and_tiles() {
    let parts = [cuboid([-3.0, 0.0, -2.0], [0.0, 1.0, 2.0]), Shape::sphere(2.0).expect("a ball")];
    let parts = scene(parts.into_iter().enumerate().map(|(i, shape)| Object::new(format!("part{i}"), shape)));
    let wide = Settings { width: 75, height: 70, ..settings(2) };
    let one = exposed(&parts, &wide, 1);
    assert_eq!(exposed(&parts, &wide, 3).samples, one.samples);
    let world = compile(&parts, Options::default()).expect("a world");
    let mut bands = Vec::new();
    for rows in [0..1, 1..33, 33..64, 64..70] {
        bands.extend(expose(&world, &parts, &wide, rows, Run::default()).expect("rows").samples);
    }
    assert_eq!(bands, one.samples);
    // Lines are added to what the picture shows without them.
    let plain = exposed(&parts, &Settings { edges: false, ..wide }, 1);
    for (plain, drawn) in plain.samples.iter().zip(&one.samples) {
        assert_eq!((plain.color, plain.alpha, plain.ink), (drawn.color, drawn.alpha, 0.0));
    }
}

#[test]
fn frames_have_the_lines_of_pictures() {
    let mut moving = scene([
        Object::new("slab", cuboid([-3.0, 0.0, -2.0], [3.0, 1.0, 2.0])),
        Object::new("ball", Shape::sphere(1.0).expect("a ball").translate([-1.0, -2.0, 0.0])),
    ]);
    moving.motions =
        vec![Motion { object: "ball".into(), translate: Some(Vec3::X * 2.0), ..Motion::default() }];
    let frames = |coherent: bool| {
        let coherence = Coherence { frames: coherent, ..Coherence::default() };
        let settings = Settings { coherence, ..settings(1) };
        let mut frames = Vec::new();
        let take = |image| -> Result<(), ()> {
            frames.push(image);
            Ok(())
        };
        let animation = Animation { frames: 3, orbit: 0.0 };
        animate(moving.clone(), Options::default(), &settings, animation, Run::default(), take)
            .expect("frames");
        frames
    };
    let kept = frames(true);
    assert!(kept == frames(false));
    assert!(kept[0] == picture(&moving, &settings(1)) && kept[0] != kept[1]);
}

#[test]
fn looks_without_surfaces_refuse_edges() {
    let ball = scene([Object::new("ball", Shape::sphere(3.0).expect("a ball"))]);
    let world = compile(&ball, Options::default()).expect("a world");
    for look in LOOKS {
        let result = render(&world, &ball, &Settings { look, ..settings(1) }, Run::default());
        match look.name {
            "lit" | "normal" | "depth" => {
                let image = result.expect("a picture");
                // On the outline, whatever the look shows beside it.
                assert!(image.pixel(32, 8)[..3].iter().all(|channel| *channel < 0.3), "{}", look.name);
            }
            name => assert_eq!(result.err(), Some(RenderError::Edges(name))),
        }
    }
    let transparent = Settings { background: Some(Background::Transparent), ..settings(1) };
    let look = look("lit").expect("a look");
    let image = picture(&ball, &Settings { look, ..transparent });
    assert_eq!(image.pixel(0, 0)[3], 0.0);
    assert_eq!(image.pixel(32, 9)[3], 1.0);
}
