//! `shotline convert`.

mod place;

use place::{Answer, DRILLED, Place, cube_ply};

impl Place {
    fn convert(&self, from: &str, to: &str) -> Answer {
        self.run(&["convert", from, to])
    }

    /// What a ray through the model meets.
    fn crossings(&self, model: &str) -> String {
        let shot = self.run(&["shoot", model, "--from", "-1.1,0.3,0.4", "--dir", "1,0.01,0.02"]).ok();
        shot.lines().filter(|line| line.contains("mesh")).map(|l| l.replace(model, "")).collect()
    }
}

#[test]
fn round_trips_keep_every_crossing() {
    let place = Place::new().with("cube.ply", cube_ply(12));
    let files = ["cube.ply", "cube.obj", "cube.stl", "cube.json", "again.ply", "again.stl", "again.json"];
    for pair in files.windows(2) {
        place.convert(pair[0], pair[1]).ok();
    }
    let expected = place.crossings("cube.ply");
    assert!(expected.contains("in") && expected.contains("out"), "{expected}");
    for file in ["cube.obj", "cube.stl", "cube.json"] {
        assert_eq!(place.crossings(file), expected, "{file}");
    }
    // Another name, the same numbers.
    let numbers = |crossings: String| crossings.replace("again", "cube").replace(' ', "");
    for file in ["again.ply", "again.stl", "again.json"] {
        assert_eq!(numbers(place.crossings(file)), numbers(expected.clone()), "{file}");
    }
    let made = ["again.json", "again.ply", "again.stl", "cube.json", "cube.obj", "cube.ply", "cube.stl"];
    assert_eq!(place.files(), made, "scenes name the meshes that are there");
}

#[test]
fn scenes_are_written_back_without_their_comments() {
    let place = Place::new().with("a.json", DRILLED.replacen('{', "{ // of steel\n", 1));
    let answer = place.convert("a.json", "b.json");
    assert_eq!(answer.stderr, "note: comments are lost\n");
    answer.ok();
    let answer = place.convert("b.json", "c.json");
    assert_eq!(answer.stderr, "");
    answer.ok();
    assert_eq!(std::fs::read(place.path("b.json")).unwrap(), std::fs::read(place.path("c.json")).unwrap());
}

#[test]
fn what_is_lost_is_told() {
    let scene = r#"{"shotline": 1, "units": "mm", "materials": {"steel": {}}, "objects": [
        {"name": "a", "material": "steel", "node": {"kind": "mesh", "file": "cube.ply"}},
        {"name": "b", "node": {"kind": "mesh", "file": "cube.ply", "translate": [0.1, 2, 0]}}]}"#;
    let place = Place::new().with("cube.ply", cube_ply(12)).with("two.json", scene);
    let answer = place.convert("two.json", "two.stl");
    for words in [
        "2 objects were joined",
        "mm",
        "materials are lost",
        "rounded to float64: 8",
        "would move 8 of 16 vertices",
    ] {
        assert!(answer.stderr.contains(words), "no '{words}' in\n{}", answer.stderr);
    }
    assert!(answer.stderr.lines().all(|line| line.starts_with("note: ")), "{}", answer.stderr);
    answer.ok();
    assert_eq!(place.run(&["convert", "two.json", "two.obj", "--quiet"]).stderr, "");
}

#[test]
fn what_cannot_be_written_leaves_no_file() {
    let place = Place::new().with("a.json", DRILLED).with("cube.ply", cube_ply(12));
    place.convert("a.json", "a.stl").refused(&[
        "a.stl: ",
        "STL holds triangles only, and object 'ball' has a combination",
        ".json",
    ]);
    place.convert("cube.ply", "cube.step").refused(&["cube.step", ".stl"]);
    place.convert("cube.ply", "none/cube.stl").refused(&["none/cube.stl", "no such folder"]);
    place.convert("none.ply", "a.obj").refused(&["none.ply"]);
    assert_eq!(place.files(), ["a.json", "cube.ply"]);
}
