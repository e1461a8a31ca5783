//! What the readers of files passed over or repaired is printed by `check`, `info` and `convert`.

mod place;

use place::Place;
use serde_json::Value;

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
                    f 1 3 4 2\nf 5 6 8 7\nfoo 1\nf 1 2 6 5\nf 3 7 8 4\nbar 2\nf 1 5 7 3\nf 2 4 8 6\n";

#[test]
fn notes_are_printed_with_count_and_first_line() {
    let place = Place::new().with("cube.obj", CUBE);
    let cut = "cube.obj: 6 polygons were cut into triangles, the first on line 9";
    let unknown =
        "cube.obj: 2 lines with keywords that OBJ does not have were passed over, the first 'foo' on line 11";
    for command in ["check", "info"] {
        let text = place.run(&[command, "cube.obj"]).ok();
        for note in [cut, unknown] {
            assert!(text.contains(&format!("note: {note}\n")), "{command}: no '{note}' in\n{text}");
        }
    }
    let info: Value = serde_json::from_str(&place.run(&["info", "cube.obj", "--json"]).ok()).unwrap();
    let note =
        |kind: &str| info["notes"].as_array().unwrap().iter().find(|n| n["kind"] == kind).unwrap().clone();
    assert_eq!(
        (&note("polygons_cut")["changed"], &note("unknown_keyword")["changed"]),
        (&false.into(), &true.into())
    );
    assert_eq!((&note("polygons_cut")["count"], &note("polygons_cut")["line"]), (&6.into(), &9.into()));
    let check: Value = serde_json::from_str(&place.run(&["check", "cube.obj", "--json"]).ok()).unwrap();
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
    let place = Place::new().with("cube.obj", CUBE).with("scene.json", scene);
    let text = place.run(&["check", "scene.json"]).ok();
    assert!(
        text.contains("note: cube.obj: 6 polygons were cut into triangles, the first on line 9\n"),
        "{text}"
    );
}
