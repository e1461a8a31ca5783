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
    for words in ["mm", "materials are lost", "rounded to float64: 8", "would move 8 of 16 vertices"] {
        assert!(result.stderr.contains(words), "no '{words}' in\n{}", result.stderr);
    }
    assert!(result.stderr.lines().all(|line| line.starts_with("note: ")), "{}", result.stderr);
    result.ok();
    let result = sandbox.convert("two.json", "two.ply");
    assert!(result.stderr.contains("2 objects were joined into one mesh"), "{}", result.stderr);
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

#[test]
fn solids_become_meshes_within_a_tolerance() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "ball", "node": {"kind": "sphere", "radius": 1}},
        {"name": "ground", "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": -3}}]}"#;
    let bounded = scene.replace(
        r#""kind": "halfspace", "normal": [0, 0, 1], "offset": -3"#,
        r#""kind": "box", "min": [2, 2, 2], "max": [3, 4, 5]"#,
    );
    let sandbox = Sandbox::new().with("open.json", scene).with("a.json", bounded);
    let convert = |model: &str, out: &str, tolerance: &str| {
        sandbox.run(&["convert", model, out, "--tolerance", tolerance, "--threads", "1"])
    };
    let made = convert("a.json", "a.stl", "0.01");
    assert!(made.stderr.contains("'ball' became a mesh of "), "{}", made.stderr);
    assert!(made.stderr.contains(" triangles, within 0.00"), "{}", made.stderr);
    made.ok();
    let checked = sandbox.run(&["check", "a.stl"]).ok();
    assert!(checked.contains("closed, volume 4.1"), "{checked}");
    for name in ["a.stl", "a.obj", "a.glb", "a.gltf", "a.3mf"] {
        convert("a.json", name, "0.1").ok();
        let info = sandbox.run(&["info", name]).ok();
        assert!(info.contains("ball") && info.contains("ground"), "{name}: {info}");
        let checked = sandbox.run(&["check", name]).ok();
        assert_eq!(checked.matches("closed, volume").count(), 2, "{name}: {checked}");
    }
    convert("a.json", "b.json", "0.1").ok();
    assert!(sandbox.run(&["info", "b.json"]).ok().contains("mesh of"));
    for tolerance in ["0", "-1", "nan"] {
        convert("a.json", "c.stl", tolerance).fails_with(&["error: --tolerance: the tolerance is"]);
    }
    convert("open.json", "c.stl", "0.1").fails_with(&[
        "object 'ground' has no bounds",
        "intersect it with a box",
        "help: --hide 'ground' leaves it out",
    ]);
    convert("a.json", "c.stl", "1e-9").fails_with(&[
        "object 'ball': a mesh within 0.000000001 needs more than 2 million cells",
        "help: choose a larger tolerance",
    ]);
    sandbox.convert("a.json", "c.stl").fails_with(&["object 'ball' has a solid", "--tolerance"]);
    assert!(!sandbox.path("c.stl").exists());
}

#[test]
fn objects_are_left_out_by_name() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "ball", "node": {"kind": "sphere", "radius": 1}},
        {"name": "box", "node": {"kind": "box", "min": [2, 2, 2], "max": [3, 4, 5]}},
        {"name": "ground", "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": -3}}]}"#;
    let sandbox = Sandbox::new().with("a.json", scene);
    let names = |file: &str| {
        let info = sandbox.run(&["info", file]).ok();
        ["ball", "box", "ground"].map(|name| info.contains(name))
    };
    sandbox.run(&["convert", "a.json", "b.stl", "--tolerance", "0.1", "--hide", "ground"]).ok();
    assert_eq!(names("b.stl"), [true, true, false]);
    sandbox.run(&["convert", "a.json", "b.json", "--hide", "b*"]).ok();
    assert_eq!(names("b.json"), [false, false, true]);
    sandbox.run(&["convert", "a.json", "c.json", "--only", "box"]).ok();
    assert_eq!(names("c.json"), [false, true, false]);
    sandbox
        .run(&["convert", "a.json", "d.json", "--hide", "floor"])
        .fails_with(&["no object is named 'floor'"]);
}

/// Empty objects vanished without a word, and one part in many places was made into a mesh again and again.
#[test]
fn empty_objects_are_told_and_parts_are_shared() {
    let empty =
        r#"{"op": "difference", "args": [{"kind": "sphere", "radius": 1}, {"kind": "sphere", "radius": 2}]}"#;
    let scene = format!(
        r#"{{"shotline": 1, "defs": {{"ball": {{"kind": "sphere", "radius": 1}}}}, "objects": [
        {{"name": "left", "node": {{"ref": "ball", "translate": [-2, 0, 0]}}}},
        {{"name": "right", "node": {{"ref": "ball", "translate": [2, 0, 0], "rotate": [10, 20, 30]}}}},
        {{"name": "mirrored", "node": {{"ref": "ball", "translate": [0, 5, 0], "scale": [1, -1, 1]}}}},
        {{"name": "large", "node": {{"ref": "ball", "translate": [0, 0, 9], "scale": [2, 2, 2]}}}},
        {{"name": "flat", "node": {{"ref": "ball", "translate": [0, 0, -9], "scale": [2, 2, 1]}}}},
        {{"name": "nothing", "node": {empty}}}]}}"#
    );
    let sandbox = Sandbox::new().with("a.json", scene);
    let made = sandbox.run(&["convert", "a.json", "b.json", "--tolerance", "0.05"]);
    assert!(made.stderr.contains("note: 'nothing' is empty and has no mesh"), "{}", made.stderr);
    assert_eq!(made.stderr.matches("became a mesh of").count(), 5);
    made.ok();
    // One mesh for all that are similar, and one for the flat one.
    assert_eq!(sandbox.files().iter().filter(|name| name.ends_with(".ply")).count(), 2);
    let checked = sandbox.run(&["check", "b.json"]).ok();
    assert!(checked.contains("sound"), "{checked}");
    let volumes = sandbox.run(&["measure", "b.json", "--json"]).ok();
    let volumes: serde_json::Value = serde_json::from_str(&volumes).unwrap();
    for (object, factor) in volumes["objects"].as_array().unwrap().iter().zip([1.0, 1.0, 1.0, 8.0, 4.0]) {
        let volume =
            object["volume"]["value"].as_f64().unwrap() / (factor * 4.0 / 3.0 * std::f64::consts::PI);
        assert!((volume - 1.0).abs() < 0.08, "{object}");
    }
    sandbox
        .run(&["convert", "a.json", "c.stl", "--tolerance", "0.05", "--only", "nothing"])
        .fails_with(&["there is nothing to convert: 'nothing' is empty and has no mesh"]);
}

/// An object of a million balls, or a file that had them all, would have taken more memory than there is.
#[test]
fn too_many_solids_or_triangles_are_refused_at_once() {
    let balls = |radius: &str| {
        format!(
            r#"{{"shotline": 1, "objects": [{{"name": "balls", "node": {{"op": "lattice",
            "args": [{{"kind": "sphere", "radius": {radius}}}], "counts": [100, 100, 100], "pitch": [1, 1, 1]}}}}]}}"#
        )
    };
    let sandbox = Sandbox::new().with("a.json", balls("0.5")).with("b.json", balls("0.3"));
    sandbox
        .run(&["convert", "a.json", "a.stl", "--tolerance", "0.05"])
        .fails_with(&["object 'balls' consists of 1000000 solids", "make a mesh of one of them"]);
    for file in ["b.stl", "b.glb"] {
        sandbox
            .run(&["convert", "b.json", file, "--tolerance", "0.01"])
            .fails_with(&["would be one mesh of ", "000000 triangles, since shared meshes are written out"]);
    }
    // A scene keeps the lattice.
    sandbox.run(&["convert", "b.json", "c.json", "--tolerance", "0.05"]).ok();
    let found = sandbox.run(&["info", "c.json", "--json"]).ok();
    assert!(found.contains("1000000"), "{found}");
}

/// The outermost volume of a detector hid all others in a viewer of meshes.
#[test]
fn enclosing_objects_are_left_out_of_meshes() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "world", "clip": true, "node": {"kind": "box", "min": [-9, -9, -9], "max": [9, 9, 9]},
        "contents": [{"name": "ball", "node": {"kind": "sphere", "radius": 1}}]}]}"#;
    let sandbox = Sandbox::new().with("a.json", scene);
    let objects = |out: &str, more: &[&str]| {
        let made = sandbox.run(&[&["convert", "a.json", out, "--tolerance", "0.1"], more].concat());
        let is_told = made.stderr.contains("'world' is left out, for it encloses the other objects");
        made.ok();
        let info = sandbox.run(&["info", out, "--json"]).ok();
        (["world", "ball"].map(|name| info.contains(&format!("\"{name}\""))), is_told)
    };
    assert_eq!(objects("b.glb", &[]), ([false, true], true));
    assert_eq!(objects("c.glb", &["--only", "world"]), ([true, true], false));
    assert_eq!(objects("d.json", &[]), ([true, true], false));
}

/// An object whose shape is another object was written in a form that could not be read.
#[test]
fn objects_in_place_of_shapes_are_written_as_references() {
    for place in ["", r#", "translate": [1, 2, 3]"#] {
        let scene = format!(
            r#"{{"shotline": 1, "defs": {{"d": {{"name": "inner", "node": {{"kind": "sphere", "radius": 1}}}}}},
            "objects": [{{"name": "outer", "priority": 2, "node": {{"ref": "d"{place}}}}}]}}"#
        );
        let sandbox = Sandbox::new().with("a.json", scene);
        sandbox.run(&["convert", "a.json", "b.json", "--tolerance", "0.1"]).ok();
        let info = sandbox.run(&["info", "b.json"]).ok();
        assert!(info.contains("inner"), "{info}");
    }
}
