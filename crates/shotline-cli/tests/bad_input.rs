//! What is wrong with the input is reported in one readable message, with exit code 2.

mod place;

use place::{Answer, DRILLED, Place, cube_ply, npy};

const RAY: &[[f64; 6]] = &[[0.0, 0.0, -10.0, 0.0, 0.0, 1.0]];

/// Casts one ray through a scene.
fn cast(place: Place, model: &str) -> Answer {
    let place = place.with_rays("rays.npy", RAY);
    let answer = place.run(&["cast", model, "--rays", "rays.npy", "--query", "crossings", "-o", "out.npz"]);
    assert!(!place.path("out.npz").exists() || answer.code == Some(0));
    answer
}

fn cast_scene(objects: &str) -> Answer {
    let text = format!("{{\n  \"shotline\": 1,\n  \"objects\": [\n    {objects}\n  ]\n}}\n");
    cast(Place::new().with("scene.json", text), "scene.json")
}

/// Casts rays of a file through a good scene.
fn cast_rays(file: Vec<u8>) -> Answer {
    let place = Place::new().with("scene.json", DRILLED).with("rays.npy", file);
    place.run(&["cast", "scene.json", "--rays", "rays.npy", "--query", "any", "-o", "out.npz"])
}

#[test]
fn missing_files() {
    cast(Place::new(), "nowhere.json")
        .refused(&["nowhere.json: cannot be read: No such file or directory\n"]);
    cast(Place::new(), ".").refused(&[".: is a folder", "help: name a file in it"]);
    cast(Place::new(), "nowhere.ply").refused(&["nowhere.ply"]);
    let scene = Place::new().with("scene.json", DRILLED);
    let args = ["cast", "scene.json", "--rays", "no.npy", "--query", "any", "-o", "out.npz"];
    scene.run(&args).refused(&["no.npy", "cannot be read"]);
    cast_scene(r#"{"name": "a", "node": {"kind": "mesh", "file": "lost.ply"}}"#)
        .refused(&["lost.ply", ":4:"]);
}

#[test]
fn options_that_would_change_nothing() {
    let place = Place::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    let cast = ["cast", "scene.json", "--rays", "rays.npy", "--query", "closest", "-o", "out.npz"];
    place
        .run(&[&cast[..], &["--overlaps", "all"]].concat())
        .refused(&["--overlaps is for", "not for closest"]);
    let render = ["render", "scene.json", "-o", "out.png"];
    place.run(&[&render[..], &["--counter", "boxes"]].concat()).refused(&["--counter is for --look cost"]);
    let depth = [&render[..], &["--look", "depth", "--lighting", "soft"]].concat();
    place.run(&depth).refused(&["--lighting is for --look lit, not for depth"]);
    place.run(&["measure", "scene.json", "--rays", "0"]).refused(&["--rays"]);
    let empty = Place::new().with("empty.json", r#"{"shotline": 1, "objects": []}"#);
    empty.run(&["measure", "empty.json"]).refused(&["empty.json", "no objects"]);
}

#[test]
fn truncated_mesh() {
    let whole = cube_ply(12);
    let half = &whole[..whole.len() - 20];
    cast(Place::new().with("cut.ply", half), "cut.ply").refused(&["cut.ply"]);
}

#[test]
fn open_mesh_in_csg() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "lid", "node": {"op": "difference", "args": [
        {"kind": "mesh", "file": "open.ply"}, {"kind": "sphere", "radius": 0.1}]}}]}"#;
    let place = Place::new().with("open.ply", cube_ply(10)).with("scene.json", scene);
    cast(place, "scene.json").refused(&["4", "open", "edge"]);
}

#[test]
fn cycle_in_definitions() {
    let scene = r#"{"shotline": 1,
      "defs": {"hen": {"op": "union", "args": [{"ref": "egg"}]},
               "egg": {"op": "union", "args": [{"ref": "hen"}]}},
      "objects": [{"name": "farm", "node": {"ref": "hen"}}]}"#;
    cast(Place::new().with("scene.json", scene), "scene.json").refused(&["scene.json:", "hen", "egg"]);
}

#[test]
fn unknown_key() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "raduis": 1}}"#).refused(&[
        "scene.json:4:",
        "raduis",
        "radius",
    ]);
}

#[test]
fn radius_that_is_no_size() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": NaN}}"#).refused(&[
        "scene.json:4:",
        "NaN",
        "use a half-space or a quadric",
    ]);
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": -2.5}}"#).refused(&[
        "scene.json:4:",
        "radius",
        "-2.5",
        "positive",
    ]);
}

#[test]
fn singular_transform() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": 1, "scale": [1, 0, 1]}}"#)
        .refused(&["scene.json:4:", "transform"]);
}

#[test]
fn every_error_is_listed() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "sphere", "radius": 0}},
        {"name": "b", "node": {"kind": "sphere", "radius": -1}}]}"#;
    cast(Place::new().with("scene.json", scene), "scene.json").refused(&["scene.json:2:", "scene.json:3:"]);
}

#[test]
fn rays_of_the_wrong_shape_or_type() {
    cast_rays(npy(&[2, 5], &[0.0; 10])).refused(&["rays.npy", "(2, 5)", "6"]);
    cast_rays(npy(&[6], &[1.0; 6])).refused(&["rays.npy", "6"]);
    let mut cut = npy(&[2, 6], &[1.0; 12]);
    cut.truncate(cut.len() - 8);
    cast_rays(cut).refused(&["rays.npy"]);
    cast_rays(b"not an array".to_vec()).refused(&["rays.npy"]);
}

#[test]
fn bad_row() {
    let rows = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    cast_rays(npy(&[2, 6], &rows.concat())).refused(&["rays.npy", "row 1", "direction", "zero"]);
    let rows = [[f64::INFINITY, 0.0, 0.0, 1.0, 0.0, 0.0]];
    cast_rays(npy(&[1, 6], &rows.concat())).refused(&["rays.npy", "row 0", "origin", "infinite"]);
}

#[test]
fn usage() {
    let place = Place::new();
    place
        .run(&["fire"])
        .refused(&["fire", "render, cast, shoot, check, info, measure, compare, bench, convert"]);
    for args in [&["compare", "x.json", "--threads", "2"][..], &["check", "x.json", "--query", "any"]] {
        let answer = place.run(args);
        assert!(!answer.stderr.contains("as a value"), "{}", answer.stderr);
        answer.refused(&["unexpected argument", args[2]]);
    }
    place.run(&["check", "x.json", "--acel", "bvh"]).refused(&["'--accel'"]);
    let from = ["shoot", "x.json", "--dir", "0,0,1", "--from", "0,0"];
    place.run(&from).refused(&["expected three numbers X,Y,Z, not 2"]);
    let cast = ["cast", "x.json", "--query", "closest", "-o", "a.npz"];
    place.run(&cast).refused(&["--rays", "--camera"]);
    for (option, value) in [("--threads", "-1"), ("--max-crossings", "-1"), ("--camera", "-4x3")] {
        place.run(&[&cast[..], &[option, value]].concat()).refused(&["invalid value", option, "expected"]);
    }
    place.run(&["cast", "x.json", "--accle", "bvh"]).refused(&["--accle", "--accel"]);
    let help = place.run(&["cast", "--help"]).ok();
    for words in ["ray_splits", "--on-invalid", "Examples:", "path_names"] {
        assert!(help.contains(words), "no '{words}' in\n{help}");
    }
    for verb in ["render", "cast", "shoot", "check", "info"] {
        assert!(place.run(&[verb, "--help"]).ok().contains(&format!("shotline {verb} ")), "{verb}");
    }
}

#[test]
fn t_range_with_nan_or_reversed() {
    let place = Place::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    for (t_min, t_max) in [("NaN", "1"), ("0", "NaN"), ("2", "1"), ("-inf", "1")] {
        let range = ["--t-min", t_min, "--t-max", t_max];
        let cast = ["cast", "scene.json", "--rays", "rays.npy", "--query", "any", "-o", "out.npz"];
        place
            .run(&[&cast[..], &range].concat())
            .refused(&["is not an interval", "help: --t-min must be finite"]);
        let shoot = ["shoot", "scene.json", "--from", "0,0,-9", "--dir", "0,0,1"];
        place.run(&[&shoot[..], &range].concat()).refused(&["is not an interval"]);
    }
    assert_eq!(place.files(), ["rays.npy", "scene.json"]);
}

#[test]
fn condition_of_transforms_is_told() {
    let scene =
        r#"{"shotline": 1, "objects": [{"node": {"kind": "sphere", "radius": 1, "scale": [1, 1, 1e-12]}}]}"#;
    let place = Place::new().with("scene.json", scene);
    assert!(place.run(&["info", "scene.json"]).ok().contains("condition       1e12"));
    let json: serde_json::Value =
        serde_json::from_str(&place.run(&["info", "scene.json", "--json"]).ok()).unwrap();
    assert!((json["condition"].as_f64().unwrap() / 1e12 - 1.0).abs() < 1e-3);
}

#[test]
fn mesh_files_outside_of_the_scenes_folder() {
    let scene = |file: &str| {
        format!(r#"{{"shotline": 1, "objects": [{{"node": {{"kind": "mesh", "file": "{file}"}}}}]}}"#)
    };
    let place = Place::new().with("cube.ply", cube_ply(12));
    std::fs::create_dir(place.path("scenes")).unwrap();
    let absolute = place.path("cube.ply").display().to_string();
    let place =
        place.with("scenes/up.json", scene("../cube.ply")).with("scenes/absolute.json", scene(&absolute));
    for (file, why) in
        [("scenes/up.json", "outside of the scene's folder"), ("scenes/absolute.json", "absolute")]
    {
        place.run(&["info", file]).refused(&[file, ":1:", why, "--allow-outside"]);
        place.run(&["info", file, "--allow-outside"]).ok();
    }
}

/// Neither a pipe, which nobody writes to, nor a device is waited for.
#[cfg(unix)]
#[test]
fn pipes_and_devices() {
    let place = Place::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    let made = std::process::Command::new("mkfifo").arg(place.path("pipe.ply")).status();
    assert!(made.is_ok_and(|status| status.success()));
    let scene = r#"{"shotline": 1, "objects": [{"node": {"kind": "mesh", "file": "pipe.ply"}}]}"#;
    let place = place.with("piped.json", scene);
    let irregular = "is not a regular file";
    place.run(&["info", "piped.json"]).refused(&["piped.json:1:", "pipe.ply", irregular]);
    place.run(&["info", "pipe.ply"]).refused(&["pipe.ply", irregular, "help: write to a file"]);
    place.run(&["info", "/dev/zero"]).refused(&["/dev/zero", irregular]);
    let args = ["cast", "scene.json", "--rays", "/dev/zero", "--query", "any", "-o", "out.npz"];
    place.run(&args).refused(&["/dev/zero", irregular]);
}

/// 10^12 balls in a row: a ray past them is answered, a ray along them is an error, not the end of the memory.
#[test]
fn more_crossings_than_there_is_room_for() {
    let mut defs = vec![r#""p0": {"kind": "sphere", "radius": 0.25}"#.to_string()];
    for level in 1..=12 {
        let step = 10u64.pow(level - 1);
        let place = |i: u64| format!(r#"{{"ref": "p{}", "translate": [{}, 0, 0]}}"#, level - 1, i * step);
        let members: Vec<String> = (0..10).map(place).collect();
        defs.push(format!(r#""p{level}": {{"op": "group", "args": [{}]}}"#, members.join(", ")));
    }
    let scene = |part: &str| {
        format!(
            r#"{{"shotline": 1, "defs": {{{}}}, "objects": [{{"node": {{"ref": "{part}"}}}}]}}"#,
            defs.join(", ")
        )
    };
    let along = [[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]];
    let place = Place::new().with("long.json", scene("p12")).with("short.json", scene("p3"));
    let place = place.with_rays("along.npy", &along);
    place.run(&["shoot", "long.json", "--from", "-1,0,0", "--dir", "1,0,0"]).refused(&[
        "long.json",
        "the ray has more than 20000 crossings",
        "help: report a part",
    ]);
    let cast = |model: &'static str, more: &[&'static str]| {
        let fixed = ["cast", model, "--rays", "along.npy", "--query", "crossings", "-o", "out.npz"];
        place.run(&[&fixed[..], more].concat())
    };
    cast("short.json", &["--max-crossings", "1999"]).refused(&[
        "along.npy",
        "the answer has more than 1,999 crossings",
        "help: cast fewer rays at a time",
        "--max-crossings",
    ]);
    cast("short.json", &["--max-crossings", "1"]).refused(&["the answer has more than 1 crossing\n"]);
    assert!(!place.path("out.npz").exists());
    cast("short.json", &["--max-crossings", "2000"]).ok();
    cast("long.json", &["--t-max", "2.5"]).ok();
}
