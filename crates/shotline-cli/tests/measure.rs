//! `shotline measure`.

mod sandbox;

use std::f64::consts::PI;

use sandbox::{DRILLED, Sandbox, cube_ply};
use serde_json::Value;

fn json(sandbox: &Sandbox, args: &[&str]) -> Value {
    serde_json::from_str(&sandbox.run(&[&["measure", "--json"], args].concat()).ok()).unwrap()
}

/// A ball with a density, and a box that overlaps it and from which a smaller box is subtracted.
const PAIR: &str = r#"{ "shotline": 1, "units": "cm",
  "materials": { "iron": { "density": 7.874 }, "air": {} },
  "objects": [
    { "name": "ball", "material": "iron", "node": { "kind": "sphere", "radius": 2, "translate": [1, 0, 0] } },
    { "name": "bitten", "material": "air", "node": { "op": "difference", "args": [
        { "kind": "box", "min": [0, 0, 0], "max": [2, 3, 4] },
        { "kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1] } ] } } ] }
"#;

#[test]
fn the_table_marks_exact_values_and_has_errors_for_the_others() {
    let sandbox = Sandbox::new().with("pair.json", PAIR);
    let text = sandbox.run(&["measure", "pair.json"]).ok();
    for words in ["volume cm^3", "mass", "33.5103216", "263.860273", "(1, 0, 0)", "exact", "±", "65,568"] {
        assert!(text.contains(words), "no '{words}' in\n{text}");
    }
    assert!(!sandbox.run(&["measure", "pair.json", "--object", "ball"]).ok().contains("±"));
}

#[test]
fn json_has_every_digit_and_true_errors() {
    let sandbox = Sandbox::new().with("pair.json", PAIR);
    let result = json(&sandbox, &["pair.json", "--rays", "100"]);
    let [ball, bitten] = [&result["objects"][0], &result["objects"][1]];
    let volume = 4.0 / 3.0 * PI * 8.0;
    assert!((ball["volume"]["value"].as_f64().unwrap() / volume - 1.0).abs() < 1e-14, "{ball}");
    assert_eq!(
        (&ball["exact"], &ball["rays"], &ball["volume"]["std_error"]),
        (&true.into(), &0.into(), &0.0.into())
    );
    assert!((ball["inertia"][1][1]["value"].as_f64().unwrap() / (0.4 * 4.0 * volume) - 1.0).abs() < 1e-14);
    assert_eq!(
        (&bitten["exact"], &bitten["mass"], &bitten["rays"]),
        (&false.into(), &Value::Null, &144.into())
    );
    let (value, error) = (&bitten["volume"]["value"], &bitten["volume"]["std_error"]);
    let (off, error) = ((value.as_f64().unwrap() - 23.0).abs(), error.as_f64().unwrap());
    assert!(off < 6.0 * error && error < 1.0, "{bitten}");
    assert_eq!(result["rays"], 144);
}

/// 7.8 g/cm^3 in a cube of side 10: the mass depends on the unit of length.
#[test]
fn masses_have_a_unit_if_lengths_have_one() {
    for (units, mass) in [("mm", 7.8), ("cm", 7800.0), ("m", 7.8e9), ("in", 7800.0 * 16.387_064)] {
        let scene = format!(
            r#"{{"shotline": 1, "units": "{units}", "materials": {{"steel": {{"density": 7.8}}}}, "objects": [
                {{"name": "cube", "material": "steel", "node": {{"kind": "box", "min": [0, 0, 0], "max": [10, 10, 10]}}}}]}}"#
        );
        let bare = scene.replace(&format!("\"units\": \"{units}\","), "");
        let sandbox = Sandbox::new().with("cube.json", &scene).with("bare.json", &bare);
        let result = json(&sandbox, &["cube.json"]);
        let found = result["objects"][0]["mass"]["value"].as_f64().unwrap();
        assert!((found / mass - 1.0).abs() < 1e-15, "{units}: {found}");
        assert_eq!((&result["units"], &result["mass_units"]), (&units.into(), &"g".into()));
        let text = sandbox.run(&["measure", "cube.json"]).ok();
        assert!(text.contains("mass g") && text.contains(&format!("volume {units}^3")), "{text}");
        let result = json(&sandbox, &["bare.json"]);
        assert_eq!(result["objects"][0]["mass"]["value"], 7800.0);
        assert_eq!((&result["units"], &result["mass_units"]), (&Value::Null, &Value::Null));
        let text = sandbox.run(&["measure", "bare.json"]).ok();
        assert!(text.contains("mass density x length^3"), "{text}");
    }
}

#[test]
fn results_depend_on_the_seed_and_not_on_threads_and_accelerators() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let measure = |more: &[&str]| json(&sandbox, &[&["drilled.json"], more].concat());
    let one = measure(&["--threads", "1"]);
    assert_eq!(one, measure(&["--threads", "2", "--accel", "grid"]));
    let volume = |result: &Value| result["objects"][0]["volume"]["value"].clone();
    assert_ne!(volume(&one), volume(&measure(&["--seed", "1"])));
}

#[test]
fn an_object_owns_less_than_its_volume_where_others_overlap_it() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "left", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "right", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}}]}"#;
    let sandbox = Sandbox::new().with("two.json", scene);
    let volumes = |policy: &str| -> Vec<f64> {
        let result = json(&sandbox, &["two.json", "--overlaps", policy]);
        let objects = result["objects"].as_array().unwrap();
        objects.iter().map(|object| object["volume"]["value"].as_f64().unwrap()).collect()
    };
    assert_eq!(volumes("all"), [8.0, 8.0]);
    let owned = volumes("priority");
    assert!((owned[0] - 4.0).abs() < 0.01 && (owned[1] - 8.0).abs() < 0.01, "{owned:?}");
    sandbox.run(&["measure", "two.json", "--overlaps", "error"]).fails_with(&["left", "right", "--overlaps"]);
}

#[test]
fn errors_name_the_object_that_cannot_be_measured() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "ball", "node": {"kind": "sphere", "radius": 1}},
        {"name": "ground", "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let sandbox = Sandbox::new()
        .with("ground.json", scene)
        .with("open.ply", cube_ply(10))
        .with("cube.ply", cube_ply(12));
    sandbox.run(&["measure", "ground.json", "--object", "ground"]).fails_with(&[
        "ground.json",
        "'ground'",
        "finite",
        "intersect",
        "--object",
    ]);
    sandbox.run(&["measure", "ground.json", "--object", "grond"]).fails_with(&["did you mean 'ground'?"]);
    let text = sandbox.run(&["measure", "ground.json"]).ok();
    assert!(text.contains("4.1887902") && text.contains("unbounded"), "{text}");
    assert_eq!(json(&sandbox, &["ground.json"])["objects"][1]["unbounded"], true);
    assert!(sandbox.run(&["measure", "ground.json", "--object", "ball"]).ok().contains("4.1887902"));
    sandbox.run(&["measure", "ground.json", "--object", "moon"]).fails_with(&["'moon'", "info"]);
    sandbox.run(&["measure", "open.ply"]).fails_with(&[
        "open.ply",
        "not closed",
        "open edges",
        "or choose others with --object",
    ]);
    assert_eq!(json(&sandbox, &["cube.ply"])["objects"][0]["volume"]["value"], 1.0);
    let huge =
        r#"{"shotline": 1, "objects": [{"name": "sun", "node": {"kind": "sphere", "radius": 1e120}}]}"#;
    let sandbox = sandbox.with("huge.json", huge);
    let words = ["huge.json", "'sun'", "too large", "other units of length", "help: choose other objects"];
    sandbox.run(&["measure", "huge.json"]).fails_with(&words);
    sandbox.run(&["measure", "cube.ply", "--rays", "many"]).fails_with(&["--rays", "many"]);
}
