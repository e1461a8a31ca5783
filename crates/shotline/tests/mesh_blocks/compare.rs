//! Compares the results of batches by the kernel with those of the plain path, bit for bit.

use std::fmt::Debug;
use std::sync::Mutex;

use shotline::compile::World;
use shotline::query::batch::{self, BatchCaster, By, ClosestRows, CrossingRows, Fields, Run, SegmentRows};
use shotline::query::{Overlaps, Scope};
use shotline::ray::Ray;

use super::cases::Placed;

/// How to cast: by the kernel or, as counters are requested, by the plain path.
fn kernel(threads: usize, fields: Fields) -> Run<'static> {
    Run { threads, fields, ..Run::default() }
}

/// The first row in which two columns differ.
fn column<T: Copy + Debug, K: PartialEq>(
    name: &str,
    [found, expected]: [&[T]; 2],
    bits: impl Fn(T) -> K,
) -> Result<(), String> {
    if found.len() != expected.len() {
        return Err(format!("{name}: {} rows instead of {}", found.len(), expected.len()));
    }
    match found.iter().zip(expected).position(|(a, b)| bits(*a) != bits(*b)) {
        Some(row) => Err(format!("{name}, row {row}: {:?} instead of {:?}", found[row], expected[row])),
        None => Ok(()),
    }
}

/// Compares columns of two results, the numbers among them by their bits.
macro_rules! same_columns {
    ($found:expr, $expected:expr; $($name:ident $bits:expr),* $(,)?) => {{
        $(column(stringify!($name), [&$found.$name, &$expected.$name], $bits)?;)*
        Ok::<(), String>(())
    }};
}

/// Compares the columns that both results have.
macro_rules! same_hits {
    ($found:expr, $expected:expr; $($name:ident $bits:expr),*) => {
        same_columns!($found, $expected;
            $($name $bits,)*
            t f64::to_bits,
            t_err f64::to_bits,
            primitive |x| x,
            object |x| x,
            surface |x| x,
            path |x| x,
            entering |x| x,
            normal |n: [f64; 3]| n.map(f64::to_bits),
        )
    };
}

fn closest_rows(found: &ClosestRows, expected: &ClosestRows) -> Result<(), String> {
    same_hits!(found, expected; )
}

fn crossing_rows(found: &CrossingRows, expected: &CrossingRows) -> Result<(), String> {
    same_hits!(found, expected; ray_splits |x| x, kind |x| x)
}

fn segment_rows(found: &SegmentRows, expected: &SegmentRows) -> Result<(), String> {
    same_columns!(found, expected;
        ray_splits |x| x,
        t_in f64::to_bits,
        t_out f64::to_bits,
        length f64::to_bits,
        material |x| x,
        object |x| x,
        path |x| x,
    )?;
    column("overlaps", [&[found.overlaps], &[expected.overlaps]], |x| x)
}

fn both<T, U, E: PartialEq + Debug>(
    name: &str,
    found: Result<T, E>,
    expected: Result<U, E>,
    compare: impl FnOnce(&T, &U) -> Result<(), String>,
) -> Result<(), String> {
    match (found, expected) {
        (Ok(found), Ok(expected)) => compare(&found, &expected).map_err(|what| format!("{name}: {what}")),
        (Err(found), Err(expected)) if found == expected => Ok(()),
        (found, expected) => Err(format!("{name}: {:?} instead of {:?}", found.err(), expected.err())),
    }
}

/// Compares all queries that the kernel casts with those of the plain path: through the same hierarchy, and by brute
/// force, which shares no structure with the kernel. Returns the first difference.
pub fn compare(placed: &Placed, rays: &[Ray], scope: Scope, threads: usize) -> Result<(), String> {
    let by_brute_force = rays.len() * placed.targets.triangles.len() < 200_000;
    compare_with(&placed.world, &placed.world, rays, scope, threads)?;
    if by_brute_force {
        compare_with(&placed.world, &placed.brute, rays, scope, threads)
            .map_err(|what| format!("by brute force: {what}"))?;
    }
    Ok(())
}

fn compare_with(
    world: &World,
    reference: &World,
    rays: &[Ray],
    scope: Scope,
    threads: usize,
) -> Result<(), String> {
    let counters = Mutex::default();
    let plain = Run { threads, counters: Some(&counters), ..Run::default() };
    let run = kernel(threads, Fields::ALL);
    let expected = batch::closest(reference, rays, scope, plain);
    both("closest", batch::closest(world, rays, scope, run), expected.clone(), closest_rows)?;
    // Twice, so that its memory is used again.
    let mut caster = BatchCaster::new(world, run);
    for _ in 0..2 {
        let mut found = ClosestRows::default();
        let found = caster.closest(rays, scope, None, &mut found).map(|()| found);
        both("closest of a batch caster", found, expected.clone(), closest_rows)?;
    }
    // Normals are computed only where they are requested.
    let few = Fields::T_ERR | Fields::PRIMITIVE | Fields::ENTERING;
    both(
        "closest without normals",
        batch::closest(world, rays, scope, kernel(threads, few)),
        expected,
        |a, b| same_columns!(a, b; t f64::to_bits, t_err f64::to_bits, primitive |x| x, entering |x| x),
    )?;
    let [found, expected] =
        [(world, run), (reference, plain)].map(|(world, run)| batch::any(world, rays, scope, run));
    both("any", found, expected.clone(), |a, b| column("any", [a, b], |x| x))?;
    let mut found = Vec::new();
    let found = caster.any(rays, scope, None, &mut found).map(|()| found);
    both("any of a batch caster", found, expected, |a, b| column("any", [a, b], |x| x))?;
    let [found, expected] =
        [(world, run), (reference, plain)].map(|(world, run)| batch::count(world, rays, scope, run));
    both("count", found, expected, |a, b| column("count", [a, b], |x| x))?;
    let [found, expected] =
        [(world, run), (reference, plain)].map(|(world, run)| batch::crossings(world, rays, scope, run));
    both("crossings", found, expected, crossing_rows)?;
    let overlaps = [Overlaps::Error, Overlaps::Priority, Overlaps::All][rays.len() % 3];
    let [found, expected] = [(world, run), (reference, plain)]
        .map(|(world, run)| batch::segments(world, rays, scope.span, overlaps, run));
    both("segments", found, expected.clone(), segment_rows)?;
    let mut lengths = vec![Vec::new(); rays.len()];
    let taken = caster.segments(rays, scope.span, overlaps, |row, segments| {
        lengths[row].extend(segments.iter().map(|segment| segment.length));
    });
    both("segments of a batch caster", taken.map(|()| lengths.concat()), expected, |a, b| {
        column("length", [a, &b.length], f64::to_bits)
    })?;
    let [found, expected] = [(world, run), (reference, plain)]
        .map(|(world, run)| batch::thickness(world, rays, scope.span, By::Object, overlaps, run));
    both("thickness", found, expected, |a, b| {
        same_columns!(a, b; lengths f64::to_bits)?;
        column("overlaps", [&[a.overlaps], &[b.overlaps]], |x| x)
    })
}

/// A few of the `t` at which rays hit a world, by the plain path.
pub fn some_hits(world: &World, rays: &[Ray], scope: Scope) -> Vec<f64> {
    let counters = Mutex::default();
    let plain = Run { threads: 1, counters: Some(&counters), ..Run::default() };
    let some = &rays[..rays.len().min(64)];
    let rows = batch::crossings(world, some, scope, plain).map(|rows| rows.t).unwrap_or_default();
    rows.into_iter().filter(|t| t.is_finite()).collect()
}
