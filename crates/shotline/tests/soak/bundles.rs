//! Rays that run close together, which are cast at solids together, compared with single rays bit for bit.

use shotline::compile::{Options, World, compile};
use shotline::math::Vec3;
use shotline::query::batch::{self, RowsOfSix, Run};
use shotline::query::{Overlaps, Scope};
use shotline::ray::Span;
use shotline::testkit::random::Random;
use shotline::testkit::scene::{random_crowd, random_mixed_scene};

use super::Tally;

/// Rays of one scene.
const RAYS_AT_A_TIME: usize = 500;

/// Pencils, and grids along an axis or almost, in which some rays may run in faces.
fn rays(random: &mut Random) -> Vec<[f64; 6]> {
    let mut rays = Vec::new();
    while rays.len() < RAYS_AT_A_TIME {
        let axis = Vec3::AXES[random.below(3)];
        let (mut o, mut d) = (random.direction() * [0.5, 6.0][random.below(2)], random.point(-1.5, 1.5));
        match random.below(3) {
            0 => d -= o,
            1 => (o, d) = ((o * 4.0).round() / 4.0 - axis * 6.0, axis),
            _ => (o, d) = (o - axis * 6.0, axis + d * 1e-3),
        }
        let (step, turn) = (random.direction() * 0.02, random.direction() * [0.0, 0.005][random.below(2)]);
        for i in 0..1 + random.below(50) {
            let (o, d) = (o + step * i as f64, d + turn * i as f64);
            rays.push([o.x, o.y, o.z, d.x, d.y, d.z]);
        }
    }
    rays
}

/// The results of every query as text: then NaN normals are equal.
fn answers(world: &World, rays: &[[f64; 6]], scope: Scope, run: Run) -> [String; 5] {
    let rays = RowsOfSix(rays);
    [
        format!("{:?}", batch::closest(world, &rays, scope, run)),
        format!("{:?}", batch::any(world, &rays, scope, run)),
        format!("{:?}", batch::count(world, &rays, scope, run)),
        format!("{:?}", batch::crossings(world, &rays, scope, run)),
        format!("{:?}", batch::segments(world, &rays, scope.span, Overlaps::All, run)),
    ]
}

/// Compares bundles with single rays.
pub fn run(random: &mut Random, rays_left: u64, tally: &mut Tally) {
    let mut left = rays_left;
    while left > 0 {
        let cast = left.min(RAYS_AT_A_TIME as u64);
        left -= cast;
        tally.rays += cast;
        let scene = if random.below(2) == 0 { random_mixed_scene(random) } else { random_crowd(random) };
        let Ok(world) = compile(&scene, Options::default()) else { continue };
        let mut rays = rays(random);
        if random.below(2) == 0 {
            // Rays that do not run close together are cast in waves, or in loose bundles.
            random.shuffle(&mut rays);
        }
        let rays = &rays[..cast as usize];
        let span = Span::new(random.number(-3.0, 3.0), 3.0 + random.number(0.0, 5.0)).expect("a span");
        let scope = match random.below(3) {
            0 => Scope::from(span),
            1 => Scope::surfaces(span),
            _ => Scope::from(Span::FORWARD),
        };
        let counters = Default::default();
        let together = Run { threads: 1, ..Run::default() };
        // Rays are cast one by one where work is counted.
        let alone = Run { counters: Some(&counters), ..together };
        let [found, expected] = [together, alone].map(|run| answers(&world, rays, scope, run));
        for (query, (found, expected)) in found.iter().zip(&expected).enumerate() {
            if found != expected {
                tally.fail(format!("query {query} of {scope:?}: {scene:?}, {rays:?}"));
            }
        }
        let all = batch::count(&world, &RowsOfSix(rays), scope, together);
        tally.crossings += all.map_or(0, |counts| counts.iter().sum::<i64>()) as u64;
    }
}
