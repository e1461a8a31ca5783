//! Small pictures with known pixel values.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use shotline::compile::{Options, World, compile};
use shotline::math::Vec3;
use shotline::query::batch::Run;
use shotline::scene::{Camera, Lens, Light, LightSource, Material, Motion, Node, Rotation, Scene, Units};
use shotline_render::{
    Animation, Background, Coherence, Image, Lighting, RenderError, Settings, animate, look, render,
};

/// A sphere of radius 1 at the origin, seen along y from 10 away in a parallel picture of height 4.
fn sphere(mu: Option<f64>) -> Scene {
    let mut scene = Scene::default();
    let node = scene.add_solid("sphere", &[&[1.0]]).unwrap();
    scene.materials.push(("grey".into(), Material { color: Some([0.5; 3]), mu, ..Material::default() }));
    scene.add_object("ball", Some("grey"), node);
    scene.camera = Some(Camera {
        eye: Vec3::new(0.0, -10.0, 0.0),
        target: Vec3::ZERO,
        up: Vec3::Z,
        lens: Lens::Orthographic { height: 4.0 },
    });
    scene
}

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).unwrap()
}

fn settings(name: &str) -> Settings {
    Settings { width: 80, height: 80, samples: 1, look: look(name).unwrap(), ..Settings::default() }
}

fn light(source: LightSource) -> Light {
    Light { source, color: None, intensity: None }
}

#[test]
fn a_sphere_is_brightest_where_it_faces_the_light() {
    let mut scene = sphere(None);
    scene.lights = vec![light(LightSource::Directional(Vec3::new(1.0, 0.0, -1.0)))];
    let image = render(&world(&scene), &scene, &settings("lit"), Run::default()).unwrap();
    let red = |column, row| image.pixel(column, row)[0];
    // The light comes from the upper left: that side is lit, the other is black.
    assert!(red(30, 30) > red(40, 40));
    assert!(red(40, 30) > 0.0);
    assert_eq!(red(50, 50), 0.0);
    // Lambert: the linear colour of sRGB 0.5 times the cosine, at the pixel's middle.
    let (x, z) = ((30.5 - 40.0) / 20.0, (40.0 - 30.5) / 20.0);
    let cosine = (z - x) / 2f64.sqrt();
    assert!((f64::from(red(30, 30)) - 0.214_041_14 * cosine).abs() < 1e-6);
}

#[test]
fn a_sphere_casts_a_shadow() {
    let mut scene = sphere(None);
    let wall = scene.add_solid("halfspace", &[&[0.0, -1.0, 0.0], &[-2.0]]).unwrap();
    scene.add_object("wall", None, wall);
    // A light beside the camera: the shadow falls to the right of the sphere, on the wall y = 2.
    scene.lights = vec![light(LightSource::Point(Vec3::new(-6.0, -6.0, 0.0)))];
    let image = render(&world(&scene), &scene, &settings("lit"), Run::default()).unwrap();
    assert_eq!(image.pixel(78, 40)[0], 0.0);
    assert!(image.pixel(2, 40)[0] > 0.1);
    assert!(image.pixel(78, 2)[0] > 0.1);
    // Plain light has none, and is the same elsewhere.
    let plain = Settings { lighting: Lighting::Plain, ..settings("lit") };
    let plain = render(&world(&scene), &scene, &plain, Run::default()).unwrap();
    assert!(plain.pixel(78, 40)[0] > 0.1);
    for (column, row) in [(2, 40), (78, 2), (30, 40)] {
        assert_eq!(plain.pixel(column, row), image.pixel(column, row));
    }
}

#[test]
fn an_xray_is_the_transmission() {
    let scene = sphere(Some(0.7));
    let image = render(&world(&scene), &scene, &settings("xray"), Run::default()).unwrap();
    for (column, row) in [(40, 40), (30, 45), (55, 52), (0, 0)] {
        let at = |pixel: u32| (f64::from(pixel) + 0.5 - 40.0) / 20.0;
        let distance = at(column).hypot(at(row));
        let chord = 2.0 * (1.0 - distance * distance).max(0.0).sqrt();
        let transmission = f64::from(image.pixel(column, row)[0]);
        assert!((transmission - (-0.7 * chord).exp()).abs() < 1e-6, "{transmission} at {column}, {row}");
    }
}

/// The look `thickness` shows lengths and ignores attenuation. The scale is from 0 to the largest length.
#[test]
fn thickness_is_the_length_of_the_path() {
    let colours = |scene: &Scene, column: u32, row: u32| {
        render(&world(scene), scene, &settings("thickness"), Run::default()).unwrap().pixel(column, row)
    };
    let scene = sphere(None);
    let linear = |srgb: [f64; 3]| srgb.map(|x| shotline_render::color::decode(x) as f32);
    assert_eq!(colours(&scene, 40, 40)[..3], linear([0.99, 1.0, 0.64]));
    assert_eq!(colours(&scene, 0, 0)[..3], linear([0.0, 0.0, 0.02]));
    // At a distance of sqrt(3) / 2 the length is half of the largest: between the third and the fourth colour.
    let half = colours(&scene, 57, 40);
    let between = linear([0.725, 0.235, 0.31]);
    assert!(half[..3].iter().zip(between).all(|(a, b)| (a - b).abs() < 0.06), "{half:?}");
    assert_eq!(colours(&sphere(Some(9.0)), 57, 40), half);
}

#[test]
fn the_legend_of_thickness_names_the_units() {
    let picture = |units: Option<Units>| {
        let scene = Scene { units, ..sphere(None) };
        let settings = Settings { width: 300, height: 80, ..settings("thickness") };
        render(&world(&scene), &scene, &settings, Run::default()).unwrap()
    };
    // The text above the bar is "thickness: 0 to 2", followed by the unit.
    let white_pixels = |image: &Image| -> Vec<(u32, u32)> {
        let pixels = (0..300).flat_map(|x| (45..62).map(move |y| (x, y)));
        pixels.filter(|&(x, y)| image.pixel(x, y)[..3] == [1.0; 3]).collect()
    };
    let [bare, cm, mm] = [None, Some(Units::Centimetres), Some(Units::Millimetres)].map(picture);
    let (letters, with_unit) = (white_pixels(&bare), white_pixels(&cm));
    assert!(letters.len() > 50 && with_unit.len() > letters.len() + 5);
    assert_eq!(with_unit[..letters.len()], letters);
    assert!(cm != mm);
}

#[test]
fn normals_are_encoded_linearly() {
    let scene = sphere(None);
    let image = render(&world(&scene), &scene, &settings("normal"), Run::default()).unwrap();
    let bytes = image.to_bytes();
    let at = (40 * 80 + 50) * 3;
    let (x, z) = (10.5 / 20.0, -0.5 / 20.0);
    let y = -f64::sqrt(1.0 - x * x - z * z);
    let want = [x, y, z].map(|n| ((n * 0.5 + 0.5) * 255.0).round() as u8);
    assert_eq!(bytes[at..at + 3], want);
}

#[test]
fn the_nearest_depth_is_brightest() {
    let scene = sphere(None);
    let image = render(&world(&scene), &scene, &settings("depth"), Run::default()).unwrap();
    assert!(image.pixel(40, 40)[0] > 0.99);
    assert!(image.pixel(55, 40)[0] < image.pixel(50, 40)[0]);
    assert_eq!(image.pixel(1, 1), [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn the_number_of_threads_changes_no_pixel() {
    for name in ["lit", "depth", "thickness", "xray"] {
        let mut scene = sphere(None);
        scene.camera = None;
        let world = world(&scene);
        let settings = Settings { width: 101, height: 67, samples: 5, ..settings(name) };
        let run = |threads| render(&world, &scene, &settings, Run { threads, ..Run::default() }).unwrap();
        assert_eq!(run(1), run(4));
    }
}

#[test]
fn scenes_without_camera_and_lights_are_framed_and_lit() {
    let mut scene = sphere(None);
    let ground = scene.add_solid("halfspace", &[&[0.0, 0.0, 1.0], &[-1.0]]).unwrap();
    scene.camera = None;
    let clear = Settings { background: Some(Background::Transparent), ..settings("lit") };
    let image = render(&world(&scene), &scene, &clear, Run::default()).unwrap();
    let covered = image.pixels().iter().filter(|p| p[3] > 0.0).count();
    assert!(covered > 80 * 80 / 4, "{covered}");
    assert_eq!(image.pixel(40, 40)[3], 1.0);
    assert_eq!((image.pixel(0, 0), image.channels()), ([0.0; 4], 4));
    // An unbounded ground does not make the sphere small in the picture.
    scene.add_object("ground", None, ground);
    let normals = render(&world(&scene), &scene, &settings("normal"), Run::default()).unwrap();
    let up = normals.pixel(0, 79);
    let sphere = normals.pixels().iter().filter(|p| **p != up).count();
    assert!(sphere > 80 * 80 / 4, "{sphere}");
}

#[test]
fn lamps_inside_an_object_light_its_contents() {
    let mut scene = sphere(None);
    let room = &[-20.0; 3];
    let room = scene.add_solid("box", &[room, &[20.0; 3]]).unwrap();
    scene.add_object("room", None, room);
    scene.lights = vec![light(LightSource::Directional(Vec3::Y))];
    // Light from outside stops at the wall of the room; a lamp inside reaches the sphere.
    let dark = render(&world(&scene), &scene, &settings("lit"), Run::default()).unwrap();
    assert_eq!(dark.pixel(40, 40)[0], 0.0);
    scene.lights = vec![light(LightSource::Point(Vec3::new(0.0, -9.0, 1.0)))];
    let image = render(&world(&scene), &scene, &settings("lit"), Run::default()).unwrap();
    assert!(image.pixel(40, 40)[0] > 0.1);
}

#[test]
fn progress_counts_every_ray_and_cancelling_ends_the_work() {
    let scene = sphere(None);
    let world = world(&scene);
    let done = AtomicU64::new(0);
    let progress = |n| _ = done.fetch_add(n, Ordering::Relaxed);
    let stop = AtomicBool::new(false);
    let run = Run { threads: 2, progress: Some(&progress), cancel: Some(&stop), ..Run::default() };
    let settings = Settings { samples: 3, ..settings("lit") };
    render(&world, &scene, &settings, run).unwrap();
    assert_eq!(done.load(Ordering::Relaxed), 80 * 80 * 3);
    stop.store(true, Ordering::Relaxed);
    assert_eq!(render(&world, &scene, &settings, run), Err(RenderError::Cancelled));
}

#[test]
fn settings_out_of_range_are_errors() {
    let scene = sphere(None);
    let world = world(&scene);
    let error = |s: Settings| render(&world, &scene, &s, Run::default()).unwrap_err();
    let no_width = Settings { width: 0, ..settings("lit") };
    assert_eq!(error(no_width), RenderError::Size { width: 0, height: 80 });
    assert_eq!(error(Settings { samples: 0, ..settings("lit") }), RenderError::Samples(0));
    let empty = Scene::default();
    let nothing = compile(&empty, Options::default()).unwrap();
    let error = render(&nothing, &empty, &settings("lit"), Run::default()).unwrap_err();
    assert_eq!(error, RenderError::NothingToFrame);
}

#[test]
fn coherence_changes_no_pixel() {
    let mut scene = sphere(None);
    let wall = scene.add_solid("halfspace", &[&[0.0, -1.0, 0.0], &[-2.0]]).unwrap();
    scene.add_object("wall", None, wall);
    scene.lights = [[3.0, -9.0, 1.0], [-3.0, -9.0, 4.0]].map(|p| light(LightSource::Point(p.into()))).into();
    let world = world(&scene);
    let picture = |shadows, neighbours| {
        let coherence = Coherence { shadows, neighbours, ..Coherence::default() };
        let work = Mutex::default();
        let run = Run { counters: Some(&work), ..Run::default() };
        let settings = Settings { coherence, samples: 4, ..settings("lit") };
        let image = render(&world, &scene, &settings, run).unwrap();
        (image, work.into_inner().unwrap().hint_hits)
    };
    let (plain, none) = picture(false, false);
    assert_eq!(none, 0);
    for (shadows, neighbours) in [(true, false), (false, true), (true, true)] {
        let (image, reused) = picture(shadows, neighbours);
        assert!(image == plain && reused > 1000, "{shadows} {neighbours} {reused}");
    }
}

/// A ball rolls past a mirror, in front of a wall on which its shadow falls.
fn rolling() -> Scene {
    let mut scene = sphere(Some(0.3));
    let wall = scene.add_solid("halfspace", &[&[0.0, -1.0, 0.0], &[-2.0]]).unwrap();
    scene.add_object("wall", Some("grey"), wall);
    let cube: [&[f64]; 2] = [&[1.2, -2.0, -1.9], &[1.9, -1.0, -1.2]];
    let cube = scene.add_solid("box", &cube).unwrap();
    scene
        .materials
        .push(("mirror".into(), Material { mirror: Some(0.8), mu: Some(0.2), ..Material::default() }));
    scene.add_object("cube", Some("mirror"), cube);
    scene.lights = vec![light(LightSource::Point(Vec3::new(3.0, -9.0, 3.0)))];
    let (rotate, translate) = (Some(Rotation::Xyz(Vec3::Y * 90.0)), Some(Vec3::new(-1.0, 0.0, 0.3)));
    scene.motions = vec![Motion { object: "ball".into(), rotate, translate, ..Motion::default() }];
    scene
}

#[test]
fn each_frame_is_the_same_as_if_rendered_alone() {
    const FRAMES: u32 = 5;
    let scene = rolling();
    let movie = |name, frames, orbit| {
        let work = Mutex::default();
        let run = Run { counters: Some(&work), ..Run::default() };
        let coherence = Coherence { frames, ..Coherence::default() };
        let settings = Settings { coherence, ..settings(name) };
        let mut images: Vec<Image> = Vec::new();
        let animation = Animation { frames: FRAMES, orbit };
        animate(scene.clone(), Options::default(), &settings, animation, run, |image| {
            images.push(image);
            Ok::<(), ()>(())
        })
        .unwrap();
        (images, work.into_inner().unwrap().boxes)
    };
    for name in ["lit", "normal", "depth", "thickness", "xray", "cost"] {
        let (images, boxes) = movie(name, true, 0.0);
        let (uncached, all_boxes) = movie(name, false, 0.0);
        assert_eq!(images.len(), FRAMES as usize);
        assert!(images == uncached, "{name}");
        assert!(name == "cost" || boxes < all_boxes * 9 / 10, "{name}: {boxes} of {all_boxes}");
        // The boxes of few objects are tested together, so their number is the same in all frames.
        assert!(name == "cost" || images[0] != images[1], "{name}");
        for (number, image) in (0..).zip(&images) {
            let mut scene = scene.clone();
            for (node, motion) in scene.set_in_motion() {
                let transform = scene.motions[motion].at(f64::from(number) / f64::from(FRAMES));
                if let Node::Transform { transform: old, .. } = &mut scene.nodes[node.0 as usize] {
                    *old = transform;
                }
            }
            assert!(
                *image == render(&world(&scene), &scene, &settings(name), Run::default()).unwrap(),
                "{name} {number}"
            );
        }
    }
    let (orbiting, _) = movie("normal", true, 360.0);
    assert!(orbiting[0] == movie("normal", true, 0.0).0[0] && orbiting[0] != orbiting[1]);
}
