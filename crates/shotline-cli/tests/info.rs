//! `shotline info`.

mod sandbox;

use std::process::Stdio;

use sandbox::{DRILLED, Sandbox, cube_ply};
use serde_json::{Value, json};

#[test]
fn sizes_of_a_scene() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&["info", "drilled.json"]).ok();
    for words in ["objects", "ball", "steel", "difference of 2", "(-5, -5, -5)", "mm"] {
        assert!(text.contains(words), "no '{words}' in\n{text}");
    }
    let info: Value = serde_json::from_str(&sandbox.run(&["info", "drilled.json", "--json"]).ok()).unwrap();
    assert_eq!(
        (&info["objects"], &info["leaves"], &info["virtual_leaves"]),
        (&2.into(), &3.into(), &3.into())
    );
    assert_eq!(info["object_list"][1], json!({"name": "slab", "material": "air", "body": "box"}));
    let bounds: Vec<f64> = ["min", "max"]
        .iter()
        .flat_map(|end| info["bounds"][end].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()))
        .collect();
    for (bound, exact) in bounds.iter().zip([-5.0, -5.0, -5.0, 8.0, 5.0, 5.0]) {
        assert!((bound - exact).abs() < 1e-9, "{bounds:?}");
    }
    for key in ["nodes", "memory_bytes", "build_s", "load_s"] {
        assert!(info[key].is_number(), "{key}");
    }
}

#[test]
fn infinite_bounds_are_null_in_json() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "ground",
        "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let sandbox = Sandbox::new().with("ground.json", scene);
    let info: Value = serde_json::from_str(&sandbox.run(&["info", "ground.json", "--json"]).ok()).unwrap();
    assert_eq!(info["bounds"]["min"], json!([null, null, null]));
    assert!(sandbox.run(&["info", "ground.json"]).ok().contains("inf"));
}

#[test]
fn a_mesh_is_an_object() {
    let sandbox = Sandbox::new().with("cube.ply", cube_ply(12));
    let text = sandbox.run(&["info", "cube.ply"]).ok();
    assert!(text.contains("mesh of 12 triangles"), "{text}");
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let mut command = sandbox.command(&["info", "drilled.json"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
}
