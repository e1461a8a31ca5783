//! `shotline check`.

mod sandbox;

use sandbox::{DRILLED, Sandbox, cube_ply};

#[test]
fn sound_models() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED).with("cube.ply", cube_ply(12));
    for model in ["drilled.json", "cube.ply"] {
        let result = sandbox.run(&["check", model]);
        assert_eq!(result.code, Some(0), "{}{}", result.stdout, result.stderr);
        assert!(result.stdout.contains("sound"), "{}", result.stdout);
    }
}

#[test]
fn a_hole_is_counted_and_located() {
    let sandbox = Sandbox::new().with("open.ply", cube_ply(10));
    let result = sandbox.run(&["check", "open.ply"]);
    assert_eq!(result.code, Some(1), "{}{}", result.stdout, result.stderr);
    for words in ["open.ply", "4 open edges", "not sound"] {
        assert!(result.stdout.contains(words), "no '{words}' in\n{}", result.stdout);
    }
}

#[test]
fn a_volume_out_of_range_is_a_fault() {
    for (side, range) in [("1e120", "large"), ("1e-110", "small")] {
        let mut cube = cube_ply(12);
        for i in 0..8 {
            let corner = [i & 1, i >> 1 & 1, i >> 2];
            let scaled = corner.map(|x| if x == 0 { "0" } else { side }).join(" ");
            cube = cube.replace(
                &format!("\n{}\n", corner.map(|x| x.to_string()).join(" ")),
                &format!("\n{scaled}\n"),
            );
        }
        let result = Sandbox::new().with("cube.ply", cube).run(&["check", "cube.ply"]);
        assert_eq!(result.code, Some(1), "{}{}", result.stdout, result.stderr);
        let words = format!("the volume is too {range} for a 64-bit number");
        assert!(result.stdout.contains(&words) && result.stdout.contains("not sound"), "{}", result.stdout);
    }
}

#[test]
fn a_flipped_face_is_found() {
    let flipped = cube_ply(12).replace("3 5 7 6\n", "3 7 5 6\n");
    let sandbox = Sandbox::new().with("flipped.ply", flipped);
    let result = sandbox.run(&["check", "flipped.ply"]);
    assert_eq!(result.code, Some(1));
    assert!(result.stdout.contains("flipped"), "{}", result.stdout);
}

#[test]
fn every_scene_error_is_listed() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "sphere", "radius": 0}},
        {"name": "b", "node": {"kind": "sphere", "radius": 1, "scale": [0, 1, 1]}}]}"#;
    let sandbox = Sandbox::new().with("scene.json", scene);
    let result = sandbox.run(&["check", "scene.json"]);
    assert_eq!(result.code, Some(1), "{}{}", result.stdout, result.stderr);
    for words in ["scene.json:2:", "scene.json:3:", "radius"] {
        assert!(result.stdout.contains(words), "no '{words}' in\n{}", result.stdout);
    }
}

#[test]
fn unreadable_input_is_an_error_and_not_a_finding() {
    let sandbox = Sandbox::new().with("scene.json", "{\"shotline\": 1, \"objects\": [");
    sandbox.run(&["check", "scene.json"]).fails_with(&["scene.json:1:"]);
    sandbox.run(&["check", "nowhere.ply"]).fails_with(&["nowhere.ply"]);
}

#[test]
fn overlapping_objects_are_named_once() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "pin", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}},
        {"name": "hub", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "far", "node": {"kind": "box", "min": [3, -1, -1], "max": [4, 1, 1]}}]}"#;
    let result = Sandbox::new().with("scene.json", scene).run(&["check", "scene.json"]);
    assert_eq!(result.code, Some(1), "{}{}", result.stdout, result.stderr);
    assert_eq!(result.stdout.matches("fault: 'hub' and 'pin'").count(), 1, "{}", result.stdout);
    // Objects that only touch are not a fault.
    assert!(!result.stdout.contains("fault: 'far'"), "{}", result.stdout);
}

/// A scene of objects, each by name, node and priority.
fn scene(objects: &[(&str, &str, i32)]) -> String {
    let object = |(name, node, priority): &(&str, &str, i32)| {
        format!(r#"{{"name": "{name}", "priority": {priority}, "node": {node}}}"#)
    };
    let objects: Vec<String> = objects.iter().map(object).collect();
    format!(r#"{{"shotline": 1, "objects": [{}]}}"#, objects.join(","))
}

const GROUND: &str = r#"{"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}"#;
const POLE: &str = r#"{"kind": "quadric", "coeffs": [1, 1, 0, 0, 0, 0, 0, 0, 0, -1]}"#;

#[test]
fn a_scene_with_an_unbounded_object_is_examined() {
    let ball = r#"{"kind": "sphere", "radius": 1, "translate": [5, 0, 1]}"#;
    let sunk = r#"{"kind": "sphere", "radius": 1, "translate": [5, 0, 0.9]}"#;
    let other = r#"{"kind": "sphere", "radius": 1, "translate": [6, 0, 1]}"#;
    let sandbox = Sandbox::new()
        .with("alone.json", scene(&[("ground", GROUND, 0)]))
        .with("resting.json", scene(&[("ground", GROUND, 0), ("ball", ball, 0)]))
        .with("sunk.json", scene(&[("ground", GROUND, 0), ("ball", sunk, 0)]))
        .with("two.json", scene(&[("ground", GROUND, 0), ("ball", ball, 0), ("other", other, 0)]));
    for model in ["alone.json", "resting.json"] {
        let text = sandbox.run(&["check", model]).ok();
        assert!(text.ends_with(": sound\n"), "{text}");
    }
    for (model, pair) in [("sunk.json", "'ball' and 'ground'"), ("two.json", "'ball' and 'other'")] {
        let result = sandbox.run(&["check", model]);
        assert_eq!(result.code, Some(1), "{}", result.stdout);
        assert!(result.stdout.contains(&format!("fault: {pair}")), "{}", result.stdout);
    }
}

#[test]
fn scenes_not_examined_in_full_are_not_called_sound() {
    let slanted = r#"{"kind": "halfspace", "normal": [0, 0.001, -1], "offset": -1e6}"#;
    let sky = r#"{"kind": "halfspace", "normal": [0, 0, -1], "offset": -9}"#;
    let sandbox = Sandbox::new()
        .with("far.json", scene(&[("ground", GROUND, 0), ("roof", slanted, 0)]))
        .with("pole.json", scene(&[("ground", GROUND, 0), ("pole", POLE, 0)]))
        .with("owned.json", scene(&[("ground", GROUND, 0), ("pole", POLE, 1)]))
        .with("apart.json", scene(&[("ground", GROUND, 0), ("sky", sky, 0)]));
    let result = sandbox.run(&["check", "far.json"]);
    assert_eq!(result.code, Some(3), "{}", result.stdout);
    assert!(result.stdout.contains("not examined: 'ground' and 'roof'"), "{}", result.stdout);
    assert!(!result.stdout.contains(": sound"), "{}", result.stdout);
    let report: serde_json::Value =
        serde_json::from_str(&sandbox.run(&["check", "far.json", "--json"]).stdout).unwrap();
    assert!(report["sound"].is_null() && report["unexamined"].as_array().unwrap().len() == 1, "{report}");
    let result = sandbox.run(&["check", "pole.json"]);
    assert_eq!(result.code, Some(1), "{}", result.stdout);
    for model in ["owned.json", "apart.json"] {
        assert_eq!(sandbox.run(&["check", model]).code, Some(0), "{model}");
    }
}

/// A PLY file of triangles.
fn ply(vertices: &[[f64; 3]], faces: &[[u32; 3]]) -> String {
    let mut out = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        faces.len()
    );
    vertices.iter().for_each(|[x, y, z]| out += &format!("{x} {y} {z}\n"));
    faces.iter().for_each(|[a, b, c]| out += &format!("3 {a} {b} {c}\n"));
    out
}

/// Tetrahedra of size 1 at some corners.
fn tetrahedra(corners: &[[f64; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for [x, y, z] in corners {
        let n = vertices.len() as u32;
        vertices.extend([[*x, *y, *z], [x + 1.0, *y, *z], [*x, y + 1.0, *z], [*x, *y, z + 1.0]]);
        faces.extend([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face| face.map(|v| v + n)));
    }
    (vertices, faces)
}

fn findings(sandbox: &Sandbox, model: &str) -> Vec<serde_json::Value> {
    let result = sandbox.run(&["check", model, "--json"]);
    let report: serde_json::Value = serde_json::from_str(&result.stdout).unwrap();
    assert_eq!(report["sound"], result.code == Some(0), "{}", result.stdout);
    report["findings"].as_array().unwrap().clone()
}

/// Each defect has its count and its first location, in the text and in JSON.
#[test]
fn each_defect_has_a_count_and_a_location() {
    let far = [5.0, 0.0, 0.0];
    type Change = fn(&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>);
    type Case<'a> = (&'a str, &'a str, usize, [&'a [u32]; 2], &'a str, Change);
    let cases: [Case; 9] = [
        ("open_edges", "fault", 3, [&[4, 4], &[5, 6]], "3 open edges", |_, f| f.truncate(f.len() - 1)),
        ("flipped_faces", "fault", 3, [&[0, 1], &[0, 1]], "3 edges of flipped faces", |_, f| f[0].swap(0, 1)),
        ("crowded_edges", "remark", 3, [&[0, 9], &[0, 1]], "3 edges of more than two faces", |_, f| {
            f.extend([[0, 2, 1], [1, 2, 0]]);
        }),
        ("degenerate_faces", "remark", 1, [&[8], &[]], "1 face with two coincident corners", |_, f| {
            f.push([1, 1, 2]);
        }),
        ("zero_area_faces", "remark", 2, [&[8], &[]], "2 faces without area", |v, f| {
            v.extend([[9.0; 3], [10.0; 3], [11.0; 3]]);
            f.extend([[8, 9, 10], [10, 9, 8]]);
        }),
        ("duplicate_faces", "remark", 2, [&[8, 0], &[]], "2 duplicate faces", |_, f| {
            f.extend([[0, 2, 1], [1, 2, 0]]);
        }),
        ("repeated_vertices", "remark", 1, [&[], &[8, 4]], "1 vertex at the point of another", |v, f| {
            v.push(v[4]);
            f[5][0] = 8;
        }),
        ("turned_shells", "remark", 1, [&[4], &[]], "1 outer shell is wound", |v, f| {
            f[4..].iter_mut().for_each(|f| f.swap(0, 1));
            v[1][0] = 2.0;
        }),
        ("self_intersections", "remark", 4, [&[0, 5], &[]], "4 pairs of faces", |v, _| {
            v[4..].iter_mut().for_each(|[x, y, z]| (*x, *y, *z) = (*x - 4.8, *y + 0.2, *z - 0.1));
        }),
    ];
    for (kind, severity, count, [faces, vertices], words, change) in cases {
        let (mut v, mut f) = tetrahedra(&[[0.0; 3], far]);
        change(&mut v, &mut f);
        let sandbox = Sandbox::new().with("mesh.ply", ply(&v, &f));
        let all = findings(&sandbox, "mesh.ply");
        let found = all.iter().find(|f| f["kind"] == kind).unwrap_or_else(|| panic!("no {kind}: {all:?}"));
        assert_eq!(found["severity"], severity, "{found}");
        assert_eq!(found["count"], count, "{found}");
        assert_eq!(found["faces"], serde_json::json!(faces), "{found}");
        assert_eq!(found["vertices"], serde_json::json!(vertices), "{found}");
        assert_eq!(found["point"].as_array().map(Vec::len), Some(3), "{found}");
        let text = sandbox.run(&["check", "mesh.ply"]).stdout;
        assert!(text.contains(&format!("{severity}: {words}")), "no '{words}' in\n{text}");
    }
}

#[test]
fn inward_faces_and_several_shells_are_remarks() {
    let (v, mut f) = tetrahedra(&[[0.0; 3], [5.0, 0.0, 0.0]]);
    f.iter_mut().for_each(|f| f.swap(0, 1));
    let text = Sandbox::new().with("mesh.ply", ply(&v, &f)).run(&["check", "mesh.ply"]).ok();
    for words in [
        "remark: the faces are wound inward",
        "remark: 2 shells; the second begins with face 4, at (5, 1, 0)",
    ] {
        assert!(text.contains(words), "no '{words}' in\n{text}");
    }
}

#[test]
fn coincident_faces_of_objects_are_remarks() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "lid", "node": {"kind": "box", "min": [0, 0, 1], "max": [2, 2, 1.5]}},
        {"name": "crate", "node": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}},
        {"name": "ball", "node": {"kind": "sphere", "radius": 0.4, "translate": [0.5, 0.5, 2]}}]}"#;
    let sandbox = Sandbox::new().with("scene.json", scene);
    let all = findings(&sandbox, "scene.json");
    // Only faces that overlap are reported: the sides of the lid and of the crate are in one plane, but do not
    // coincide.
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!((&all[0]["kind"], &all[0]["severity"]), (&"coincidence".into(), &"remark".into()));
    assert_eq!(all[0]["objects"], serde_json::json!(["crate", "lid"]));
    assert_eq!(all[0]["point"][2], 1.0);
    assert!(sandbox.run(&["check", "scene.json"]).ok().contains("remark: 'crate' and 'lid', on "));
}

#[test]
fn surfaces_that_intersect_are_not_reported_as_coincident() {
    let ball = |x: f64| format!(r#"{{"kind": "sphere", "radius": 1, "translate": [{x}, 0, 0]}}"#);
    let sandbox = Sandbox::new().with("scene.json", scene(&[("a", &ball(0.0), 0), ("b", &ball(0.5), 1)]));
    assert_eq!(findings(&sandbox, "scene.json"), Vec::<serde_json::Value>::new());
}
