//! Welding on the command line, and meshes of which nothing can be hit.

mod place;

use place::Place;
use serde_json::Value;

const NOISE: &[u8] = include_bytes!("../../../testdata/cases/cad-noise.stl");
const TWO_SIDED: &[u8] = include_bytes!("../../../testdata/cases/two-sided.obj");

/// Holds `check` to finding a model not sound, and to saying why.
fn is_not_sound(place: &Place, model: &str, why: &str) {
    let found = place.run(&["check", model]);
    assert_eq!(found.code, Some(1));
    assert!(found.stdout.contains(why), "{}", found.stdout);
}

#[test]
fn check_names_the_noise_that_keeps_a_mesh_open_and_weld_closes_it() {
    let place = Place::new().with("noise.stl", NOISE);
    is_not_sound(&place, "noise.stl", "welded, the mesh is closed: use --weld auto");
    let closed = place.run(&["check", "noise.stl", "--weld", "auto"]).ok();
    assert!(closed.contains(": closed") || closed.contains("closed, volume"), "{closed}");
    assert!(closed.contains("note: noise.stl: ") && closed.contains("merged with"), "{closed}");
    let measured: Value =
        serde_json::from_str(&place.run(&["measure", "noise.stl", "--weld", "1e-12", "--json"]).ok())
            .unwrap();
    assert_eq!(measured["objects"][0]["exact"], true);
    place.run(&["convert", "noise.stl", "welded.ply", "--weld", "auto"]).ok();
    assert!(place.run(&["check", "welded.ply"]).ok().contains("closed, volume"));
}

#[test]
fn a_mesh_of_a_scene_is_welded_as_it_says() {
    let scene = |weld: &str| {
        format!(
            r#"{{"shotline": 1, "objects": [{{"node": {{"kind": "mesh", "file": "noise.stl", "weld": {weld}}}}}]}}"#
        )
    };
    let place = Place::new()
        .with("noise.stl", NOISE)
        .with("auto.json", scene("\"auto\""))
        .with("bad.json", scene("-1"));
    assert!(place.run(&["check", "auto.json"]).ok().contains("closed, volume"));
    let bad = place.run(&["check", "bad.json"]);
    assert_eq!(bad.code, Some(2));
    assert!(bad.stderr.contains("-1 is not a distance to weld within"), "{}", bad.stderr);
    let bad = place.run(&["info", "noise.stl", "--weld", "near"]);
    assert!(bad.code == Some(2) && bad.stderr.contains("or auto"), "{}", bad.stderr);
    place.run(&["info", "noise.stl", "--weld", "-1"]).refused(&["--weld", "-1 is not a distance"]);
    let word = Place::new().with("noise.stl", NOISE).with("word.json", scene("\"automatic\""));
    let answer = word.run(&["info", "word.json"]);
    assert_eq!(answer.stderr.matches("at least 0").count(), 1, "{}", answer.stderr);
    answer.refused(&["word.json:1:", "'automatic' is not a distance", "help: give a number"]);
}

#[test]
fn a_weld_that_leaves_nothing_is_told_as_such() {
    let place = Place::new().with("noise.stl", NOISE);
    let found = place.run(&["check", "noise.stl", "--weld", "100"]);
    let why = "\nnoise.stl: after welding within 100 the mesh has no face with three different corners; choose a \
               smaller distance\n";
    assert!(found.code == Some(1) && found.stdout.contains(why), "{}", found.stdout);
    let cube = Place::new().with("cube.ply", place::cube_ply(12));
    let found = cube.run(&["check", "cube.ply", "--weld", "0"]).ok();
    assert!(found.contains("no vertices were merged: no two are in one place"), "{found}");
    let found = cube.run(&["check", "cube.ply", "--weld", "0.25"]).ok();
    assert!(found.contains("no two that are in different places lie within 0.25"), "{found}");
}

#[test]
fn faces_that_cancel_are_a_fault_where_nothing_is_left() {
    let place = Place::new().with("two.obj", TWO_SIDED);
    is_not_sound(&place, "two.obj", "nothing of this mesh can ever be hit");
    let picture = place.run(&["render", "two.obj", "-o", "two.png", "--size", "8x8"]);
    assert!(picture.stderr.contains("two.obj: nothing of it can ever be hit"), "{}", picture.stderr);
}
