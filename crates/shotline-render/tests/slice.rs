//! Slices: what owns each pixel of a plane.

use shotline::compile::{Options, World, compile};
use shotline::math::{SPLIT_MIX64_STEP, split_mix64};
use shotline::prelude::*;
use shotline::query::ConflictKind;
use shotline::query::batch::Run;
use shotline_render::slice::{
    Area, ColorBy, Conflicts, Slice, SliceError, SliceSettings, regions, slice, slice_png, slice_svg,
};

fn ball(name: &str, radius: f64) -> Object {
    Object::new(name, Shape::sphere(radius).expect("a ball"))
}

fn cuboid(name: &str, min: [f64; 3], max: [f64; 3]) -> Object {
    Object::new(name, Shape::cuboid(min, max).expect("a box"))
}

fn settings(plane: &str, area: Option<[f64; 4]>, size: Option<(u32, u32)>) -> SliceSettings {
    let area = area.map(|[u0, v0, u1, v1]| Area::new([u0, v0], [u1, v1]).expect("an area"));
    SliceSettings { plane: plane.parse().expect("a plane"), area, size }
}

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).expect("a world")
}

fn sliced(scene: &Scene, plane: &str, area: Option<[f64; 4]>, size: Option<(u32, u32)>) -> Slice {
    slice(&world(scene), &settings(plane, area, size), Run::default()).expect("a slice")
}

/// Positions of the middles of pixels, with the indices of the pixels.
fn middles(slice: &Slice) -> impl Iterator<Item = (usize, [f64; 2])> {
    let (width, height) = (slice.width, slice.height);
    let middle = move |i: u32| [f64::from(i % width) + 0.5, f64::from(i / width) + 0.5];
    (0..width * height).map(move |i| (i as usize, middle(i)))
}

#[test]
fn a_box_without_a_ball_is_exact_to_the_pixel() {
    let shell = Shape::cuboid([-2.0; 3], [2.0; 3]).expect("a box") - Shape::sphere(1.5).expect("a ball");
    let scene = Scene::of([Object::new("shell", shell)]);
    for (plane, height) in [("z=0", 0.0), ("x=0.5", 0.5), ("y=-1.25", 1.25)] {
        let found = sliced(&scene, plane, Some([-3.0, -2.5, 3.0, 2.5]), Some((97, 61)));
        let (mut inside, mut outside) = (0, 0);
        for (i, position) in middles(&found) {
            let (u, v) = (-3.0 + position[0] * 6.0 / 97.0, 2.5 - position[1] * 5.0 / 61.0);
            let radius = (u * u + v * v + height * height).sqrt();
            let is_doubtful = (radius - 1.5).abs() < 1e-12 || (u.abs().max(v.abs()) - 2.0).abs() < 1e-12;
            let is_inside = u.abs() < 2.0 && v.abs() < 2.0 && radius > 1.5;
            if !is_doubtful {
                assert_eq!(found.object[i], if is_inside { 0 } else { -1 }, "{plane} {u} {v}");
                if is_inside { inside += 1 } else { outside += 1 }
            }
        }
        assert!(inside > 1000 && outside > 1000);
    }
}

/// The axes of a general plane: a ball is a disc of the right area in the right place.
#[test]
fn a_ball_cut_by_an_oblique_plane_is_a_disc() {
    let centre = Vec3::new(4.0, 5.0, -6.0);
    let scene = Scene::of([ball("ball", 2.0).translate(centre)]);
    let found = sliced(&scene, "1,2,3,-3", None, Some((400, 400)));
    let normal = Vec3::new(1.0, 2.0, 3.0).normalize();
    let beside = normal.dot(centre) + 3.0 / 14f64.sqrt();
    let [width, height] = found.pixel_size();
    let pixels = found.object.iter().filter(|object| **object == 0).count() as f64;
    let disc = std::f64::consts::PI * (4.0 - beside * beside);
    assert!((pixels * width * height / disc - 1.0).abs() < 0.01, "{pixels}");
    for (i, position) in middles(&found) {
        let distance = found.point(position).distance(centre);
        assert!((distance - 2.0).abs() < 1e-9 || (distance < 2.0) == (found.object[i] == 0));
    }
}

struct Random(u64);

impl Random {
    fn number(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(SPLIT_MIX64_STEP);
        low + (high - low) * ((split_mix64(self.0) >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn below(&mut self, n: u32) -> u32 {
        self.number(0.0, f64::from(n)) as u32
    }

    fn object(&mut self, depth: u32, size: f64) -> Object {
        let radius = size * self.number(0.3, 1.0);
        let shape = match self.below(3) {
            0 => Shape::sphere(radius),
            1 => Shape::cylinder(radius, -radius, radius),
            _ => Shape::cuboid([-radius; 3], [radius, 0.8 * radius, radius]),
        };
        let turns = [0, 1, 2].map(|_| self.number(-180.0, 180.0));
        let offset = [0, 1, 2].map(|_| self.number(-size, size) * 0.5);
        let contents: Vec<Object> = match depth {
            0 => Vec::new(),
            _ => (0..self.below(4)).map(|_| self.object(depth - 1, 0.6 * size)).collect(),
        };
        let object = Object::new(format!("o{}", self.below(1000)), shape.expect("a shape"));
        let object = object.material(format!("m{}", self.below(3))).priority(self.below(3) as i32 - 1);
        let object = object.containing(contents);
        let object = if self.below(3) == 0 { object.clip() } else { object };
        object.rotate(turns).translate(offset)
    }
}

#[test]
fn pixels_have_the_owners_of_their_middles() {
    let mut random = Random(7);
    let (mut owned, mut conflicts, mut compared) = (0, 0, 0);
    for i in 0..60 {
        let objects: Vec<Object> = (0..1 + random.below(4)).map(|_| random.object(3, 4.0)).collect();
        let scene = (0..3)
            .fold(Scene::of(objects), |scene, i| scene.with_material(format!("m{i}"), Material::default()));
        let world = world(&scene);
        let plane = match i % 4 {
            3 => [0, 1, 2, 3].map(|_| random.number(-1.0, 1.0).to_string()).join(","),
            axis => format!("{}={}", ["x", "y", "z"][axis], random.number(-2.0, 2.0)),
        };
        let found = slice(&world, &settings(&plane, None, Some((40, 30))), Run::default()).expect("a slice");
        let mut caster = Caster::new(&world);
        for (i, position) in middles(&found) {
            let row = i / 40;
            let ends = found.rows[row].iter().flat_map(|part| part.columns);
            let conflict_ends = found.conflicts[row].iter().flat_map(|part| part.columns);
            if ends.chain(conflict_ends).any(|column| (column - position[0]).abs() < 1e-9) {
                continue;
            }
            let point = found.point(position);
            let owner = caster.owner_at(point).expect("an owner");
            let expected = owner.map_or((-1, -1), |(object, path)| (object as i32, path as i64));
            assert_eq!((found.object[i], found.path[i]), expected, "{plane} at {position:?}");
            let material = owner.and_then(|(object, _)| world.object_material(object));
            assert_eq!(found.material[i], material.map_or(-1, |material| material as i32));
            // Both objects of an overlap contain the point.
            if let Some(pair) = usize::try_from(found.overlap[i]).ok().map(|pair| found.pairs[pair]) {
                let mut around = Vec::new();
                caster.contains(point, &mut around).expect("objects");
                let holds_both = around.contains(&pair.first) && around.contains(&pair.second);
                assert!(holds_both || pair.kind == ConflictKind::Protrusion, "{pair:?} {around:?}");
                conflicts += 1;
            }
            owned += usize::from(owner.is_some());
            compared += 1;
        }
    }
    assert!(compared > 70_000 && owned > 10_000 && conflicts > 1000, "{compared} {owned} {conflicts}");
}

#[test]
fn overlaps_are_marked_and_named() {
    let scene = Scene::of([
        cuboid("left", [-2.0, -1.0, -1.0], [0.5, 1.0, 1.0]),
        cuboid("right", [0.0, -1.0, -1.0], [2.0, 1.0, 1.0]),
        cuboid("above", [-2.0, 1.0, -1.0], [2.0, 2.0, 1.0]).priority(1),
    ]);
    let world = world(&scene);
    let found = sliced(&scene, "z=0", Some([-4.0, -4.0, 4.0, 4.0]), Some((16, 16)));
    assert_eq!(found.pairs.len(), 1);
    let pair = found.pairs[0];
    assert_eq!((pair.first, pair.second, pair.pixels, pair.kind), (0, 1, 4, ConflictKind::Overlap));
    assert_eq!(pair.text(&world), "'left' and 'right' overlap");
    let point = found.point(pair.at);
    assert!((0.0..0.5).contains(&point.x) && point.y.abs() < 1.0, "{point}");
    let marked: Vec<usize> = (0..256).filter(|&i| found.overlap[i] == 0).collect();
    assert_eq!(marked, [6 * 16 + 8, 7 * 16 + 8, 8 * 16 + 8, 9 * 16 + 8]);
    // The one that is placed later owns it.
    assert!(marked.iter().all(|&i| found.object[i] == 1));
    let svg = |conflicts| slice_svg(&found, &world, &scene, ColorBy::Object, conflicts);
    assert!(svg(Conflicts::Marked).contains("'left' and 'right' overlap"));
    assert!(!svg(Conflicts::Hidden).contains("overlap"));
    let png = |conflicts| slice_png(&found, &world, &scene, ColorBy::Object, conflicts);
    assert!(png(Conflicts::Marked) != png(Conflicts::Hidden));
}

/// Too thin for the middle of a pixel, but named.
#[test]
fn thin_overlaps_are_named() {
    let scene = Scene::of([
        cuboid("left", [-2.0, -1.0, -1.0], [0.001, 1.0, 1.0]),
        cuboid("right", [0.0, -1.0, -1.0], [2.0, 1.0, 1.0]),
    ]);
    let found = sliced(&scene, "z=0", Some([-4.0, -4.0, 4.0, 4.0]), Some((16, 16)));
    assert_eq!((found.pairs.len(), found.pairs[0].pixels), (1, 0));
    assert!(found.overlap.iter().all(|pair| *pair == -1));
}

#[test]
fn what_sticks_out_is_named() {
    let inner = cuboid("pin", [0.0, -0.5, -0.5], [3.0, 0.5, 0.5]);
    let scene = Scene::of([cuboid("block", [-2.0; 3], [2.0; 3]).containing([inner]).clip()]);
    let found = sliced(&scene, "z=0", Some([-4.0, -4.0, 4.0, 4.0]), Some((16, 16)));
    assert_eq!(found.pairs.len(), 1);
    let pair = found.pairs[0];
    assert_eq!((pair.kind, pair.pixels), (ConflictKind::Protrusion, 4));
    assert_eq!(pair.text(&world(&scene)), "'pin' sticks out of 'block'");
    // What sticks out does not count.
    assert_eq!(found.object[7 * 16 + 13], -1);
}

#[test]
fn the_default_area_is_around_the_bounded_objects_of_the_plane() {
    let ground = Object::new("ground", Shape::halfspace([0.0, 0.0, 1.0], 0.0).expect("a half-space"));
    let scene = Scene::of([
        ground,
        cuboid("hut", [10.0, 20.0, 0.0], [14.0, 22.0, 3.0]),
        cuboid("roof", [0.0, 0.0, 5.0], [1.0, 1.0, 6.0]),
    ]);
    let found = sliced(&scene, "z=1", None, None);
    assert_eq!((found.width, found.height), (800, (800.0_f64 * 2.32 / 4.32).round() as u32));
    let size = found.area.size();
    assert!((size[0] - 4.32).abs() < 1e-12 && (size[1] - 2.32).abs() < 1e-12, "{size:?}");
    assert!(found.area.min[0] < 10.0 && found.area.max[1] > 22.0);
    // The ground is there, below.
    let below = sliced(&scene, "x=12", None, Some((50, 50)));
    assert_eq!((below.object[49 * 50 + 25], below.object[25 * 50 + 25], below.object[25]), (0, 1, -1));
    // Square pixels in any size.
    let size = sliced(&scene, "z=1", None, Some((100, 30))).pixel_size();
    assert!((size[0] / size[1] - 1.0).abs() < 1e-12);
}

#[test]
fn a_plane_that_meets_nothing_is_empty() {
    let scene = Scene::of([ball("ball", 1.0)]);
    let found = sliced(&scene, "z=7", None, None);
    assert!(found.object.iter().all(|object| *object == -1) && found.rows.iter().all(Vec::is_empty));
    assert!(found.area.min[0] < -1.0 && found.area.max[0] > 1.0);
    assert!(regions(&found, &world(&scene), &scene, ColorBy::Material).is_empty());
    assert!(
        slice_png(&found, &world(&scene), &scene, ColorBy::Object, Conflicts::Marked).starts_with(b"\x89PNG")
    );
}

#[test]
fn what_cannot_be_sliced_is_an_error() {
    let ground =
        Scene::of([Object::new("ground", Shape::halfspace([0.0, 0.0, 1.0], 0.0).expect("a half-space"))]);
    let try_slice = |scene: &Scene, settings| slice(&world(scene), &settings, Run::default()).map(|_| ());
    assert_eq!(try_slice(&ground, settings("x=0", None, None)), Err(SliceError::NothingBounded));
    let area = Some([-1.0, -1.0, 1.0, 1.0]);
    assert_eq!(try_slice(&ground, settings("x=0", area, Some((4, 4)))), Ok(()));
    let none = Some((0, 4));
    assert_eq!(
        try_slice(&ground, settings("x=0", area, none)),
        Err(SliceError::Size { width: 0, height: 4 })
    );
    assert_eq!(Area::new([0.0; 2], [1.0, 0.0]), Err(SliceError::Area));
    assert_eq!(Area::new([0.0; 2], [f64::NAN, 1.0]), Err(SliceError::Area));
    let cancel = true.into();
    let run = Run { cancel: Some(&cancel), ..Run::default() };
    let cancelled = slice(&world(&ground), &settings("x=0", area, Some((64, 64))), run).map(|_| ());
    assert_eq!(cancelled, Err(SliceError::Cancelled));
}

/// Faces in the plane, and along the middles of rows: a slice is what is below them, as a cut in a picture.
#[test]
fn faces_in_the_plane_and_along_rows_are_no_gaps() {
    let scene = Scene::of([
        cuboid("low", [0.0, 0.0, -1.0], [4.0, 4.0, 0.0]),
        cuboid("high", [0.0, 0.0, 0.0], [4.0, 4.0, 1.0]),
        cuboid("back", [0.0, 4.0, -1.0], [4.0, 8.0, 1.0]),
    ]);
    // The middle of the fourth row is y = 4.
    let found = sliced(&scene, "z=0", Some([0.0, 0.5, 4.0, 7.5]), Some((4, 7)));
    let rows: Vec<&[i32]> = found.object.chunks(4).collect();
    for (row, object) in [(0, 2), (2, 2), (3, 0), (4, 0), (6, 0)] {
        assert_eq!(rows[row], [object; 4], "{row}");
    }
    assert_eq!(sliced(&scene, "0,0,-1,0", Some([0.0, 0.0, 4.0, 4.0]), Some((1, 1))).object, [1]);
    assert!(found.pairs.is_empty());
}

#[test]
fn nothing_depends_on_threads_and_accelerators() {
    let mut random = Random(11);
    let scene = Scene::of((0..4).map(|_| random.object(3, 4.0)).collect::<Vec<_>>());
    let scene = (0..3).fold(scene, |scene, i| scene.with_material(format!("m{i}"), Material::default()));
    let mut first = None;
    for accel in ["brute", "bvh", "grid"] {
        let world = compile(&scene, Options { accel: Some(accel) }).expect("a world");
        for threads in [1, 3] {
            let run = Run { threads, ..Run::default() };
            let found = slice(&world, &settings("z=0.3", None, Some((60, 50))), run).expect("a slice");
            let parts = (found.rows.clone(), found.conflicts.clone());
            let found = (found.object, found.material, found.path, found.overlap, found.pairs, parts);
            assert!(first.get_or_insert_with(|| found.clone()) == &found, "{accel} {threads}");
        }
    }
}

#[test]
fn pictures_name_what_they_show() {
    let red = Material { color: Some([1.0, 0.0, 0.0]), ..Material::default() };
    let mut scene = Scene::of([
        ball("a < b & \"c\"", 1.0).material("red"),
        ball("inner", 0.5).priority(1).material("plain"),
        ball("bare", 0.4).translate([2.0, 0.0, 0.0]),
    ])
    .with_material("red", red)
    .with_material("plain", Material::default());
    scene.units = Some(Units::Millimetres);
    let world = world(&scene);
    let found = sliced(&scene, "z=0", None, Some((300, 200)));
    let by_material = regions(&found, &world, &scene, ColorBy::Material);
    let names: Vec<&str> = by_material.iter().map(|region| region.name.as_str()).collect();
    assert_eq!(names, ["red", "plain", "no material"]);
    assert_eq!((by_material[0].color, by_material[2].number), ([255, 0, 0], -1));
    let svg = slice_svg(&found, &world, &scene, ColorBy::Object, Conflicts::Marked);
    for text in
        ["a &lt; b &amp; &quot;c&quot;</text>", ">inner</text>", ">x (mm)</text>", "z = 0 mm, by object"]
    {
        assert!(svg.contains(text), "{text}");
    }
    let by_instance = slice_svg(&found, &world, &scene, ColorBy::Instance, Conflicts::Hidden);
    assert!(by_instance.contains("by instance") && by_instance.contains(">bare</text>"));
    // A path for each ball.
    assert_eq!(svg.matches("<path fill=").count(), 3);
}
