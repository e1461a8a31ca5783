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

/// A tank with water in it, in which two of three balls overlap, and a pipe that sticks out of it.
const NEST: &str = r#"{ "shotline": 1, "units": "cm",
  "defs": { "ball": { "name": "ball", "node": { "kind": "sphere", "radius": 1 } } },
  "objects": [ { "name": "tank", "clip": true, "translate": [100, 0, 0],
    "node": { "kind": "cylinder", "radius": 5, "z0": 0, "z1": 20 },
    "contents": [
      { "name": "water", "node": { "kind": "cylinder", "radius": 4, "z0": 0, "z1": 15 },
        "contents": [ BALLS ] },
      { "name": "pipe", "node": { "kind": "cylinder", "radius": 0.5, "z0": 16, "z1": TOP } } ] } ] }"#;

fn nest(balls: &[f64], top: &str) -> Sandbox {
    let ball = |x: &f64| format!(r#"{{ "ref": "ball", "translate": [{x}, 0, 10] }}"#);
    let balls: Vec<String> = balls.iter().map(ball).collect();
    Sandbox::new().with("nest.json", NEST.replace("BALLS", &balls.join(", ")).replace("TOP", top))
}

#[test]
fn copies_that_overlap_and_contents_that_stick_out_are_faults() {
    let result = nest(&[-1.5, 0.0, 2.25], "25").run(&["check", "nest.json", "--json"]);
    assert_eq!(result.code, Some(1), "{}", result.stdout);
    let report: serde_json::Value = serde_json::from_str(&result.stdout).expect("JSON");
    let faults: Vec<_> = report["findings"]
        .as_array()
        .expect("findings")
        .iter()
        .filter(|f| f["severity"] == "fault")
        .collect();
    let kinds: Vec<_> = faults.iter().map(|fault| (&fault["kind"], &fault["objects"])).collect();
    let expected = [("overlap", ["ball", "ball"]), ("protrusion", ["pipe", "tank"])];
    assert!(
        kinds
            .iter()
            .zip(&expected)
            .all(|((kind, objects), (k, o))| **kind == *k && **objects == serde_json::json!(o)),
        "{kinds:?}"
    );
    assert_eq!(kinds.len(), 2, "{kinds:?}");
    let text = |i: usize| faults[i]["text"].as_str().expect("text");
    assert!(
        text(0).starts_with("two placements of 'ball', on ") && text(0).contains(": about 0.5"),
        "{}",
        text(0)
    );
    assert!(text(1).starts_with("'pipe' out of 'tank', on "), "{}", text(1));
}

/// Faces that contents share with what contains them and with each other are no faults.
#[test]
fn contents_that_touch_are_sound() {
    let text = nest(&[-2.0, 0.0, 2.0], "20").run(&["check", "nest.json"]).ok();
    assert!(text.ends_with(": sound\n"), "{text}");
}

#[test]
fn contents_are_objects() {
    let scene = r#"{ "shotline": 1, "objects": [ { "name": "a", "node": { "kind": "sphere", "radius": 1 },
      "contents": [ { "kind": "sphere", "radius": 0.5 } ] } ] }"#;
    let result = Sandbox::new().with("bare.json", scene).run(&["check", "bare.json"]);
    assert_eq!(result.code, Some(1), "{}", result.stdout);
    for words in ["2:21", "the contents of an object are objects and groups of them", "give the shape a name"]
    {
        assert!(result.stdout.contains(words), "no '{words}' in\n{}", result.stdout);
    }
}

/// What sticks out of an object that clips is reported at every depth: only what was directly in it was.
#[test]
fn deeper_contents_that_stick_out_are_faults() {
    let part = |name: &str, max: f64, more: &str| {
        let node = format!(r#"{{ "kind": "box", "min": [1, 1, 1], "max": [{max}, 3, 3] }}"#);
        format!(r#"{{ "name": "{name}", "node": {node}{more} }}"#)
    };
    let inner = part("b", 3.0, &format!(r#", "contents": [{}]"#, part("c", 9.0, "")));
    let outer =
        format!(r#""node": {{ "kind": "box", "min": [0, 0, 0], "max": [4, 4, 4] }}, "contents": [{inner}]"#);
    let scene = format!(r#"{{ "shotline": 1, "objects": [{{ "name": "a", "clip": true, {outer} }}] }}"#);
    let sandbox = Sandbox::new().with("deep.json", scene);
    let result = sandbox.run(&["check", "deep.json"]);
    assert_eq!(result.code, Some(1), "{}", result.stdout);
    assert!(result.stdout.contains("fault: 'c' out of 'a'"), "{}", result.stdout);
    let shot = sandbox.run(&["shoot", "deep.json", "--from=-9,2,2", "--dir=1,0,0"]).ok();
    assert!(shot.contains("protrusion: 'c' sticks out of 'a' from t = 13 to t = 18"), "{shot}");
}

/// An overlap ends where a third object begins to own the ray: it was reported up to the end of the two.
#[test]
fn overlaps_end_with_their_owner() {
    let slab = |name: &str, min: [f64; 3], priority: i32| {
        let node = format!(r#"{{ "kind": "box", "min": {min:?}, "max": [3, 3, 3] }}"#);
        format!(r#"{{ "name": "{name}", "priority": {priority}, "node": {node} }}"#)
    };
    let objects = [slab("a", [0.0; 3], 0), slab("d", [2.0, 0.0, 0.0], 0), slab("c", [-1.0, 0.5, -1.0], 1)];
    let scene = format!(r#"{{ "shotline": 1, "objects": [{}] }}"#, objects.join(", "));
    let sandbox = Sandbox::new().with("third.json", scene);
    for (from, to) in [("--from=2.5,-9,1.5", "--dir=0,1,0"), ("--from=2.5,9,1.5", "--dir=0,-1,0")] {
        let shot = sandbox.run(&["shoot", "third.json", from, to]).ok();
        let expected = if to.contains("-1") { "from t = 8.5 to t = 9;" } else { "from t = 9 to t = 9.5;" };
        assert!(shot.contains(expected), "{shot}");
    }
    let text = sandbox.run(&["check", "third.json"]).stdout;
    assert!(text.contains(": about 0.5 deep there, with a volume of about 1."), "{text}");
}
