//! Millions of random and aimed rays. Each list is compared with a slow check that shares no code with the
//! solver.
//!
//! A short run is one of the tests. `make soak` runs a long one. `SHOTLINE_SOAK` is the number of rays per family
//! and `SHOTLINE_SOAK_SEED` selects another sequence. The rays are independent of the number of threads, and a
//! longer run begins with the same rays.

#[path = "mesh_blocks/mod.rs"]
mod blocks;
#[path = "soak/bundles.rs"]
mod bundles;
#[path = "soak/exact.rs"]
mod exact;
#[path = "soak/mesh.rs"]
mod mesh;
#[path = "soak/thin.rs"]
mod thin;
#[path = "soak/torus.rs"]
mod torus;

use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering};

use shotline::testkit::random::Random;

/// The number of rays per batch. Threads process the batches of one family.
const BATCH: u64 = 10_000;

/// The results of some rays.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Rays tested.
    pub rays: u64,
    /// The total number of crossings in all lists.
    pub crossings: u64,
    /// Rays so nearly tangent that only exact arithmetic could decide their crossings.
    pub exact: u64,
    /// Rays that run in a face and yield a different list from the far end, which is allowed.
    pub undecidable: u64,
    /// The description of the first wrong list.
    pub first_failure: Option<String>,
    /// The number of wrong lists.
    pub failures: u64,
}

impl Tally {
    fn fail(&mut self, what: String) {
        self.failures += 1;
        self.first_failure.get_or_insert(what);
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Tally) {
        self.rays += other.rays;
        self.crossings += other.crossings;
        self.exact += other.exact;
        self.undecidable += other.undecidable;
        self.failures += other.failures;
        self.first_failure = self.first_failure.take().or(other.first_failure);
    }
}

fn setting(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Err(_) => default,
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is '{text}', but must be a whole number")),
    }
}

/// Runs all rays of a family on all cores and prints a report.
fn soak(family: &str, default: u64, run: impl Fn(&mut Random, u64, &mut Tally) + Sync) {
    let (rays, seed) = (setting("SHOTLINE_SOAK", default), setting("SHOTLINE_SOAK_SEED", 1));
    let next = AtomicU64::new(0);
    let work = || {
        let mut tally = Tally::default();
        loop {
            let begin = BATCH * next.fetch_add(1, Ordering::Relaxed);
            if begin >= rays {
                return tally;
            }
            let mut random = Random::new(seed ^ (begin / BATCH).wrapping_mul(0x2545_f491_4f6c_dd1d));
            run(&mut random, BATCH.min(rays - begin), &mut tally);
            if (begin / BATCH) % 1000 == 999 {
                println!("{family}: {begin} rays begun, {} failures in this thread", tally.failures);
            }
        }
    };
    let mut tally = Tally::default();
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        for thread in threads {
            tally += thread.join().expect("no thread panics");
        }
    });
    let Tally { rays, crossings, exact, undecidable, failures, first_failure } = tally;
    println!(
        "{family}: {rays} rays, {crossings} crossings, {exact} decided exactly, {undecidable} in a face, {failures} failures"
    );
    assert_eq!(failures, 0, "{family}: the first failure: {}", first_failure.unwrap_or_default());
}

#[test]
fn tori() {
    soak("tori", 30_000, torus::run);
}

#[test]
fn mesh_edges_and_vertices() {
    let meshes = mesh::Meshes::new();
    soak("mesh edges and vertices", 30_000, |random, rays, tally| meshes.run(random, rays, tally));
}

/// Blocks of rays that the kernel casts at meshes, compared with the plain path.
#[test]
fn blocks_of_rays_at_meshes() {
    const RAYS_AT_A_TIME: usize = 1_000;
    soak("blocks of rays at meshes", 10_000, |random, rays, tally| {
        let mut left = rays;
        while left > 0 {
            // A case casts three times. A scene that is refused counts as one ray.
            let families = &blocks::meshes::FAMILIES;
            let case = match random.below(3) {
                0 => blocks::cases::any_world(random.bits(), families, RAYS_AT_A_TIME),
                _ => blocks::cases::any(random.bits(), families, RAYS_AT_A_TIME),
            };
            let cast = match case {
                Ok(true) => 3 * RAYS_AT_A_TIME as u64,
                Ok(false) => 1,
                Err(what) => {
                    tally.fail(what);
                    RAYS_AT_A_TIME as u64
                }
            };
            tally.rays += cast;
            left = left.saturating_sub(cast);
        }
    });
}

#[test]
fn thin_meshes_and_spans() {
    let meshes = thin::Meshes::new();
    soak("thin meshes and spans", 10_000, |random, rays, tally| meshes.run(random, rays, tally));
}

/// Rays that are cast at solids together, compared with single rays.
#[test]
fn bundles_of_rays_at_solids() {
    soak("bundles of rays at solids", 20_000, bundles::run);
}
