//! Rays that meet more than anybody wants, and queries for surfaces only.

mod place;

use place::{Place, nested_spheres};

const ROOM: &str = r#"{"shotline": 1, "objects": [
    {"name": "room", "node": {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}}]}"#;

/// Commands that report and do not cast many rays.
#[test]
fn parts_in_one_another_over_and_over_are_refused() {
    let place = nested_spheres();
    let ray = ["--from=-5,0.1,0.2", "--dir=1,0,0"];
    place
        .run(&[&["shoot", "scene.json"], &ray[..]].concat())
        .refused(&["more than 20000 crossings", "--t-min"]);
    let traced = place.run(&[&["shoot", "scene.json", "--trace=closest"], &ray[..]].concat());
    traced.refused(&["more than 20000 crossings"]);
    let checked = place.run(&["check", "scene.json"]);
    assert_eq!(checked.code, Some(3));
    assert!(checked.stdout.contains("more than 1048576 crossings"), "{}", checked.stdout);
    assert!(!checked.stdout.contains("sound"), "{}", checked.stdout);
}

#[test]
fn a_ray_beyond_its_limits_is_named() {
    let rays = [[50.0, 50.0, 0.2, 1.0, 0.0, 0.0], [-5.0, 0.1, 0.2, 1.0, 0.0, 0.0]];
    let place = nested_spheres().with_rays("rays.npy", &rays);
    let cast =
        |query| place.run(&["cast", "scene.json", "--rays", "rays.npy", "--query", query, "-o", "out.npz"]);
    cast("crossings").refused(&["row 1 of rays.npy", "more than 1048576 crossings", "--t-max"]);
    cast("closest").refused(&["row 1 of rays.npy", "more than 10000000 steps", "--t-max"]);
    cast("any").ok();
}

#[test]
fn shoot_lists_surfaces_only() {
    let place = Place::new().with("room.json", ROOM);
    let ray = ["shoot", "room.json", "--from=0,0,0", "--dir=1,0,0"];
    let all = place.run(&ray).ok();
    assert!(all.contains("in (start)") && all.contains("2 crossings"), "{all}");
    let surfaces = place.run(&[&ray[..], &["--surfaces-only"]].concat()).ok();
    assert!(!surfaces.contains("start") && surfaces.contains("1 crossing\n"), "{surfaces}");
    // The length inside is what it is.
    assert!(surfaces.contains("1 in 1 segment"), "{surfaces}");
    let traced = place.run(&[&ray[..], &["--surfaces-only", "--trace=closest"]].concat()).ok();
    assert!(traced.contains("=> out"), "{traced}");
}

#[test]
fn cast_and_bench_look_for_surfaces_only() {
    let place = Place::new().with("room.json", ROOM).with_rays("rays.npy", &[[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]]);
    let cast = |query, more: &[&str]| {
        let args = ["cast", "room.json", "--rays", "rays.npy", "--query", query, "-o", "out.npz"];
        place.run(&[&args[..], more].concat())
    };
    for query in ["closest", "any", "count", "crossings"] {
        cast(query, &["--surfaces-only"]).ok();
    }
    cast("segments", &["--surfaces-only"]).refused(&["--surfaces-only", "closest, any, count or crossings"]);
    place.run(&["bench", "room.json", "--repeats", "1", "--surfaces-only"]).ok();
    place
        .run(&["bench", "room.json", "--query", "segments", "--surfaces-only"])
        .refused(&["--surfaces-only"]);
}
