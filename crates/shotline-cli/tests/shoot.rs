//! `shotline shoot`.

mod sandbox;

use sandbox::{DRILLED, Sandbox, cube_ply};
use serde_json::Value;

fn near(value: &Value, expected: f64) -> bool {
    value.as_f64().is_some_and(|x| (x - expected).abs() <= 1e-12 * expected.abs().max(1.0))
}

#[test]
fn the_table_lists_every_crossing() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&["shoot", "drilled.json", "--from", "-10,0,0", "--to", "-9,0,0"]).ok();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
    let row = |number: &str| rows.iter().find(|r| r.first() == Some(&number)).expect("a row").clone();
    assert_eq!(row("1")[..8], ["1", "5", "5", "-5", "0", "0", "in", "ball"]);
    assert_eq!(row("2")[..8], ["2", "9", "9", "-1", "0", "0", "out", "ball"]);
    assert_eq!(row("6")[..8], ["6", "18", "18", "8", "0", "0", "out", "slab"]);
    assert!(row("1").contains(&"steel") && row("1").contains(&"0.00"), "obliquity head on: {text}");
    assert_eq!(row("4").last(), Some(&"8"), "thickness so far: {text}");
    for words in ["steel  8 mm in 2 segments", "air    2 mm in 1 segment", "all    10 mm", "6 crossings"] {
        assert!(text.contains(words), "no '{words}' in\n{text}");
    }
}

#[test]
fn json_has_the_same_values_with_all_digits() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let text = sandbox.run(&["shoot", "drilled.json", "--from", "-10,0,0", "--dir", "2,0,0", "--json"]).ok();
    let shot: Value = serde_json::from_str(&text).unwrap();
    let crossings = shot["crossings"].as_array().unwrap();
    assert_eq!(crossings.len(), 6);
    let first = &crossings[0];
    assert!(near(&first["t"], 2.5) && near(&first["distance"], 5.0) && near(&first["normal"][0], -1.0));
    assert_eq!((&first["entering"], &first["kind"]), (&Value::Bool(true), &"surface".into()));
    assert_eq!((&first["object"], &first["material"]), (&"ball".into(), &"steel".into()));
    assert!(near(&crossings[5]["thickness"], 10.0));
    assert_eq!(shot["materials"][1]["material"], "steel");
    assert!(near(&shot["materials"][1]["length"], 8.0));
    assert_eq!(shot["units"], "mm");
}

#[test]
fn a_picture_shows_the_ray() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let shoot = |rest: &[&str]| {
        sandbox.run(&[&["shoot", "drilled.json", "--from", "-10,0,0", "--to", "-9,0,0"], rest].concat())
    };
    let text = shoot(&[]).ok();
    assert_eq!(shoot(&["--picture", "ray.png", "--size", "60x40"]).ok(), text);
    assert!(std::fs::read(sandbox.path("ray.png")).unwrap().starts_with(b"\x89PNG"));
    shoot(&["--picture", "ray.gif"]).fails_with(&["ray.gif", ".png or .apng or .jpg"]);
    shoot(&["--picture", "-"]).fails_with(&["--picture -: standard output is for the report", "name a file"]);
    shoot(&["--picture", "no.png", "--size", "0x4"]).fails_with(&["error: --size: a picture of 0x4 pixels"]);
    shoot(&["--size", "8x8"]).fails_with(&["--picture"]);
    let nowhere = r#"{"shotline": 1, "objects": [{"name": "ground",
        "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let sandbox = Sandbox::new().with("ground.json", nowhere);
    let miss = ["shoot", "ground.json", "--from", "0,0,3", "--dir", "1,0,0", "--picture", "ray.png"];
    sandbox.run(&miss).fails_with(&["ground.json", "nothing of finite size to frame"]);
}

#[test]
fn infinite_ends_are_null_in_json_and_inf_in_the_table() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "ground",
        "node": {"kind": "halfspace", "normal": [0, 0, 1], "offset": 0}}]}"#;
    let sandbox = Sandbox::new().with("ground.json", scene);
    let down = ["shoot", "ground.json", "--from", "0,0,3", "--dir", "0,0,-1"];
    let text = sandbox.run(&down).ok();
    assert!(text.contains("out (end)") && text.contains("inf"), "{text}");
    let shot: Value = serde_json::from_str(&sandbox.run(&[&down[..], &["--json"]].concat()).ok()).unwrap();
    let end = &shot["crossings"][1];
    assert_eq!((&end["kind"], &end["t"], &end["normal"]), (&"end".into(), &Value::Null, &Value::Null));
    let inside = sandbox.run(&["shoot", "ground.json", "--from", "0,0,-3", "--dir", "0,0,1"]).ok();
    assert!(inside.contains("in (start)"), "{inside}");
}

#[test]
fn misses_and_spans_are_reported() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let miss = sandbox.run(&["shoot", "drilled.json", "--from", "0,0,9", "--dir", "0,0,1"]).ok();
    assert!(miss.contains("miss"), "{miss}");
    let limited = ["shoot", "drilled.json", "--from", "-10,0,0", "--to", "10,0,0", "--t-max", "0.375"];
    let text = sandbox.run(&limited).ok();
    assert!(text.contains("2 crossings") && text.contains("out (end)"), "{text}");
}

#[test]
fn overlaps_are_reported() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "box", "min": [0, -1, -1], "max": [2, 1, 1]}},
        {"name": "b", "node": {"kind": "box", "min": [1, -1, -1], "max": [3, 1, 1]}}]}"#;
    let sandbox = Sandbox::new().with("two.json", scene);
    let text = sandbox.run(&["shoot", "two.json", "--from", "-1,0,0", "--dir", "1,0,0"]).ok();
    assert!(text.contains("overlap: 'a' and 'b'") && text.contains("from t = 2 to t = 3"), "{text}");
    assert!(text.contains("3 in"), "each length counts once: {text}");
}

#[test]
fn a_surface_has_crossings_but_no_thickness() {
    let sandbox = Sandbox::new().with("open.ply", cube_ply(10));
    let text = sandbox.run(&["shoot", "open.ply", "--from", "-1,0.3,0.4", "--dir", "1,0,0"]).ok();
    assert!(text.contains("1 crossing") && text.contains("no thickness"), "{text}");
    assert!(text.contains("open"), "{text}");
}

#[test]
fn invalid_rays_are_errors() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let shoot = |rest: &[&str]| sandbox.run(&[&["shoot", "drilled.json"], rest].concat());
    shoot(&["--from", "0,0,0", "--dir", "0,0,0"]).fails_with(&["direction", "zero", "--dir"]);
    shoot(&["--from", "0,0,0", "--dir", "0,nan,0"]).fails_with(&["nan", "not finite", "--dir"]);
    shoot(&["--from", "0,0", "--dir", "0,1,0"]).fails_with(&["three numbers", "--from"]);
    shoot(&["--from", "0,0,0"]).fails_with(&["--to", "--dir"]);
    shoot(&["--from", "0,0,0", "--to", "1,0,0", "--dir", "1,0,0"]).fails_with(&["--to", "--dir"]);
    shoot(&["--from", "0,0,0", "--to", "1,0,0", "--t-min", "2", "--t-max", "1"])
        .fails_with(&["2", "1", "--t-max"]);
}

#[test]
fn three_numbers_have_commas_or_spaces_between_them() {
    let sandbox = Sandbox::new().with("drilled.json", DRILLED);
    let shoot = |from: &[&str]| {
        let args: Vec<&str> = [&["shoot", "drilled.json", "--dir", "1,0,0", "--from"], from].concat();
        sandbox.run(&args)
    };
    assert_eq!(shoot(&["-10 0  0"]).ok(), shoot(&["-10,0,0"]).ok());
    shoot(&["1", "2", "3"])
        .fails_with(&["unexpected argument '2'", "commas between them, as in --from 1,2,3"]);
}
