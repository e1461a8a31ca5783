//! Welding on the command line, and meshes that no ray can hit.

mod sandbox;

use sandbox::Sandbox;
use serde_json::Value;

const NOISE: &[u8] = include_bytes!("../../../testdata/cases/cad-noise.stl");
const TWO_SIDED: &[u8] = include_bytes!("../../../testdata/cases/two-sided.obj");

/// Asserts that `check` reports a model as not sound, with a reason.
fn assert_not_sound(sandbox: &Sandbox, model: &str, why: &str) {
    let found = sandbox.run(&["check", model]);
    assert_eq!(found.code, Some(1));
    assert!(found.stdout.contains(why), "{}", found.stdout);
}

#[test]
fn check_reports_noise_that_opens_a_mesh_and_weld_closes_it() {
    let sandbox = Sandbox::new().with("noise.stl", NOISE);
    assert_not_sound(&sandbox, "noise.stl", "welded, the mesh is closed: use --weld auto");
    let closed = sandbox.run(&["check", "noise.stl", "--weld", "auto"]).ok();
    assert!(closed.contains(": closed") || closed.contains("closed, volume"), "{closed}");
    assert!(closed.contains("note: noise.stl: ") && closed.contains("merged with"), "{closed}");
    let measured: Value =
        serde_json::from_str(&sandbox.run(&["measure", "noise.stl", "--weld", "1e-12", "--json"]).ok())
            .unwrap();
    assert_eq!(measured["objects"][0]["exact"], true);
    sandbox.run(&["convert", "noise.stl", "welded.ply", "--weld", "auto"]).ok();
    assert!(sandbox.run(&["check", "welded.ply"]).ok().contains("closed, volume"));
}

#[test]
fn a_mesh_of_a_scene_is_welded_as_the_scene_says() {
    let scene = |weld: &str| {
        format!(
            r#"{{"shotline": 1, "objects": [{{"node": {{"kind": "mesh", "file": "noise.stl", "weld": {weld}}}}}]}}"#
        )
    };
    let sandbox = Sandbox::new()
        .with("noise.stl", NOISE)
        .with("auto.json", scene("\"auto\""))
        .with("bad.json", scene("-1"));
    assert!(sandbox.run(&["check", "auto.json"]).ok().contains("closed, volume"));
    let bad = sandbox.run(&["check", "bad.json"]);
    assert_eq!(bad.code, Some(2));
    assert!(bad.stderr.contains("-1 is not a distance to weld within"), "{}", bad.stderr);
    let bad = sandbox.run(&["info", "noise.stl", "--weld", "near"]);
    assert!(bad.code == Some(2) && bad.stderr.contains("or auto"), "{}", bad.stderr);
    sandbox.run(&["info", "noise.stl", "--weld", "-1"]).fails_with(&["--weld", "-1 is not a distance"]);
    let word = Sandbox::new().with("noise.stl", NOISE).with("word.json", scene("\"automatic\""));
    let result = word.run(&["info", "word.json"]);
    assert_eq!(result.stderr.matches("at least 0").count(), 1, "{}", result.stderr);
    result.fails_with(&["word.json:1:", "'automatic' is not a distance", "help: give a number"]);
}

#[test]
fn a_weld_that_leaves_nothing_is_reported() {
    let sandbox = Sandbox::new().with("noise.stl", NOISE);
    let found = sandbox.run(&["check", "noise.stl", "--weld", "100"]);
    let why = "\nnoise.stl: after welding within 100 the mesh has no face with three different corners; choose a \
               smaller distance\n";
    assert!(found.code == Some(1) && found.stdout.contains(why), "{}", found.stdout);
    let cube = Sandbox::new().with("cube.ply", sandbox::cube_ply(12));
    let found = cube.run(&["check", "cube.ply", "--weld", "0"]).ok();
    assert!(found.contains("no vertices were merged: no two are in one place"), "{found}");
    let found = cube.run(&["check", "cube.ply", "--weld", "0.25"]).ok();
    assert!(found.contains("no two that are in different places lie within 0.25"), "{found}");
}

#[test]
fn faces_that_cancel_are_a_fault_if_nothing_is_left() {
    let sandbox = Sandbox::new().with("two.obj", TWO_SIDED);
    assert_not_sound(&sandbox, "two.obj", "nothing of this mesh can ever be hit");
    let picture = sandbox.run(&["render", "two.obj", "-o", "two.png", "--size", "8x8"]);
    assert!(picture.stderr.contains("two.obj: nothing of it can ever be hit"), "{}", picture.stderr);
}
