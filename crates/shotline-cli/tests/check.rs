//! `shotline check`.

mod place;

use place::{DRILLED, Place, cube_ply};

#[test]
fn sound_models() {
    let place = Place::new().with("drilled.json", DRILLED).with("cube.ply", cube_ply(12));
    for model in ["drilled.json", "cube.ply"] {
        let answer = place.run(&["check", model]);
        assert_eq!(answer.code, Some(0), "{}{}", answer.stdout, answer.stderr);
        assert!(answer.stdout.contains("sound"), "{}", answer.stdout);
    }
}

#[test]
fn a_hole_is_counted_and_placed() {
    let place = Place::new().with("open.ply", cube_ply(10));
    let answer = place.run(&["check", "open.ply"]);
    assert_eq!(answer.code, Some(1), "{}{}", answer.stdout, answer.stderr);
    for words in ["open.ply", "4 open edges", "not sound"] {
        assert!(answer.stdout.contains(words), "no '{words}' in\n{}", answer.stdout);
    }
}

#[test]
fn a_flipped_face_is_found() {
    let flipped = cube_ply(12).replace("3 5 7 6\n", "3 7 5 6\n");
    let place = Place::new().with("flipped.ply", flipped);
    let answer = place.run(&["check", "flipped.ply"]);
    assert_eq!(answer.code, Some(1));
    assert!(answer.stdout.contains("flipped"), "{}", answer.stdout);
}

#[test]
fn every_scene_error_is_listed() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "sphere", "radius": 0}},
        {"name": "b", "node": {"kind": "sphere", "radius": 1, "scale": [0, 1, 1]}}]}"#;
    let place = Place::new().with("scene.json", scene);
    let answer = place.run(&["check", "scene.json"]);
    assert_eq!(answer.code, Some(1), "{}{}", answer.stdout, answer.stderr);
    for words in ["scene.json:2:", "scene.json:3:", "radius"] {
        assert!(answer.stdout.contains(words), "no '{words}' in\n{}", answer.stdout);
    }
}

#[test]
fn what_cannot_be_read_is_another_matter() {
    let place = Place::new().with("scene.json", "{\"shotline\": 1, \"objects\": [");
    place.run(&["check", "scene.json"]).refused(&["scene.json:1:"]);
    place.run(&["check", "nowhere.ply"]).refused(&["nowhere.ply"]);
}

#[test]
fn overlapping_objects_are_named_once() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "pin", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}},
        {"name": "hub", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "far", "node": {"kind": "box", "min": [3, -1, -1], "max": [4, 1, 1]}}]}"#;
    let answer = Place::new().with("scene.json", scene).run(&["check", "scene.json"]);
    assert_eq!(answer.code, Some(1), "{}{}", answer.stdout, answer.stderr);
    assert_eq!(answer.stdout.matches("fault: 'hub' and 'pin'").count(), 1, "{}", answer.stdout);
    assert!(!answer.stdout.contains("'far'"), "{}", answer.stdout);
}

#[test]
fn a_model_without_bounds_is_not_searched_for_overlaps() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "ground",
        "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let text = Place::new().with("scene.json", scene).run(&["check", "scene.json"]).ok();
    assert!(text.contains("no bounds") && text.contains("sound"), "{text}");
}
