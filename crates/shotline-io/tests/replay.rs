//! Runs every fuzz target on its corpus, on every input that once caused a failure, and on seeded mutations of both.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use shotline::testkit::random::Random;
use shotline_io::fuzz::{TARGETS, Target};

/// The number of mutations of each input. Casting is more expensive than reading.
fn mutations(target: &str) -> usize {
    if matches!(target, "cast" | "csg") { 6 } else { 40 }
}

/// The inputs of a target: `fuzz/corpus` and `fuzz/regressions`.
fn inputs(target: &str) -> Vec<PathBuf> {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let folders = [fuzz.join("corpus").join(target), fuzz.join("regressions").join(target)];
    let entries = folders.iter().flat_map(|folder| fs::read_dir(folder).into_iter().flatten());
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// The bytes with up to four changes: some flipped, removed, repeated, or replaced by bytes of another input.
fn mutated(bytes: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(out.len() + 1);
        let end = (at + random.below(9)).min(out.len());
        let from = random.below(other.len() + 1);
        let piece = &other[from..(from + random.below(9)).min(other.len())];
        match random.below(4) {
            0 => out.splice(at..end, piece.iter().copied()).for_each(drop),
            1 => drop(out.drain(at..end)),
            2 => out.extend_from_within(at..end),
            _ => out[at..end].iter_mut().for_each(|b| *b ^= 1 << random.below(8)),
        }
    }
    out
}

#[test]
fn no_target_panics_on_its_corpus() {
    for (name, target) in TARGETS {
        let corpus: Vec<(PathBuf, Vec<u8>)> =
            inputs(name).into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect();
        assert!(!corpus.is_empty(), "{name} has no corpus");
        let mut random = Random::new(1);
        for (path, bytes) in &corpus {
            assert_no_panic(*target, bytes, &format!("{}", path.display()));
            for _ in 0..mutations(name) {
                let other = &corpus[random.below(corpus.len())].1;
                let bytes = mutated(bytes, other, &mut random);
                assert_no_panic(*target, &bytes, &format!("{name}: {:?}", String::from_utf8_lossy(&bytes)));
            }
        }
    }
}

fn assert_no_panic(target: Target, bytes: &[u8], context: &str) {
    let outcome = catch_unwind(AssertUnwindSafe(|| target(bytes)));
    assert!(outcome.is_ok(), "the panic above was met on {context}");
}
