//! `check`, `info` and `convert` print what the readers of files ignored or repaired.

mod sandbox;

use sandbox::Sandbox;
use serde_json::{Value, json};

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
                    f 1 3 4 2\nf 5 6 8 7\nfoo 1\nf 1 2 6 5\nf 3 7 8 4\nbar 2\nf 1 5 7 3\nf 2 4 8 6\n";

#[test]
fn notes_are_printed_with_count_and_first_line() {
    let sandbox = Sandbox::new().with("cube.obj", CUBE);
    let cut = "cube.obj: 6 polygons were cut into triangles, the first on line 9";
    let unknown =
        "cube.obj: 2 lines with keywords that OBJ does not have were passed over, the first 'foo' on line 11";
    for command in ["check", "info"] {
        let text = sandbox.run(&[command, "cube.obj"]).ok();
        for note in [cut, unknown] {
            assert!(text.contains(&format!("note: {note}\n")), "{command}: no '{note}' in\n{text}");
        }
    }
    let info: Value = serde_json::from_str(&sandbox.run(&["info", "cube.obj", "--json"]).ok()).unwrap();
    let note =
        |kind: &str| info["notes"].as_array().unwrap().iter().find(|n| n["kind"] == kind).unwrap().clone();
    assert_eq!(
        (&note("polygons_cut")["changed"], &note("unknown_keyword")["changed"]),
        (&false.into(), &true.into())
    );
    assert_eq!((&note("polygons_cut")["count"], &note("polygons_cut")["line"]), (&6.into(), &9.into()));
    let check: Value = serde_json::from_str(&sandbox.run(&["check", "cube.obj", "--json"]).ok()).unwrap();
    let found =
        check["findings"].as_array().unwrap().iter().find(|f| f["kind"] == "unknown_keyword").unwrap();
    assert_eq!(
        (&found["severity"], &found["line"], &found["byte"]),
        (&"note".into(), &11.into(), &Value::Null)
    );
}

#[test]
fn notes_of_the_meshes_of_a_scene_name_their_file() {
    let scene = r#"{"shotline": 1, "objects": [{"node": {"kind": "mesh", "file": "cube.obj"}}]}"#;
    let sandbox = Sandbox::new().with("cube.obj", CUBE).with("scene.json", scene);
    let text = sandbox.run(&["check", "scene.json"]).ok();
    assert!(
        text.contains("note: cube.obj: 6 polygons were cut into triangles, the first on line 9\n"),
        "{text}"
    );
}

fn case(name: &str) -> Sandbox {
    let path = format!("{}/../../testdata/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    Sandbox::new().with(name, std::fs::read(path).unwrap())
}

fn run_json(sandbox: &Sandbox, args: &[&str]) -> Value {
    serde_json::from_str(&sandbox.run(args).ok()).unwrap()
}

/// The `t` and polygons of the crossings of a ray.
fn hits(name: &str, from: &str, dir: &str) -> Vec<(f64, u64)> {
    let (from, dir) = (format!("--from={from}"), format!("--dir={dir}"));
    let shot = run_json(&case(name), &["shoot", name, &from, &dir, "--json"]);
    let crossings = shot["crossings"].as_array().unwrap();
    crossings.iter().map(|c| (c["t"].as_f64().unwrap(), c["polygon"].as_u64().unwrap())).collect()
}

fn measured_volume(name: &str) -> Value {
    run_json(&case(name), &["measure", name, "--json"])["objects"][0]["volume"].clone()
}

#[test]
fn a_byte_order_mark_and_comments_do_not_change_the_cube() {
    for name in ["bom.obj", "inline-comment.obj"] {
        assert_eq!(hits(name, "-5,0.2,0.3", "1,0,0"), [(4.0, 4), (6.0, 5)], "{name}");
        assert_eq!(measured_volume(name)["value"], 8.0, "{name}");
    }
    let text = case("bom.obj").run(&["check", "bom.obj"]).ok();
    assert!(text.contains("note: bom.obj: 1 vertex is used by no face, vertex 9\n"), "{text}");
}

#[test]
fn a_ray_into_the_notch_of_a_concave_polygon_misses() {
    assert_eq!(hits("concave-sheet.obj", "1.4,1.2,5", "0,0,-1"), []);
    assert_eq!(hits("concave-sheet.obj", "0.4,1.2,5", "0,0,-1").len(), 1);
    assert_eq!(hits("concave-prism.obj", "0.59,2.23,-0.23", "0.23,-0.42,0.88"), []);
}

#[test]
fn a_prism_of_concave_polygons_is_measured_exactly() {
    let volume = measured_volume("concave-prism.obj");
    assert!((volume["value"].as_f64().unwrap() - 3.0).abs() < 1e-5, "{volume}");
    assert_eq!(volume["std_error"], json!(0.0), "{volume}");
}

#[test]
fn queries_report_on_stderr_what_was_dropped_and_not_what_was_ignored() {
    let sandbox = case("two-corner-face.obj");
    let result = sandbox.run(&["shoot", "two-corner-face.obj", "--from=0.1,0.1,-1", "--dir=0,0,1", "--json"]);
    assert_eq!(
        result.stderr,
        "note: two-corner-face.obj: 1 face of fewer than three corners was dropped, on line 9\n"
    );
    assert!(sandbox.run(&["measure", "two-corner-face.obj"]).stderr.contains("1 face of fewer"));
    assert_eq!(sandbox.run(&["measure", "two-corner-face.obj", "--quiet"]).stderr, "");
    assert_eq!(case("bom.obj").run(&["measure", "bom.obj"]).stderr, "");
}

#[test]
fn files_of_other_programs_have_the_right_volume() {
    for name in
        ["nan-unused.obj", "nan-unused.ply", "cr-only.ply", "binary-tail.stl", "bom.stl", "comment-first.stl"]
    {
        let volume = measured_volume(name)["value"].as_f64().unwrap();
        assert!((volume * 6.0 - 1.0).abs() < 1e-12, "{name}: {volume}");
    }
}
