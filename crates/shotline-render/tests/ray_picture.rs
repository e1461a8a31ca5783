//! The picture of one ray.

use shotline::compile::{Options, compile};
use shotline::prelude::*;
use shotline::query::batch::Run;
use shotline::query::{Caster, Kinds, Overlaps, Scope};
use shotline::ray::{Ray, Span};
use shotline_render::{Image, RayDrawing, RayMark, RenderError, Settings, render_ray};

const RED: [f64; 3] = [0.9, 0.1, 0.1];
const BLUE: [f64; 3] = [0.1, 0.1, 0.9];

fn scene() -> Scene {
    let material = |color| Material { color: Some(color), ..Material::default() };
    let cuboid = |name: &str, min, max| Object::new(name, Shape::cuboid(min, max).expect("a box"));
    Scene::of([
        cuboid("red", [-4.0, -1.0, -1.0], [-2.0, 1.0, 1.0]).material("red"),
        cuboid("blue", [2.0, -1.0, -1.0], [4.0, 1.0, 1.0]).material("blue"),
    ])
    .with_material("red", material(RED))
    .with_material("blue", material(BLUE))
}

fn picture(scene: &Scene, ray: &Ray) -> Result<Image, RenderError> {
    let world = compile(scene, Options::default()).expect("a world");
    let mut caster = Caster::new(&world);
    let (mut hits, mut segments) = (Vec::new(), Vec::new());
    let span = Span::FORWARD;
    caster.crossings(ray, Scope { span, kinds: Kinds::All }, &mut hits).expect("crossings");
    caster.segments(ray, span, Overlaps::Priority, &mut segments).expect("segments");
    let marks: Vec<RayMark> =
        hits.iter().map(|hit| RayMark { t: hit.t, label: format!("t = {}", hit.t) }).collect();
    let drawing = RayDrawing { ray: *ray, span, segments: &segments, marks: &marks };
    let settings = Settings { width: 160, height: 120, samples: 1, ..Settings::default() };
    render_ray(&world, scene, &drawing, &settings, Run::default())
}

/// How many pixels have a colour.
fn pixels_of(image: &Image, color: [f64; 3]) -> usize {
    let linear = color.map(|channel| shotline_render::color::decode(channel) as f32);
    let is_color = |pixel: &&[f32; 4]| pixel.iter().zip(linear).all(|(a, b)| (a - b).abs() < 1e-4);
    image.pixels().iter().filter(is_color).count()
}

#[test]
fn the_parts_inside_objects_have_their_colours() {
    for direction in [Vec3::X, Vec3::new(1.0, 0.05, 0.02), Vec3::X * 1e-3] {
        let ray = Ray::new(Vec3::new(-9.0, 0.0, 0.0), direction).expect("a ray");
        let image = picture(&scene(), &ray).expect("a picture");
        let (red, blue) = (pixels_of(&image, RED), pixels_of(&image, BLUE));
        assert!(red > 40 && blue > 40, "{red} {blue}");
    }
    // A ray that begins between the objects is in one of them only.
    let ray = Ray::new(Vec3::ZERO, Vec3::X).expect("a ray");
    let image = picture(&scene(), &ray).expect("a picture");
    assert!(pixels_of(&image, RED) == 0 && pixels_of(&image, BLUE) > 40);
}

/// Whatever its direction, a ray is seen from beside it and not as a point.
#[test]
fn a_ray_in_any_direction_is_seen_in_full() {
    for direction in [Vec3::new(-1.0, 1.0, -1.0), Vec3::Y, Vec3::NEG_Z, Vec3::new(0.0, 1.0, 1.0)] {
        let ray = Ray::new(Vec3::new(3.0, 0.0, 0.0) - 9.0 * direction, direction).expect("a ray");
        let image = picture(&scene(), &ray).expect("a picture");
        assert!(pixels_of(&image, BLUE) > 25, "{direction} {}", pixels_of(&image, BLUE));
    }
}

#[test]
fn rays_that_miss_and_scenes_without_bounds() {
    let ray = Ray::new(Vec3::new(-9.0, 0.0, 7.0), Vec3::X).expect("a ray");
    assert!(picture(&scene(), &ray).is_ok());
    let ground =
        Scene::of([Object::new("ground", Shape::halfspace([0.0, 0.0, 1.0], 0.0).expect("a ground"))]);
    assert_eq!(picture(&ground, &ray).err(), Some(RenderError::NothingToFrame));
}
