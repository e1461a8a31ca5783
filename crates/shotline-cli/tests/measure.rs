//! `shotline measure`.

mod place;

use std::f64::consts::PI;

use place::{DRILLED, Place, cube_ply};
use serde_json::Value;

fn json(place: &Place, args: &[&str]) -> Value {
    serde_json::from_str(&place.run(&[&["measure", "--json"], args].concat()).ok()).unwrap()
}

/// A ball of a density, and one that overlaps it, with a bite of a box taken out.
const PAIR: &str = r#"{ "shotline": 1, "units": "cm",
  "materials": { "iron": { "density": 7.874 }, "air": {} },
  "objects": [
    { "name": "ball", "material": "iron", "node": { "kind": "sphere", "radius": 2, "translate": [1, 0, 0] } },
    { "name": "bitten", "material": "air", "node": { "op": "difference", "args": [
        { "kind": "box", "min": [0, 0, 0], "max": [2, 3, 4] },
        { "kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1] } ] } } ] }
"#;

#[test]
fn a_table_marks_what_is_exact_and_how_sure_the_rest_is() {
    let place = Place::new().with("pair.json", PAIR);
    let text = place.run(&["measure", "pair.json"]).ok();
    for words in ["volume cm^3", "mass", "33.5103216", "263.860273", "(1, 0, 0)", "exact", "±", "65,568"] {
        assert!(text.contains(words), "no '{words}' in\n{text}");
    }
    assert!(!place.run(&["measure", "pair.json", "--object", "ball"]).ok().contains("±"));
}

#[test]
fn json_has_every_digit_and_honest_errors() {
    let place = Place::new().with("pair.json", PAIR);
    let answer = json(&place, &["pair.json", "--rays", "100"]);
    let [ball, bitten] = [&answer["objects"][0], &answer["objects"][1]];
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
    assert_eq!(answer["rays"], 144);
}

/// 7.8 g/cm^3 in a cube of 10: the unit of length decides the mass, which was 7800 of nothing for all of them.
#[test]
fn masses_have_a_unit_or_say_that_they_have_none() {
    for (units, mass) in [("mm", 7.8), ("cm", 7800.0), ("m", 7.8e9), ("in", 7800.0 * 16.387_064)] {
        let scene = format!(
            r#"{{"shotline": 1, "units": "{units}", "materials": {{"steel": {{"density": 7.8}}}}, "objects": [
                {{"name": "cube", "material": "steel", "node": {{"kind": "box", "min": [0, 0, 0], "max": [10, 10, 10]}}}}]}}"#
        );
        let bare = scene.replace(&format!("\"units\": \"{units}\","), "");
        let place = Place::new().with("cube.json", &scene).with("bare.json", &bare);
        let answer = json(&place, &["cube.json"]);
        let told = answer["objects"][0]["mass"]["value"].as_f64().unwrap();
        assert!((told / mass - 1.0).abs() < 1e-15, "{units}: {told}");
        assert_eq!((&answer["units"], &answer["mass_units"]), (&units.into(), &"g".into()));
        let text = place.run(&["measure", "cube.json"]).ok();
        assert!(text.contains("mass g") && text.contains(&format!("volume {units}^3")), "{text}");
        let answer = json(&place, &["bare.json"]);
        assert_eq!(answer["objects"][0]["mass"]["value"], 7800.0);
        assert_eq!((&answer["units"], &answer["mass_units"]), (&Value::Null, &Value::Null));
        let text = place.run(&["measure", "bare.json"]).ok();
        assert!(text.contains("mass density x length^3"), "{text}");
    }
}

#[test]
fn the_seed_decides_every_bit_and_threads_and_accelerators_none() {
    let place = Place::new().with("drilled.json", DRILLED);
    let answer = |more: &[&str]| json(&place, &[&["drilled.json"], more].concat());
    let one = answer(&["--threads", "1"]);
    assert_eq!(one, answer(&["--threads", "2", "--accel", "grid"]));
    let volume = |answer: &Value| answer["objects"][0]["volume"]["value"].clone();
    assert_ne!(volume(&one), volume(&answer(&["--seed", "1"])));
}

#[test]
fn what_an_object_owns_is_less_than_what_it_is() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "left", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "right", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}}]}"#;
    let place = Place::new().with("two.json", scene);
    let volumes = |policy: &str| -> Vec<f64> {
        let answer = json(&place, &["two.json", "--overlaps", policy]);
        let objects = answer["objects"].as_array().unwrap();
        objects.iter().map(|object| object["volume"]["value"].as_f64().unwrap()).collect()
    };
    assert_eq!(volumes("all"), [8.0, 8.0]);
    let owned = volumes("priority");
    assert!((owned[0] - 4.0).abs() < 0.01 && (owned[1] - 8.0).abs() < 0.01, "{owned:?}");
    place.run(&["measure", "two.json", "--overlaps", "error"]).refused(&["left", "right", "--overlaps"]);
}

#[test]
fn what_cannot_be_measured_is_refused_by_name() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "ball", "node": {"kind": "sphere", "radius": 1}},
        {"name": "ground", "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let place =
        Place::new().with("ground.json", scene).with("open.ply", cube_ply(10)).with("cube.ply", cube_ply(12));
    place.run(&["measure", "ground.json", "--object", "ground"]).refused(&[
        "ground.json",
        "'ground'",
        "finite",
        "intersect",
        "--object",
    ]);
    let text = place.run(&["measure", "ground.json"]).ok();
    assert!(text.contains("4.1887902") && text.contains("unbounded"), "{text}");
    assert_eq!(json(&place, &["ground.json"])["objects"][1]["unbounded"], true);
    assert!(place.run(&["measure", "ground.json", "--object", "ball"]).ok().contains("4.1887902"));
    place.run(&["measure", "ground.json", "--object", "moon"]).refused(&["'moon'", "info"]);
    place.run(&["measure", "open.ply"]).refused(&[
        "open.ply",
        "not closed",
        "open edges",
        "or choose others with --object",
    ]);
    assert_eq!(json(&place, &["cube.ply"])["objects"][0]["volume"]["value"], 1.0);
    let huge =
        r#"{"shotline": 1, "objects": [{"name": "sun", "node": {"kind": "sphere", "radius": 1e120}}]}"#;
    let place = place.with("huge.json", huge);
    let words = ["huge.json", "'sun'", "too large", "other units of length", "help: choose other objects"];
    place.run(&["measure", "huge.json"]).refused(&words);
    place.run(&["measure", "cube.ply", "--rays", "many"]).refused(&["--rays", "many"]);
}
