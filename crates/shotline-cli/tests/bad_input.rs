//! Errors in the input are reported in one readable message, with exit code 2.

mod sandbox;

use sandbox::{DRILLED, RunResult, Sandbox, cube_ply, npy};

const RAY: &[[f64; 6]] = &[[0.0, 0.0, -10.0, 0.0, 0.0, 1.0]];

/// Casts one ray through a scene.
fn cast(sandbox: Sandbox, model: &str) -> RunResult {
    let sandbox = sandbox.with_rays("rays.npy", RAY);
    let result = sandbox.run(&["cast", model, "--rays", "rays.npy", "--query", "crossings", "-o", "out.npz"]);
    assert!(!sandbox.path("out.npz").exists() || result.code == Some(0));
    result
}

fn cast_scene(objects: &str) -> RunResult {
    let text = format!("{{\n  \"shotline\": 1,\n  \"objects\": [\n    {objects}\n  ]\n}}\n");
    cast(Sandbox::new().with("scene.json", text), "scene.json")
}

/// Casts rays of a file through a good scene.
fn cast_rays(file: Vec<u8>) -> RunResult {
    let sandbox = Sandbox::new().with("scene.json", DRILLED).with("rays.npy", file);
    sandbox.run(&["cast", "scene.json", "--rays", "rays.npy", "--query", "any", "-o", "out.npz"])
}

#[test]
fn missing_files() {
    cast(Sandbox::new(), "nowhere.json")
        .fails_with(&["nowhere.json: cannot be read: No such file or directory\n"]);
    cast(Sandbox::new(), ".").fails_with(&[".: is a folder", "help: name a file in it"]);
    cast(Sandbox::new(), "nowhere.ply").fails_with(&["nowhere.ply"]);
    let scene = Sandbox::new().with("scene.json", DRILLED);
    let args = ["cast", "scene.json", "--rays", "no.npy", "--query", "any", "-o", "out.npz"];
    scene.run(&args).fails_with(&["no.npy", "cannot be read"]);
    cast_scene(r#"{"name": "a", "node": {"kind": "mesh", "file": "lost.ply"}}"#)
        .fails_with(&["lost.ply", ":4:"]);
}

#[test]
fn options_without_an_effect() {
    let sandbox = Sandbox::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    let cast = ["cast", "scene.json", "--rays", "rays.npy", "--query", "closest", "-o", "out.npz"];
    sandbox
        .run(&[&cast[..], &["--overlaps", "all"]].concat())
        .fails_with(&["--overlaps is for", "not for closest"]);
    let render = ["render", "scene.json", "-o", "out.png"];
    sandbox
        .run(&[&render[..], &["--counter", "boxes"]].concat())
        .fails_with(&["--counter is for --look cost"]);
    let depth = [&render[..], &["--look", "depth", "--lighting", "soft"]].concat();
    sandbox.run(&depth).fails_with(&["--lighting is for --look lit, not for depth"]);
    sandbox.run(&["measure", "scene.json", "--rays", "0"]).fails_with(&["--rays"]);
    let empty = Sandbox::new().with("empty.json", r#"{"shotline": 1, "objects": []}"#);
    empty.run(&["measure", "empty.json"]).fails_with(&["empty.json", "no objects"]);
}

#[test]
fn truncated_mesh() {
    let complete = cube_ply(12);
    let truncated = &complete[..complete.len() - 20];
    cast(Sandbox::new().with("cut.ply", truncated), "cut.ply").fails_with(&["cut.ply"]);
}

#[test]
fn open_mesh_in_csg() {
    let scene = r#"{"shotline": 1, "objects": [{"name": "lid", "node": {"op": "difference", "args": [
        {"kind": "mesh", "file": "open.ply"}, {"kind": "sphere", "radius": 0.1}]}}]}"#;
    let sandbox = Sandbox::new().with("open.ply", cube_ply(10)).with("scene.json", scene);
    cast(sandbox, "scene.json").fails_with(&["4", "open", "edge"]);
}

#[test]
fn cycle_in_definitions() {
    let scene = r#"{"shotline": 1,
      "defs": {"hen": {"op": "union", "args": [{"ref": "egg"}]},
               "egg": {"op": "union", "args": [{"ref": "hen"}]}},
      "objects": [{"name": "farm", "node": {"ref": "hen"}}]}"#;
    cast(Sandbox::new().with("scene.json", scene), "scene.json").fails_with(&["scene.json:", "hen", "egg"]);
}

#[test]
fn unknown_key() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "raduis": 1}}"#).fails_with(&[
        "scene.json:4:",
        "raduis",
        "radius",
    ]);
}

#[test]
fn radius_that_is_not_positive() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": NaN}}"#).fails_with(&[
        "scene.json:4:",
        "NaN",
        "use a half-space or a quadric",
    ]);
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": -2.5}}"#).fails_with(&[
        "scene.json:4:",
        "radius",
        "-2.5",
        "positive",
    ]);
}

#[test]
fn singular_transform() {
    cast_scene(r#"{"name": "a", "node": {"kind": "sphere", "radius": 1, "scale": [1, 0, 1]}}"#)
        .fails_with(&["scene.json:4:", "transform"]);
}

#[test]
fn every_error_is_listed() {
    let scene = r#"{"shotline": 1, "objects": [
        {"name": "a", "node": {"kind": "sphere", "radius": 0}},
        {"name": "b", "node": {"kind": "sphere", "radius": -1}}]}"#;
    cast(Sandbox::new().with("scene.json", scene), "scene.json")
        .fails_with(&["scene.json:2:", "scene.json:3:"]);
}

#[test]
fn rays_of_the_wrong_shape_or_type() {
    cast_rays(npy(&[2, 5], &[0.0; 10])).fails_with(&["rays.npy", "(2, 5)", "6"]);
    cast_rays(npy(&[6], &[1.0; 6])).fails_with(&["rays.npy", "6"]);
    let mut cut = npy(&[2, 6], &[1.0; 12]);
    cut.truncate(cut.len() - 8);
    cast_rays(cut).fails_with(&["rays.npy"]);
    cast_rays(b"not an array".to_vec()).fails_with(&["rays.npy"]);
}

#[test]
fn bad_row() {
    let rows = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    cast_rays(npy(&[2, 6], &rows.concat())).fails_with(&["rays.npy", "row 1", "direction", "zero"]);
    let rows = [[f64::INFINITY, 0.0, 0.0, 1.0, 0.0, 0.0]];
    cast_rays(npy(&[1, 6], &rows.concat())).fails_with(&["rays.npy", "row 0", "origin", "infinite"]);
}

#[test]
fn usage() {
    let sandbox = Sandbox::new();
    sandbox.run(&["fire"]).fails_with(&[
        "fire",
        "render, slice, view, cast, shoot, check, info, measure, compare, bench, convert",
    ]);
    for args in [&["compare", "x.json", "--threads", "2"][..], &["check", "x.json", "--query", "any"]] {
        let result = sandbox.run(args);
        assert!(!result.stderr.contains("as a value"), "{}", result.stderr);
        result.fails_with(&["unexpected argument", args[2]]);
    }
    sandbox.run(&["check", "x.json", "--acel", "bvh"]).fails_with(&["'--accel'"]);
    let from = ["shoot", "x.json", "--dir", "0,0,1", "--from", "0,0"];
    sandbox.run(&from).fails_with(&["expected three numbers X,Y,Z, not 2"]);
    let cast = ["cast", "x.json", "--query", "closest", "-o", "a.npz"];
    sandbox.run(&cast).fails_with(&["--rays", "--camera"]);
    for (option, value) in [("--threads", "-1"), ("--max-crossings", "-1"), ("--camera", "-4x3")] {
        sandbox.run(&[&cast[..], &[option, value]].concat()).fails_with(&[
            "invalid value",
            option,
            "expected",
        ]);
    }
    sandbox.run(&["cast", "x.json", "--accle", "bvh"]).fails_with(&["--accle", "--accel"]);
    let help = sandbox.run(&["cast", "--help"]).ok();
    for words in ["ray_splits", "--on-invalid", "Examples:", "path_names"] {
        assert!(help.contains(words), "no '{words}' in\n{help}");
    }
    for verb in ["render", "cast", "shoot", "check", "info"] {
        assert!(sandbox.run(&[verb, "--help"]).ok().contains(&format!("shotline {verb} ")), "{verb}");
    }
}

#[test]
fn t_range_with_nan_or_reversed() {
    let sandbox = Sandbox::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    for (t_min, t_max) in [("NaN", "1"), ("0", "NaN"), ("2", "1"), ("-inf", "1")] {
        let range = ["--t-min", t_min, "--t-max", t_max];
        let cast = ["cast", "scene.json", "--rays", "rays.npy", "--query", "any", "-o", "out.npz"];
        sandbox
            .run(&[&cast[..], &range].concat())
            .fails_with(&["is not an interval", "help: --t-min must be finite"]);
        let shoot = ["shoot", "scene.json", "--from", "0,0,-9", "--dir", "0,0,1"];
        sandbox.run(&[&shoot[..], &range].concat()).fails_with(&["is not an interval"]);
    }
    assert_eq!(sandbox.files(), ["rays.npy", "scene.json"]);
}

#[test]
fn condition_of_transforms_is_reported() {
    let scene =
        r#"{"shotline": 1, "objects": [{"node": {"kind": "sphere", "radius": 1, "scale": [1, 1, 1e-12]}}]}"#;
    let sandbox = Sandbox::new().with("scene.json", scene);
    assert!(sandbox.run(&["info", "scene.json"]).ok().contains("condition       1e12"));
    let json: serde_json::Value =
        serde_json::from_str(&sandbox.run(&["info", "scene.json", "--json"]).ok()).unwrap();
    assert!((json["condition"].as_f64().unwrap() / 1e12 - 1.0).abs() < 1e-3);
}

#[test]
fn mesh_files_outside_of_the_scenes_folder() {
    let scene = |file: &str| {
        format!(r#"{{"shotline": 1, "objects": [{{"node": {{"kind": "mesh", "file": "{file}"}}}}]}}"#)
    };
    let sandbox = Sandbox::new().with("cube.ply", cube_ply(12));
    std::fs::create_dir(sandbox.path("scenes")).unwrap();
    let absolute = sandbox.path("cube.ply").display().to_string();
    let sandbox =
        sandbox.with("scenes/up.json", scene("../cube.ply")).with("scenes/absolute.json", scene(&absolute));
    for (file, why) in
        [("scenes/up.json", "outside of the scene's folder"), ("scenes/absolute.json", "absolute")]
    {
        sandbox.run(&["info", file]).fails_with(&[file, ":1:", why, "--allow-outside"]);
        sandbox.run(&["info", file, "--allow-outside"]).ok();
    }
}

/// The program does not wait for a pipe without a writer, nor for a device.
#[cfg(unix)]
#[test]
fn pipes_and_devices() {
    let sandbox = Sandbox::new().with("scene.json", DRILLED).with_rays("rays.npy", RAY);
    let made = std::process::Command::new("mkfifo").arg(sandbox.path("pipe.ply")).status();
    assert!(made.is_ok_and(|status| status.success()));
    let scene = r#"{"shotline": 1, "objects": [{"node": {"kind": "mesh", "file": "pipe.ply"}}]}"#;
    let sandbox = sandbox.with("piped.json", scene);
    let irregular = "is not a regular file";
    sandbox.run(&["info", "piped.json"]).fails_with(&["piped.json:1:", "pipe.ply", irregular]);
    sandbox.run(&["info", "pipe.ply"]).fails_with(&["pipe.ply", irregular, "help: write to a file"]);
    sandbox.run(&["info", "/dev/zero"]).fails_with(&["/dev/zero", irregular]);
    let args = ["cast", "scene.json", "--rays", "/dev/zero", "--query", "any", "-o", "out.npz"];
    sandbox.run(&args).fails_with(&["/dev/zero", irregular]);
}

/// 10^12 balls in a row: a ray past them has a result, and a ray along them is an error that does not exhaust the memory.
#[test]
fn more_crossings_than_fit_into_memory() {
    let mut defs = vec![r#""p0": {"kind": "sphere", "radius": 0.25}"#.to_string()];
    for level in 1..=12 {
        let step = 10u64.pow(level - 1);
        let member = |i: u64| format!(r#"{{"ref": "p{}", "translate": [{}, 0, 0]}}"#, level - 1, i * step);
        let members: Vec<String> = (0..10).map(member).collect();
        defs.push(format!(r#""p{level}": {{"op": "group", "args": [{}]}}"#, members.join(", ")));
    }
    let scene = |part: &str| {
        format!(
            r#"{{"shotline": 1, "defs": {{{}}}, "objects": [{{"node": {{"ref": "{part}"}}}}]}}"#,
            defs.join(", ")
        )
    };
    let along = [[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0]];
    let sandbox = Sandbox::new().with("long.json", scene("p12")).with("short.json", scene("p3"));
    let sandbox = sandbox.with_rays("along.npy", &along);
    sandbox.run(&["shoot", "long.json", "--from", "-1,0,0", "--dir", "1,0,0"]).fails_with(&[
        "long.json",
        "the ray has more than 20000 crossings",
        "help: shorten the ray",
    ]);
    let cast = |model: &'static str, more: &[&'static str]| {
        let fixed = ["cast", model, "--rays", "along.npy", "--query", "crossings", "-o", "out.npz"];
        sandbox.run(&[&fixed[..], more].concat())
    };
    cast("short.json", &["--max-crossings", "1999"]).fails_with(&[
        "along.npy",
        "the result has more than 1,999 crossings",
        "help: cast fewer rays at a time",
        "--max-crossings",
    ]);
    cast("short.json", &["--max-crossings", "1"]).fails_with(&["the result has more than 1 crossing\n"]);
    assert!(!sandbox.path("out.npz").exists());
    cast("short.json", &["--max-crossings", "2000"]).ok();
    cast("long.json", &["--t-max", "2.5"]).ok();
}
