//! `shotline cast`.

mod sandbox;

use std::fs;

use sandbox::{DRILLED, Sandbox};
use serde_json::Value;

/// Rays across the drilled ball: through the hole, beside it, past everything, from the inside.
const RAYS: &[[f64; 6]] = &[
    [-10.0, 0.0, 0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, -10.0, 0.0, 0.0, 3.0],
    [-10.0, 0.3, 0.2, 1.0, 0.01, 0.02],
    [0.0, 0.0, 9.0, 0.0, 0.0, 1.0],
    [3.0, 0.0, 0.0, 0.5, 0.0, 0.0],
];

const QUERIES: [&str; 6] = ["closest", "any", "count", "crossings", "segments", "thickness"];

fn sandbox() -> Sandbox {
    Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", RAYS)
}

fn cast<'a>(query: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    let fixed = ["cast", "drilled.json", "--rays", "rays.npy", "-o", "out.npz", "--query", query];
    [&fixed[..], rest].concat()
}

#[test]
fn the_same_bits_for_every_accelerator_and_number_of_threads() {
    // Many rays, so that the threads share them.
    let many: Vec<[f64; 6]> = (0..20_000)
        .map(|i| {
            let a = f64::from(i) * 0.017;
            [-10.0, a.sin() * 4.0, (a * 1.7).cos() * 4.0, 1.0, 0.1 * (a * 0.3).sin(), 0.05]
        })
        .collect();
    let sandbox = sandbox().with_rays("rays.npy", &many);
    for query in QUERIES {
        let mut first: Option<Vec<u8>> = None;
        for accel in shotline::accel::NAMES {
            for threads in ["1", "2"] {
                sandbox.run(&cast(query, &["--accel", accel, "--threads", threads])).ok();
                let bytes = fs::read(sandbox.path("out.npz")).unwrap();
                let same = first.get_or_insert_with(|| bytes.clone()) == &bytes;
                assert!(same, "{query} differs with {accel} and {threads} threads");
            }
        }
    }
}

#[test]
fn statistics_are_one_line_of_json() {
    let text = sandbox().run(&cast("crossings", &["--stats", "--threads", "2"])).ok();
    assert_eq!(text.lines().count(), 1);
    let stats: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&stats["rays"], &stats["threads"], &stats["repaired"]), (&5.into(), &2.into(), &0.into()));
    assert_eq!((&stats["query"], &stats["invalid"]), (&"crossings".into(), &0.into()));
    assert_eq!(stats["accel"], shotline::accel::DEFAULT);
    for key in ["load_s", "build_s", "cast_s", "rays_per_s", "memory_bytes"] {
        assert!(stats[key].as_f64().is_some_and(|x| x >= 0.0), "{key} in {text}");
    }
}

#[test]
fn an_invalid_row_is_an_error_or_a_counted_miss() {
    let mut rays = RAYS.to_vec();
    rays[3] = [0.0, f64::NAN, 0.0, 1.0, 0.0, 0.0];
    rays[4] = [0.0; 6];
    let sandbox = sandbox().with_rays("rays.npy", &rays);
    sandbox.run(&cast("count", &[])).fails_with(&["rays.npy", "row 3", "origin", "--on-invalid miss"]);
    for command in ["compare", "bench"] {
        let result = sandbox.run(&[command, "drilled.json", "--rays", "rays.npy"]);
        assert!(!result.stderr.contains("--on-invalid"), "{}", result.stderr);
        result.fails_with(&["rays.npy: row 3", "help: correct the row or remove it"]);
    }
    assert!(!sandbox.path("out.npz").exists());
    let text = sandbox.run(&cast("count", &["--on-invalid", "miss", "--stats"])).ok();
    let stats: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&stats["rays"], &stats["invalid"]), (&5.into(), &2.into()));
}

#[test]
fn an_empty_batch_has_a_result() {
    let sandbox = sandbox().with_rays("rays.npy", &[]);
    for query in QUERIES {
        sandbox.run(&cast(query, &[])).ok();
    }
}

#[test]
fn overlaps_are_errors_with_names_and_interval() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "left", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "right", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}}]}"#;
    let sandbox = sandbox().with("drilled.json", scene);
    let words = ["drilled.json", "row 0", "rays.npy", "left", "right", "11", "12", "--overlaps"];
    sandbox.run(&cast("segments", &[])).fails_with(&words);
    for policy in ["priority", "all"] {
        let text = sandbox.run(&cast("segments", &["--overlaps", policy, "--stats"])).ok();
        let stats: Value = serde_json::from_str(&text).unwrap();
        assert!(stats["overlaps"].as_u64().is_some());
    }
}

#[test]
fn columns_of_thickness_are_errors_for_other_queries() {
    let sandbox = sandbox();
    sandbox.run(&cast("segments", &["--by", "object"])).fails_with(&["--by is for --query thickness"]);
    sandbox.run(&cast("thickness", &["--by", "object"])).ok();
    let bench = ["bench", "drilled.json", "--rays", "rays.npy", "--query", "thickness", "--repeats", "1"];
    assert!(sandbox.run(&bench).ok().contains("rays/s"));
}

#[test]
fn a_failed_cast_leaves_no_file_and_keeps_the_old_one() {
    let sandbox = sandbox().with("out.npz", "old");
    sandbox.run(&cast("count", &["--accel", "none"])).fails_with(&["none", "bvh", "brute"]);
    let sandbox = sandbox.with("drilled.json", "{");
    sandbox.run(&cast("count", &[])).fails_with(&["drilled.json"]);
    assert_eq!(fs::read_to_string(sandbox.path("out.npz")).unwrap(), "old");
    assert_eq!(sandbox.files(), ["drilled.json", "out.npz", "rays.npy"]);
    let nowhere = ["cast", "drilled.json", "--rays", "rays.npy", "--query", "any", "-o", "no/out.npz"];
    Sandbox::new()
        .with("drilled.json", DRILLED)
        .with_rays("rays.npy", RAYS)
        .run(&nowhere)
        .fails_with(&["no/out.npz", "cannot be written"]);
}

#[test]
fn nothing_but_the_result_is_printed_in_a_pipe() {
    let result = sandbox().run(&cast("closest", &[]));
    assert_eq!((result.stdout.as_str(), result.stderr.as_str(), result.code), ("", "", Some(0)));
}
