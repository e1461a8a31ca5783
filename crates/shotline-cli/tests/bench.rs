//! `shotline bench`.

mod sandbox;

use sandbox::{DRILLED, Sandbox, cube_ply};
use serde_json::Value;

#[test]
fn every_query_is_measured() {
    let rays: Vec<[f64; 6]> = (0..50).map(|i| [-9.0, f64::from(i) * 0.1, 0.0, 1.0, 0.0, 0.0]).collect();
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with_rays("rays.npy", &rays);
    for query in ["closest", "any", "count", "crossings", "segments"] {
        let args = ["bench", "drilled.json", "--rays", "rays.npy", "--query", query, "--repeats", "4"];
        let text = sandbox.run(&args).ok();
        for words in [query, "50 rays of drilled.json", "median", "rays/s", "best", "over 4 repeats"] {
            assert!(text.contains(words), "no '{words}' in\n{text}");
        }
        let json = sandbox.run(&[&args[..], &["--json", "--threads", "1", "--accel", "bsp"]].concat()).ok();
        let report: Value = serde_json::from_str(&json).unwrap();
        assert_eq!((&report["query"], &report["accel"]), (&query.into(), &"bsp".into()));
        assert_eq!((&report["rays"], &report["threads"]), (&50.into(), &1.into()));
        assert_eq!(report["cast_s"].as_array().unwrap().len(), 4);
        let rate = |name: &str| report[name].as_f64().unwrap();
        assert!(0.0 < rate("rays_per_s") && rate("rays_per_s") <= rate("best_rays_per_s"));
        assert!(rate("spread") >= 0.0 && rate("load_s") > 0.0 && rate("build_s") > 0.0);
    }
}

#[test]
fn without_rays_those_of_a_picture_are_cast() {
    let sandbox = Sandbox::new().with("cube.ply", cube_ply(12));
    let text = sandbox.run(&["bench", "cube.ply", "--repeats", "1"]).ok();
    assert!(text.contains("closest of 76,800 rays of cube.ply, under bvh"), "{text}");
    assert!(text.contains("over 1 repeat\n"), "{text}");
}

#[test]
fn what_cannot_be_measured_is_an_error() {
    let bad = [[0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0]];
    let sandbox =
        Sandbox::new().with("open.ply", cube_ply(10)).with_rays("bad.npy", &bad).with_rays("none.npy", &[]);
    sandbox.run(&["bench", "open.ply", "--query", "segments"]).fails_with(&[
        "open.ply",
        "not closed",
        "help: close",
    ]);
    sandbox.run(&["bench", "open.ply", "--rays", "bad.npy"]).fails_with(&["bad.npy", "row 0"]);
    sandbox.run(&["bench", "open.ply", "--rays", "none.npy"]).fails_with(&["no ray"]);
    sandbox.run(&["bench", "open.ply", "--repeats", "0"]).fails_with(&["--repeats"]);
    sandbox.run(&["bench", "none.ply"]).fails_with(&["none.ply"]);
}
