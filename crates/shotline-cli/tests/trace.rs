//! `shotline shoot --trace`.

mod sandbox;

use sandbox::{DRILLED, RunResult, Sandbox, cube_ply};
use serde_json::Value;

const ALONG_X: [&str; 6] = ["shoot", "drilled.json", "--from", "-10,0,0", "--dir", "1,0,0"];

#[test]
fn every_step_of_a_ray_is_reported() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&[&ALONG_X[..], &["--trace"]].concat()).ok();
    let expected = "   t  step
   0  the scene: 2 placements
   5    + ball
  16    + slab
   5    body ball: 2 leaves
   5      + sphere#0
   9      + box#1
   5      test sphere#0: in at 5, out at 15
   5      cross into sphere#0
   5      => in
   9      test box#1: in at 9, out at 11
   9      cross into box#1
   9      => out
  11      cross out of box#1
  11      => in
  15      cross out of sphere#0
  15      => out
  16    body slab: 1 leaf
          test box: in at 16, out at 18
  16      cross into box
  16      => in
  18      cross out of box
  18      => out

ray from";
    assert!(text.starts_with(expected), "{text}");
    assert!(text.contains("6 crossings"), "the report follows: {text}");
}

#[test]
fn the_closest_crossing_skips_what_is_behind_it() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&[&ALONG_X[..], &["--trace=closest"]].concat()).ok();
    assert!(text.contains("  16  done: 1 pending entry is never opened\n"), "{text}");
    assert!(!text.contains("test box"), "{text}");
    let cut = sandbox.run(&[&ALONG_X[..], &["--trace=closest", "--steps", "3"]].concat()).ok();
    assert!(cut.contains("  8 more steps are left out; --steps 11 shows all\n"), "{cut}");
}

#[test]
fn every_accelerator_names_its_nodes_and_cells() {
    let ball = |x| format!(r#"{{"kind": "sphere", "radius": 0.6, "translate": [{x}, {}, 0]}}"#, x % 3);
    let balls: Vec<String> = (0..12).map(ball).collect();
    let scene = format!(
        r#"{{"shotline": 1, "objects": [{{"node": {{"op": "union", "args": [{}]}}}}]}}"#,
        balls.join(", ")
    );
    let sandbox = Sandbox::new().with("row.json", scene).with("cube.ply", cube_ply(12));
    for (accel, words) in [
        ("brute", "+ sphere#10"),
        ("bvh", "open box [-0.6, 4.6] x"),
        ("bvh_best", "open box [-0.6, 11.6] x"),
        ("grid", "open cell 0,0,0 of"),
        ("octree", "open cell [-0.6, 11.6] x"),
        ("bsp", "open plane x = "),
    ] {
        let along =
            ["shoot", "row.json", "--from", "-5,0.5,0", "--dir", "1,0,0", "--trace", "--accel", accel];
        let text = sandbox.run(&along).ok();
        assert!(text.contains(words), "no '{words}' of {accel} in {text}");
        let down = ["shoot", "cube.ply", "--from", "0.3,0.4,5", "--dir", "0,0,-1", "--trace=closest"];
        let text = sandbox.run(&[&down[..], &["--accel", accel]].concat()).ok();
        assert!(text.contains("in at 4 (triangle 2); limit 4"), "{accel}: {text}");
    }
}

#[test]
fn steps_are_also_json() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&[&ALONG_X[..], &["--trace", "--json", "--accel", "bvh_best"]].concat()).ok();
    let shot: Value = serde_json::from_str(&text).unwrap();
    let steps = shot["trace"]["steps"].as_array().unwrap();
    assert_eq!((steps.len(), &shot["trace"]["left_out"]), (27, &0.into()));
    let boundaries = steps.iter().filter(|s| s["step"] == "boundary");
    let ts: Vec<f64> = boundaries.map(|s| s["t"].as_f64().unwrap()).collect();
    assert_eq!(ts, [5.0, 9.0, 11.0, 15.0, 16.0, 18.0]);
    assert_eq!(steps[2]["part"], "box [-5, 8] x [-5, 5] x [-5, 5]");
    assert_eq!(steps[9]["step"], "found");
    assert_eq!(steps[9]["crossings"][1]["t"], 15.0);
}

#[test]
fn steps_need_a_trace() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    sandbox.run(&[&ALONG_X[..], &["--steps", "5"]].concat()).fails_with(&["--trace"]);
    sandbox.run(&[&ALONG_X[..], &["--trace=furthest"]].concat()).fails_with(&["closest", "furthest"]);
}

/// The trace on the page about accelerators is the output of the program.
#[test]
fn the_example_of_the_page_is_current() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let page = std::fs::read_to_string(format!("{root}/docs/accelerators.md")).unwrap();
    let example = page.split_once("```text\n$ shotline ").unwrap().1.split_once("```").unwrap().0;
    let (command, expected) = example.split_once('\n').unwrap();
    let args: Vec<&str> = command.split_whitespace().collect();
    let text = RunResult::of(Sandbox::new().command(&args).current_dir(root).output().unwrap()).ok();
    assert!(text.starts_with(expected), "{text}");
}
