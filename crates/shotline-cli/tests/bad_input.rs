//! What is wrong with the input is told in one readable message, with exit code 2.

mod place;

use place::{Answer, DRILLED, Place, cube_ply, npy};

const RAY: &[[f64; 6]] = &[[0.0, 0.0, -10.0, 0.0, 0.0, 1.0]];

/// Casts one ray through a scene.
fn cast(place: Place, model: &str) -> Answer {
    let place = place.with_rays("rays.npy", RAY);
    let answer = place.run(&["cast", model, "--rays", "rays.npy", "--query", "crossings", "-o", "out.npz"]);
    assert!(!place.path("out.npz").exists() || answer.code == Some(0));
    answer
}

fn cast_scene(objects: &str) -> Answer {
    let text = format!("{{\n  \"shotline\": 1,\n  \"objects\": [\n    {objects}\n  ]\n}}\n");
    cast(Place::new().with("scene.json", text), "scene.json")
}

/// Casts rays of a file through a good scene.
fn cast_rays(file: Vec<u8>) -> Answer {
    let place = Place::new().with("scene.json", DRILLED).with("rays.npy", file);
    place.run(&["cast", "scene.json", "--rays", "rays.npy", "--query", "any", "-o", "out.npz"])
}

#[test]
fn missing_files() {
    cast(Place::new(), "nowhere.json").refused(&["nowhere.json", "cannot be read"]);
    cast(Place::new(), "nowhere.ply").refused(&["nowhere.ply"]);
    let scene = Place::new().with("scene.json", DRILLED);
    let args = ["cast", "scene.json", "--rays", "no.npy", "--query", "any", "-o", "out.npz"];
    scene.run(&args).refused(&["no.npy", "cannot be read"]);
    cast_scene(r#"{"name": "a", "node": {"kind": "mesh", "file": "lost.ply"}}"#)
        .refused(&["lost.ply", ":4:"]);
}

#[test]
fn truncated_mesh() {
    let whole = cube_ply(12);
    let half = &whole[..whole.len() - 20];
    cast(Place::new().with("cut.ply", half), "cut.ply").refused(&["cut.ply"]);
}

#[test]
fn open_mesh_in_csg() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "lid", "node": {"op": "difference", "args": [
        {"kind": "mesh", "file": "open.ply"}, {"kind": "sphere", "radius": 0.1}]}}]}"#;
    let place = Place::new().with("open.ply", cube_ply(10)).with("scene.json", scene);
    cast(place, "scene.json").refused(&["4", "open", "edge"]);
}

#[test]
fn cycle_in_definitions() {
    let scene = r#"{"shotline": 1,
      "defs": {"hen": {"op": "union", "args": [{"ref": "egg"}]},
               "egg": {"op": "union", "args": [{"ref": "hen"}]}},
      "objects": [{"name": "farm", "node": {"ref": "hen"}}]}"#;
    cast(Place::new().with("scene.json", scene), "scene.json").refused(&["scene.json:", "hen", "egg"]);
}

#[test]
fn unknown_key() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "raduis": 1}}"#).refused(&[
        "scene.json:4:",
        "raduis",
        "radius",
    ]);
}

#[test]
fn radius_that_is_no_size() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": NaN}}"#)
        .refused(&["scene.json:4:", "NaN"]);
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": -2.5}}"#).refused(&[
        "scene.json:4:",
        "radius",
        "-2.5",
        "positive",
    ]);
}

#[test]
fn singular_transform() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": 1, "scale": [1, 0, 1]}}"#)
        .refused(&["scene.json:4:", "transform"]);
}

#[test]
fn every_error_is_listed() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "sphere", "radius": 0}},
        {"name": "b", "node": {"kind": "sphere", "radius": -1}}]}"#;
    cast(Place::new().with("scene.json", scene), "scene.json").refused(&["scene.json:2:", "scene.json:3:"]);
}

#[test]
fn rays_of_the_wrong_shape_or_type() {
    cast_rays(npy(&[2, 5], &[0.0; 10])).refused(&["rays.npy", "(2, 5)", "6"]);
    cast_rays(npy(&[6], &[1.0; 6])).refused(&["rays.npy", "6"]);
    let mut cut = npy(&[2, 6], &[1.0; 12]);
    cut.truncate(cut.len() - 8);
    cast_rays(cut).refused(&["rays.npy"]);
    cast_rays(b"not an array".to_vec()).refused(&["rays.npy"]);
}

#[test]
fn bad_row() {
    let rows = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    cast_rays(npy(&[2, 6], &rows.concat())).refused(&["rays.npy", "row 1", "direction", "zero"]);
    let rows = [[f64::INFINITY, 0.0, 0.0, 1.0, 0.0, 0.0]];
    cast_rays(npy(&[1, 6], &rows.concat())).refused(&["rays.npy", "row 0", "origin", "infinite"]);
}

#[test]
fn usage() {
    let place = Place::new();
    place.run(&["fire"]).refused(&["fire"]);
    place.run(&["cast", "x.json", "--accle", "bvh"]).refused(&["--accle", "--accel"]);
    let help = place.run(&["cast", "--help"]).ok();
    for words in ["ray_splits", "--on-invalid", "Examples:", "path_names"] {
        assert!(help.contains(words), "no '{words}' in\n{help}");
    }
    for verb in ["render", "cast", "shoot", "check", "info"] {
        assert!(place.run(&[verb, "--help"]).ok().contains(&format!("shotline {verb} ")), "{verb}");
    }
}
