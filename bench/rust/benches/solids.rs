//! The cost of one line per solid, in the solid's own frame. The lines are random and hit the solid.
//!
//!     cargo bench -p shotline-benches

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use shotline::math::Vec3;
use shotline::ray::Line;
use shotline::solid::{self, Params, Solid};
use shotline::testkit::random::Random;

/// Kinds with parameters of ordinary proportions.
const SOLIDS: &[(&str, &str, &[&[f64]])] = &[
    ("box", "box", &[&[-1.0, -0.8, -0.6], &[1.0, 0.8, 0.6]]),
    ("sphere", "sphere", &[&[1.0]]),
    ("cylinder", "cylinder", &[&[1.0], &[-1.0], &[1.0]]),
    ("cone", "cone", &[&[1.0], &[0.2], &[-1.0], &[1.0]]),
    ("torus, thin", "torus", &[&[1.0], &[0.05]]),
    ("torus", "torus", &[&[1.0], &[0.4]]),
    ("torus, spindle", "torus", &[&[0.5], &[0.7]]),
];
const LINES: usize = 1024;

fn solids(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a line that meets");
    group.throughput(Throughput::Elements(LINES as u64));
    for (name, kind, values) in SOLIDS {
        let kind = solid::kind(kind).expect("a kind of the registry");
        let parts = kind.build(&Params::of(kind, values)).expect("good parameters");
        let Some(solid) = parts.single().cloned() else { continue };
        let lines = lines_that_meet(&*solid);
        let mut list = Vec::new();
        group.bench_function(*name, |b| {
            b.iter(|| {
                for line in &lines {
                    list.clear();
                    solid.crossings(black_box(line), &mut list);
                    black_box(&list);
                }
            });
        });
    }
    group.finish();
}

/// Lines with at least one pair of crossings, between random points of a sphere of three times the bounding
/// radius.
fn lines_that_meet(solid: &dyn Solid) -> Vec<Line> {
    let mut random = Random::new(1);
    let (centre, radius) = solid.bounds().bounding_sphere();
    let mut point = || -> Vec3 { centre + random.direction() * (3.0 * radius) };
    let mut list = Vec::new();
    let lines = std::iter::from_fn(|| {
        let (a, b) = (point(), point());
        Some(Line::exact(a, b - a))
    });
    lines
        .filter(|line| {
            list.clear();
            solid.crossings(line, &mut list);
            !list.is_empty()
        })
        .take(LINES)
        .collect()
}

criterion_group!(benches, solids);
criterion_main!(benches);
