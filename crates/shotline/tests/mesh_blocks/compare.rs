//! Compares the results of batches by the kernel with those of the plain path, bit for bit.

use std::fmt::Debug;
use std::sync::Mutex;

use shotline::compile::World;
use shotline::query::Scope;
use shotline::query::batch::{self, ClosestRows, Columns, CrossingRows, Run};
use shotline::ray::Ray;

/// How to cast: by the kernel or, as counters are requested, by the plain path.
fn kernel(threads: usize, columns: Columns) -> Run<'static> {
    Run { threads, columns, ..Run::default() }
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

fn closest_rows(found: &ClosestRows, expected: &ClosestRows) -> Result<(), String> {
    column("t", [&found.t, &expected.t], f64::to_bits)?;
    column("t_err", [&found.t_err, &expected.t_err], f64::to_bits)?;
    column("primitive", [&found.primitive, &expected.primitive], |x| x)?;
    column("object", [&found.object, &expected.object], |x| x)?;
    column("surface", [&found.surface, &expected.surface], |x| x)?;
    column("path", [&found.path, &expected.path], |x| x)?;
    column("entering", [&found.entering, &expected.entering], |x| x)?;
    column("normal", [&found.normal, &expected.normal], |n| n.map(f64::to_bits))
}

fn crossing_rows(found: &CrossingRows, expected: &CrossingRows) -> Result<(), String> {
    column("ray_splits", [&found.ray_splits, &expected.ray_splits], |x| x)?;
    column("t", [&found.t, &expected.t], f64::to_bits)?;
    column("t_err", [&found.t_err, &expected.t_err], f64::to_bits)?;
    column("primitive", [&found.primitive, &expected.primitive], |x| x)?;
    column("object", [&found.object, &expected.object], |x| x)?;
    column("surface", [&found.surface, &expected.surface], |x| x)?;
    column("path", [&found.path, &expected.path], |x| x)?;
    column("entering", [&found.entering, &expected.entering], |x| x)?;
    column("kind", [&found.kind, &expected.kind], |x| x)?;
    column("normal", [&found.normal, &expected.normal], |n| n.map(f64::to_bits))
}

fn both<T, E: PartialEq + Debug>(
    name: &str,
    found: Result<T, E>,
    expected: Result<T, E>,
    compare: impl FnOnce(&T, &T) -> Result<(), String>,
) -> Result<(), String> {
    match (found, expected) {
        (Ok(found), Ok(expected)) => compare(&found, &expected).map_err(|what| format!("{name}: {what}")),
        (Err(found), Err(expected)) if found == expected => Ok(()),
        (found, expected) => Err(format!("{name}: {:?} instead of {:?}", found.err(), expected.err())),
    }
}

/// Compares all queries that the kernel casts. Returns the first difference.
pub fn compare(world: &World, rays: &[Ray], scope: Scope, threads: usize) -> Result<(), String> {
    let counters = Mutex::default();
    let plain = Run { threads, counters: Some(&counters), ..Run::default() };
    let run = kernel(threads, Columns::ALL);
    let expected = batch::closest(world, rays, scope, plain);
    both("closest", batch::closest(world, rays, scope, run), expected.clone(), closest_rows)?;
    // Normals are computed only where they are requested.
    let few = Columns::T_ERR | Columns::PRIMITIVE | Columns::ENTERING;
    both(
        "closest without normals",
        batch::closest(world, rays, scope, kernel(threads, few)),
        expected,
        |a, b| {
            column("t", [&a.t, &b.t], f64::to_bits)?;
            column("t_err", [&a.t_err, &b.t_err], f64::to_bits)?;
            column("primitive", [&a.primitive, &b.primitive], |x| x)?;
            column("entering", [&a.entering, &b.entering], |x| x)
        },
    )?;
    let [found, expected] = [run, plain].map(|run| batch::any(world, rays, scope, run));
    both("any", found, expected, |a, b| column("any", [a, b], |x| x))?;
    let [found, expected] = [run, plain].map(|run| batch::count(world, rays, scope, run));
    both("count", found, expected, |a, b| column("count", [a, b], |x| x))?;
    let [found, expected] = [run, plain].map(|run| batch::crossings(world, rays, scope, run));
    both("crossings", found, expected, crossing_rows)
}

/// A few of the `t` at which rays hit a world, by the plain path.
pub fn some_hits(world: &World, rays: &[Ray], scope: Scope) -> Vec<f64> {
    let counters = Mutex::default();
    let plain = Run { threads: 1, counters: Some(&counters), ..Run::default() };
    let some = &rays[..rays.len().min(64)];
    let rows = batch::crossings(world, some, scope, plain).map(|rows| rows.t).unwrap_or_default();
    rows.into_iter().filter(|t| t.is_finite()).collect()
}
