//! How build time, memory and ray cost grow with the number of instances, and the cost of moving some:
//! `cargo bench -p shotline-benches --bench instances`.
//!
//! A field of 10^2 to 10^7 instances of one sphere: build time, memory, and nanoseconds per ray. Then some of
//! 10^5 instances move: the time to refit is compared with the time to recompile.

use std::time::Instant;

use shotline::compile::{DynamicWorld, Options, compile};
use shotline::math::Affine;
use shotline::query::Caster;
use shotline::ray::{Ray, Span};
use shotline::scene::{LocalTransform, Node, NodeId, Scene};
use shotline::testkit::random::Random;

/// Returns a scene of random spheres in a cube and their transform nodes. The radius shrinks with the count, so
/// that the volume of all spheres stays the same.
fn field(count: usize) -> (Scene, Vec<NodeId>) {
    let mut random = Random::new(1);
    let mut scene = Scene::default();
    let radius = 0.3 * (count as f64).powf(-1.0 / 3.0);
    let ball = scene.add_solid("sphere", &[&[radius]]).expect("there are spheres");
    let mut place = |_| scene.add_transform(Affine::translation(random.point(-1.0, 1.0)), ball);
    let members: Vec<NodeId> = (0..count).map(&mut place).collect();
    let group = scene.add(Node::Group { members: members.clone() });
    scene.add_object("field", None, group);
    (scene, members)
}

fn rays(count: usize) -> Vec<Ray> {
    let mut random = Random::new(2);
    let mut one = || {
        let origin = random.direction() * 4.0;
        Ray::new(origin, random.point(-1.0, 1.0) - origin).expect("a ray")
    };
    (0..count).map(|_| one()).collect()
}

fn main() {
    let rays = rays(100_000);
    println!(
        "  instances    build, s    memory, MB  bytes each  closest, ns  crossings, ns  crossings a ray"
    );
    for power in 2..=7 {
        let count = 10usize.pow(power);
        let (scene, _) = field(count);
        let begin = Instant::now();
        let world = compile(&scene, Options::default()).expect("it compiles");
        let build = begin.elapsed().as_secs_f64();
        let mut caster = Caster::new(&world);
        let begin = Instant::now();
        let first = rays
            .iter()
            .filter(|ray| caster.closest(ray, Span::FORWARD).expect("within limits").is_some())
            .count();
        let closest = begin.elapsed().as_nanos() / rays.len() as u128;
        assert!(first > 0, "rays meet something");
        let mut hits = Vec::new();
        let begin = Instant::now();
        let met: usize = rays
            .iter()
            .map(|ray| {
                hits.clear();
                caster.crossings(ray, Span::FORWARD, &mut hits).expect("within limits");
                hits.len()
            })
            .sum();
        let every = begin.elapsed().as_nanos() / rays.len() as u128;
        let memory = world.stats().memory_bytes;
        let (megabytes, each) = (memory as f64 / 1e6, memory / count);
        let met = met as f64 / rays.len() as f64;
        println!(
            "{count:>11}  {build:>10.4}  {megabytes:>12.3}  {each:>10}  {closest:>11}  {every:>13}  {met:>15.2}"
        );
    }
    println!("\nof 100,000 instances, moved by a hundredth of the field: milliseconds, median of 9");
    for moved in [1, 10, 1000] {
        motion(moved);
    }
}

fn motion(moved: usize) {
    let (scene, places) = field(100_000);
    let mut random = Random::new(3);
    let mut live = DynamicWorld::new(scene, Options::default()).expect("it compiles");
    let (mut refit, mut recompiled) = (Vec::new(), Vec::new());
    for round in 0..10 {
        let mut change = || {
            let node = places[random.below(places.len())];
            let Node::Transform { transform: LocalTransform::Matrix(old), .. } = live.scene().node(node)
            else {
                unreachable!("the places are transforms")
            };
            (node, LocalTransform::Matrix(Affine::translation(random.point(-0.01, 0.01)).then_after(old)))
        };
        let changes: Vec<_> = (0..moved).map(|_| change()).collect();
        let begin = Instant::now();
        live.set(&changes).expect("it moves");
        // The first change also finds where operands are used, which later ones reuse.
        if round > 0 {
            refit.push(begin.elapsed().as_secs_f64() * 1e3);
            let begin = Instant::now();
            drop(compile(live.scene(), Options::default()).expect("it compiles"));
            recompiled.push(begin.elapsed().as_secs_f64() * 1e3);
        }
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let (refit, recompiled) = (median(&mut refit), median(&mut recompiled));
    println!(
        "{moved:>6} moved: {refit:>8.4} refitted, {recompiled:>8.1} recompiled: {:.0} times faster",
        recompiled / refit
    );
}
