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
    assert!(bad.stderr.contains("'-1' is not a distance to weld within"), "{}", bad.stderr);
    let bad = place.run(&["info", "noise.stl", "--weld", "near"]);
    assert!(bad.code == Some(2) && bad.stderr.contains("or auto"), "{}", bad.stderr);
}

#[test]
fn faces_that_cancel_are_a_fault_where_nothing_is_left() {
    let place = Place::new().with("two.obj", TWO_SIDED);
    is_not_sound(&place, "two.obj", "nothing of this mesh can ever be hit");
    let picture = place.run(&["render", "two.obj", "-o", "two.png", "--size", "8x8"]);
    assert!(picture.stderr.contains("two.obj: nothing of it can ever be hit"), "{}", picture.stderr);
}
