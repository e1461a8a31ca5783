//! Rays that exceed limits, and queries for surfaces only.

mod sandbox;

use sandbox::{Sandbox, nested_spheres};

const ROOM: &str = r#"{"shotline": 1, "objects": [
    {"name": "room", "node": {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}]}"#;

/// Commands that cast few rays report too many crossings.
#[test]
fn deeply_nested_groups_are_errors() {
    let sandbox = nested_spheres();
    let ray = ["--from=-5,0.1,0.2", "--dir=1,0,0"];
    sandbox
        .run(&[&["shoot", "scene.json"], &ray[..]].concat())
        .fails_with(&["more than 20000 crossings", "--t-min"]);
    let traced = sandbox.run(&[&["shoot", "scene.json", "--trace=closest"], &ray[..]].concat());
    traced.fails_with(&["more than 20000 crossings"]);
    let checked = sandbox.run(&["check", "scene.json"]);
    assert_eq!(checked.code, Some(3));
    assert!(checked.stdout.contains("more than 1048576 crossings"), "{}", checked.stdout);
    assert!(!checked.stdout.contains("sound"), "{}", checked.stdout);
}

#[test]
fn a_ray_beyond_its_limits_is_named() {
    let rays = [[50.0, 50.0, 0.2, 1.0, 0.0, 0.0], [-5.0, 0.1, 0.2, 1.0, 0.0, 0.0]];
    let sandbox = nested_spheres().with_rays("rays.npy", &rays);
    let cast =
        |query| sandbox.run(&["cast", "scene.json", "--rays", "rays.npy", "--query", query, "-o", "out.npz"]);
    cast("crossings").fails_with(&["row 1 of rays.npy", "more than 1048576 crossings", "--t-max"]);
    cast("closest").fails_with(&["row 1 of rays.npy", "more than 10000000 steps", "--t-max"]);
    cast("any").ok();
}

#[test]
fn shoot_lists_surfaces_only() {
    let sandbox = Sandbox::new().with("room.json", ROOM);
    let ray = ["shoot", "room.json", "--from=0,0,0", "--dir=1,0,0"];
    let all = sandbox.run(&ray).ok();
    assert!(all.contains("in (start)") && all.contains("2 crossings"), "{all}");
    let surfaces = sandbox.run(&[&ray[..], &["--surfaces-only"]].concat()).ok();
    assert!(!surfaces.contains("start") && surfaces.contains("1 crossing\n"), "{surfaces}");
    // The length inside does not change.
    assert!(surfaces.contains("1 in 1 segment"), "{surfaces}");
    let traced = sandbox.run(&[&ray[..], &["--surfaces-only", "--trace=closest"]].concat()).ok();
    assert!(traced.contains("=> out"), "{traced}");
}

#[test]
fn cast_and_bench_find_surfaces_only() {
    let sandbox =
        Sandbox::new().with("room.json", ROOM).with_rays("rays.npy", &[[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]]);
    let cast = |query, more: &[&str]| {
        let args = ["cast", "room.json", "--rays", "rays.npy", "--query", query, "-o", "out.npz"];
        sandbox.run(&[&args[..], more].concat())
    };
    for query in ["closest", "any", "count", "crossings"] {
        cast(query, &["--surfaces-only"]).ok();
    }
    cast("segments", &["--surfaces-only"])
        .fails_with(&["--surfaces-only", "closest, any, count or crossings"]);
    sandbox.run(&["bench", "room.json", "--repeats", "1", "--surfaces-only"]).ok();
    sandbox
        .run(&["bench", "room.json", "--query", "segments", "--surfaces-only"])
        .fails_with(&["--surfaces-only"]);
}
