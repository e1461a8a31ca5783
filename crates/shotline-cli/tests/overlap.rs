//! `shotline check`: overlaps that are small in the scene, and empty objects.

mod sandbox;

use sandbox::Sandbox;

/// A scene of objects, each by name and node.
fn scene(objects: &[(String, String)]) -> String {
    let object = |(name, node): &(String, String)| format!(r#"{{"name": "{name}", "node": {node}}}"#);
    let objects: Vec<String> = objects.iter().map(object).collect();
    format!(r#"{{"shotline": 1, "objects": [{}]}}"#, objects.join(","))
}

fn named(objects: &[(&str, &str)]) -> String {
    let objects: Vec<_> = objects.iter().map(|(name, node)| (name.to_string(), node.to_string())).collect();
    scene(&objects)
}

fn ball(at: [f64; 3]) -> String {
    format!(r#"{{"kind": "sphere", "radius": 1, "translate": {at:?}}}"#)
}

#[test]
fn an_overlap_is_found_however_far_away_a_third_object_is() {
    for away in [1e2, 1e3, 1e4, 1e9] {
        let (a, b, far) = (ball([0.0; 3]), ball([1.5, 0.0, 0.0]), ball([away; 3]));
        let sandbox = Sandbox::new().with("far.json", named(&[("a", &a), ("b", &b), ("far", &far)]));
        let result = sandbox.run(&["check", "far.json"]);
        assert_eq!(result.code, Some(1), "{away}: {}", result.stdout);
        assert!(result.stdout.contains("fault: 'a' and 'b'"), "{away}: {}", result.stdout);
        assert!(!result.stdout.contains("empty"), "{away}: {}", result.stdout);
    }
}

#[test]
fn boxes_that_meet_without_an_overlap_leave_a_scene_sound() {
    let (a, b, far) = (ball([0.0; 3]), ball([1.5, 1.5, 0.0]), ball([1e3; 3]));
    let turned = r#"{"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1], "rotate": [10, 20, 30]}"#;
    let beside = r#"{"kind": "box", "min": [1, 0, 0], "max": [2, 1, 1], "rotate": [10, 20, 30]}"#;
    let sandbox = Sandbox::new()
        .with("apart.json", named(&[("a", &a), ("b", &b), ("far", &far)]))
        .with("flush.json", named(&[("turned", turned), ("beside", beside), ("far", &far)]));
    for model in ["apart.json", "flush.json"] {
        let text = sandbox.run(&["check", model]).ok();
        assert!(text.ends_with(": sound\n"), "{text}");
    }
}

#[test]
fn many_boxes_that_abut_are_sound() {
    let node = |i: usize| {
        let (x, y) = (i % 100, i / 100);
        format!(r#"{{"kind": "box", "min": [{x}, {y}, 0], "max": [{}, {}, 1]}}"#, x + 1, y + 1)
    };
    let boxes: Vec<_> = (0..10_000).map(|i| (format!("box {i}"), node(i))).collect();
    let text = Sandbox::new().with("grid.json", scene(&boxes)).run(&["check", "grid.json"]).ok();
    assert!(text.ends_with(": sound\n"), "{}", &text[text.len().saturating_sub(300)..]);
}

/// Rods between the balls of a grid, some of which overlap balls a little. Beyond a limit of work fewer rays are cast: it
/// counts nothing that an accelerator changes.
#[test]
fn every_accelerator_gives_the_same_report() {
    let grid = (0..216).map(|i| {
        let at = [i % 6, i / 6 % 6, i / 36];
        format!(r#"{{"kind": "sphere", "radius": 0.497, "translate": {at:?}}}"#)
    });
    let grid = format!(r#"{{"op": "union", "args": [{}]}}"#, grid.collect::<Vec<_>>().join(","));
    let mut objects = vec![("grid".to_string(), grid)];
    for i in 0..25 {
        let radius = (0.5f64.sqrt() - 0.497) * (0.975 + 0.03 * f64::from(i * 7 % 25) / 25.0);
        let at = [f64::from(i % 5) + 0.5, f64::from(i / 5) + 0.5, 0.0];
        let rod =
            format!(r#"{{"kind": "cylinder", "radius": {radius}, "z0": -1, "z1": 6, "translate": {at:?}}}"#);
        objects.push((format!("rod {i}"), rod));
    }
    let sandbox = Sandbox::new().with("rods.json", scene(&objects));
    let report = |accel: &str| sandbox.run(&["check", "rods.json", "--accel", accel]).stdout;
    let expected = report("bvh");
    assert!(expected.contains("'grid' and 'rod"), "{expected}");
    for accel in shotline::accel::NAMES {
        assert_eq!(report(accel), expected, "{accel}");
    }
}

/// The box of every slanted plate meets the boxes of all others, but no plate overlaps another.
#[test]
fn too_many_pairs_are_counted_and_the_scene_is_not_called_sound() {
    let flat = |i: usize| {
        format!(
            r#"{{"kind": "box", "min": [0, 0, 0], "max": [9, 9, 0.0001], "translate": [0, 0, {}], "rotate": [40, 0, 0]}}"#,
            0.001 * i as f64
        )
    };
    let flats: Vec<_> = (0..300).map(|i| (format!("flat {i}"), flat(i))).collect();
    let sandbox = Sandbox::new().with("flats.json", scene(&flats));
    let result = sandbox.run(&["check", "flats.json"]);
    assert_eq!(result.code, Some(3), "{}{}", result.stdout, result.stderr);
    assert!(result.stdout.contains("of 44,850 pairs of parts whose boxes meet, "), "{}", result.stdout);
    assert!(!result.stdout.contains(": sound"), "{}", result.stdout);
}

#[test]
fn empty_objects_are_remarks_and_a_scene_without_objects_is_not_sound() {
    let nothing =
        r#"{"op": "difference", "args": [{"kind": "sphere", "radius": 1}, {"kind": "sphere", "radius": 2}]}"#;
    let apart = r#"{"op": "intersection", "args": [{"kind": "sphere", "radius": 1},
        {"kind": "sphere", "radius": 1, "translate": [5, 0, 0]}]}"#;
    let group = r#"{"op": "group", "args": [{"name": "inner", "node": {"kind": "sphere", "radius": 0.5}}]}"#;
    let (far, speck) = (
        ball([1e3; 3]),
        r#"{"op": "group", "args": [
        {"kind": "sphere", "radius": 1e-6, "translate": [9, 0, 0]},
        {"kind": "sphere", "radius": 1e-6, "translate": [9, 8, 7]}]}"#,
    );
    let objects = [("nothing", nothing), ("apart", apart), ("group", group), ("far", &far), ("speck", speck)];
    let sandbox = Sandbox::new().with("objects.json", named(&objects)).with("none.json", named(&[]));
    let text = sandbox.run(&["check", "objects.json"]).ok();
    assert!(text.contains("remark: 'nothing' seems to be empty: none of 16,384 rays"), "{text}");
    assert!(text.contains("remark: 'apart' is empty"), "{text}");
    assert_eq!(text.matches("empty").count(), 2, "{text}");
    let result = sandbox.run(&["check", "none.json"]);
    assert_eq!(result.code, Some(1), "{}", result.stdout);
    assert!(result.stdout.contains("fault: the scene has no objects"), "{}", result.stdout);
    assert!(sandbox.run(&["info", "none.json"]).ok().contains("note: the scene has no objects"));
    let info = sandbox.run(&["info", "objects.json"]).ok();
    assert_eq!(info.matches("note: object 'apart' is empty").count(), 1, "{info}");
    assert_eq!(info.matches("empty").count(), 1, "{info}");
}

#[test]
fn a_self_crossing_mesh_is_not_called_wound_inward_and_its_signed_volume_has_a_sign() {
    // A cube with one corner pulled through the opposite side.
    let cube = "v 5 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let sandbox = Sandbox::new().with("pulled.obj", cube);
    let text = sandbox.run(&["check", "pulled.obj"]).ok();
    assert!(text.contains("signed volume -0.666666667"), "{text}");
    assert!(!text.contains("wound inward"), "{text}");
    assert!(
        text.contains("negative winding number") && text.contains("passing through each other"),
        "{text}"
    );
    // The volume is that of the region with a nonzero winding number.
    let report = sandbox.run(&["measure", "pulled.obj", "--json"]).ok();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let volume = report["objects"][0]["volume"]["value"].as_f64().unwrap();
    assert!(volume > 1.0, "{report}");
}
