//! Compares batches to a single caster that traces one ray after the other.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use super::*;
use crate::compile::{Options, compile};
use crate::counters::Counters;
use crate::math::{Affine, Vec3};
use crate::query::{Caster, Hit, Segment};
use crate::ray::Ray;
use crate::scene::{Material, Node, Scene};
use crate::testkit::random::Random;
use crate::testkit::scene::random_scene;

fn world(scene: &Scene) -> World {
    compile(scene, Options::default()).unwrap_or_else(|e| panic!("{e:?}"))
}

/// A random scene whose objects have one of two materials or none.
fn material_world(random: &mut Random) -> World {
    let mut scene = random_scene(random);
    scene.materials = ["steel", "water"].map(|name| (name.to_owned(), Material::default())).to_vec();
    for i in 0..scene.objects.len() {
        let object = scene.objects[i].0 as usize;
        if let Node::Object { material, .. } = &mut scene.nodes[object] {
            *material = ["steel", "water"].get(i % 3).map(|name| name.to_string());
        }
    }
    world(&scene)
}

fn ball() -> World {
    ball_with("bvh")
}

/// A ball at which rays are cast one by one.
fn plain_ball() -> World {
    ball_with("grid")
}

fn ball_with(accel: &'static str) -> World {
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
    scene.add_object("ball", None, ball);
    compile(&scene, Options { accel: Some(accel) }).expect("a world")
}

fn some_rays(random: &mut Random, n: usize) -> Vec<Ray> {
    let mut ray = || {
        let o = random.direction() * 6.0;
        Ray::new(o, random.point(-1.5, 1.5) - o).expect("a ray")
    };
    (0..n).map(|_| ray()).collect()
}

fn run(threads: usize) -> Run<'static> {
    Run { threads, ..Run::default() }
}

/// Rows that may be invalid rays, and the number of requests.
struct Rows {
    rows: Vec<[f64; 6]>,
    asked: AtomicUsize,
    /// From this request on, the last row is not a ray.
    spoiled_from: usize,
}

impl Rows {
    fn new(rays: &[Ray]) -> Rows {
        let row = |ray: &Ray| {
            let ([a, b, c], [d, e, f]) = (ray.origin().to_array(), ray.direction().to_array());
            [a, b, c, d, e, f]
        };
        Rows { rows: rays.iter().map(row).collect(), asked: AtomicUsize::new(0), spoiled_from: usize::MAX }
    }
}

impl Rays for Rows {
    fn len(&self) -> usize {
        self.rows.len()
    }

    fn ray(&self, row: usize) -> Result<Ray, InvalidRay> {
        let asked = self.asked.fetch_add(1, Ordering::Relaxed);
        if asked >= self.spoiled_from && row + 1 == self.rows.len() {
            return Err(InvalidRay::Origin);
        }
        let [a, b, c, d, e, f] = self.rows[row];
        Ray::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
    }
}

/// The results of every batch query as text, which shows every bit except those of NaN.
fn batch_answers(world: &World, rays: &(impl Rays + ?Sized), run: Run) -> String {
    let span = Span::FORWARD;
    let closest = closest(world, rays, span, run).expect("closest");
    let any = any(world, rays, span, run).expect("any");
    let count = count(world, rays, span, run).expect("count");
    let crossings = crossings(world, rays, span, run).expect("crossings");
    let segments = segments(world, rays, span, Overlaps::Priority, run).expect("segments");
    let thickness = thickness(world, rays, span, By::Material, Overlaps::Priority, run).expect("thickness");
    format!("{closest:?}\n{any:?}\n{count:?}\n{crossings:?}\n{segments:?}\n{thickness:?}")
}

/// The same results from a caster.
fn plain_answers(world: &World, rays: &[Ray]) -> String {
    let (mut caster, span) = (Caster::new(world), Span::FORWARD);
    let number = |x: Option<u32>| x.map_or(-1, |x| x as i32);
    let mut first = ClosestRows::default();
    let mut all = CrossingRows { ray_splits: vec![0], ..CrossingRows::default() };
    let mut inside = SegmentRows { ray_splits: vec![0], ..SegmentRows::default() };
    let columns = world.material_names().len() + 1;
    let mut through = Thickness { columns, ..Thickness::default() };
    let (mut any, mut count) = (Vec::new(), Vec::new());
    let (mut hits, mut segments): (Vec<Hit>, Vec<Segment>) = (Vec::new(), Vec::new());
    for ray in rays {
        let hit = caster.closest(ray, span).expect("within limits");
        first.t.push(hit.map_or(f64::INFINITY, |h| h.t));
        first.normal.push(hit.map_or([f64::NAN; 3], |h| h.normal.to_array()));
        first.object.push(number(hit.map(|h| h.object)));
        first.surface.push(number(hit.and_then(|h| h.surface)));
        first.primitive.push(number(hit.and_then(|h| h.primitive)));
        first.path.push(hit.map_or(-1, |h| h.path as i64));
        first.entering.push(hit.is_some_and(|h| h.entering));
        first.t_err.push(hit.map_or(f64::NAN, |h| h.t_err));
        any.push(caster.any(ray, span).expect("within limits"));
        count.push(caster.count(ray, span).expect("within limits") as i64);
        hits.clear();
        caster.crossings(ray, span, &mut hits).expect("within limits");
        for hit in &hits {
            all.t.push(hit.t);
            all.normal.push(hit.normal.to_array());
            all.entering.push(hit.entering);
            all.object.push(hit.object as i32);
            all.surface.push(number(hit.surface));
            all.primitive.push(number(hit.primitive));
            all.path.push(hit.path as i64);
            all.kind.push(hit.kind as i8);
            all.t_err.push(hit.t_err);
        }
        all.ray_splits.push(all.t.len() as i64);
        segments.clear();
        inside.overlaps += caster.segments(ray, span, Overlaps::Priority, &mut segments).expect("solids");
        let mut lengths = vec![0.0; world.material_names().len() + 1];
        for segment in &segments {
            inside.t_in.push(segment.t_in);
            inside.t_out.push(segment.t_out);
            inside.length.push(segment.length);
            inside.material.push(number(segment.material));
            inside.object.push(segment.object as i32);
            inside.path.push(segment.path as i64);
            let column = segment.material.map_or(lengths.len() - 1, |material| material as usize);
            lengths[column] += segment.length;
        }
        inside.ray_splits.push(inside.t_in.len() as i64);
        through.lengths.extend(lengths);
    }
    through.overlaps = inside.overlaps;
    format!("{first:?}\n{any:?}\n{count:?}\n{all:?}\n{inside:?}\n{through:?}")
}

/// For any number of threads, and at the limits of intervals, chunks and rounds.
#[test]
fn batches_are_what_the_caster_answers() {
    let mut random = Random::new(31);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
    for n in [0, 1, 64, 65, 255, 257, 4095, 4096, 4097, 9_000] {
        let world = material_world(&mut random);
        let rays = some_rays(&mut random, n);
        let expected = plain_answers(&world, &rays);
        for threads in [1, 2, 5] {
            assert!(batch_answers(&world, &rays, run(threads)) == expected, "{n} rays, {threads} threads");
        }
        let run = Run { pool: Some(&pool), ..Run::default() };
        assert!(batch_answers(&world, &Rows::new(&rays), run) == expected, "{n} rows, kept threads");
    }
}

/// Rays have so many crossings that the rows of a few chunks fill a round.
#[test]
fn many_rounds_are_one_answer() {
    let world = row_of_balls(30);
    let ray = |i: usize| {
        let y = if i % 7 < 2 { 3.0 } else { i as f64 * 1e-5 };
        Ray::new(Vec3::new(-1.0, y, 0.0), Vec3::X).expect("a ray")
    };
    let rays: Vec<Ray> = (0..5_000).map(ray).collect();
    let expected = plain_answers(&world, &rays);
    for threads in [1, 2, 4] {
        assert!(batch_answers(&world, &rays, run(threads)) == expected, "{threads} threads");
    }
}

fn row_of_balls(n: i32) -> World {
    let mut scene = Scene::default();
    let ball = scene.add_solid("sphere", &[&[0.4]]).expect("a sphere");
    let place = |i| scene.add_transform(Affine::translation(Vec3::X * f64::from(i)), ball);
    let members = (0..n).map(place).collect();
    let group = scene.add(Node::Group { members });
    scene.add_object("row", None, group);
    world(&scene)
}

#[test]
fn threads_are_started_for_many_rays_only() {
    let (world, rays) = (ball(), some_rays(&mut Random::new(37), 50_000));
    let here = std::thread::current().id();
    for (n, threads, alone) in [(4096, 0, true), (4096, 3, true), (50_000, 1, true), (50_000, 3, false)] {
        let elsewhere = AtomicBool::new(false);
        let progress = |_| _ = elsewhere.fetch_or(std::thread::current().id() != here, Ordering::Relaxed);
        let run = Run { progress: Some(&progress), ..run(threads) };
        any(&world, &rays[..n], Span::FORWARD, run).expect("any");
        crossings(&world, &rays[..n], Span::FORWARD, run).expect("crossings");
        assert_eq!(elsewhere.into_inner(), !alone, "{n} rays, {threads} threads");
    }
}

#[test]
fn bad_rows_are_named_before_any_work() {
    let (world, mut random) = (ball(), Random::new(32));
    for n in [3_000, 50_000] {
        let mut rows = Rows::new(&some_rays(&mut random, n));
        for bad in [n / 2, n / 2 + 1, n - 1] {
            rows.rows[bad][3..].fill(0.0);
        }
        let expected = BatchError::Ray { row: n / 2, error: InvalidRay::ZeroDirection };
        assert_eq!(check(&rows), Err(expected.clone()));
        for threads in [1, 2] {
            let (counters, done) = (Mutex::new(Counters::default()), AtomicU64::new(0));
            let progress = |n| _ = done.fetch_add(n, Ordering::Relaxed);
            let run = Run { counters: Some(&counters), progress: Some(&progress), ..run(threads) };
            let error = crossings(&world, &rows, Span::FORWARD, run).expect_err("a bad row");
            assert_eq!(error, expected);
            assert_eq!(closest(&world, &rows, Span::FORWARD, run), Err(expected.clone()));
            assert_eq!((counters.into_inner().expect("no panic").boxes, done.into_inner()), (0, 0));
        }
    }
}

#[test]
fn a_row_that_is_spoiled_on_the_way_is_an_error() {
    let (world, n) = (plain_ball(), 5_000);
    for threads in [1, 2] {
        let mut rows = Rows::new(&some_rays(&mut Random::new(33), n));
        rows.spoiled_from = n;
        let expected = Err(BatchError::Ray { row: n - 1, error: InvalidRay::Origin });
        assert_eq!(any(&world, &rows, Span::FORWARD, run(threads)).map(drop), expected);
    }
}

/// Of two rays that fail, the first is named, however late it is found.
#[test]
fn the_first_ray_without_an_answer_is_named() {
    let mut scene = Scene::default();
    for name in ["left", "right"] {
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
        scene.add_object(name, None, ball);
    }
    let world = world(&scene);
    let through = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X).expect("a ray");
    let past = Ray::new(Vec3::new(-5.0, 3.0, 0.0), Vec3::X).expect("a ray");
    let mut rays = vec![past; 30_000];
    for first in [29_999, 17_000, 300, 0] {
        rays[first] = through;
        for threads in [1, 2, 4] {
            let segments = segments(&world, &rays, Span::FORWARD, Overlaps::Error, run(threads)).map(drop);
            let thickness =
                thickness(&world, &rays, Span::FORWARD, By::Material, Overlaps::Error, run(threads))
                    .map(drop);
            for answer in [segments, thickness] {
                assert!(matches!(answer, Err(BatchError::Query { row, .. }) if row == first), "{answer:?}");
            }
        }
    }
}

/// The flag is checked every few rows, not every chunk, because rays may be expensive.
#[test]
fn a_batch_that_is_cancelled_ends_soon() {
    let (world, rays) = (plain_ball(), some_rays(&mut Random::new(34), 20_000));
    for threads in [1, 2] {
        let (cancel, done) = (AtomicBool::new(false), AtomicU64::new(0));
        let progress = |n| {
            assert!((1..=64).contains(&n));
            done.fetch_add(n, Ordering::Relaxed);
            cancel.store(true, Ordering::Relaxed);
        };
        let run = Run { progress: Some(&progress), cancel: Some(&cancel), ..run(threads) };
        assert_eq!(count(&world, &rays, Span::FORWARD, run), Err(BatchError::Cancelled));
        assert_eq!(crossings(&world, &rays, Span::FORWARD, run), Err(BatchError::Cancelled));
        assert!((1..=64 * threads as u64).contains(&done.into_inner()));
    }
}

#[test]
fn all_progress_and_work_is_told() {
    let (world, rays) = (ball(), some_rays(&mut Random::new(35), 10_001));
    let told = |threads| {
        let (counters, done) = (Mutex::new(Counters::default()), AtomicU64::new(0));
        let progress = |n| _ = done.fetch_add(n, Ordering::Relaxed);
        let run = Run { counters: Some(&counters), progress: Some(&progress), ..run(threads) };
        closest(&world, &rays, Span::FORWARD, run).expect("closest");
        crossings(&world, &rays, Span::FORWARD, run).expect("crossings");
        assert_eq!(done.into_inner(), 20_002);
        counters.into_inner().expect("no panic")
    };
    assert_eq!((told(1), told(1).primitive_tests > 10_000), (told(3), true));
}

#[test]
fn more_rows_than_asked_for_are_an_error() {
    let (world, ray) = (row_of_balls(10), Ray::new(Vec3::X * -1.0, Vec3::X).expect("a ray"));
    let rays = vec![ray; 6_000];
    for threads in [1, 2] {
        let run = |most_rows| Run { most_rows, ..run(threads) };
        for most in [0, 119_999] {
            let error = crossings(&world, &rays, Span::FORWARD, run(most)).expect_err("too many");
            assert_eq!(error, BatchError::TooMany { most });
        }
        assert_eq!(
            crossings(&world, &rays, Span::FORWARD, run(120_000)).map(|rows| rows.t.len()),
            Ok(120_000)
        );
        assert!(count(&world, &rays, Span::FORWARD, run(0)).is_ok());
    }
}

/// Two balls, one inside the other, and only the inner one has a material: every length is in a column.
#[test]
fn thickness_counts_what_has_no_material() {
    let mut scene = Scene::default();
    scene.materials.push(("lead".into(), Material::default()));
    for (radius, material) in [(2.0, None), (1.0, Some("lead"))] {
        let ball = scene.add_solid("sphere", &[&[radius]]).expect("a sphere");
        scene.add_object("ball", material, ball);
    }
    let (world, ray) = (world(&scene), Ray::new(Vec3::X * -5.0, Vec3::X).expect("a ray"));
    for n in [1, 600] {
        let answer = |by| thickness(&world, &vec![ray; n], Span::FORWARD, by, Overlaps::Priority, run(1));
        for (by, columns) in [(By::Material, [2.0, 2.0]), (By::Object, [2.0, 2.0])] {
            let lengths = columns.repeat(n);
            // The later ball owns the overlap, at each of its two ends.
            assert_eq!(answer(by), Ok(Thickness { lengths, columns: 2, overlaps: n as u64 }), "{by:?}");
        }
    }
}

#[test]
fn without_materials_all_lengths_are_in_the_last_column() {
    let mut scene = Scene::default();
    for name in ["left", "right"] {
        let ball = scene.add_solid("sphere", &[&[1.0]]).expect("a sphere");
        scene.add_object(name, None, ball);
    }
    let (world, ray) = (world(&scene), Ray::new(Vec3::X * -5.0, Vec3::X).expect("a ray"));
    for n in [0, 1, 600] {
        let answer = |by| thickness(&world, &vec![ray; n], Span::FORWARD, by, Overlaps::Priority, run(1));
        let overlaps = n as u64;
        assert_eq!(answer(By::Material), Ok(Thickness { lengths: vec![2.0; n], columns: 1, overlaps }));
        let lengths = [0.0, 2.0].repeat(n);
        assert_eq!(answer(By::Object), Ok(Thickness { lengths, columns: 2, overlaps }));
    }
    let more = thickness(
        &world,
        &vec![ray; 3],
        Span::FORWARD,
        By::Object,
        Overlaps::All,
        Run { most_rows: 5, ..run(1) },
    );
    assert_eq!(more, Err(BatchError::TooMany { most: 5 }));
}

#[test]
fn points_are_in_what_the_caster_says() {
    let mut random = Random::new(36);
    for n in [0, 1, 4097, 9_000] {
        let world = world(&random_scene(&mut random));
        let points: Vec<Vec3> = (0..n).map(|_| random.point(-2.0, 2.0)).collect();
        let mut caster = Caster::new(&world);
        let mut expected = ObjectRows { point_splits: vec![0], object: Vec::new() };
        let mut inside = Vec::new();
        for &point in &points {
            let mut objects = Vec::new();
            caster.contains(point, &mut objects).expect("solids");
            inside.push(!objects.is_empty());
            expected.object.extend(objects.iter().map(|&object| object as i32));
            expected.point_splits.push(expected.object.len() as i64);
        }
        for threads in [1, 3] {
            assert_eq!(contains(&world, &points, run(threads)), Ok(inside.clone()));
            assert_eq!(objects_containing(&world, &points, run(threads)), Ok(expected.clone()));
        }
    }
}

#[test]
fn points_that_are_nowhere_are_named() {
    let world = ball();
    for x in [f64::NAN, f64::INFINITY] {
        let mut points = vec![Vec3::ZERO; 5_000];
        points[4_500].y = x;
        points[4_700].z = x;
        for threads in [1, 2] {
            let expected = BatchError::Point { row: 4_500 };
            assert_eq!(contains(&world, &points, run(threads)), Err(expected.clone()));
            assert_eq!(objects_containing(&world, &points, run(threads)), Err(expected));
        }
    }
}

#[test]
fn costs_are_those_of_the_closest_crossing() {
    let mut random = Random::new(9);
    let world = material_world(&mut random);
    let rays = some_rays(&mut random, 2 * CHUNK + 3);
    let costs = cost(&world, &rays, Span::FORWARD, run(2)).expect("an answer");
    let mut caster = Caster::new(&world);
    for (ray, costs) in rays.iter().zip(costs.chunks_exact(COUNTERS.len())) {
        caster.closest(ray, Span::FORWARD).expect("within limits");
        let counters = caster.take_counters();
        let expected: Vec<i64> = COUNTERS.iter().map(|counter| (counter.of)(&counters) as i64).collect();
        assert_eq!(costs, expected);
    }
}
