//! `shotline convert`.

mod sandbox;

use sandbox::{DRILLED, RunResult, Sandbox, cube_ply};

impl Sandbox {
    fn convert(&self, from: &str, to: &str) -> RunResult {
        self.run(&["convert", from, to])
    }

    /// The crossings of a ray through the model.
    fn crossings(&self, model: &str) -> String {
        let shot = self.run(&["shoot", model, "--from", "-1.1,0.3,0.4", "--dir", "1,0.01,0.02"]).ok();
        shot.lines().filter(|line| line.contains("mesh")).map(|l| l.replace(model, "")).collect()
    }
}

#[test]
fn round_trips_keep_every_crossing() {
    let sandbox = Sandbox::new().with("cube.ply", cube_ply(12));
    let files = ["cube.ply", "cube.obj", "cube.stl", "cube.json", "again.ply", "again.stl", "again.json"];
    for pair in files.windows(2) {
        sandbox.convert(pair[0], pair[1]).ok();
    }
    let expected = sandbox.crossings("cube.ply");
    assert!(expected.contains("in") && expected.contains("out"), "{expected}");
    for file in ["cube.obj", "cube.stl", "cube.json"] {
        assert_eq!(sandbox.crossings(file), expected, "{file}");
    }
    // Another name, the same numbers.
    let numbers = |crossings: String| crossings.replace("again", "cube").replace(' ', "");
    for file in ["again.ply", "again.stl", "again.json"] {
        assert_eq!(numbers(sandbox.crossings(file)), numbers(expected.clone()), "{file}");
    }
    let made = ["again.json", "again.ply", "again.stl", "cube.json", "cube.obj", "cube.ply", "cube.stl"];
    assert_eq!(sandbox.files(), made, "scenes name the mesh files that exist");
}

#[test]
fn scenes_are_written_back_without_their_comments() {
    let sandbox = Sandbox::new().with("a.json", DRILLED.replacen('{', "{ // of steel\n", 1));
    let result = sandbox.convert("a.json", "b.json");
    assert_eq!(result.stderr, "note: comments are lost\n");
    result.ok();
    let result = sandbox.convert("b.json", "c.json");
    assert_eq!(result.stderr, "");
    result.ok();
    assert_eq!(
        std::fs::read(sandbox.path("b.json")).unwrap(),
        std::fs::read(sandbox.path("c.json")).unwrap()
    );
}

#[test]
fn losses_are_reported() {
    let scene = r#"{"shotline": 1, "units": "mm", "materials": {"steel": {}}, "objects": [
        {"name": "a", "material": "steel", "node": {"kind": "mesh", "file": "cube.ply"}},
        {"name": "b", "node": {"kind": "mesh", "file": "cube.ply", "translate": [0.1, 2, 0]}}]}"#;
    let sandbox = Sandbox::new().with("cube.ply", cube_ply(12)).with("two.json", scene);
    let result = sandbox.convert("two.json", "two.stl");
    for words in [
        "2 objects were joined",
        "mm",
        "materials are lost",
        "rounded to float64: 8",
        "would move 8 of 16 vertices",
    ] {
        assert!(result.stderr.contains(words), "no '{words}' in\n{}", result.stderr);
    }
    assert!(result.stderr.lines().all(|line| line.starts_with("note: ")), "{}", result.stderr);
    result.ok();
    assert_eq!(sandbox.run(&["convert", "two.json", "two.obj", "--quiet"]).stderr, "");
}

#[test]
fn a_failed_conversion_leaves_no_file() {
    let sandbox = Sandbox::new().with("a.json", DRILLED).with("cube.ply", cube_ply(12));
    sandbox.convert("a.json", "a.stl").fails_with(&[
        "a.stl: ",
        "STL holds triangles only, and object 'ball' has a combination",
        ".json",
    ]);
    sandbox.convert("cube.ply", "cube.step").fails_with(&["cube.step", ".stl"]);
    sandbox.convert("cube.ply", "none/cube.stl").fails_with(&["none/cube.stl", "no such folder"]);
    sandbox.convert("none.ply", "a.obj").fails_with(&["none.ply"]);
    assert_eq!(sandbox.files(), ["a.json", "cube.ply"]);
}
